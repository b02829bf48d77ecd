"""Three places of the image that stand for the region of a pair: spread over it, and not far outside. Compiled.

A plan's pieces hold the region in which a ray triangle sees a scene triangle, but may hold more: by a margin of pixels,
and where the scene triangle is seen edge-on, much more. Whatever is interpolated on that triangle means nothing there.
So the corners of the pieces are first moved to a place well inside, until their weights on the scene triangle are not
below `OUTSIDE`.
"""

from __future__ import annotations

import numpy as np

from anamorph.base.compiled import compiled, inlined
from anamorph.methods.trilinear.plan import Plan
from anamorph.methods.trilinear.terms import ACROSS, quadratic

OUTSIDE = -0.25
"""The least weight of a scene triangle's corner at a sample, but where `LEAST_EXTENT` asks for more."""

HALVINGS = 6
"""Of a corner's way from the place inside, before it is that place itself."""

STEPS = 8
"""Along a piece's side, in search of a place inside."""

LEAST_EXTENT = 1.0 / 8.0
"""Pixels that samples are apart at least, and the third from the line through the others: slivers may be thinner."""


def samples(plan: Plan, chosen: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Samples of pairs of a plan.

    The first is farthest from the middle of the region, the second farthest from the first, and the third farthest from
    the line through both. They are never in one line, even if the region is.

    Parameters
    ----------
    plan : Plan
    chosen : (S,) int array
        Rows of `plan.pair`.

    Returns
    -------
    place : (S, 3, 2) float64
        In pixels from the ray triangle's center, as are the plan's.
    box : (S, 4) float64
        Least x and y, then greatest, of all pieces of each pair.
    """
    first, stop = np.searchsorted(plan.owner, chosen, "left"), np.searchsorted(plan.owner, chosen, "right")
    place, box = np.empty((len(chosen), 3, 2)), np.empty((len(chosen), 4))
    moved = np.empty((int(3 * (stop - first).max(initial=0)), 2))
    _spread(plan.place.reshape(-1, 2), 3 * first, 3 * stop, plan.terms[chosen], moved, place, box)
    return place, box


@inlined
def _least_weight(terms: np.ndarray, x: float, y: float) -> float:
    """The least of a place's three weights on the scene triangle; far below 0 where that is not seen at all."""
    across = terms[ACROSS] * x + terms[ACROSS + 1] * y + terms[ACROSS + 2]
    least = np.inf
    for i in (0, 6, 12):
        least = min(least, quadratic(terms, i, x, y)[0])
    return least / across if across > 0.0 else -np.inf


@inlined
def _inside(terms: np.ndarray, corners: np.ndarray, first: int, stop: int) -> tuple[float, float]:
    """The middle of some triangles' corners, or, where that is outside, what place in them is most inside."""
    x, y = 0.0, 0.0
    for k in range(first, stop):
        x, y = x + corners[k, 0] / (stop - first), y + corners[k, 1] / (stop - first)
    most = _least_weight(terms, x, y)
    if most >= 0.0:
        return x, y
    for k in range(first, stop, 3):
        for i in range((STEPS + 1) ** 2):
            b, c = i % (STEPS + 1) / STEPS, i // (STEPS + 1) / STEPS
            if b + c > 1.0:
                continue
            a = 1.0 - b - c
            other_x = a * corners[k, 0] + b * corners[k + 1, 0] + c * corners[k + 2, 0]
            other_y = a * corners[k, 1] + b * corners[k + 1, 1] + c * corners[k + 2, 1]
            least = _least_weight(terms, other_x, other_y)
            if least > most:
                x, y, most = other_x, other_y, least
    return x, y


@inlined
def _farthest(corners: np.ndarray, count: int, x: float, y: float) -> tuple[float, float]:
    far_x, far_y, most = x, y, 0.0
    for k in range(count):
        square = (corners[k, 0] - x) ** 2 + (corners[k, 1] - y) ** 2
        if square > most:
            far_x, far_y, most = corners[k, 0], corners[k, 1], square
    return far_x, far_y


@compiled
def _spread(
    corners: np.ndarray,
    first: np.ndarray,
    stop: np.ndarray,
    terms: np.ndarray,
    moved: np.ndarray,
    place: np.ndarray,
    box: np.ndarray,
) -> None:
    for s in range(len(first)):
        count = stop[s] - first[s]
        x0, y0 = _inside(terms[s], corners, first[s], stop[s])
        low_x, low_y, high_x, high_y = x0, y0, x0, y0
        for k in range(count):
            x, y = np.float64(corners[first[s] + k, 0]), np.float64(corners[first[s] + k, 1])
            low_x, high_x, low_y, high_y = min(low_x, x), max(high_x, x), min(low_y, y), max(high_y, y)
            for halved in range(HALVINGS + 1):
                if _least_weight(terms[s], x, y) >= OUTSIDE:
                    break
                share = 0.5 if halved < HALVINGS else 0.0
                x, y = x0 + share * (x - x0), y0 + share * (y - y0)
            moved[k, 0], moved[k, 1] = x, y
        box[s, 0], box[s, 1], box[s, 2], box[s, 3] = low_x, low_y, high_x, high_y
        x1, y1 = _farthest(moved, count, x0, y0)
        x2, y2 = _farthest(moved, count, x1, y1)
        length = np.hypot(x2 - x1, y2 - y1)
        if length < LEAST_EXTENT:
            x2, y2, length = x1 + LEAST_EXTENT, y1, LEAST_EXTENT
        across_x, across_y = (y1 - y2) / length, (x2 - x1) / length
        x3, y3, width = 0.5 * (x1 + x2), 0.5 * (y1 + y2), 0.0
        for k in range(count):
            off = across_x * (moved[k, 0] - x1) + across_y * (moved[k, 1] - y1)
            if abs(off) > abs(width):
                x3, y3, width = moved[k, 0], moved[k, 1], off
        if abs(width) < LEAST_EXTENT:
            more = (LEAST_EXTENT if width >= 0.0 else -LEAST_EXTENT) - width
            x3, y3 = x3 + more * across_x, y3 + more * across_y
        place[s, 0, 0], place[s, 0, 1] = x1, y1
        place[s, 1, 0], place[s, 1, 1] = x2, y2
        place[s, 2, 0], place[s, 2, 1] = x3, y3
