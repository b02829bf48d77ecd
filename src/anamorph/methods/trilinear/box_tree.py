"""A tree over scene triangles, by which each ray triangle finds those that it may see.

Triangles are sorted along a space-filling curve and taken `LEAF` at a time; above these leaves stands a complete binary
tree of boxes. Making it is compiled, because a scene that is edited makes it anew.

Source of the sorting: Morton order, as in Lauterbach et al., "Fast BVH construction on GPUs" (2009), section 4.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from anamorph.base.compiled import compiled

LEAF = 4
"""Triangles in a leaf."""

BITS = 10
"""Of each coordinate along the curve."""


class BoxTree(NamedTuple):
    """Boxes over sorted triangles, as compiled loops read them.

    Parameters
    ----------
    faces : (M,) int32
        The triangles' numbers in the caller's list, in the order of the leaves.
    low, high : (2 L, 3) float64
        Boxes of the nodes: node 1 is the root, 2 i and 2 i + 1 are below node i, and L to 2 L - 1 are the leaves. A
        leaf without triangles has an empty box.
    corners : (M, 3, 3) float64
        The triangles' corners, in the order of the leaves.
    """

    faces: np.ndarray
    low: np.ndarray
    high: np.ndarray
    corners: np.ndarray


def make_tree(corners: np.ndarray) -> BoxTree:
    """The tree over triangles (M, 3, 3)."""
    corners = np.ascontiguousarray(corners, float)
    keys = np.empty(len(corners), np.int64)
    _curve(corners, keys)
    # Each holds its triangle's number below its place: sorting them is stable, and several times as fast as argsort.
    keys.sort()
    return _boxed((keys & 0xFFFFFFFF).astype(np.int32), corners)


def moved_tree(tree: BoxTree, corners: np.ndarray) -> BoxTree:
    """The tree with its triangles where `corners` (M, 3, 3) says, in the caller's order."""
    return _boxed(tree.faces, np.ascontiguousarray(corners, float))


def _boxed(order: np.ndarray, corners: np.ndarray) -> BoxTree:
    leaves = 1
    while leaves * LEAF < len(order):
        leaves *= 2
    tree = BoxTree(order, np.full((2 * leaves, 3), np.inf), np.full((2 * leaves, 3), -np.inf), np.empty_like(corners))
    _fill(order, corners, tree.low, tree.high, tree.corners)
    return tree


@compiled
def _curve(corners: np.ndarray, keys: np.ndarray) -> None:
    """The places of triangles (M, 3, 3) along a Morton curve, in the upper halves of `keys` (M,), their numbers below.

    The curve fills the box around the sums of each triangle's corners.
    """
    for number in range(len(keys)):
        keys[number] = number
    for axis in range(3):
        low, high = np.inf, -np.inf
        for number in range(len(keys)):
            middle = corners[number, 0, axis] + corners[number, 1, axis] + corners[number, 2, axis]
            low, high = min(low, middle), max(high, middle)
        span = high - low if high > low else 1.0
        for number in range(len(keys)):
            middle = corners[number, 0, axis] + corners[number, 1, axis] + corners[number, 2, axis]
            cell = np.int64((middle - low) / span * (2**BITS - 1))
            for bit in range(BITS):
                keys[number] |= ((cell >> bit) & 1) << (32 + 3 * bit + axis)


@compiled
def _fill(
    order: np.ndarray, corners: np.ndarray, low: np.ndarray, high: np.ndarray, sorted_corners: np.ndarray
) -> None:
    """Put triangles (M, 3, 3) into `order`, and boxes around them: all of these are empty at first."""
    leaves = len(low) // 2
    for place in range(len(order)):
        node = leaves + place // LEAF
        for corner in range(3):
            for axis in range(3):
                value = corners[order[place], corner, axis]
                sorted_corners[place, corner, axis] = value
                low[node, axis], high[node, axis] = min(low[node, axis], value), max(high[node, axis], value)
    for node in range(leaves - 1, 0, -1):
        for axis in range(3):
            low[node, axis] = min(low[2 * node, axis], low[2 * node + 1, axis])
            high[node, axis] = max(high[2 * node, axis], high[2 * node + 1, axis])
