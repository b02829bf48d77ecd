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
from anamorph.base.vectors import Vector, along, dot
from anamorph.methods.threeray.camera_bases import Bases
from anamorph.methods.threeray.surfel_tree import Nodes, SurfelTree
from anamorph.raytriangle.bounds import Shape, seen_weights, support
from anamorph.raytriangle.camera_frames import Frames, vector

GRAIN = 32
"""Cameras that a core takes at a time."""

AT_FIRST = 2**14
"""Pairs that there is space for before it is known how many there are."""

SHARE = 0.5
"""A node is one point if its radius is less than this share of a square's side: with 1, holes open."""

BORDER = 0.25
"""A node of less than this share of that area is one point also if the camera does not see the point."""


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


def pairs_seen(
    frames: Frames, bases: Bases, nodes: Nodes, points: np.ndarray, side: float
) -> Generator[None, None, np.ndarray]:
    """The points that cameras may see, in steps.

    Parameters
    ----------
    frames : Frames
        Of the cameras, K of them.
    bases : Bases
    nodes : Nodes
    points : (M,) int64
        From `stand_ins`.
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
        count = _see(frames, bases, nodes, points, limit, pairs, start, stop)
        if count > len(pairs):
            pairs = np.empty((count, 2), np.uint32)
            _see(frames, bases, nodes, points, limit, pairs, start, stop)
        parts[start] = pairs[:count].copy()

    count = len(bases.samples)
    if count and len(nodes.center):
        yield from steps_over_all_cores(work, count, max(1, min(GRAIN, count // (8 * cores()))))
    return np.concatenate([np.zeros((0, 2), np.uint32), *(parts[start] for start in sorted(parts))])


@compiled
def _see(
    frames: Frames,
    bases: Bases,
    nodes: Nodes,
    points: np.ndarray,
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
            first, last = nodes.first[node], nodes.first[node] + nodes.held[node]
            seen = _is_seen(frames, bases, c, vector(nodes.middle[node]), shape)
            most = limit * limit * _sample(frames, bases, c, vector(nodes.middle[node])) if seen else 0.0
            one = seen and dot(half, half) < most
            # At a camera's border the point may be its neighbour's; not much further down, that is all there is.
            if one and dot(half, half) > BORDER * most:
                one = _is_seen(frames, bases, c, vector(nodes.center[points[node]]), nothing)
            if one:
                first, last = points[node], points[node] + 1
            if seen:
                for s in range(first, last):
                    if _is_seen(frames, bases, c, vector(nodes.center[s]), nothing):
                        if count < len(pairs):
                            pairs[count, 0], pairs[count, 1] = c, s
                        count += 1
            node += 1 if seen and not one else nodes.size[node]
    return count


@inlined
def _is_seen(frames: Frames, bases: Bases, c: int, middle: Vector, shape: Shape) -> bool:
    """Whether camera c may see something of a box."""
    plane = vector(bases.plane[c])
    if dot(plane, middle) + support(shape, True, plane) < bases.plane[c, 3]:
        return False
    seen, _, _ = seen_weights(frames, c, middle, shape, True)
    return seen


@inlined
def _sample(frames: Frames, bases: Bases, c: int, middle: Vector) -> float:
    """The area that a sample of camera c covers about a place, across its rays, square metres; 0 if it is not known.

    It is that of the camera's sweeping triangle there, over the samples that the camera has. Its root is the geometric
    mean of how wide and how high a sample is. A wide camera's is that of its solid angle.
    """
    if bases.samples[c] <= 0.0:
        return 0.0
    place = along(middle, -1.0, vector(frames.origin[c]))
    if frames.reach[c, 2] <= 0.0:
        return dot(place, place) * bases.spread[c] / bases.samples[c]
    speed = 0.5 * (frames.reach[c, 2] + frames.reach[c, 3])
    start = 0.5 * (frames.reach[c, 0] + frames.reach[c, 1])
    t = max(0.0, (dot(vector(frames.axis[c]), place) - start) / speed)
    value = frames.determinant[c, 0] + t * (frames.determinant[c, 1] + t * frames.determinant[c, 2])
    return 0.5 * abs(value) / (frames.factors[c, 0] * bases.samples[c])
