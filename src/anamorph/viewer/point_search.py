"""Where the mirrors of a scene show points to an eye, and what of that is hidden: all that the viewer asks of
`reflection_points`."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from anamorph.base.steps import drain
from anamorph.base.vectors import Vector, tuple_of
from anamorph.methods.tracing import GivenRays, PathTracer
from anamorph.optics.tessellation import outlined_scene
from anamorph.rays.caster import Caster
from anamorph.reflections.reflection_points import ReflectionPoints, ReflectionStatus, reflection_points
from anamorph.scene.camera import Camera
from anamorph.scene.geometry import flatten
from anamorph.scene.model import Scene
from anamorph.viewer.facts import Reflection, Reflections

NEARLY = 1e-3
"""How much of a leg of a path may be missing before something hides its end, as a share of the leg: pixels tell of a
point in float32, and the triangles of a mesh lie beside its exact surface."""


def reflections_of(scene: Scene, eye: Camera, size: tuple[int, int], point: Vector) -> Reflections:
    """All the reflection points of a point, as an eye's image of `size` (width, height) shows them.

    Raises
    ------
    AnamorphError
        As `reflection_points`.
    """
    points = np.array([point])
    found = reflection_points(scene, eye, points, size)
    assert found.image is not None
    hidden = ~visible(scene, eye, size, points, found)
    rows = [
        Reflection(
            name=scene.meshes[found.mesh[row]].name,
            position=tuple_of(found.position[row]),
            pixel=(float(x / w), float(y / w)) if w > 0.0 else None,
            length=float(found.length[row]),
            order=int(found.order[row]),
            hidden=bool(hidden[row]),
        )
        for row in np.argsort(found.length, kind="stable")
        for x, y, w in (found.image[row],)
    ]
    return Reflections(point, eye.position, ReflectionStatus(found.point_status[0]), tuple(rows))


def vertex_counts(scene: Scene, eye: Camera, size: tuple[int, int]) -> tuple[np.ndarray, ...]:
    """How often the eye sees each vertex of each diffuse mesh in mirrors: (V,) int64 for each mesh of the scene.

    What is hidden does not count: `size` (width, height) is that of the eye's image, as for `visible`. Of mirrors and
    lenses themselves, which are not looked for, it is 0.

    Raises
    ------
    AnamorphError
        As `reflection_points`.
    """
    diffuse = [np.zeros((0, 3)) if mesh.specular else np.asarray(mesh.positions, float) for mesh in scene.meshes]
    # Vertices stand at one place where faces meet at an edge.
    points, places = np.unique(np.concatenate(diffuse), axis=0, return_inverse=True)
    found = reflection_points(scene, eye, points)
    seen = found.point[visible(scene, eye, size, points, found)]
    counts = np.bincount(seen, minlength=len(points))[places.reshape(-1)]
    parts = iter(np.split(counts, np.cumsum([len(each) for each in diffuse])[:-1]))
    return tuple(
        np.zeros(len(mesh.positions), np.int64) if mesh.specular else part
        for mesh, part in zip(scene.meshes, parts, strict=True)
    )


def visible(
    scene: Scene, eye: Camera, size: tuple[int, int], points: np.ndarray, found: ReflectionPoints
) -> np.ndarray:
    """Whether nothing stands in the paths over reflection points of `points` (N, 3): (M,) bool.

    A ray is cast from the eye to each, and on from there to the point. As in the reference, mirrors have the outlines
    of their exact surfaces in the eye's image of `size` (width, height): else they would hide themselves along seams.
    """
    start = np.broadcast_to(np.asarray(eye.position, float), found.direction.shape)
    records = drain(_tracer(scene, eye, size).tracing(GivenRays(start, found.direction)))
    away = np.linalg.norm(records[:, :3] - found.position, axis=1)
    reach = np.linalg.norm(found.position - start, axis=1)
    leg = np.linalg.norm(points[found.point] - found.position, axis=1)
    return (away <= NEARLY * reach) & (records[:, 11] >= (1.0 - NEARLY) * leg)


@lru_cache(maxsize=1)
def _tracer(scene: Scene, eye: Camera, size: tuple[int, int]) -> PathTracer:
    """Of paths with one bounce."""
    outlined = outlined_scene(scene, eye, size)
    geometry = flatten(outlined)
    return PathTracer(outlined, geometry, Caster(geometry), max_bounces=1)
