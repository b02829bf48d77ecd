"""What of the paths over reflection points, or through lenses, nothing hides."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from anamorph.base.steps import drain
from anamorph.methods.tracing import GivenRays, PathTracer
from anamorph.optics.tessellation import outlined_scene
from anamorph.rays.caster import Caster
from anamorph.reflections.reflection_points import ReflectionPoints
from anamorph.reflections.refraction_points import RefractionPoints
from anamorph.scene.camera import Camera
from anamorph.scene.geometry import flatten
from anamorph.scene.model import Scene

NEARLY = 1e-3
"""How much of a leg of a path may be missing before something hides its end, as a share of the leg: pixels tell of a
point in float32, and the triangles of a mesh lie beside its exact surface."""


def visible(
    scene: Scene,
    eye: Camera,
    points: np.ndarray,
    found: ReflectionPoints | RefractionPoints,
    size: tuple[int, int] = (1024, 768),
) -> np.ndarray:
    """Whether nothing stands in the paths over reflection points, or in those through lenses.

    A ray is cast from the eye to each, and on from there to the point. As in the reference, mirrors and lenses have the
    outlines of their exact surfaces in the eye's image: else they would hide themselves along seams.

    Parameters
    ----------
    scene : Scene
    eye : Camera
    points : (N, 3) float64
        Metres.
    found : ReflectionPoints or RefractionPoints
        Of these points, for this eye.
    size : (width, height)
        Of its image, pixels.

    Returns
    -------
    (M,) bool
    """
    ends = found.position if found.position.ndim == 3 else found.position[:, None]
    start = np.broadcast_to(np.asarray(eye.position, float), found.direction.shape)
    records = drain(_tracer(scene, eye, size, ends.shape[1]).tracing(GivenRays(start, found.direction)))
    legs = np.linalg.norm(np.diff(np.concatenate([start[:, None], ends], axis=1), axis=1), axis=2)
    away = np.linalg.norm(records[:, :3] - ends[:, -1], axis=1)
    last = np.linalg.norm(np.asarray(points, float)[found.point] - ends[:, -1], axis=1)
    return (away <= NEARLY * legs[:, 0]) & (records[:, 11] >= (1.0 - NEARLY) * last)


@lru_cache(maxsize=2)
def _tracer(scene: Scene, eye: Camera, size: tuple[int, int], bounces: int) -> PathTracer:
    """Of paths with so many bounces: one on a mirror, two through a lens."""
    outlined = outlined_scene(scene, eye, size)
    geometry = flatten(outlined)
    return PathTracer(outlined, geometry, Caster(geometry), max_bounces=bounces)
