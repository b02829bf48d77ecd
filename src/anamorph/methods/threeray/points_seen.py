"""Which points each camera may see: pairs of a camera and a point, found in the tree. Compiled.

With detail, inner nodes are points too: a node that is less than a pixel wide where a camera sees it is one point, a
surfel near its middle, and what is below it is not looked at. So the pairs are as many as the pixels, and not as the
points.

Source: Mei, Popescu and Sacks 2007, section 5.2. Deviations: cameras are bounded linearly (`bounds`), and each point
of a leaf is asked for, where the paper projects all of them: to bound a point costs less than to project it.
"""

from __future__ import annotations

from collections.abc import Generator
from typing import NamedTuple

import numpy as np

from anamorph.base.compiled import compiled, cores, inlined, steps_over_all_cores
from anamorph.base.vectors import along, dot
from anamorph.methods.threeray.surfel_tree import SurfelTree
from anamorph.raytriangle.bounds import seen_weights
from anamorph.raytriangle.camera_frames import Frames, vector

GRAIN = 32
"""Cameras that a core takes at a time."""

AT_FIRST = 2**14
"""Pairs that there is space for before it is known how many there are."""

SHARE = 0.5
"""A node with a radius of less than this share of a pixel is one point: with 1, holes open."""


class PointTree(NamedTuple):
    """A `SurfelTree` as compiled loops read it, whose nodes are points too."""

    first: np.ndarray
    held: np.ndarray
    size: np.ndarray
    middle: np.ndarray
    half: np.ndarray
    center: np.ndarray
    point: np.ndarray
    """(M,) int64: of each node, the number of a surfel near its middle."""


def point_tree(tree: SurfelTree) -> PointTree:
    """The tree with a point for each node."""
    point = np.zeros(len(tree.size), np.int64)
    held = PointTree(tree.first, tree.count, tree.size, tree.middle, tree.half, tree.surfels.center, point)
    if len(tree.surfels):
        _stand_in(held)
    return held


@compiled
def _stand_in(tree: PointTree) -> None:
    """Find each node's point, from the last to the first: of its own points, or those of its two halves."""
    for node in range(len(tree.size) - 1, -1, -1):
        middle, nearest = vector(tree.middle[node]), np.inf
        if tree.size[node] > 1:
            left = node + 1
            for half in (left, left + tree.size[left]):
                offset = along(vector(tree.center[tree.point[half]]), -1.0, middle)
                if dot(offset, offset) < nearest:
                    nearest, tree.point[node] = dot(offset, offset), tree.point[half]
        for s in range(tree.first[node], tree.first[node] + tree.held[node]):
            offset = along(vector(tree.center[s]), -1.0, middle)
            if dot(offset, offset) < nearest:
                nearest, tree.point[node] = dot(offset, offset), s


def areas_of(image: np.ndarray) -> np.ndarray:
    """The areas of image triangles with these homogeneous corners (K, 3, 3), (K,) float64; 0 where one is behind."""
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        places = image[..., :2] / image[..., 2:]
        one, other = places[:, 1] - places[:, 0], places[:, 2] - places[:, 0]
        area = 0.5 * np.abs(one[:, 0] * other[:, 1] - one[:, 1] * other[:, 0])
    return np.where((image[..., 2] > 0.0).all(axis=1) & np.isfinite(area), area, 0.0)


def pairs_seen(frames: Frames, tree: PointTree, samples: np.ndarray, detail: bool) -> Generator[None, None, np.ndarray]:
    """The points that cameras may see, in steps.

    Parameters
    ----------
    frames : Frames
        Of the cameras, K of them.
    tree : PointTree
    samples : (K,) float64
        How many samples of the image the cameras' triangles cover; 0 where nobody knows.
    detail : bool
        Whether nodes of less than a sample are points.

    Returns
    -------
    (N, 2) uint32
        Numbers of a camera and a point, camera by camera. No point that a camera sees is missing, but for those that a
        node stands for.
    """
    parts: dict[int, np.ndarray] = {}
    limit = SHARE if detail else 0.0

    def work(start: int, stop: int) -> None:
        pairs = np.empty((AT_FIRST, 2), np.uint32)
        count = _see(frames, tree, samples, limit, pairs, start, stop)
        if count > len(pairs):
            pairs = np.empty((count, 2), np.uint32)
            _see(frames, tree, samples, limit, pairs, start, stop)
        parts[start] = pairs[:count].copy()

    count = len(samples)
    if count and len(tree.center):
        yield from steps_over_all_cores(work, count, max(1, min(GRAIN, count // (8 * cores()))))
    return np.concatenate([np.zeros((0, 2), np.uint32), *(parts[start] for start in sorted(parts))])


@compiled
def _see(
    frames: Frames, tree: PointTree, samples: np.ndarray, limit: float, pairs: np.ndarray, start: int, stop: int
) -> int:
    """Fill `pairs` as far as they go for cameras from `start` to `stop`; how many there are."""
    count, nothing = 0, (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    for c in range(start, stop):
        node = 0
        while node < len(tree.size):
            half = vector(tree.half[node])
            shape = (half[0], half[1], half[2], 0.0, 0.0, 0.0)
            first, last, seen = tree.first[node], tree.first[node] + tree.held[node], False
            seen, _, _ = seen_weights(frames, c, vector(tree.middle[node]), shape, True)
            one = seen and dot(half, half) < limit * limit * _pixel(frames, samples, c, tree.middle[node])
            if one:
                first, last = tree.point[node], tree.point[node] + 1
            if seen:
                for s in range(first, last):
                    shown, _, _ = seen_weights(frames, c, vector(tree.center[s]), nothing, True)
                    if shown:
                        if count < len(pairs):
                            pairs[count, 0], pairs[count, 1] = c, s
                        count += 1
            node += 1 if seen and not one else tree.size[node]
    return count


@inlined
def _pixel(frames: Frames, samples: np.ndarray, c: int, middle: np.ndarray) -> float:
    """The area that a sample of camera c covers about a place, across its rays, square metres; 0 if nobody knows.

    It is that of the camera's sweeping triangle there, over the samples that the camera has. Its root is the geometric
    mean of how wide and how high a sample is.
    """
    speed = 0.5 * (frames.reach[c, 2] + frames.reach[c, 3])
    if speed <= 0.0 or samples[c] <= 0.0:
        return 0.0
    place = along(vector(middle), -1.0, vector(frames.origin[c]))
    start = 0.5 * (frames.reach[c, 0] + frames.reach[c, 1])
    t = max(0.0, (dot(vector(frames.axis[c]), place) - start) / speed)
    value = frames.determinant[c, 0] + t * (frames.determinant[c, 1] + t * frames.determinant[c, 2])
    return 0.5 * abs(value) / (frames.factors[c, 0] * samples[c])
