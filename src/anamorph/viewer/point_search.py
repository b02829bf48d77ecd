"""Where mirrors and lenses show points to an eye, and what of that is hidden: all that the viewer asks of them."""

from __future__ import annotations

import numpy as np

from anamorph.base.errors import AnamorphError
from anamorph.base.vectors import Vector, tuple_of
from anamorph.reflections.open_paths import visible
from anamorph.reflections.reflection_points import ReflectionPoints, ReflectionStatus, reflection_points
from anamorph.reflections.refraction_points import RefractionPoints, refraction_points
from anamorph.scene.camera import Camera
from anamorph.scene.lens_pairs import lens_pairs
from anamorph.scene.model import Mirror, Scene
from anamorph.viewer.facts import Reflection, Reflections


def reflections_of(scene: Scene, eye: Camera, size: tuple[int, int], point: Vector) -> Reflections:
    """All the reflection points and refraction points of a point, in an eye's image of `size` (width, height).

    Raises
    ------
    AnamorphError
        As `reflection_points`.
    """
    points, rows, status = np.array([point]), [], ReflectionStatus.FOUND
    for found in _all_found(scene, eye, size, points):
        assert found.image is not None
        status = max(status, ReflectionStatus(found.point_status[0]))
        seen = visible(scene, eye, points, found, size)
        rows += [
            Reflection(
                name=scene.meshes[np.atleast_1d(found.mesh[row])[0]].name,
                path=tuple(tuple_of(place) for place in np.atleast_2d(found.position[row])),
                pixel=(float(x / w), float(y / w)) if w > 0.0 else None,
                length=float(found.length[row]),
                order=int(found.order[row]),
                hidden=not seen[row],
            )
            for row, (x, y, w) in enumerate(found.image)
        ]
    return Reflections(point, eye.position, status, tuple(sorted(rows, key=lambda each: each.length)))


def vertex_counts(scene: Scene, eye: Camera, size: tuple[int, int]) -> tuple[np.ndarray, ...]:
    """How often the eye sees each vertex of each diffuse mesh in mirrors and through lenses: (V,) int64 for each mesh.

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
    seen = [found.point[visible(scene, eye, points, found, size)] for found in _all_found(scene, eye, size, points)]
    counts = np.bincount(np.concatenate(seen), minlength=len(points))[places.reshape(-1)]
    parts = iter(np.split(counts, np.cumsum([len(each) for each in diffuse])[:-1]))
    return tuple(
        np.zeros(len(mesh.positions), np.int64) if mesh.specular else part
        for mesh, part in zip(scene.meshes, parts, strict=True)
    )


def _all_found(
    scene: Scene, eye: Camera, size: tuple[int, int], points: np.ndarray
) -> list[ReflectionPoints | RefractionPoints]:
    """What mirrors show of points (N, 3), and what lenses do."""
    found: list[ReflectionPoints | RefractionPoints] = []
    if any(isinstance(mesh.material, Mirror) for mesh in scene.meshes):
        found.append(reflection_points(scene, eye, points, size))
    if lens_pairs(scene.meshes):
        found.append(refraction_points(scene, eye, points, size))
    if not found:
        raise AnamorphError(f"scene '{scene.name}': has no mirror and no lens; give a part the material mirror")
    return found
