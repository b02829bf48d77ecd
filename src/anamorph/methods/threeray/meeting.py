"""What each sample's own ray meets first, of the surfels that its camera may see. Compiled.

For each camera the tree is traversed. Each surfel that may be seen is bounded by a range of each weight, which is a
polygon of up to six sides in the image, and the rays of the camera's samples in it meet the surfel's triangle: of
several the nearest along the ray. A camera of a few samples would look at more surfels than these meet: there the rays
go through the tree themselves. The samples of two cameras are never the same, so that cores share nothing.

Source: Mei, Popescu and Sacks 2007, section 6. Deviation: the paper projects points by the camera's cubic and draws
squares, which leave holes, and leak where surfaces touch. Rays that meet triangles do neither.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from anamorph.base.compiled import compiled, inlined
from anamorph.base.vectors import Vector, dot
from anamorph.methods.threeray.bounds import Range, seen_weights
from anamorph.methods.threeray.camera_frames import Frames, vector
from anamorph.methods.threeray.cameras_seen import Cameras, Places
from anamorph.methods.threeray.objects import Materials
from anamorph.methods.threeray.sample_rays import Samples
from anamorph.rays.caster import ROUNDING

GRAIN = 8
"""Cameras that a core takes at a time."""

FEW = 160
"""With so many samples or fewer it does not pay for a camera to look: they go through the tree with others."""

TILE = 8
"""Columns and rows of samples that go through the tree together."""

PACKET = TILE * TILE

LEAST_SLOPE = 1e-30
"""A direction's coordinate of a smaller share of it is as if it were this."""

BORDER = 6e-8
"""How far beyond a triangle's border a ray still meets it, as a share of the triangle: half a float32's last place."""

MARGIN = 1e-6
"""Samples, and weights, by which the polygon of a surfel is widened."""

WORK = "nodes", "surfels", "boxes", "tests"
"""What is counted: nodes and surfels that were bounded, surfels that may be seen, and samples that were asked."""


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


class Packet(NamedTuple):
    """Rays of neighbouring samples that go through the tree together, up to `PACKET` of them."""

    rays: np.ndarray
    """(6, PACKET) float64: origins and directions."""
    inverse: np.ndarray
    """(3, PACKET) float64: one over the directions."""
    way: np.ndarray
    """(PACKET,) float64: the t of what is met; infinite at first."""
    ways: np.ndarray
    """(PACKET,) float64: the t at which the triangle is met that is asked now."""
    camera: np.ndarray
    """(PACKET,) int32"""
    triangle: np.ndarray
    """(PACKET,) int32: what is met."""
    place: np.ndarray
    """(PACKET, 2) int64: the rows and columns of the samples."""

    @classmethod
    def reserved(cls) -> Packet:
        """A packet that is not filled."""
        return cls(
            np.empty((6, PACKET)), np.empty((3, PACKET)), np.empty(PACKET), np.empty(PACKET),
            np.empty(PACKET, np.int32), np.empty(PACKET, np.int32), np.empty((PACKET, 2), np.int64),
        )  # fmt: skip


class Triangles(NamedTuple):
    """The scene's triangles as compiled loops read them: vectors that give numbers of a point x, (F, 4) float64."""

    plane: np.ndarray
    """n and n . a: the normal, of the length of twice the area, and the first corner's height."""
    second: np.ndarray
    """m and m . a: m . x - m . a is the weight of the second corner at a point of the plane."""
    third: np.ndarray
    """The same of the third corner."""
    item: np.ndarray
    """(F,) int64: the object number."""


def triangles_of(corners: np.ndarray, face_object: np.ndarray) -> Triangles:
    """The triangles with these corners (F, 3, 3); those without an area are met by nothing."""
    a, b, c = np.moveaxis(corners, 1, 0)
    normal = np.cross(b - a, c - a)
    square = np.einsum("fi,fi->f", normal, normal)[:, None]
    square = np.where(square > 0.0, square, 1.0)
    vectors = normal, np.cross(c - a, normal) / square, np.cross(normal, b - a) / square
    rows = [np.column_stack([each, np.einsum("fi,fi->f", each, a)]) for each in vectors]
    return Triangles(rows[0], rows[1], rows[2], np.asarray(face_object).astype(np.int64))


