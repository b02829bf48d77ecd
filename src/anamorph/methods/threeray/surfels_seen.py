"""What each sample's own ray meets first, of the surfels that its camera may see. Compiled.

For each camera the tree is traversed. Each surfel that may be seen is bounded by a range of each weight, which is a
polygon of up to six sides in the image, and the rays of the camera's samples in it meet the surfel's triangle: of
several the nearest along the ray. The samples of two cameras are never the same, so that cores share nothing.
"""

from __future__ import annotations

import math

import numpy as np

from anamorph.base.compiled import compiled, inlined
from anamorph.base.vectors import Vector
from anamorph.methods.threeray.cameras_seen import Cameras
from anamorph.methods.threeray.objects import Materials
from anamorph.methods.threeray.sample_rays import Samples
from anamorph.methods.threeray.scene_triangles import Triangles, meets, stops
from anamorph.methods.threeray.surfel_tree import Nodes
from anamorph.raytriangle.bounds import Range, seen_weights
from anamorph.raytriangle.camera_frames import Frames, vector
from anamorph.raytriangle.owners import Places
from anamorph.raytriangle.walls import Walls, meets_volume

MARGIN = 1e-6
"""Samples, and weights, by which the polygon of a surfel is widened."""


@compiled
def look(
    cameras: Cameras,
    frames: Frames,
    walls: Walls,
    by_walls: bool,
    places: Places,
    nodes: Nodes,
    triangles: Triangles,
    materials: Materials,
    samples: Samples,
    chosen: np.ndarray,
    work: np.ndarray,
    ways: np.ndarray,
    space: np.ndarray,
    start: int,
    stop: int,
) -> None:
    """Have the samples of cameras `chosen[start:stop]` meet what these may see.

    Boxes are told `by_walls` or by bounds. `work` (len(chosen), 4) is filled, see `WORK`; `ways` (width,) and `space`
    (26,) float64 are the core's own, for what it is asking.
    """
    for number in range(start, stop):
        c, node, bounded, asked, boxes, tests = chosen[number], 0, 0, 0, 0, 0
        while node < len(nodes.size):
            middle, half = vector(nodes.middle[node]), vector(nodes.half[node])
            bounded += 1
            shape = (half[0], half[1], half[2], 0.0, 0.0, 0.0)
            if by_walls:
                seen = meets_volume(frames, walls, c, middle, half, space)
            else:
                seen, low, high = seen_weights(frames, c, middle, shape, True)
            if not seen:
                node += nodes.size[node]
                continue
            for s in range(nodes.first[node], nodes.first[node] + nodes.held[node]):
                asked += 1
                v = nodes.covariance[s]
                shape = (v[0], v[1], v[2], v[3], v[4], v[5])
                seen, low, high = seen_weights(frames, c, vector(nodes.center[s]), shape, False)
                if seen:
                    boxes += 1
                    f = nodes.triangle[s]
                    tests += _meet_within(cameras, places, triangles, materials, samples, c, f, low, high, ways)
            node += 1
        work[number, 0], work[number, 1], work[number, 2], work[number, 3] = bounded, asked, boxes, tests


@inlined
def _rows_of(image: np.ndarray, low: Vector, high: Vector, first: int, last: int) -> Range:
    """The rows, from the image's first on, between which weights within bounds may be; of all if behind the eye."""
    if min(image[0, 2], image[1, 2], image[2, 2]) <= 0.0:
        return float(first), float(last)
    least, most = math.inf, -math.inf
    for free in range(3):
        one, other = (free + 1) % 3, (free + 2) % 3
        for ends in range(4):
            w_one = high[one] if ends & 1 else low[one]
            w_other = high[other] if ends & 2 else low[other]
            w_free = 1.0 - w_one - w_other
            if low[free] - MARGIN <= w_free <= high[free] + MARGIN:
                y = w_one * image[one, 1] + w_other * image[other, 1] + w_free * image[free, 1]
                y /= w_one * image[one, 2] + w_other * image[other, 2] + w_free * image[free, 2]
                least, most = min(least, y), max(most, y)
    return max(least - MARGIN, float(first)), min(most + MARGIN, float(last))


@inlined
def _cut(slope: float, value: float, left: float, right: float) -> Range:
    """Where between left and right slope x + value is not negative."""
    if slope > 0.0:
        return max(left, -value / slope), right
    if slope < 0.0:
        return left, min(right, -value / slope)
    return (left, right) if value >= 0.0 else (right + 1.0, right)


@inlined
def _meet_within(
    cameras: Cameras,
    places: Places,
    triangles: Triangles,
    materials: Materials,
    samples: Samples,
    c: int,
    f: int,
    low: Vector,
    high: Vector,
    ways: np.ndarray,
) -> int:
    """Have a triangle met by the samples of a camera whose weights are within bounds; returns how many were asked."""
    x0, y0, last_x, last_y = places.box[c, 0], places.box[c, 1], places.box[c, 2] - 1, places.box[c, 3] - 1
    least, most = _rows_of(cameras.image[c], low, high, y0, last_y)
    if not least <= most:
        return 0
    w = places.weights[c]
    sum_x, sum_y, sum_1 = w[0, 0] + w[1, 0] + w[2, 0], w[0, 1] + w[1, 1] + w[2, 1], w[0, 2] + w[1, 2] + w[2, 2]
    tests = 0
    for row in range(math.ceil(least), math.floor(most) + 1):
        y = float(row - y0)
        total = sum_y * y + sum_1
        left, right = 0.0, float(last_x - x0)
        for i in range(3):
            at = w[i, 1] * y + w[i, 2]
            left, right = _cut(w[i, 0] - low[i] * sum_x, at - low[i] * total, left, right)
            if high[i] < 1.0:
                left, right = _cut(high[i] * sum_x - w[i, 0], high[i] * total - at, left, right)
        if left <= right:
            first, last = max(0, math.ceil(left - MARGIN)), min(last_x - x0, math.floor(right + MARGIN))
            _meet_span(cameras, triangles, materials, samples, c, f, row, x0 + first, x0 + last + 1, ways)
            tests += last - first + 1
    return tests


@inlined
def _meet_span(
    cameras: Cameras,
    triangles: Triangles,
    materials: Materials,
    samples: Samples,
    c: int,
    f: int,
    row: int,
    left: int,
    stop: int,
    ways: np.ndarray,
) -> None:
    """Have the samples of camera c in a part of a row meet triangle f."""
    p_x, p_y, p_z = samples.rays[0, row, left:stop], samples.rays[1, row, left:stop], samples.rays[2, row, left:stop]
    d_x, d_y, d_z = samples.rays[3, row, left:stop], samples.rays[4, row, left:stop], samples.rays[5, row, left:stop]
    if meets(p_x, p_y, p_z, d_x, d_y, d_z, triangles, f, ways):
        owner, way, triangle = (
            samples.owner[row, left:stop],
            samples.way[row, left:stop],
            samples.triangle[row, left:stop],
        )
        for k in range(len(p_x)):
            if ways[k] < way[k] and owner[k] == c:
                direction = (d_x[k], d_y[k], d_z[k])
                if stops(cameras, triangles, materials, c, f, ways[k], direction):
                    way[k], triangle[k] = ways[k], f
