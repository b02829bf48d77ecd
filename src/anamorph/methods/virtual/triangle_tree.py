"""A tree over the scene's triangles, each node with a ball around them."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from anamorph.raytriangle.parting import boxes_of, parted, sizes_of


class TriangleNodes(NamedTuple):
    """A `TriangleTree` as compiled loops read it."""

    first: np.ndarray
    held: np.ndarray
    size: np.ndarray
    balls: np.ndarray
    order: np.ndarray
    corners: np.ndarray


@dataclass(frozen=True, eq=False)
class TriangleTree:
    """Balls over triangles.

    Parameters
    ----------
    order : (K,) int64
        The triangles' numbers, in the order of the leaves.
    first, count, size : (M,) int64
        A leaf has the triangles order[first] to order[first + count], an inner node's count is 0; and how many nodes a
        node and all below it are.
    corners : (F, 3, 3) float64
        Of all triangles.
    balls : (M, 4) float64
        Middle and radius, metres.
    """

    order: np.ndarray
    first: np.ndarray
    count: np.ndarray
    size: np.ndarray
    corners: np.ndarray
    balls: np.ndarray

    @property
    def nodes(self) -> TriangleNodes:
        """As compiled loops read it."""
        return TriangleNodes(self.first, self.count, self.size, self.balls, self.order, self.corners)

    def moved(self, corners: np.ndarray) -> TriangleTree:
        """The same with its triangles elsewhere."""
        balls = _balls(corners[self.order], self.first, self.count, self.size)
        return replace(self, corners=corners, balls=balls)

    def parts(self, most: int) -> np.ndarray:
        """Nodes, (K,) int64, that have all triangles together and no more than about `most` each."""
        chosen, waiting = [], [0] if len(self.size) else []
        while waiting:
            node = waiting.pop()
            left = node + 1
            if self.count[node] > 0 or self.size[node] <= 2 * most:
                chosen.append(node)
            else:
                waiting += [left + int(self.size[left]), left]
        return np.array(chosen, np.int64)


def triangle_tree(corners: np.ndarray, chosen: np.ndarray) -> TriangleTree:
    """The tree over those of the triangles (F, 3, 3) that are `chosen`, by their numbers (K,)."""
    order = np.array(chosen, np.int64)
    first, count = (
        parted(corners.min(axis=1), corners.max(axis=1), 1, order) if len(order) else np.zeros((2, 0), np.int64)
    )
    size = sizes_of(count)
    return TriangleTree(order, first, count, size, corners, _balls(corners[order], first, count, size))


def _balls(corners: np.ndarray, first: np.ndarray, count: np.ndarray, size: np.ndarray) -> np.ndarray:
    middle, half = boxes_of(corners.min(axis=1), corners.max(axis=1), first, count, size)
    return np.column_stack([middle, np.linalg.norm(half, axis=1)])
