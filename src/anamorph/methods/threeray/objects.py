"""What the objects of a scene do to light, and to the rays that leave them."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from anamorph.methods.tracing.bounces import DIFFUSE, GLASS, MIRROR
from anamorph.scene.model import Glass, Mirror, Scene
from anamorph.surfaces.intersection import NONE, PATCHES, PLANE, pack


class Materials(NamedTuple):
    """What the scene's objects do to light and to rays that leave them; row 0 is the sky's, and is never read."""

    kind: np.ndarray
    """(objects + 1,) int64: DIFFUSE, MIRROR or GLASS."""
    tint: np.ndarray
    """(objects + 1, 3) float64"""
    reflectance: np.ndarray
    """(objects + 1,) float64: of mirrors."""
    surface: np.ndarray
    """(objects + 1,) int64: the same number for the patches of one kind, of which bodies are made border to border."""
    curved: np.ndarray
    """(objects + 1,) bool: whether the exact surface lies off the triangles."""


def materials_of(scene: Scene) -> Materials:
    """The materials of a scene's meshes."""
    count = len(scene.meshes) + 1
    kind, curved = np.full(count, DIFFUSE, np.int64), np.zeros(count, bool)
    tint, reflectance, surface = np.ones((count, 3)), np.zeros(count), np.arange(count)
    for number, mesh in enumerate(scene.meshes, start=1):
        match mesh.material:
            case Mirror(tint=color, reflectance=share):
                kind[number], tint[number], reflectance[number] = MIRROR, color, share
            case Glass(tint=color):
                kind[number], tint[number] = GLASS, color
        if mesh.specular and mesh.parameters is not None:
            form, _ = pack(mesh.surface)
            curved[number] = form not in (NONE, PLANE)
            surface[number] = count + form if form in PATCHES else number
    return Materials(kind, tint, reflectance, surface, curved)
