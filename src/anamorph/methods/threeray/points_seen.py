"""Which points each camera may see: pairs of a camera and a point, found in the tree. Compiled.

With detail, inner nodes are points too: a node that is less than a pixel wide where a camera sees it is one point, a
surfel near its middle, and what is below it is not looked at. So the pairs are as many as the pixels, and not as the
points.

Source: Mei, Popescu and Sacks 2007, section 5.2. Deviations: cameras are bounded linearly (`bounds`), and each point
of a leaf is asked for, where the paper projects all of them: to bound a point costs less than to project it.
"""

from __future__ import annotations

from collections.abc import Generator

import numpy as np

from anamorph.base.compiled import compiled, cores, inlined, steps_over_all_cores
from anamorph.base.vectors import along, dot
from anamorph.methods.threeray.surfel_tree import Nodes, SurfelTree
from anamorph.raytriangle.bounds import seen_weights
from anamorph.raytriangle.camera_frames import Frames, vector

GRAIN = 32
"""Cameras that a core takes at a time."""

AT_FIRST = 2**14
"""Pairs that there is space for before it is known how many there are."""

SHARE = 0.5
"""A node is one point if its radius is less than this share of a square's side: with 1, holes open."""


def stand_ins(tree: SurfelTree) -> np.ndarray:
    """The point that each node is where it is small: a surfel near its middle, (M,) int64."""
    found = np.zeros(len(tree.size), np.int64)
    if len(tree.surfels):
        _stand_in(tree.nodes, found)
    return found


@compiled
def _stand_in(nodes: Nodes, found: np.ndarray) -> None:
    """Find each node's point, from the last to the first: of its own, or of those of its two halves."""
    for node in range(len(found) - 1, -1, -1):
        middle, nearest = vector(nodes.middle[node]), np.inf
        if nodes.size[node] > 1:
            left = node + 1
            for half in (left, left + nodes.size[left]):
                offset = along(vector(nodes.center[found[half]]), -1.0, middle)
                if dot(offset, offset) < nearest:
                    nearest, found[node] = dot(offset, offset), found[half]
        for s in range(nodes.first[node], nodes.first[node] + nodes.held[node]):
            offset = along(vector(nodes.center[s]), -1.0, middle)
            if dot(offset, offset) < nearest:
                nearest, found[node] = dot(offset, offset), s


def areas_of(image: np.ndarray) -> np.ndarray:
    """The areas of image triangles with these homogeneous corners (K, 3, 3), (K,) float64; 0 where one is behind."""
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        places = image[..., :2] / image[..., 2:]
        one, other = places[:, 1] - places[:, 0], places[:, 2] - places[:, 0]
        area = 0.5 * np.abs(one[:, 0] * other[:, 1] - one[:, 1] * other[:, 0])
    return np.where((image[..., 2] > 0.0).all(axis=1) & np.isfinite(area), area, 0.0)


def pairs_seen(
    frames: Frames, nodes: Nodes, points: np.ndarray, samples: np.ndarray, side: float
) -> Generator[None, None, np.ndarray]:
    """The points that cameras may see, in steps.

    Parameters
    ----------
    frames : Frames
        Of the cameras, K of them.
    nodes : Nodes
    points : (M,) int64
        From `stand_ins`.
    samples : (K,) float64
        How many samples of the image the cameras' triangles cover; 0 where nobody knows.
    side : float
        Nodes that are less than so many samples wide are points; 0 for none.

    Returns
    -------
    (N, 2) uint32
        Numbers of a camera and a point, camera by camera. No point that a camera sees is missing, but for those that a
        node stands for.
    """
    parts: dict[int, np.ndarray] = {}
    limit = SHARE * side

    def work(start: int, stop: int) -> None:
        pairs = np.empty((AT_FIRST, 2), np.uint32)
        count = _see(frames, nodes, points, samples, limit, pairs, start, stop)
        if count > len(pairs):
            pairs = np.empty((count, 2), np.uint32)
            _see(frames, nodes, points, samples, limit, pairs, start, stop)
        parts[start] = pairs[:count].copy()

    count = len(samples)
    if count and len(nodes.center):
        yield from steps_over_all_cores(work, count, max(1, min(GRAIN, count // (8 * cores()))))
    return np.concatenate([np.zeros((0, 2), np.uint32), *(parts[start] for start in sorted(parts))])


@compiled
def _see(
    frames: Frames,
    nodes: Nodes,
    points: np.ndarray,
    samples: np.ndarray,
    limit: float,
    pairs: np.ndarray,
    start: int,
    stop: int,
) -> int:
    """Fill `pairs` as far as they go for cameras from `start` to `stop`; how many there are."""
    count, nothing = 0, (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    for c in range(start, stop):
        node = 0
        while node < len(nodes.size):
            half = vector(nodes.half[node])
            shape = (half[0], half[1], half[2], 0.0, 0.0, 0.0)
            first, last, seen = nodes.first[node], nodes.first[node] + nodes.held[node], False
            seen, _, _ = seen_weights(frames, c, vector(nodes.middle[node]), shape, True)
            one = seen and dot(half, half) < limit * limit * _pixel(frames, samples, c, nodes.middle[node])
            if one:
                first, last = points[node], points[node] + 1
            if seen:
                for s in range(first, last):
                    shown, _, _ = seen_weights(frames, c, vector(nodes.center[s]), nothing, True)
                    if shown:
                        if count < len(pairs):
                            pairs[count, 0], pairs[count, 1] = c, s
                        count += 1
            node += 1 if seen and not one else nodes.size[node]
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
