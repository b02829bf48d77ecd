"""A tree over scene triangles, by which each ray triangle finds those that it may see.

Nodes are in the order in which they are met: behind an inner node come its two halves, each with all that is below it.
They are parted where the areas of both parts' boxes, times the triangles in them, are least. Compiled, because a scene
that is edited makes its tree anew.

Source: Wald, "On fast construction of SAH-based bounding volume hierarchies" (2007), sections 2 and 3.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from anamorph.base.compiled import compiled, inlined

LEAF = 4
"""Triangles in a leaf, at most, but for those that all have one middle."""

BINS = 16
"""Places along each axis at which parting is tried, and one."""

DEEPEST = 64
"""Levels by their boxes; below that, triangles are halved as they come."""

ROUNDING = 1e-12
"""What leaves' boxes are widened by, as a share of the scene's coordinates: more than all levels lose by rounding."""


class BoxTree(NamedTuple):
    """Boxes over sorted triangles, M of them, as compiled loops read them."""

    faces: np.ndarray
    """(M,) int32: the triangles' numbers in the caller's list, in the order of the leaves."""
    corners: np.ndarray
    """(M, 3, 3) float64: the triangles' corners, in the order of the leaves."""
    first: np.ndarray
    """(N,) int64: the first of a leaf's triangles."""
    held: np.ndarray
    """(N,) int64: how many those are; 0 for an inner node."""
    size: np.ndarray
    """(N,) int64: how many nodes a node and all below it are: so many further on stands the next one beside it."""
    middle: np.ndarray
    """(N, 3) float64: of each node's box."""
    half: np.ndarray
    """(N, 3) float64: half the box's sides; less than 0 without a triangle."""


def make_tree(corners: np.ndarray) -> BoxTree:
    """The tree over triangles (M, 3, 3)."""
    corners = np.ascontiguousarray(corners, float)
    count = len(corners)
    order = np.arange(count)
    first, held, size = np.zeros((3, max(2 * count, 1)), np.int64)
    low, high = (np.ascontiguousarray(end(axis=1)) if count else np.zeros((0, 3)) for end in (corners.min, corners.max))
    waiting, bins = np.empty((2 * DEEPEST, 3), np.int64), np.empty((BINS + 1, 8))
    nodes = _part(low, high, order, first, held, waiting, bins)
    _measure(held[:nodes], size[:nodes])
    first, held, size = (each[:nodes].copy() for each in (first, held, size))
    return _boxed(order.astype(np.int32), corners, first, held, size)


def moved_tree(tree: BoxTree, corners: np.ndarray) -> BoxTree:
    """The tree with its triangles where `corners` (M, 3, 3) says, in the caller's order."""
    return _boxed(tree.faces, np.ascontiguousarray(corners, float), tree.first, tree.held, tree.size)


def _boxed(faces: np.ndarray, corners: np.ndarray, first: np.ndarray, count: np.ndarray, size: np.ndarray) -> BoxTree:
    tree = BoxTree(faces, corners[faces], first, count, size, np.zeros((len(first), 3)), np.full((len(first), 3), -1.0))
    _fit(tree, ROUNDING * float(np.abs(corners).max(initial=0.0)))
    return tree


@inlined
def _clear(rows: np.ndarray) -> None:
    """Empty boxes of no triangles."""
    rows[..., :3], rows[..., 3:6], rows[..., 6] = np.inf, -np.inf, 0.0


@inlined
def _add(row: np.ndarray, low: np.ndarray, high: np.ndarray, count: float) -> None:
    for axis in range(3):
        row[axis], row[3 + axis] = min(row[axis], low[axis]), max(row[3 + axis], high[axis])
    row[6] += count


@inlined
def _cost(row: np.ndarray) -> float:
    """The area of a box times the triangles in it; 0 without any."""
    x, y, z = max(row[3] - row[0], 0.0), max(row[4] - row[1], 0.0), max(row[5] - row[2], 0.0)
    return (x * y + y * z + z * x) * row[6] if row[6] > 0.0 else 0.0


@inlined
def _bin_of(twice: float, start: float, scale: float) -> int:
    return min(int((twice - start) * scale), BINS - 1)


