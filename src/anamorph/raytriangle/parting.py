"""Boxes parted where rays meet the fewest of them, again and again: the nodes of a tree, and their boxes. Compiled.

A ray that meets a box meets another inside of it with the ratio of their surfaces. Of the cuts across the three axes,
at equal distances, the one is made that has rays meet the fewest boxes in both sides together.

Nodes are in the order in which they are met: behind an inner node come its two halves, each with all that is below it.

Source: MacDonald and Booth, "Heuristics for ray tracing using space subdivision" (1990), sections 3 and 4.
"""

from __future__ import annotations

import numpy as np

from anamorph.base.compiled import compiled

DEEPEST = 64
"""Parts that wait for their turn, at most."""

SLICES = 16
"""Between which the cuts across an axis are."""

NODE = 2.0
"""What it costs to ask whether a ray meets a node, in boxes of a part."""

PAD, ROUNDING = 1e-9, 1e-12
"""By how much leaves' boxes are widened, as shares of their sides and of all coordinates: more than all levels lose by
rounding."""

Cut = tuple[float, int, float, float, int]
"""What the sides cost, in boxes times surface; the axis, -1 for none; where the slices begin; how many there are in a
metre; and the last one before the cut."""


def parted(low: np.ndarray, high: np.ndarray, most: int, order: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Part boxes until each part has `most` at the most, and no cut makes rays meet fewer; or all are in one place.

    Parameters
    ----------
    low, high : (N, 3) float64
        Ends of the boxes, at least one.
    most : int
    order : (M,) int64
        Which boxes; is put in the order of the parts.

    Returns
    -------
    first, count : (nodes,) int64
        A part has the boxes order[first] to order[first + count]; an inner node's count is 0.
    """
    first, count = np.empty((2, 2 * len(order)), np.int64)
    waiting, slices = np.empty((DEEPEST, 2), np.int64), (np.empty((SLICES + 1, 6)), np.empty((SLICES + 1, 2)))
    nodes = _part(0.5 * low + 0.5 * high, low, high, most, order, first, count, waiting, *slices)
    return first[:nodes].copy(), count[:nodes].copy()


def sizes_of(count: np.ndarray) -> np.ndarray:
    """How many nodes each node and all below it are, (nodes,) int64, from the counts that `parted` gives."""
    size = np.empty(len(count), np.int64)
    _measure(count, size)
    return size


def boxes_of(
    low: np.ndarray, high: np.ndarray, first: np.ndarray, count: np.ndarray, size: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """The boxes of all nodes, a little widened: middles, and half the sides, less than 0 of a node with nothing in it.

    Parameters
    ----------
    low, high : (M, 3) float64
        Ends of what is in the parts, in their order.
    first, count, size : (nodes,) int64

    Returns
    -------
    middle, half : (nodes, 3) float64
    """
    middle, half = np.zeros((len(first), 3)), np.full((len(first), 3), -1.0)
    rounding = ROUNDING * float(np.maximum(np.abs(low), np.abs(high)).max(initial=0.0))
    _fit(low, high, first, count, size, rounding, middle, half)
    return middle, half


@compiled
def _measure(count: np.ndarray, size: np.ndarray) -> None:
    for node in range(len(count) - 1, -1, -1):
        size[node] = 1
        if count[node] == 0 and node + 1 < len(count):
            left = node + 1
            size[node] += size[left] + size[left + size[left]]


@compiled
def _fit(
    lows: np.ndarray,
    highs: np.ndarray,
    first: np.ndarray,
    count: np.ndarray,
    size: np.ndarray,
    rounding: float,
    middle: np.ndarray,
    half: np.ndarray,
) -> None:
    for node in range(len(first) - 1, -1, -1):
        left = node + 1
        right = left + size[left] if size[node] > 1 else 0
        for k in range(3):
            low, high = np.inf, -np.inf
            if size[node] > 1:
                low = min(middle[left, k] - half[left, k], middle[right, k] - half[right, k])
                high = max(middle[left, k] + half[left, k], middle[right, k] + half[right, k])
            for i in range(first[node], first[node] + count[node]):
                low, high = min(low, lows[i, k]), max(high, highs[i, k])
            if high >= low:
                middle[node, k] = 0.5 * (low + high)
                half[node, k] = 0.5 * (high - low)
                if count[node] > 0:
                    half[node, k] += PAD * half[node, k] + rounding


@compiled
def _part(
    middle: np.ndarray,
    low: np.ndarray,
    high: np.ndarray,
    most: int,
    order: np.ndarray,
    first: np.ndarray,
    count: np.ndarray,
    waiting: np.ndarray,
    boxes: np.ndarray,
    sides: np.ndarray,
) -> int:
    nodes, depth = 0, 1
    waiting[0, 0], waiting[0, 1] = 0, len(order)
    while depth > 0:
        depth -= 1
        start, stop = waiting[depth, 0], waiting[depth, 1]
        cost, axis, begin, scale, last = _best_cut(middle, low, high, order[start:stop], boxes, sides)
        _clear(boxes[SLICES])
        for i in range(start, stop):
            _grow(boxes[SLICES], low[order[i]], high[order[i]])
        surface = _surface(boxes[SLICES])
        ends = axis < 0 or (stop - start <= most and cost + NODE * surface >= (stop - start) * surface)
        first[nodes], count[nodes] = start, stop - start if ends else 0
        nodes += 1
        if not ends:
            cut, other = start, stop
            while cut < other:
                if int((middle[order[cut], axis] - begin) * scale) <= last:
                    cut += 1
                else:
                    other -= 1
                    order[cut], order[other] = order[other], order[cut]
            # With the smaller side next, fewer wait than the boxes can be halved.
            smaller = 1 if cut - start <= stop - cut else 0
            waiting[depth + smaller, 0], waiting[depth + smaller, 1] = start, cut
            waiting[depth + 1 - smaller, 0], waiting[depth + 1 - smaller, 1] = cut, stop
            depth += 2
    return nodes


@compiled
def _best_cut(
    middle: np.ndarray, low: np.ndarray, high: np.ndarray, order: np.ndarray, boxes: np.ndarray, sides: np.ndarray
) -> Cut:
    """The cheapest cut between boxes; `boxes` (17, 6) and `sides` (17, 2) are work space."""
    best = (np.inf, -1, 0.0, 0.0, 0)
    for axis in range(3):
        begin, end = np.inf, -np.inf
        for i in order:
            begin, end = min(begin, middle[i, axis]), max(end, middle[i, axis])
        scale = SLICES * (1.0 - 1e-9) / (end - begin) if end > begin else 0.0
        if not 0.0 < scale < np.inf:
            continue
        for number in range(SLICES):
            _clear(boxes[number])
            sides[number, 0] = 0.0
        for i in order:
            number = int((middle[i, axis] - begin) * scale)
            sides[number, 0] += 1.0
            _grow(boxes[number], low[i], high[i])
        # What costs the far sides, from the last slice on; then the near ones, from the first.
        held = 0.0
        _clear(boxes[SLICES])
        for number in range(SLICES - 1, 0, -1):
            held += sides[number, 0]
            _grow(boxes[SLICES], boxes[number, :3], boxes[number, 3:])
            sides[number - 1, 1] = held * _surface(boxes[SLICES]) if held > 0.0 else np.inf
        held = 0.0
        _clear(boxes[SLICES])
        for number in range(SLICES - 1):
            held += sides[number, 0]
            _grow(boxes[SLICES], boxes[number, :3], boxes[number, 3:])
            cost = held * _surface(boxes[SLICES]) + sides[number, 1]
            if held > 0.0 and cost < best[0]:
                best = (cost, axis, begin, scale, number)
    return best


@compiled
def _clear(box: np.ndarray) -> None:
    box[:3], box[3:] = np.inf, -np.inf


@compiled
def _grow(box: np.ndarray, low: np.ndarray, high: np.ndarray) -> None:
    for k in range(3):
        box[k], box[3 + k] = min(box[k], low[k]), max(box[3 + k], high[k])


@compiled
def _surface(box: np.ndarray) -> float:
    """Half of a box's surface."""
    x, y, z = box[3] - box[0], box[4] - box[1], box[5] - box[2]
    return x * y + y * z + z * x
