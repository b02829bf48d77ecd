"""What is seen at one pixel: what the method shows there, how wrong that is, and the way that light takes in truth."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from anamorph.base.errors import AnamorphError
from anamorph.base.vectors import tuple_of
from anamorph.frame import Frame
from anamorph.measure.status import STATUS_NAMES
from anamorph.methods.specification import Specification
from anamorph.methods.tracing import PathTracer
from anamorph.optics.tessellation import outlined_scene
from anamorph.rays.caster import Caster
from anamorph.scene.camera import Camera
from anamorph.scene.geometry import flatten
from anamorph.scene.model import Scene
from anamorph.viewer.facts import Inspection, Stop, Vector
from anamorph.viewer.measured import Measured
from anamorph.viewer.space import PreparedScene

EYE, SKY, NOTHING = "eye", "sky", "nothing"
"""Names of what is no mesh."""


def inspect(
    space: PreparedScene, camera: Camera, pixel: tuple[int, int], method: Specification, measured: Measured
) -> Inspection:
    """Look into one pixel of an image.

    Parameters
    ----------
    space : Space
        Of the scene as it is drawn.
    camera : Camera
        That the image is taken from.
    pixel : (x, y)
        Whole pixels from the top left.
    method : Specification
        What drew the frame, for the record.
    measured : Measured
        The frame held against the reference.

    Raises
    ------
    AnamorphError
        The pixel lies outside the image.
    """
    (column, row), maps = pixel, measured.maps
    height, width = maps.specular.shape
    if not (0 <= column < width and 0 <= row < height):
        raise AnamorphError(f"pixel {pixel}: lies outside the image of {width} x {height}; choose one inside")
    position, number, looks_at, status = _seen(measured.frame, column, row)
    true_position, true_number, _, _ = _seen(measured.reference, column, row)
    path = trace_path(space, camera, (width, height), pixel)
    point = tuple_of(position) if number else None
    counts = bool(maps.specular[row, column])
    return Inspection(
        pixel=(column, row),
        method=method,
        seen=_name(space.scene, number, position),
        point=point,
        distance=None if point is None else _length(path, point, bool(looks_at)),
        status=STATUS_NAMES[status],
        path=path,
        reference=_name(space.scene, true_number, true_position),
        angular_mrad=float(maps.angular[row, column]) if counts else None,
        pixels=float(maps.pixels[row, column]) if counts else None,
        silhouette=bool(maps.silhouette[row, column]),
    )


def trace_path(space: PreparedScene, camera: Camera, size: tuple[int, int], pixel: tuple[int, int]) -> tuple[Stop, ...]:
    """The way from the eye through the middle of a pixel, bent at the exact surfaces, to where it ends.

    A path into the sky ends as far away as the scene is large.
    """
    # Mirrors and lenses have outlines of their own in each image.
    scene = outlined_scene(space.scene, camera, size)
    geometry, caster = space.geometry, space.surroundings.caster
    if any(mesh is not own for mesh, own in zip(scene.meshes, space.scene.meshes, strict=True)):
        geometry = flatten(scene)
        caster = Caster(geometry)
    tracer = PathTracer(scene, geometry, caster)
    direction = camera.directions(np.add(pixel, 0.5), size)
    records = tracer.follow(np.asarray(camera.position, float), direction)
    triangles = records.view(np.int32)[:, 3]
    names = [scene.meshes[geometry.face_object[triangle] - 1].name if triangle >= 0 else SKY for triangle in triangles]
    last = records[-1].astype(float)
    far = last[11] if np.isfinite(last[11]) else space.surroundings.diagonal
    # A ray begins where the one before it has ended.
    points = [*records[1:, :3].astype(float), last[:3] + far * last[4:7]]
    stops = [Stop(name, tuple_of(point)) for name, point in zip(names, points, strict=True)]
    return (Stop(EYE, tuple_of(camera.position)), *stops)


def _seen(frame: Frame, column: int, row: int) -> tuple[np.ndarray, int, int, int]:
    """Position, object, specular object and status of one pixel of a frame that has been measured."""
    assert frame.position is not None and frame.object_id is not None
    assert frame.specular is not None and frame.status is not None
    place = row, column
    return frame.position[place], int(frame.object_id[place]), int(frame.specular[place]), int(frame.status[place])


def _name(scene: Scene, number: int, position: np.ndarray) -> str:
    if number:
        return scene.meshes[number - 1].name
    # The sky, too, is seen in some direction.
    return SKY if position.any() else NOTHING


def _length(path: Sequence[Stop], point: Vector, specular: bool) -> float:
    """Along the true path's surfaces to `point`, or straight there."""
    points = np.array([*(stop.point for stop in (path[:-1] if specular else path[:1])), point])
    return float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum())