@compiled
def look(
    cameras: Cameras,
    frames: Frames,
    places: Places,
    nodes: Nodes,
    triangles: Triangles,
    materials: Materials,
    samples: Samples,
    chosen: np.ndarray,
    work: np.ndarray,
    ways: np.ndarray,
    start: int,
    stop: int,
) -> None:
    """Have the samples of cameras `chosen[start:stop]` meet what these may see.

    `work` (len(chosen), 4) is filled, see `WORK`; `ways` (width,) float64 are the core's own, for what it is asking.
    """
    for number in range(start, stop):
        c, node, bounded, asked, boxes, tests = chosen[number], 0, 0, 0, 0, 0
        while node < len(nodes.size):
            half = vector(nodes.half[node])
            bounded += 1
            shape = (half[0], half[1], half[2], 0.0, 0.0, 0.0)
            seen, low, high = seen_weights(frames, c, vector(nodes.middle[node]), shape, True)
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


@compiled
def follow(
    cameras: Cameras,
    nodes: Nodes,
    triangles: Triangles,
    materials: Materials,
    samples: Samples,
    alone: np.ndarray,
    rectangle: tuple[int, int, int, int],
    packet: Packet,
    work: np.ndarray,
    start: int,
    stop: int,
) -> None:
    """Have the samples of cameras that are `alone` (K,) go through the tree, tile by tile of a rectangle.

    The tiles are those from `start` to `stop`, row by row; `work` (tiles, 4) is filled, see `WORK`.
    """
    columns = -(-(rectangle[2] - rectangle[0]) // TILE)
    for tile in range(start, stop):
        x0, y0 = rectangle[0] + TILE * (tile % columns), rectangle[1] + TILE * (tile // columns)
        count = 0
        for row in range(y0, min(y0 + TILE, rectangle[3])):
            for column in range(x0, min(x0 + TILE, rectangle[2])):
                c = samples.owner[row, column]
                if c >= 0 and alone[c]:
                    _join(packet, count, samples, c, row, column)
                    count += 1
        if count > 0:
            work[tile, 0], work[tile, 3] = _follow(cameras, nodes, triangles, materials, packet, count)
        for k in range(count):
            row, column = packet.place[k, 0], packet.place[k, 1]
            samples.way[row, column], samples.triangle[row, column] = packet.way[k], packet.triangle[k]


@inlined
def _join(packet: Packet, k: int, samples: Samples, c: int, row: int, column: int) -> None:
    """Put a sample of camera c into a packet."""
    total = 0.0
    for axis in range(3):
        packet.rays[axis, k] = samples.rays[axis, row, column]
        packet.rays[3 + axis, k] = samples.rays[3 + axis, row, column]
        total += abs(packet.rays[3 + axis, k])
    for axis in range(3):
        packet.inverse[axis, k] = _inverse(packet.rays[3 + axis, k], LEAST_SLOPE * total)
    packet.way[k], packet.triangle[k], packet.camera[k] = np.inf, -1, c
    packet.place[k, 0], packet.place[k, 1] = row, column


@inlined
def _follow(
    cameras: Cameras, nodes: Nodes, triangles: Triangles, materials: Materials, packet: Packet, count: int
) -> tuple[int, int]:
    """Have a packet go through the tree: where one ray goes, all do. Returns how many nodes and tests there were."""
    rays, inverse, way, ways = packet.rays, packet.inverse, packet.way[:count], packet.ways[:count]
    p_x, p_y, p_z = rays[0, :count], rays[1, :count], rays[2, :count]
    d_x, d_y, d_z = rays[3, :count], rays[4, :count], rays[5, :count]
    i_x, i_y, i_z = inverse[0, :count], inverse[1, :count], inverse[2, :count]
    node, bounded, tests = 0, 0, 0
    while node < len(nodes.size):
        bounded += 1
        m_x, m_y, m_z = nodes.middle[node, 0], nodes.middle[node, 1], nodes.middle[node, 2]
        h_x, h_y, h_z = nodes.half[node, 0], nodes.half[node, 1], nodes.half[node, 2]
        some = False
        for k in range(len(p_x)):
            middle_x, middle_y, middle_z = (m_x - p_x[k]) * i_x[k], (m_y - p_y[k]) * i_y[k], (m_z - p_z[k]) * i_z[k]
            half_x, half_y, half_z = h_x * abs(i_x[k]), h_y * abs(i_y[k]), h_z * abs(i_z[k])
            first = max(0.0, max(middle_x - half_x, max(middle_y - half_y, middle_z - half_z)))
            last = min(way[k], min(middle_x + half_x, min(middle_y + half_y, middle_z + half_z)))
            some = some | (first <= last)
        if not some:
            node += nodes.size[node]
            continue
        for s in range(nodes.first[node], nodes.first[node] + nodes.held[node]):
            tests += count
            f = nodes.triangle[s]
            if _ask(p_x, p_y, p_z, d_x, d_y, d_z, triangles, f, ways):
                for k in range(count):
                    direction = (d_x[k], d_y[k], d_z[k])
                    if ways[k] < way[k] and _stops(
                        cameras, triangles, materials, packet.camera[k], f, ways[k], direction
                    ):
                        way[k], packet.triangle[k] = ways[k], f
        node += 1
    return bounded, tests


@inlined
def _inverse(d: float, least: float) -> float:
    return 1.0 / d if abs(d) > least else math.copysign(1.0 / least, d)


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
    if _ask(p_x, p_y, p_z, d_x, d_y, d_z, triangles, f, ways):
        owner, way, triangle = (
            samples.owner[row, left:stop],
            samples.way[row, left:stop],
            samples.triangle[row, left:stop],
        )
        for k in range(len(p_x)):
            if ways[k] < way[k] and owner[k] == c:
                direction = (d_x[k], d_y[k], d_z[k])
                if _stops(cameras, triangles, materials, c, f, ways[k], direction):
                    way[k], triangle[k] = ways[k], f


@inlined
def _ask(
    p_x: np.ndarray,
    p_y: np.ndarray,
    p_z: np.ndarray,
    d_x: np.ndarray,
    d_y: np.ndarray,
    d_z: np.ndarray,
    triangles: Triangles,
    f: int,
    ways: np.ndarray,
) -> bool:
    """Fill the `ways` t at which rays meet triangle f, infinite where they do not; whether any does."""
    n_x, n_y, n_z, n_a = triangles.plane[f, 0], triangles.plane[f, 1], triangles.plane[f, 2], triangles.plane[f, 3]
    u_x, u_y, u_z, u_a = triangles.second[f, 0], triangles.second[f, 1], triangles.second[f, 2], triangles.second[f, 3]
    v_x, v_y, v_z, v_a = triangles.third[f, 0], triangles.third[f, 1], triangles.third[f, 2], triangles.third[f, 3]
    some = False
    # Without a branch, and along slices, the processor asks several at once.
    for k in range(len(p_x)):
        t = (n_a - (n_x * p_x[k] + n_y * p_y[k] + n_z * p_z[k])) / (n_x * d_x[k] + n_y * d_y[k] + n_z * d_z[k])
        x, y, z = p_x[k] + t * d_x[k], p_y[k] + t * d_y[k], p_z[k] + t * d_z[k]
        u, v = u_x * x + u_y * y + u_z * z - u_a, v_x * x + v_y * y + v_z * z - v_a
        met = (u >= -BORDER) & (v >= -BORDER) & (u + v <= 1.0 + BORDER) & (t >= 0.0)
        ways[k] = t if met else np.inf
        some = some | met
    return some


@inlined
def _stops(
    cameras: Cameras, triangles: Triangles, materials: Materials, c: int, f: int, t: float, direction: Vector
) -> bool:
    """Whether a ray of camera c that meets triangle f at t ends there.

    It does not where it has just started, nor where it passes the back of the surface that it leaves, as paths do in
    `methods.tracing.bounces`.
    """
    left, surface = cameras.left[c], materials.surface
    if t < cameras.near[c]:
        return False
    own = left > 0 and surface[left] == surface[triangles.item[f]]
    if not own or dot(vector(triangles.plane[f]), direction) <= 0.0:
        return True
    distance = t * math.sqrt(dot(direction, direction))
    if materials.curved[left]:
        return distance >= cameras.longest[c]
    rise = t * dot(direction, vector(cameras.normal[c]))
    return rise >= cameras.rounding[c] + ROUNDING * (distance + cameras.longest[c])
