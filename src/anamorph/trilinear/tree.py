"""A tree over scene triangles, by which each ray triangle finds those that it may see.

Triangles are sorted along a space-filling curve and taken `LEAF` at a time; above these leaves stands a complete binary
tree of boxes. It is made in a few array operations, and refitted in fewer where the triangles move.

Source of the sorting: Morton order, as in Lauterbach et al., "Fast BVH construction on GPUs" (2009), section 4.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

LEAF = 4
"""Triangles in a leaf."""

BITS = 10
"""Of each coordinate along the curve."""


@dataclass(frozen=True, eq=False)
class Tree:
    """Boxes over sorted triangles.

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


def make_tree(corners: np.ndarray) -> Tree:
    """The tree over triangles (M, 3, 3)."""
    corners = np.asarray(corners, float)
    order = np.argsort(_curve(corners.mean(axis=1)), kind="stable").astype(np.int32)
    return _boxed(order, corners[order])


def moved_tree(tree: Tree, corners: np.ndarray) -> Tree:
    """The tree with its triangles where `corners` (M, 3, 3) says, in the caller's order."""
    return _boxed(tree.faces, np.asarray(corners, float)[tree.faces])


def _curve(points: np.ndarray) -> np.ndarray:
    """The places of points (M, 3) along a Morton curve."""
    low, high = points.min(axis=0, initial=np.inf), points.max(axis=0, initial=-np.inf)
    span = np.where(high > low, high - low, 1.0)
    cells = ((points - low) / span * (2**BITS - 1)).astype(np.int64)
    place = np.zeros(len(points), np.int64)
    for bit in range(BITS):
        for axis in range(3):
            place |= ((cells[:, axis] >> bit) & 1) << (3 * bit + axis)
    return place


def _boxed(order: np.ndarray, corners: np.ndarray) -> Tree:
    leaves = 1
    while leaves * LEAF < len(order):
        leaves *= 2
    low, high = np.full((2 * leaves, 3), np.inf), np.full((2 * leaves, 3), -np.inf)
    starts = np.arange(0, len(order), LEAF)
    if len(order):
        filled = slice(leaves, leaves + len(starts))
        low[filled] = np.minimum.reduceat(corners.min(axis=1), starts)
        high[filled] = np.maximum.reduceat(corners.max(axis=1), starts)
    first = leaves
    while first > 1:
        below, first = first, first // 2
        low[first:below] = np.minimum(low[below : 2 * below : 2], low[below + 1 : 2 * below : 2])
        high[first:below] = np.maximum(high[below : 2 * below : 2], high[below + 1 : 2 * below : 2])
    return Tree(order, low, high, np.ascontiguousarray(corners))
