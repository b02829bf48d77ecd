"""Ray triangles as rows of numbers that compiled loops read: their frames, their pictures, and what their edges sweep.

A point lies in the plane of the parametric triangle at t where (point - t m) . N(t) = 0, as `coefficients` has it. The
edge between the rays i and j sweeps a surface. With r_i(t), r_j(t) its ends, the line through a and b meets the line
between them where (5.2 of the thesis, derived again)

    det(b - a, r_i - a, r_j - a) = (b - a) . (r_i x r_j) + ((b - a) x a) . (r_i - r_j) = 0,

which is quadratic in t; its vectors that do not depend on a and b are kept here.
"""

from __future__ import annotations

import math

import numpy as np

from anamorph.base.compiled import inlined
from anamorph.raytriangle.coefficients import SPREAD, RayTriangleFrame

Vector = tuple[float, float, float]

CENTER, REMAINDER, SIZE, PACE, SHIFT = 0, 3, 6, 7, 8
"""Where in a row each number, or the first of three or more, is; as the fields of `RayTriangleFrame`."""

START, CHANGE, MEAN, PLANES = 9, 15, 21, 24
"""Both differences of the origins; both of the directions; the mean direction; N0, N1, N2."""

EXTENT, BLUR, NOISE, FLAT = 33, 34, 35, 36

MIDDLE, LENGTHS, LINES = 37, 40, 44
"""m . N0, m . N1, m . N2; the lengths of the two differences of origins and the two of directions; t of `lines`."""

SIDES, SIDE = 46, 15
"""For each edge, named by the ray opposite: r_i x r_j by powers of t, then r_i - r_j."""

PICTURE = 91
"""(x w, y w, w) of the three corners."""

WIDTH = 100


def packed(frame: RayTriangleFrame, picture: np.ndarray) -> np.ndarray:
    """Rows (K, 100) float64 of K ray triangles with homogeneous picture corners (K, 3, 3)."""
    rows = np.zeros((len(picture), WIDTH))
    starts = SPREAD.T @ frame.origins
    changes = SPREAD.T @ frame.directions + frame.mean[:, None]
    for first, numbers in (
        (CENTER, frame.center),
        (REMAINDER, frame.remainder),
        (SIZE, frame.size),
        (PACE, frame.pace),
        (SHIFT, frame.shift),
        (START, frame.origins),
        (CHANGE, frame.directions),
        (MEAN, frame.mean),
        (PLANES, frame.planes),
        (EXTENT, frame.extent),
        (BLUR, frame.blur),
        (NOISE, frame.noise),
        (FLAT, frame.flat),
        (MIDDLE, np.einsum("ni,nki->nk", frame.mean, frame.planes)),
        (LENGTHS, np.linalg.norm(np.concatenate([frame.origins, frame.directions], axis=1), axis=2)),
        (LINES, np.sort(frame.lines, axis=1)),
        (PICTURE, picture),
        *((SIDES + SIDE * edge, _swept(starts, changes, edge)) for edge in range(3)),
    ):
        width = math.prod(numbers.shape[1:])
        rows[:, first : first + width] = numbers.reshape(len(rows), width)
    return rows


def _swept(starts: np.ndarray, changes: np.ndarray, edge: int) -> np.ndarray:
    i, j = (edge + 1) % 3, (edge + 2) % 3
    p, q, m, n = starts[:, i], starts[:, j], changes[:, i], changes[:, j]
    crossed = [np.cross(p, q), np.cross(p, n) + np.cross(m, q), np.cross(m, n)]
    return np.stack([*crossed, p - q, m - n], axis=1)


@inlined
def three(row: np.ndarray, first: int) -> Vector:
    """Three numbers of a row."""
    return row[first], row[first + 1], row[first + 2]


@inlined
def dot(a: Vector, b: Vector) -> float:
    """Scalar product."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@inlined
def cross(a: Vector, b: Vector) -> Vector:
    """Vector product."""
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


@inlined
def plus(a: Vector, t: float, b: Vector) -> Vector:
    """a + t b."""
    return a[0] + t * b[0], a[1] + t * b[1], a[2] + t * b[2]


@inlined
def normal(row: np.ndarray, t: float) -> Vector:
    """N(t)."""
    return plus(three(row, PLANES), t, plus(three(row, PLANES + 3), t, three(row, PLANES + 6)))


@inlined
def local(row: np.ndarray, x: float, y: float, z: float) -> Vector:
    """A world point in the frame of the row."""
    size = row[SIZE]
    return (
        ((x - row[CENTER]) - row[REMAINDER]) / size,
        ((y - row[CENTER + 1]) - row[REMAINDER + 1]) / size,
        ((z - row[CENTER + 2]) - row[REMAINDER + 2]) / size,
    )
