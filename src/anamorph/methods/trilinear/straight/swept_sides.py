"""Rows of ray triangles, with what their edges sweep and their images behind the numbers of `raytriangle.rows`.

The edge between the rays i and j sweeps a surface. With r_i(t), r_j(t) its ends, the line through a and b meets the
line between them where (Vallance 2005, 5.2, derived again)

    det(b - a, r_i - a, r_j - a) = (b - a) . (r_i x r_j) + ((b - a) x a) . (r_i - r_j) = 0,

which is quadratic in t; its vectors that do not depend on a and b are kept here.
"""

from __future__ import annotations

import numpy as np

from anamorph.raytriangle.rows import WIDTH, packed
from anamorph.raytriangle.scaled import SPREAD, scaled_rays

SIDES, SIDE = WIDTH, 15
"""For each edge, named by the ray opposite: r_i x r_j by powers of t, then r_i - r_j."""

IMAGE = SIDES + 3 * SIDE
"""(x w, y w, w) of the three corners."""


def straight_rows(image: np.ndarray, origins: np.ndarray, directions: np.ndarray) -> np.ndarray:
    """Rows (K, 100) float64 of K ray triangles (K, 3, 3) with homogeneous image corners (K, 3, 3)."""
    rays = scaled_rays(origins, directions)
    starts = SPREAD.T @ rays.origins
    changes = SPREAD.T @ rays.directions + rays.mean[:, None]
    swept = [_swept(starts, changes, edge) for edge in range(3)]
    return np.concatenate(
        [packed(rays), *(part.reshape(-1, SIDE) for part in swept), np.reshape(image, (-1, 9)).astype(float)], axis=1
    )


def _swept(starts: np.ndarray, changes: np.ndarray, edge: int) -> np.ndarray:
    i, j = (edge + 1) % 3, (edge + 2) % 3
    p, q, m, n = starts[:, i], starts[:, j], changes[:, i], changes[:, j]
    crossed = [np.cross(p, q), np.cross(p, n) + np.cross(m, q), np.cross(m, n)]
    return np.stack([*crossed, p - q, m - n], axis=1)
