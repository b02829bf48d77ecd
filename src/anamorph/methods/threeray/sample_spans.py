"""The samples of a camera whose weights are within bounds: a polygon of up to six sides in the image. Compiled.

Its rows come from its corners, and the columns of each row from its sides, which are lines in the image.
"""

from __future__ import annotations

import math

import numpy as np

from anamorph.base.compiled import inlined
from anamorph.base.vectors import Vector
from anamorph.raytriangle.bounds import Range
from anamorph.raytriangle.owners import EDGE

MARGIN = 1e-6
"""Samples by which the polygon is widened, and weights by which its corners may be beyond a bound."""

WIDER = 2.0 * EDGE
"""Weights by which its sides are moved outward: a camera owns samples whose weights are a little below 0."""


@inlined
def rows_within(image: np.ndarray, low: Vector, high: Vector, first: int, stop: int) -> tuple[int, int]:
    """The first row with samples whose weights are within bounds, and the last one and one; of a part behind the eye,
    all.

    Parameters
    ----------
    image : (3, 3) float64
        A camera's corners: see `Cameras`.
    low, high : (3,) tuples
        The least and the greatest weights.
    first, stop : int
        The camera's own rows.
    """
    if min(image[0, 2], image[1, 2], image[2, 2]) <= 0.0:
        return first, stop
    least, most = math.inf, -math.inf
    for free in range(3):
        one, other = (free + 1) % 3, (free + 2) % 3
        for ends in range(4):
            w_one = high[one] if ends & 1 else low[one]
            w_other = high[other] if ends & 2 else low[other]
            w_free = 1.0 - w_one - w_other
            if low[free] - MARGIN <= w_free <= high[free] + MARGIN:
                y = w_one * image[one, 1] + w_other * image[other, 1] + w_free * image[free, 1]
                y /= w_one * image[one, 2] + w_other * image[other, 2] + w_free * image[free, 2]
                least, most = min(least, y), max(most, y)
    if not least <= most:
        return first, first
    return math.ceil(max(least - MARGIN, float(first))), math.floor(min(most + MARGIN, stop - 1.0)) + 1


@inlined
def columns_within(weights: np.ndarray, row: int, low: Vector, high: Vector, count: int) -> tuple[int, int]:
    """The first column with samples whose weights are within bounds, and the last one and one.

    Parameters
    ----------
    weights : (3, 3) float64
        See `Places`.
    row : int
        From the first one of the camera's box.
    low, high : (3,) tuples
        The least and the greatest weights.
    count : int
        Columns of the box.
    """
    w, y = weights, float(row)
    sum_x, total = w[0, 0] + w[1, 0] + w[2, 0], w[0, 2] + w[1, 2] + w[2, 2]
    total += (w[0, 1] + w[1, 1] + w[2, 1]) * y
    left, right = 0.0, count - 1.0
    for i in range(3):
        at = w[i, 1] * y + w[i, 2]
        least, most = low[i] - WIDER, high[i] + WIDER
        left, right = _cut(w[i, 0] - least * sum_x, at - least * total, left, right)
        if high[i] < 1.0:
            left, right = _cut(most * sum_x - w[i, 0], most * total - at, left, right)
    if not left <= right + MARGIN:
        return 0, 0
    return max(0, math.ceil(left - MARGIN)), min(count, math.floor(right + MARGIN) + 1)


@inlined
def _cut(slope: float, value: float, left: float, right: float) -> Range:
    """Where between left and right slope x + value is not negative."""
    if slope > 0.0:
        return max(left, -value / slope), right
    if slope < 0.0:
        return left, min(right, -value / slope)
    return (left, right) if value >= 0.0 else (right + 1.0, right)
