"""Measures of triangles: which way they face, how large they are, and whether they are triangles at all."""

from __future__ import annotations

import numpy as np

SLIVER = 1e-9
"""A triangle is degenerate when twice its area is at most this share of its longest side squared."""


def doubled_areas(positions: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Normals of the triangles, (F, 3) float64, each as long as twice the triangle's area."""
    corners = np.asarray(positions, float)[faces]
    return np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])


def turned_over(positions: np.ndarray, faces: np.ndarray, normals: np.ndarray) -> np.ndarray:
    """Which triangles are wound against the vertices' normals (V, 3), (F,) bool."""
    return np.einsum("fi,fi->f", doubled_areas(positions, faces), np.asarray(normals, float)[faces].sum(axis=1)) < 0.0


def has_area(positions: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Which triangles are more than a point or a line, (F,) bool."""
    corners = np.asarray(positions, float)[faces]
    longest = np.max(np.sum((corners - np.roll(corners, 1, axis=1)) ** 2, axis=2), axis=1, initial=0.0)
    return np.linalg.norm(doubled_areas(positions, faces), axis=1) > SLIVER * longest
