"""Where an eye sees points through the lenses of a scene, and how often."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from anamorph.base.errors import AnamorphError
from anamorph.base.vectors import tuple_of
from anamorph.files.opening import open_scene
from anamorph.optics.dispersion import line_indices
from anamorph.reflections.lens_searching import LensFaces, LensSearch
from anamorph.reflections.reflection_points import ReflectionStatus, finite, raised
from anamorph.scene.camera import Camera
from anamorph.scene.checks import check_contents
from anamorph.scene.lens_pairs import lens_pairs
from anamorph.scene.model import Glass, Scene

COLORS = ("red", "green", "blue")
"""Light of the C, d and F lines."""


@dataclass(frozen=True, eq=False)
class RefractionPoints:
    """All the places of a scene's lenses by which an eye sees some points, through both faces of one lens.

    What stands between hides nothing. Light is not followed through two lenses, or off a mirror behind a lens.

    Parameters
    ----------
    point : (M,) int64
        Which of the N points is seen there, ascending.
    mesh : (M, 2) int64
        The two faces among the meshes of the scene: the one that the eye looks at, and the one behind it.
    position : (M, 2, 3) float64
        Where the line of sight crosses each, metres.
    parameters : (M, 2, 2) float64
        The (u, v) there on their exact surfaces.
    triangle : (M, 2) int64
        The triangles of the meshes that lie there, or near there.
    direction : (M, 3) float64
        Unit, from the eye.
    length : (M,) float64
        Of the path from the eye to the point, with the part in the glass times its refractive index; metres.
    order : (M,) int8
        1 where the point's neighbourhood is seen the right way round or turned by half a turn; -1 where it is seen
        mirrored; 0 at a focus.
    status : (M,) uint8
        A `ReflectionStatus` each.
    point_status : (N,) uint8
        The same of each point: the greatest of what is known.
    image : (M, 3) float64, optional
        Homogeneous image coordinates (x w, y w, w) of the first place, in pixels, where a camera looks on; w < 0 is
        behind it.
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


def refraction_points(
    scene: Scene | str | Path,
    eye: Camera | ArrayLike,
    points: ArrayLike,
    size: tuple[int, int] = (1024, 768),
    color: str = "green",
) -> RefractionPoints:
    """Find where an eye sees points through the lenses of a scene: all the places, on the exact surfaces.

    Each lens is looked through from both of its sides. A point in the glass is not seen through two faces, and an eye
    in the glass sees nothing through them.

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
    color : str
        "red", "green" or "blue": light of the C, d or F line, which glass with an Abbe number bends differently.

    Returns
    -------
    RefractionPoints

    Raises
    ------
    AnamorphError
        The scene has no lens of two faces, the eye is on one, or an argument is not what it should be.
    """
    opened = scene if isinstance(scene, Scene) else open_scene(scene)[0]
    checked = check_contents(opened)
    place = finite("eye", eye.position if isinstance(eye, Camera) else eye, (3,))
    sought = np.atleast_2d(np.asarray(points, float))
    sought = finite("points", sought, (len(sought), 3))
    if color not in COLORS:
        raise AnamorphError(f"color is {color!r}; choose red, green or blue")
    pairs = lens_pairs(checked.meshes)
    if not pairs:
        raise AnamorphError(
            f"scene '{checked.name}': has no lens; give two faces of glass with exact surfaces, called NAME/front and "
            "NAME/back"
        )
    states = np.zeros(len(sought), np.uint8)
    found, meshes, parameters = [], [], []
    for pair in pairs:
        glass = checked.meshes[pair.front].material
        assert isinstance(glass, Glass)
        index = line_indices(glass.index, glass.abbe)[COLORS.index(color)]
        edge = None if pair.edge is None else checked.meshes[pair.edge]
        ways = (pair.front, pair.back), (pair.back, pair.front)
        sides = [LensFaces.of(checked.meshes[near], checked.meshes[far], edge) for near, far in ways]
        for (near, _), faces in zip(ways, sides, strict=True):
            if faces.near.touched(place[None])[0]:
                name = checked.meshes[near].name
                raise AnamorphError(f"eye {tuple_of(place)} is on the lens face '{name}'; move it away from it")
        on = np.logical_or(*(faces.far.touched(sought) for faces in sides))
        away = np.flatnonzero(~on)
        for way, faces in zip(ways, sides, strict=True):
            own = LensSearch.of(faces, tuple_of(place), index).find(sought[away])
            own = replace(own, point=away[own.point])
            full = np.zeros(len(sought), bool)
            full[away] = own.full
            raised(states, on, full, own.point, own.order)
            found.append(own)
            meshes.append(np.broadcast_to(way, (len(own.point), 2)))
            places = zip((faces.near, faces.far), np.moveaxis(own.place, 1, 0), strict=True)
            parameters.append(np.stack([face.placed(each) for face, each in places], axis=1))

    def joined(field: str) -> np.ndarray:
        return np.concatenate([getattr(own, field) for own in found])

    mesh, length, point = np.concatenate(meshes), joined("length"), joined("point")
    order = np.lexsort([length, mesh[:, 0], point])
    position, turns = joined("position")[order], joined("order")[order]
    offset = position[:, 0] - place
    return RefractionPoints(
        point=point[order],
        mesh=mesh[order],
        position=position,
        parameters=np.concatenate(parameters)[order],
        triangle=joined("triangle")[order],
        direction=offset / np.linalg.norm(offset, axis=1, keepdims=True),
        length=length[order],
        order=turns.astype(np.int8),
        status=np.where(turns == 0, ReflectionStatus.FOCUS, ReflectionStatus.FOUND).astype(np.uint8),
        point_status=states,
        image=eye.image(position[:, 0], size) if isinstance(eye, Camera) else None,
    )