@compiled
def _best(low: np.ndarray, high: np.ndarray, some: np.ndarray, bins: np.ndarray) -> tuple[int, int, float, float]:
    """Where to part triangles: axis, or -1; last bin of the first part; where bins begin, and how many a metre has."""
    found, last, found_start, found_scale, least = -1, 0, 0.0, 0.0, np.inf
    running = bins[BINS]
    for axis in range(3):
        start, stop = np.inf, -np.inf
        for face in some:
            twice = low[face, axis] + high[face, axis]
            start, stop = min(start, twice), max(stop, twice)
        scale = BINS / (stop - start) if stop > start else 0.0
        if not 0.0 < scale < np.inf:
            continue
        _clear(bins)
        for face in some:
            row = _bin_of(low[face, axis] + high[face, axis], start, scale)
            _add(bins[row], low[face], high[face], 1.0)
        for row in range(BINS - 1, 0, -1):
            _add(running, bins[row, :3], bins[row, 3:6], bins[row, 6])
            bins[row - 1, 7] = _cost(running)
        _clear(running)
        for row in range(BINS - 1):
            _add(running, bins[row, :3], bins[row, 3:6], bins[row, 6])
            cost = _cost(running) + bins[row, 7]
            if 0.0 < running[6] < len(some) and cost < least:
                found, last, found_start, found_scale, least = axis, row, start, scale, cost
    return found, last, found_start, found_scale


@compiled
def _part(
    low: np.ndarray,
    high: np.ndarray,
    order: np.ndarray,
    first: np.ndarray,
    count: np.ndarray,
    waiting: np.ndarray,
    bins: np.ndarray,
) -> int:
    """Part triangles with these boxes again and again: puts `order` in the leaves' order; returns how many nodes."""
    nodes, depth = 0, 1
    waiting[0, 0], waiting[0, 1], waiting[0, 2] = 0, len(order), 0
    while depth > 0:
        depth -= 1
        start, stop, level = waiting[depth, 0], waiting[depth, 1], waiting[depth, 2]
        axis, last, begin, scale = -1, 0, 0.0, 0.0
        if stop - start > LEAF:
            axis, last, begin, scale = _best(low, high, order[start:stop], bins)
        first[nodes], count[nodes] = start, stop - start if axis < 0 else 0
        nodes += 1
        if axis < 0:
            continue
        middle, end = start, stop - 1
        if level >= DEEPEST:
            middle = (start + stop) // 2
        while level < DEEPEST and middle <= end:
            face = order[middle]
            if _bin_of(low[face, axis] + high[face, axis], begin, scale) <= last:
                middle += 1
            else:
                order[middle], order[end] = order[end], face
                end -= 1
        waiting[depth, 0], waiting[depth, 1], waiting[depth, 2] = middle, stop, level + 1
        waiting[depth + 1, 0], waiting[depth + 1, 1], waiting[depth + 1, 2] = start, middle, level + 1
        depth += 2
    return nodes


@compiled
def _measure(count: np.ndarray, size: np.ndarray) -> None:
    """Count the nodes below each, from the last to the first."""
    for node in range(len(count) - 1, -1, -1):
        size[node] = 1
        if count[node] == 0 and node + 1 < len(count):
            left = node + 1
            size[node] += size[left] + size[left + size[left]]


@compiled
def _fit(tree: BoxTree, rounding: float) -> None:
    """Put boxes around the triangles, those of leaves wider by `rounding` metres."""
    for node in range(len(tree.first) - 1, -1, -1):
        left = node + 1
        right = left + tree.size[left] if tree.size[node] > 1 else 0
        for axis in range(3):
            low, high = np.inf, -np.inf
            if tree.size[node] > 1:
                low = min(
                    tree.middle[left, axis] - tree.half[left, axis], tree.middle[right, axis] - tree.half[right, axis]
                )
                high = max(
                    tree.middle[left, axis] + tree.half[left, axis], tree.middle[right, axis] + tree.half[right, axis]
                )
            for k in range(tree.first[node], tree.first[node] + tree.held[node]):
                for corner in range(3):
                    low, high = min(low, tree.corners[k, corner, axis]), max(high, tree.corners[k, corner, axis])
            if high >= low:
                tree.middle[node, axis] = 0.5 * (low + high)
                tree.half[node, axis] = 0.5 * (high - low) + (rounding if tree.held[node] > 0 else 0.0)
