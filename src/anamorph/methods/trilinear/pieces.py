"""Convex pieces of the image that surely hold all that a pair sees. Compiled.

Over a box a quadratic is at most its tangent at the middle plus a bound on its second-order terms: three half-planes
that hold all that is seen. Cutting a polygon by them makes its box smaller and the bound, which falls with its square,
tighter, so that two or three rounds leave little more than the straight triangle; where they do not, the polygon is
parted in two.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from anamorph.base.compiled import compiled, inlined
from anamorph.methods.trilinear.beams import Beams
from anamorph.methods.trilinear.domains import PADDING
from anamorph.methods.trilinear.polygons import CAPACITY, area, box, cut, span
from anamorph.methods.trilinear.terms import ACROSS, AHEAD, TERMS, bending, is_inside, quadratic, widen

ROUNDS = 4
"""Of cutting before a polygon is parted."""

DEEPEST = 5
"""How often a polygon is halved at most."""

WORTH_PARTING = 400.0
"""Square pixels: a smaller polygon is drawn as it is."""

WORTH_CUTTING = 0.75
"""A round that leaves more than this share of the area is the last one."""

BENT = 0.1
"""A polygon is parted where the bound on some edge's bend is more than this share of its box's extent."""

FEW_SAMPLES = 32
"""Of a polygon that are asked one by one whether they see anything."""


class Workspace(NamedTuple):
    """Arrays to be filled, for one thread."""

    terms: np.ndarray
    """(P, 24) float64"""
    pair: np.ndarray
    """(P, 3) int32: ray triangle (its place in `Beams`), scene triangle, and 1 where it is seen from its front."""
    place: np.ndarray
    """(T, 3, 2) float32: triangles of the image, pixels."""
    owner: np.ndarray
    """(T,) int32: the pair of each."""
    polygons: np.ndarray
    """(DEEPEST + 2, CAPACITY, 2) float64"""
    counts: np.ndarray
    """(DEEPEST + 2,) int64"""
    halvings: np.ndarray
    """(DEEPEST + 2,) int64"""
    spare: np.ndarray
    """(CAPACITY, 2) float64"""
    stack: np.ndarray
    """(64,) int64"""


def make_workspace(pairs: int, pieces: int) -> Workspace:
    """Arrays for so many pairs and pieces."""
    return Workspace(
        np.empty((pairs, TERMS)), np.empty((pairs, 3), np.int32),
        np.empty((pieces, 3, 2), np.float32), np.empty(pieces, np.int32),
        np.empty((DEEPEST + 2, CAPACITY, 2)), np.empty(DEEPEST + 2, np.int64), np.empty(DEEPEST + 2, np.int64),
        np.empty((CAPACITY, 2)), np.empty(64, np.int64),
    )  # fmt: skip


@inlined
def _fit(terms: np.ndarray, polygon: np.ndarray, count: int, spare: np.ndarray) -> tuple[int, bool]:
    """Cut a polygon down to what may be seen in it; whether it is worth parting it after that."""
    size = area(polygon, count)
    for _ in range(ROUNDS):
        x, y, half_x, half_y = box(polygon, count)
        worst = 0.0
        for corner in range(3):
            value, slope_x, slope_y = quadratic(terms, 6 * corner, x, y)
            bend = bending(terms, 6 * corner, half_x, half_y)
            if value + abs(slope_x) * half_x + abs(slope_y) * half_y + bend < 0.0:
                return 0, False
            steepness = np.sqrt(slope_x * slope_x + slope_y * slope_y)
            worst = max(worst, bend / max(steepness, 1e-300))
            offset = value - slope_x * x - slope_y * y + bend + PADDING * steepness
            count = cut(polygon, count, spare, slope_x, slope_y, offset)
            if count == 0:
                return 0, False
        before, size = size, area(polygon, count)
        if size > WORTH_CUTTING * before:
            break
    return count, size > WORTH_PARTING and worst > BENT * max(half_x, half_y)


@inlined
def _holds_sample(terms: np.ndarray, polygon: np.ndarray, count: int, spacing: float) -> bool:
    """Whether a sample of the polygon sees the scene triangle, as far as a few of them can tell."""
    if spacing == 0.0:
        return True
    _, middle, _, half = box(polygon, count)
    asked = 0
    for row in range(int(np.ceil((middle - half) / spacing - 0.5)), int(np.floor((middle + half) / spacing - 0.5)) + 1):
        y = (row + 0.5) * spacing
        low, high = span(polygon, count, y)
        if low > high:
            continue
        for column in range(int(np.ceil(low / spacing - 0.5)), int(np.floor(high / spacing - 0.5)) + 1):
            asked += 1
            if asked > FEW_SAMPLES or is_inside(terms, (column + 0.5) * spacing, y):
                return True
    return False


@inlined
def _copy(polygon: np.ndarray, count: int, into: np.ndarray) -> None:
    for k in range(count):
        into[k, 0], into[k, 1] = polygon[k, 0], polygon[k, 1]


@inlined
def _emit(work: Workspace, polygon: np.ndarray, count: int, pair: int, pieces: int) -> int:
    for k in range(1, count - 1):
        for axis in range(2):
            work.place[pieces, 0, axis] = polygon[0, axis]
            work.place[pieces, 1, axis] = polygon[k, axis]
            work.place[pieces, 2, axis] = polygon[k + 1, axis]
        work.owner[pieces] = pair
        pieces += 1
    return pieces


@compiled
def find_pieces(beams: Beams, k: int, work: Workspace, pair: int, pieces: int) -> int:
    """Add the pieces of a pair whose terms are known; their number with those before, or -1 where they do not fit."""
    terms = work.terms[pair]
    _copy(beams.domain[k], beams.corners[k], work.polygons[0])
    first = work.polygons[0]
    count = beams.corners[k]
    x, y, half_x, half_y = beams.extent[k]
    widen(terms, abs(x) + half_x, abs(y) + half_y)
    for side in (ACROSS, AHEAD):
        a, b = terms[side], terms[side + 1]
        count = cut(first, count, work.spare, a, b, terms[side + 2] + PADDING * np.sqrt(a * a + b * b))
    if count == 0:
        return pieces
    work.counts[0], work.halvings[0] = count, 0
    waiting = 1
    while waiting > 0:
        waiting -= 1
        polygon, halved = work.polygons[waiting], work.halvings[waiting]
        count, parts = _fit(terms, polygon, work.counts[waiting], work.spare)
        if count == 0:
            continue
        if not parts or halved == DEEPEST:
            if not _holds_sample(terms, polygon, count, beams.spacing):
                continue
            if pieces + count > len(work.owner):
                return -1
            pieces = _emit(work, polygon, count, pair, pieces)
            continue
        x, y, half_x, half_y = box(polygon, count)
        other = work.polygons[waiting + 1]
        _copy(polygon, count, other)
        a, b = (1.0, 0.0) if half_x > half_y else (0.0, 1.0)
        middle = a * x + b * y
        work.counts[waiting] = cut(polygon, count, work.spare, a, b, PADDING - middle)
        work.counts[waiting + 1] = cut(other, count, work.spare, -a, -b, PADDING + middle)
        work.halvings[waiting], work.halvings[waiting + 1] = halved + 1, halved + 1
        waiting += 2
    return pieces
