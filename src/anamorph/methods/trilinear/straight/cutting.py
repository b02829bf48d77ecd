"""Triangles of the image cut to the neighbourhood of their ray triangle. Compiled.

Near vanishing lines u and v grow without bound. What lies further from the ray triangle than `GUARD` times its size is
cut away, and what lies beyond one of its sides is left out.
"""

from __future__ import annotations

import numpy as np

from anamorph.base.compiled import compiled, inlined
from anamorph.methods.trilinear.straight.swept_sides import IMAGE
from anamorph.methods.trilinear.straight.traces import SECOND, THIRD, TRACE, T, U, V
from anamorph.raytriangle.rows import PACE, SHIFT

Pieces = tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]
"""Place, weights, t and pair, as in `StraightPieces`."""

GUARD = 4.0
"""How far pieces may reach: weights in the image are at least minus this."""

SLIVER = 1e-9
"""A piece that reaches no further into the ray triangle has come there by rounding."""

EYE = 1e-3
"""Where the image's w changes its sign over a ray triangle, pieces are cut at this share of the greatest."""

CORNERS = 8
"""A triangle cut by four lines has seven corners at most."""

MOST = 5
"""Triangles that one may be cut into."""


@inlined
def _beyond_a_side(a: np.ndarray, b: np.ndarray, c: np.ndarray) -> bool:
    beyond_u = a[U] < SLIVER and b[U] < SLIVER and c[U] < SLIVER
    beyond_v = a[V] < SLIVER and b[V] < SLIVER and c[V] < SLIVER
    last = 1.0 - SLIVER
    return beyond_u or beyond_v or (a[U] + a[V] > last and b[U] + b[V] > last and c[U] + c[V] > last)


@inlined
def _inside(row: np.ndarray, point: np.ndarray, line: int) -> float:
    """How far inside one of the lines that pieces are cut by; negative outside."""
    w0, w1, w2 = row[IMAGE + 2], row[IMAGE + 5], row[IMAGE + 8]
    u, v = point[U], point[V]
    rest = 1.0 - u - v
    if line == 3:
        return rest * w0 + u * w1 + v * w2 - EYE * max(abs(w0), max(abs(w1), abs(w2)))
    share = rest * abs(w0) if line == 0 else u * abs(w1) if line == 1 else v * abs(w2)
    return share + GUARD * (rest * abs(w0) + u * abs(w1) + v * abs(w2))


@compiled
def cut_piece(
    row: np.ndarray,
    pair: int,
    a: np.ndarray,
    b: np.ndarray,
    c: np.ndarray,
    polygon: np.ndarray,
    pieces: Pieces,
    used: int,
) -> int:
    """Add what is kept of the triangle of three points of traces to `pieces`; how many those hold then."""
    if _beyond_a_side(a, b, c):
        return used
    for word in range(TRACE):
        polygon[0, 0, word], polygon[0, 1, word], polygon[0, 2, word] = a[word], b[word], c[word]
    before_eye = row[IMAGE + 2] > 0.0 and row[IMAGE + 5] > 0.0 and row[IMAGE + 8] > 0.0
    count, now = 3, 0
    for line in range(3 if before_eye else 4):
        outside = False
        for k in range(count):
            outside = outside or _inside(row, polygon[now, k], line) < 0.0
        if outside:
            count = _cut(row, polygon[now], count, line, polygon[1 - now])
            now = 1 - now
    for k in range(1, count - 1):
        used = _write(row, pair, polygon[now], k, pieces, used)
    return used


@compiled
def _cut(row: np.ndarray, whole: np.ndarray, count: int, line: int, kept: np.ndarray) -> int:
    """What of a convex polygon is inside a line; how many corners that has."""
    result = 0
    for k in range(count):
        here, following = whole[k], whole[(k + 1) % count]
        at_here, at_following = _inside(row, here, line), _inside(row, following, line)
        if at_here >= 0.0:
            for word in range(TRACE):
                kept[result, word] = here[word]
            result += 1
        if (at_here >= 0.0) != (at_following >= 0.0):
            share = at_here / (at_here - at_following)
            for word in range(TRACE):
                kept[result, word] = (1.0 - share) * here[word] + share * following[word]
            result += 1
    return result


@compiled
def _write(
    row: np.ndarray,
    pair: int,
    polygon: np.ndarray,
    k: int,
    pieces: Pieces,
    used: int,
) -> int:
    """Add the triangle of a polygon's corners 0, k and k + 1."""
    place, weights, t, pairs = pieces
    if _beyond_a_side(polygon[0], polygon[k], polygon[k + 1]):
        return used
    for corner in range(3):
        point = polygon[k + corner - 1 if corner else 0]
        u, v = point[U], point[V]
        rest = 1.0 - u - v
        w = rest * row[IMAGE + 2] + u * row[IMAGE + 5] + v * row[IMAGE + 8]
        for axis in range(2):
            homogeneous = rest * row[IMAGE + axis] + u * row[IMAGE + 3 + axis] + v * row[IMAGE + 6 + axis]
            place[used, corner, axis] = homogeneous / w
        weights[used, corner, 0], weights[used, corner, 1] = point[SECOND], point[THIRD]
        t[used, corner] = (point[T] + row[SHIFT]) * row[PACE]
    pairs[used] = pair
    return used + 1
