"""Where on a scene's mirrors an eye sees points, and how often."""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from anamorph.base.errors import AnamorphError
from anamorph.base.vectors import tuple_of
from anamorph.files.opening import open_scene
from anamorph.reflections.searching import MirrorSearch
from anamorph.scene.camera import Camera
from anamorph.scene.checks import FARTHEST, check_contents
from anamorph.scene.model import Mirror, Scene


class ReflectionStatus(IntEnum):
    """What is known of a reflection point, or of all those of a point.

    FOUND: it is where its numbers say; of a point, all are found.
    FOCUS: several merge here, or it is one of a whole curve or surface of them: one stands for all of its mirror.
    ON_SURFACE: the point itself is on a mirror or a lens, and what is seen of it there is not looked for.
    MANY: there were so many places to search from that some were left out; there may be more than are given.
    """

    FOUND = 0
    FOCUS = 1
    ON_SURFACE = 2
    MANY = 3


@dataclass(frozen=True, eq=False)
class ReflectionPoints:
    """All the places of a scene's mirrors at which an eye sees some points, one bounce away.

    What stands between them hides nothing: the whole scene but its mirrors is looked through.

    Parameters
    ----------
    point : (M,) int64
        Which of the N points is seen there, ascending.
    mesh : (M,) int64
        The mirror's number among the meshes of the scene.
    position : (M, 3) float64
        Where on the mirror, metres.
    parameters : (M, 2) float64
        The (u, v) there on its exact surface; of a mesh without one, the weights of the triangle's second and third
        corner.
    triangle : (M,) int64
        The triangle of the mesh that lies there, or near there.
    direction : (M, 3) float64
        Unit, from the eye.
    length : (M,) float64
        Of the path from the eye over the mirror to the point, metres.
    order : (M,) int8
        1 where the length is the least or the greatest of all paths near by, and the point is seen the right way round
        or turned by half a turn; -1 where it is neither, and the point is seen mirrored; 0 at a focus.
    status : (M,) uint8
        A `ReflectionStatus` each.
    point_status : (N,) uint8
        The same of each point: the greatest of what is known.
    image : (M, 3) float64, optional
        Homogeneous image coordinates (x w, y w, w), in pixels, where a camera looks on; w < 0 is behind it.
    """

    point: np.ndarray
    mesh: np.ndarray
    position: np.ndarray
    parameters: np.ndarray
    triangle: np.ndarray
    direction: np.ndarray
    length: np.ndarray
    order: np.ndarray
    status: np.ndarray
    point_status: np.ndarray
    image: np.ndarray | None = None

    @property
    def counts(self) -> np.ndarray:
        """How often each point is seen, (N,) int64."""
        return np.bincount(self.point, minlength=len(self.point_status))


def reflection_points(
    scene: Scene | str | Path,
    eye: Camera | ArrayLike,
    points: ArrayLike,
    size: tuple[int, int] = (1024, 768),
) -> ReflectionPoints:
    """Find where on the mirrors of a scene an eye sees points: all the places, on the exact surfaces.

    Parameters
    ----------
    scene : Scene, str or Path
        A scene, the name of a built-in one, or the path of a scene file or a model file.
    eye : Camera or (3,) array
        Metres.
    points : (N, 3) or (3,) array
        Metres.
    size : (width, height)
        Of a camera's image, pixels.

    Returns
    -------
    ReflectionPoints

    Raises
    ------
    AnamorphError
        The scene has no mirror, the eye is on one, or an array is not what it should be.
    """
    opened = scene if isinstance(scene, Scene) else open_scene(scene)[0]
    checked = check_contents(opened)
    place = finite("eye", eye.position if isinstance(eye, Camera) else eye, (3,))
    sought = np.atleast_2d(np.asarray(points, float))
    sought = finite("points", sought, (len(sought), 3))
    numbers = [number for number, mesh in enumerate(checked.meshes) if isinstance(mesh.material, Mirror)]
    if not numbers:
        raise AnamorphError(f"scene '{checked.name}': has no mirror; give a part the material mirror")
    states = np.zeros(len(sought), np.uint8)
    found, parameters = [], []
    for number in numbers:
        mesh = checked.meshes[number]
        search = MirrorSearch.of(mesh, place)
        if search.pieces.touched(place[None])[0]:
            raise AnamorphError(f"eye {tuple_of(place)} is on the mirror '{mesh.name}'; move it away from it")
        own = search.find(sought)
        found.append(own)
        parameters.append(search.pieces.placed(own.place))
        raised(states, own.on, own.full, own.point, own.order)

    def joined(field: str) -> np.ndarray:
        return np.concatenate([getattr(own, field) for own in found])

    mesh_of = np.repeat(numbers, [len(own.point) for own in found])
    length, point = joined("length"), joined("point")
    order = np.lexsort([length, mesh_of, point])
    position, turns = joined("position")[order], joined("order")[order]
    offset = position - place
    return ReflectionPoints(
        point=point[order],
        mesh=mesh_of[order],
        position=position,
        parameters=np.concatenate(parameters)[order],
        triangle=joined("triangle")[order],
        direction=offset / np.linalg.norm(offset, axis=1, keepdims=True),
        length=length[order],
        order=turns.astype(np.int8),
        status=np.where(turns == 0, ReflectionStatus.FOCUS, ReflectionStatus.FOUND).astype(np.uint8),
        point_status=states,
        image=eye.image(position, size) if isinstance(eye, Camera) else None,
    )


def raised(states: np.ndarray, on: np.ndarray, full: np.ndarray, point: np.ndarray, order: np.ndarray) -> None:
    """Raise what is known of N points, `states` (N,), by what was found on one more mirror or lens.

    `on` and `full` (N,) tell which are on it and which were not searched for to the end; `point` and `order` (M,) are
    those of what was found.
    """
    focus = np.bincount(point[order == 0], minlength=len(states)) > 0
    for marked, status in (
        (on, ReflectionStatus.ON_SURFACE),
        (full & ~focus, ReflectionStatus.MANY),
        (focus, ReflectionStatus.FOCUS),
    ):
        states[marked] = np.maximum(states[marked], status)


def finite(name: str, values: ArrayLike, shape: tuple[int, ...]) -> np.ndarray:
    """An argument as float64, if it has a shape and its numbers are those of a scene; else an AnamorphError."""
    array = np.asarray(values, float)
    if array.shape != shape:
        raise AnamorphError(f"{name}: has the shape {array.shape}; give {shape} numbers, in metres")
    if not (np.abs(array) <= FARTHEST).all():
        raise AnamorphError(f"{name}: has numbers that are not finite, or beyond {FARTHEST:.0e} m; leave them out")
    return array
