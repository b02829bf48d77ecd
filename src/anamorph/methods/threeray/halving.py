"""Points halved at the median of their widest side, again and again: the order of a tree. Compiled."""

from __future__ import annotations

import numpy as np

from anamorph.base.compiled import compiled
from anamorph.raytriangle.parting import DEEPEST


def halved(points: np.ndarray, most: int, order: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Halve points until each part has `most` at the most, or is in one place.

    Parameters
    ----------
    points : (N, D) float64
        At least one.
    most : int
    order : (M,) int64
        Which points; is put in the order of the parts.

    Returns
    -------
    first, count : (nodes,) int64
        Behind each inner node, whose count is 0, come its halves, each with all that is below it. A part has the points
        order[first] to order[first + count].
    """
    first, count = np.empty((2, 2 * len(order)), np.int64)
    nodes = _halve(points, most, order, first, count, np.empty((DEEPEST, 2), np.int64))
    return first[:nodes].copy(), count[:nodes].copy()


@compiled
def _halve(
    points: np.ndarray,
    most: int,
    order: np.ndarray,
    first: np.ndarray,
    count: np.ndarray,
    waiting: np.ndarray,
) -> int:
    nodes, depth = 0, 1
    waiting[0, 0], waiting[0, 1] = 0, len(order)
    while depth > 0:
        depth -= 1
        start, stop = waiting[depth, 0], waiting[depth, 1]
        axis, widest = 0, 0.0
        for k in range(points.shape[1]):
            low, high = np.inf, -np.inf
            for i in range(start, stop):
                low, high = min(low, points[order[i], k]), max(high, points[order[i], k])
            if high - low > widest:
                axis, widest = k, high - low
        ends = stop - start <= most or widest == 0.0
        first[nodes], count[nodes] = start, stop - start if ends else 0
        nodes += 1
        if not ends:
            middle = (start + stop) // 2
            _select(points, order, start, stop, middle, axis)
            waiting[depth, 0], waiting[depth, 1] = middle, stop
            waiting[depth + 1, 0], waiting[depth + 1, 1] = start, middle
            depth += 2
    return nodes


@compiled
def _select(points: np.ndarray, order: np.ndarray, start: int, stop: int, middle: int, axis: int) -> None:
    """Put what is least along an axis before `middle`: Hoare's selection."""
    low, high = start, stop - 1
    while low < high:
        pivot = points[order[(low + high) // 2], axis]
        i, j = low, high
        while i <= j:
            while points[order[i], axis] < pivot:
                i += 1
            while points[order[j], axis] > pivot:
                j -= 1
            if i <= j:
                order[i], order[j] = order[j], order[i]
                i, j = i + 1, j - 1
        if middle <= j:
            high = j
        elif middle >= i:
            low = i
        else:
            return
