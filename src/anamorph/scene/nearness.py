"""A scene far from the origin, moved near it in float64, before anything of it is rounded to float32."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from anamorph.base.vectors import tuple_of
from anamorph.scene.model import PointLight, Scene
from anamorph.surfaces.similarity import Similarity

FAR = 64.0
"""Float32 errs by a ten-millionth of the distance from the origin: so many times the distance at which mirrors and
lenses are looked at, that is less than 1e-5 radians."""


def origin_of(scene: Scene) -> np.ndarray:
    """The place, (3,) float64, metres, to which the origin belongs: zeros where it is near enough.

    It is in the middle of all mirrors and lenses, or at the eye where there are none, because rays start there. It is
    rounded to a power of two, so that coordinates that are float32 already lose nothing more.
    """
    eye = np.asarray(scene.camera.position, float)
    parts = [np.asarray(mesh.positions, float) for mesh in scene.meshes if mesh.specular and len(mesh.positions)]
    points = np.concatenate(parts or [eye[None]])
    low, high = points.min(axis=0), points.max(axis=0)
    middle, size = (low + high) / 2.0, np.linalg.norm(high - low)
    around = float(np.linalg.norm(eye - middle) + size) or 1.0
    if np.abs(middle).max() <= FAR * around:
        return np.zeros(3)
    grid = 2.0 ** np.floor(np.log2(around))
    return grid * np.round(middle / grid)


def moved_scene(scene: Scene, by: np.ndarray) -> Scene:
    """The scene, its camera and its lights moved along a vector (3,)."""
    if not by.any():
        return scene
    shift = Similarity.shift(by)
    lights = tuple(
        replace(light, position=tuple_of(np.add(light.position, by))) if isinstance(light, PointLight) else light
        for light in scene.lights
    )
    meshes = tuple(mesh.moved(shift) for mesh in scene.meshes)
    return replace(scene, meshes=meshes, camera=scene.camera.moved(by), lights=lights)
