"""The strip between the two traces of a shape as triangles. Compiled.

At every t what is seen between the traces is a straight line in u and v, since the plane of the scene triangle cuts the
parametric triangle in one. All these lines go through one point, to which the ray belongs that lies in that plane, and
cross nowhere else. So the points of both traces in the order of t make the triangles, and what lies between two levels
that both traces have is filled exactly. A shape of two corners and nothing between has no area: the thesis draws a line
for it, this draws nothing.
"""

from __future__ import annotations

import math

import numpy as np

from anamorph.base.compiled import compiled, inlined
from anamorph.methods.trilinear.straight.cutting import Pieces, cut_piece
from anamorph.methods.trilinear.straight.traces import TRACE, T, U, V


@compiled
def strip(
    row: np.ndarray,
    pair: int,
    traces: np.ndarray,
    lefts: int,
    rights: int,
    one_start: bool,
    one_end: bool,
    polygon: np.ndarray,
    pieces: Pieces,
    used: int,
) -> int:
    """Add the triangles between traces (2, N, 5) to `pieces`; how many those hold then.

    `one_start` and `one_end` say whether both traces begin, or end, in the same point. `polygon` (3, 8, 5) is work
    space. `pieces` are the arrays place, weights, t and pair of `StraightPieces`.
    """
    i, j = 0, 0
    while i < lefts - 1 or j < rights - 1:
        here, there = traces[0, i], traces[1, j]
        next_here, next_there = math.inf, math.inf
        if i < lefts - 1:
            next_here = traces[0, i + 1, T]
        if j < rights - 1:
            next_there = traces[1, j + 1, T]
        opened = not (one_start and i == 0 and j == 0)
        if next_here == next_there:
            i, j = i + 1, j + 1
            above, across = traces[0, i], traces[1, j]
            if one_end and i == lefts - 1 and j == rights - 1:
                if opened:
                    used = cut_piece(row, pair, here, there, above, polygon, pieces, used)
            elif opened:
                used = _between_levels(row, pair, here, there, above, across, polygon, pieces, used)
            else:
                used = cut_piece(row, pair, here, across, above, polygon, pieces, used)
        elif next_here < next_there:
            i += 1
            if opened:
                used = cut_piece(row, pair, here, there, traces[0, i], polygon, pieces, used)
        else:
            j += 1
            if opened:
                used = cut_piece(row, pair, here, there, traces[1, j], polygon, pieces, used)
    return used


@inlined
def _area(a: np.ndarray, b: np.ndarray, c: np.ndarray) -> float:
    """Twice the area of a triangle in u and v, negative where it is clockwise."""
    return (b[U] - a[U]) * (c[V] - a[V]) - (b[V] - a[V]) * (c[U] - a[U])


@compiled
def _between_levels(
    row: np.ndarray,
    pair: int,
    here: np.ndarray,
    there: np.ndarray,
    above: np.ndarray,
    across: np.ndarray,
    polygon: np.ndarray,
    pieces: Pieces,
    used: int,
) -> int:
    """Add what lies between the level from `here` to `there` and the next one, from `above` to `across`.

    It is divided by the diagonal that is inside it; where two opposite sides cross each other, at the crossing.
    """
    last, first = _area(here, there, across), _area(here, across, above)
    early, late = _area(here, there, above), _area(there, across, above)
    if last * first >= 0.0:
        used = cut_piece(row, pair, here, there, across, polygon, pieces, used)
        return cut_piece(row, pair, here, across, above, polygon, pieces, used)
    if early * late >= 0.0:
        used = cut_piece(row, pair, here, there, above, polygon, pieces, used)
        return cut_piece(row, pair, there, across, above, polygon, pieces, used)
    middle = polygon[2, 0]
    if early * last < 0.0:
        # The levels cross at the ray that lies in the scene triangle's plane.
        _crossing(here, there, first / (first - late), above, across, early / (early - last), middle)
        used = cut_piece(row, pair, here, middle, above, polygon, pieces, used)
        return cut_piece(row, pair, middle, there, across, polygon, pieces, used)
    _crossing(here, above, last / (last - late), there, across, early / (early - first), middle)
    used = cut_piece(row, pair, here, there, middle, polygon, pieces, used)
    return cut_piece(row, pair, middle, across, above, polygon, pieces, used)


@compiled
def _crossing(
    a: np.ndarray, b: np.ndarray, share: float, c: np.ndarray, d: np.ndarray, other: float, middle: np.ndarray
) -> None:
    """Into `middle`, the point at `share` from a to b, and at `other` from c to d: the mean of what they say."""
    for word in range(TRACE):
        on_one = a[word] + share * (b[word] - a[word])
        on_other = c[word] + other * (d[word] - c[word])
        middle[word] = 0.5 * (on_one + on_other)
