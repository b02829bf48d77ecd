"""What each sample's own ray meets first, of the surfels that its camera may see. Compiled.

For each camera the tree is traversed. Each surfel that may be seen is bounded by a range of each weight, which is a
polygon of up to six sides in the image, and the rays of the camera's samples in it meet the surfel's triangle: of
several the nearest along the ray. The samples of two cameras are never the same, so that cores share nothing.
"""

from __future__ import annotations

import numpy as np

from anamorph.base.compiled import compiled, inlined
from anamorph.base.vectors import Vector
from anamorph.methods.threeray.cameras_seen import Cameras
from anamorph.methods.threeray.objects import Materials
from anamorph.methods.threeray.sample_rays import Samples
from anamorph.methods.threeray.sample_spans import columns_within, rows_within
from anamorph.methods.threeray.scene_triangles import Triangles, meets, stops
from anamorph.methods.threeray.surfel_tree import Nodes
from anamorph.raytriangle.bounds import seen_weights
from anamorph.raytriangle.camera_frames import Frames, vector
from anamorph.raytriangle.owners import Places
from anamorph.raytriangle.walls import Walls, meets_volume


@compiled
def look(
    cameras: Cameras,
    frames: Frames,
    walls: Walls | None,
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

    Frames and walls are those of the chosen cameras alone. Boxes are told by walls, or by bounds where there are none:
    that is compiled by itself. `work` (len(chosen), 4) is filled, see `WORK`; `ways` (width,) and `space` (26,) float64
    are the core's own, for what it is asking.
    """
    for number in range(start, stop):
        c, node, bounded, asked, boxes, tests = chosen[number], 0, 0, 0, 0, 0
        while node < len(nodes.size):
            middle, half = vector(nodes.middle[node]), vector(nodes.half[node])
            bounded += 1
            shape = (half[0], half[1], half[2], 0.0, 0.0, 0.0)
            if walls is None:
                seen, low, high = seen_weights(frames, number, middle, shape, True)
            else:
                seen = meets_volume(frames, walls, number, middle, half, space)
            if not seen:
                node += nodes.size[node]
                continue
            for s in range(nodes.first[node], nodes.first[node] + nodes.held[node]):
                asked += 1
                v = nodes.covariance[s]
                shape = (v[0], v[1], v[2], v[3], v[4], v[5])
                seen, low, high = seen_weights(frames, number, vector(nodes.center[s]), shape, False)
                if seen:
                    boxes += 1
                    f = nodes.triangle[s]
                    tests += _meet_within(cameras, places, triangles, materials, samples, c, f, low, high, ways)
            node += 1
        work[number, 0], work[number, 1], work[number, 2], work[number, 3] = bounded, asked, boxes, tests


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
    x0, y0, x1, y1 = places.box[c, 0], places.box[c, 1], places.box[c, 2], places.box[c, 3]
    tests = 0
    first, stop = rows_within(cameras.image[c], low, high, y0, y1)
    for row in range(first, stop):
        left, right = columns_within(places.weights[c], row - y0, low, high, x1 - x0)
        if left < right:
            _meet_span(cameras, triangles, materials, samples, c, f, row, x0 + left, x0 + right, ways)
            tests += right - left
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
