"""A tree of boxes over surfels, by which a camera finds those that it may see.

Each object has a tree of its own, and above these stands one over the objects. Nodes are in the order in which a
traversal meets them: behind an inner node come its two halves.

Source: Mei, Popescu and Sacks 2007, section 4. Deviation: nodes of points are halved at the median of their widest
side, which bounds the depth whatever the points are, and those of surfels are parted where rays meet the fewest.
Objects that move keep their trees, and only the boxes follow.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from anamorph.methods.threeray.halving import halved
from anamorph.methods.threeray.surfels import Surfels
from anamorph.raytriangle.parting import boxes_of, parted, sizes_of

LEAF = 8
"""Surfels in a leaf, at most, but for those that all have one centre."""

POINTS = 2
"""Points in a leaf, at most: small leaves have nodes of nearly each size, so that one is nearly a pixel wide."""


class Nodes(NamedTuple):
    """A `SurfelTree` as compiled loops read it."""

    first: np.ndarray
    held: np.ndarray
    size: np.ndarray
    middle: np.ndarray
    half: np.ndarray
    center: np.ndarray
    covariance: np.ndarray
    triangle: np.ndarray


@dataclass(frozen=True, eq=False)
class SurfelTree:
    """Boxes over surfels, M of them.

    Parameters
    ----------
    surfels : Surfels
        In the order of the leaves.
    first, count : (M,) int64
        A leaf's surfels are those from `first` on; `count` is 0 for an inner node.
    size : (M,) int64
        How many nodes a node and all below it are: that many further on stands the next one that is not below it.
    middle, half : (M, 3) float64
        Each node's box around the ellipses of its surfels: its middle, and half its sides. Metres.
    """

    surfels: Surfels
    first: np.ndarray
    count: np.ndarray
    size: np.ndarray
    middle: np.ndarray
    half: np.ndarray

    @property
    def nodes(self) -> Nodes:
        """As compiled loops read it."""
        surfels = self.surfels
        return Nodes(
            self.first, self.count, self.size, self.middle, self.half,
            surfels.center, surfels.covariance, surfels.triangle,
        )  # fmt: skip

    def moved(self, corners: np.ndarray) -> SurfelTree:
        """The tree with its triangles where `corners` (F, 3, 3) says."""
        surfels = self.surfels.moved(corners)
        return replace(self, surfels=surfels, **_boxes(surfels, self.first, self.count, self.size))


def make_tree(surfels: Surfels, face_object: np.ndarray, points: bool = False) -> SurfelTree:
    """The tree over surfels of triangles that belong to objects `face_object` (F,), or over their centres as points."""
    objects = np.asarray(face_object)[surfels.triangle]
    # Where one object ends, another begins; their order within an object is that of the triangles.
    order = np.argsort(objects, kind="stable")
    ends = np.flatnonzero(np.diff(objects[order])) + 1
    parts, extents = [], surfels.half_extents()
    for part, start in zip(np.split(order, ends), [0, *ends], strict=True):
        if len(part):
            if points:
                first, count = halved(surfels.center, POINTS, part)
            else:
                first, count = parted(surfels.center - extents, surfels.center + extents, LEAF, part)
            parts.append((first + start, count))
    first, count = _above(parts, surfels.center, order) if parts else np.zeros((2, 1), np.int64)
    ordered, size = surfels.chosen(order), sizes_of(count)
    return SurfelTree(ordered, first, count, size, **_boxes(ordered, first, count, size))


def _above(
    parts: list[tuple[np.ndarray, np.ndarray]], center: np.ndarray, order: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """The nodes over several trees and these themselves: `first` and `count`."""
    if len(parts) == 1:
        return parts[0]
    places = np.array([center[order[first[0]]] for first, _ in parts])
    ranked = np.argsort(places[:, np.ptp(places, axis=0).argmax()], kind="stable")
    middle = len(parts) // 2
    halves = [_above([parts[k] for k in some], center, order) for some in (ranked[:middle], ranked[middle:])]
    first, count = (np.concatenate([[0], *columns]) for columns in zip(*halves, strict=True))
    return first, count


def _boxes(surfels: Surfels, first: np.ndarray, count: np.ndarray, size: np.ndarray) -> dict[str, np.ndarray]:
    extent = surfels.half_extents()
    middle, half = boxes_of(surfels.center - extent, surfels.center + extent, first, count, size)
    return {"middle": middle, "half": half}
