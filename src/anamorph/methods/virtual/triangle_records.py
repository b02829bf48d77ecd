"""The scene's triangles, as met.wgsl reads them."""

from __future__ import annotations

import numpy as np

from anamorph.scene.geometry import Geometry
from anamorph.scene.model import Scene
from anamorph.surfaces.intersection import PATCHES, pack

SCENE_TRIANGLE = np.dtype(
    [
        ("a", "f4", 3), ("specular", "u4"),
        ("b", "f4", 3), ("surface", "u4"),
        ("c", "f4", 3), ("padding", "u4"),
    ]
)  # fmt: skip
"""`SceneTriangle` of met.wgsl."""


def surfaces_of(scene: Scene) -> np.ndarray:
    """A number of each object's surface, (objects + 1,) uint32: one for all patches of a kind, as bodies have them."""
    numbers = np.arange(len(scene.meshes) + 1, dtype=np.uint32)
    for number, mesh in enumerate(scene.meshes, start=1):
        if mesh.specular and mesh.parameters is not None:
            kind, _ = pack(mesh.surface)
            if kind in PATCHES:
                numbers[number] = len(scene.meshes) + 1 + kind
    return numbers


def triangles_of(geometry: Geometry, scene: Scene) -> np.ndarray:
    """The triangles, (F,) of SCENE_TRIANGLE."""
    triangles = np.zeros(len(geometry.faces), SCENE_TRIANGLE)
    corners = geometry.positions[geometry.faces]
    triangles["a"], triangles["b"], triangles["c"] = np.moveaxis(corners, 1, 0)
    triangles["specular"] = np.array([False, *(mesh.specular for mesh in scene.meshes)])[geometry.face_object]
    triangles["surface"] = surfaces_of(scene)[geometry.face_object]
    return triangles
