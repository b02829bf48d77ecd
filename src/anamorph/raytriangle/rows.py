"""Scaled ray triangles as rows of numbers, which compiled loops read."""

from __future__ import annotations

import math

import numpy as np

from anamorph.base.compiled import inlined
from anamorph.base.vectors import Vector, along
from anamorph.raytriangle.scaled import ScaledRays

CENTER, REMAINDER, SIZE, PACE, SHIFT = 0, 3, 6, 7, 8
"""Where in a row each number, or the first of three or more, is; as the fields of `ScaledRays`."""

START, CHANGE, MEAN, PLANES = 9, 15, 21, 24
"""Both differences of the origins; both of the directions; the mean direction; N0, N1, N2."""

EXTENT, BLUR, NOISE, FLAT = 33, 34, 35, 36

MIDDLE, LENGTHS, LINES = 37, 40, 44
"""m . N0, m . N1, m . N2; the lengths of the two differences of origins and the two of directions; t of `lines`."""

WIDTH = 46


def packed(rays: ScaledRays) -> np.ndarray:
    """Rows (K, 46) float64 of K ray triangles."""
    rows = np.zeros((len(rays.size), WIDTH))
    for first, numbers in (
        (CENTER, rays.center),
        (REMAINDER, rays.remainder),
        (SIZE, rays.size),
        (PACE, rays.pace),
        (SHIFT, rays.shift),
        (START, rays.origins),
        (CHANGE, rays.directions),
        (MEAN, rays.mean),
        (PLANES, rays.planes),
        (EXTENT, rays.extent),
        (BLUR, rays.blur),
        (NOISE, rays.noise),
        (FLAT, rays.flat),
        (MIDDLE, np.einsum("ni,nki->nk", rays.mean, rays.planes)),
        (LENGTHS, np.linalg.norm(np.concatenate([rays.origins, rays.directions], axis=1), axis=2)),
        (LINES, np.sort(rays.lines, axis=1)),
    ):
        width = math.prod(numbers.shape[1:])
        rows[:, first : first + width] = numbers.reshape(len(rows), width)
    return rows


@inlined
def three(row: np.ndarray, first: int) -> Vector:
    """Three numbers of a row."""
    return row[first], row[first + 1], row[first + 2]


@inlined
def normal(row: np.ndarray, t: float) -> Vector:
    """N(t)."""
    return along(three(row, PLANES), t, along(three(row, PLANES + 3), t, three(row, PLANES + 6)))


@inlined
def local(row: np.ndarray, x: float, y: float, z: float) -> Vector:
    """A world point in the scaled units of the row."""
    size = row[SIZE]
    return (
        ((x - row[CENTER]) - row[REMAINDER]) / size,
        ((y - row[CENTER + 1]) - row[REMAINDER + 1]) / size,
        ((z - row[CENTER + 2]) - row[REMAINDER + 2]) / size,
    )
