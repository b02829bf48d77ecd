"""Three places of the image that stand for the samples which see a pair, and are spread over them. Compiled."""

from __future__ import annotations

import numpy as np

from anamorph.base.compiled import compiled, inlined

LEAST_EXTENT = 1.0 / 8.0
"""Samples that the three are apart at least, and the third from the line through the others."""


def spread(place: np.ndarray, first: np.ndarray, stop: np.ndarray) -> np.ndarray:
    """Three places for each of some groups of places, (S, 3, 2) float64.

    The first is farthest from the middle of the group, the second farthest from the first, and the third farthest from
    the line through both. They are never in one line, even if the group is.

    Parameters
    ----------
    place : (M, 2) float64
    first, stop : (S,) int64
        The places of each group, one at least.
    """
    three = np.empty((len(first), 3, 2))
    _spread(place, first, stop, three)
    return three


@inlined
def _farthest(place: np.ndarray, first: int, stop: int, x: float, y: float) -> tuple[float, float]:
    far_x, far_y, most = x, y, 0.0
    for k in range(first, stop):
        square = (place[k, 0] - x) ** 2 + (place[k, 1] - y) ** 2
        if square > most:
            far_x, far_y, most = place[k, 0], place[k, 1], square
    return far_x, far_y


@compiled
def _spread(place: np.ndarray, first: np.ndarray, stop: np.ndarray, three: np.ndarray) -> None:
    for s in range(len(first)):
        x0, y0 = 0.0, 0.0
        for k in range(first[s], stop[s]):
            x0, y0 = x0 + place[k, 0] / (stop[s] - first[s]), y0 + place[k, 1] / (stop[s] - first[s])
        x1, y1 = _farthest(place, first[s], stop[s], x0, y0)
        x2, y2 = _farthest(place, first[s], stop[s], x1, y1)
        length = np.hypot(x2 - x1, y2 - y1)
        if length < LEAST_EXTENT:
            x2, y2, length = x1 + LEAST_EXTENT, y1, LEAST_EXTENT
        across_x, across_y = (y1 - y2) / length, (x2 - x1) / length
        x3, y3, width = 0.5 * (x1 + x2), 0.5 * (y1 + y2), 0.0
        for k in range(first[s], stop[s]):
            off = across_x * (place[k, 0] - x1) + across_y * (place[k, 1] - y1)
            if abs(off) > abs(width):
                x3, y3, width = place[k, 0], place[k, 1], off
        if abs(width) < LEAST_EXTENT:
            more = (LEAST_EXTENT if width >= 0.0 else -LEAST_EXTENT) - width
            x3, y3 = x3 + more * across_x, y3 + more * across_y
        three[s, 0, 0], three[s, 0, 1] = x1, y1
        three[s, 1, 0], three[s, 1, 1] = x2, y2
        three[s, 2, 0], three[s, 2, 1] = x3, y3
