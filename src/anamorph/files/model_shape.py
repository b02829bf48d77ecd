"""What a model file holds before it is placed: a shape in coordinates of its own, and what it looks like."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from anamorph.scene.model import Material


@dataclass(frozen=True, eq=False)
class ModelShape:
    """Triangles of one material, as a file has them.

    Parameters
    ----------
    name : str
    positions : (V, 3) float64
    faces : (F, 3) int64
    normals : (V, 3) float64 or None
        Of any length; None where the file has none.
    matrix : (4, 4) float64
        From these coordinates to the world's.
    material : Diffuse, Mirror or Glass
    material_name : str
        "" for none.
    texcoords : (V, 2) float64 or None
        From the top left.
    colors : (V, 3) float64 or None
        Linear.
    """

    name: str
    positions: np.ndarray
    faces: np.ndarray
    normals: np.ndarray | None
    matrix: np.ndarray
    material: Material
    material_name: str
    texcoords: np.ndarray | None
    colors: np.ndarray | None


def cofactors(matrices: np.ndarray) -> np.ndarray:
    """What normals are multiplied by where points are multiplied by `matrices` (..., 3, 3), up to positive factors."""
    rows = [np.cross(matrices[..., (row + 1) % 3, :], matrices[..., (row + 2) % 3, :]) for row in range(3)]
    sign = np.where(np.linalg.det(matrices) >= 0.0, 1.0, -1.0)
    return sign[..., None, None] * np.stack(rows, axis=-2)
