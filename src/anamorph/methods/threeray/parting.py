"""Boxes parted where rays meet the fewest of them, again and again: the order of a tree. Compiled.

A ray that meets a box meets another inside of it with the ratio of their surfaces. Of the cuts across the three axes,
at equal distances, the one is made that has rays meet the fewest boxes in both sides together.

Source: MacDonald and Booth, "Heuristics for ray tracing using space subdivision" (1990), sections 3 and 4.
"""

from __future__ import annotations

import numpy as np

from anamorph.base.compiled import compiled
from anamorph.methods.threeray.halving import DEEPEST

SLICES = 16
"""Between which the cuts across an axis are."""

NODE = 2.0
"""What it costs to ask whether a ray meets a node, in boxes of a part."""

Cut = tuple[float, int, float, float, int]
"""What the sides cost, in boxes times surface; the axis, -1 for none; where the slices begin; how many there are in a
metre; and the last one before the cut."""


def parted(middle: np.ndarray, half: np.ndarray, most: int, order: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Part boxes until each part has `most` at the most, and no cut makes rays meet fewer; or all are in one place.

    Parameters
    ----------
    middle, half : (N, 3) float64
        Middles of the boxes, at least one, and half their sides.
    most : int
    order : (M,) int64
        Which boxes; is put in the order of the parts.

    Returns
    -------
    first, count : (nodes,) int64
        As of `halving.halved`.
    """
    first, count = np.empty((2, 2 * len(order)), np.int64)
    waiting, slices = np.empty((DEEPEST, 2), np.int64), (np.empty((SLICES + 1, 6)), np.empty((SLICES + 1, 2)))
    nodes = _part(middle, middle - half, middle + half, most, order, first, count, waiting, *slices)
    return first[:nodes].copy(), count[:nodes].copy()


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
        ends = stop - start <= most and cost + NODE * _surface(boxes[SLICES]) >= (stop - start) * _surface(
            boxes[SLICES]
        )
        ends |= axis < 0
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
        if not end > begin:
            continue
        scale = SLICES * (1.0 - 1e-9) / (end - begin)
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
