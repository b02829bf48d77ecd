"""A tree over scene triangles, by which each ray triangle finds those that it may see."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from anamorph.raytriangle.parting import boxes_of, parted, sizes_of

LEAF = 4
"""Triangles in a leaf, at most, but for those that all have one middle."""


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
    order, (first, held) = np.arange(len(corners)), np.zeros((2, 1), np.int64)
    if len(corners):
        first, held = parted(corners.min(axis=1), corners.max(axis=1), LEAF, order)
    return _boxed(order.astype(np.int32), corners, first, held, sizes_of(held))


def moved_tree(tree: BoxTree, corners: np.ndarray) -> BoxTree:
    """The tree with its triangles where `corners` (M, 3, 3) says, in the caller's order."""
    return _boxed(tree.faces, np.ascontiguousarray(corners, float), tree.first, tree.held, tree.size)


def _boxed(faces: np.ndarray, corners: np.ndarray, first: np.ndarray, held: np.ndarray, size: np.ndarray) -> BoxTree:
    ordered = corners[faces]
    boxes = boxes_of(ordered.min(axis=1), ordered.max(axis=1), first, held, size)
    return BoxTree(faces, ordered, first, held, size, *boxes)
