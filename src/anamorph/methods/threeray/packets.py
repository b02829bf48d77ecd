"""Samples of small cameras go through the tree themselves, in packets of neighbours. Compiled.

A camera of a few samples would look at more surfels than these meet. Their rays go through the tree together instead,
tile by tile of the image, whichever cameras they belong to.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from anamorph.base.compiled import compiled, inlined
from anamorph.methods.threeray.cameras_seen import Cameras
from anamorph.methods.threeray.objects import Materials
from anamorph.methods.threeray.sample_rays import Samples
from anamorph.methods.threeray.scene_triangles import Triangles, meets, stops
from anamorph.methods.threeray.surfel_tree import Nodes

TILE = 8
"""Columns and rows of samples that go through the tree together."""

PACKET = TILE * TILE

LEAST_SLOPE = 1e-30
"""A direction's coordinate of a smaller share of it is as if it were this."""


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
            work[tile, 0], work[tile, 1] = _follow(cameras, nodes, triangles, materials, packet, count)
            work[tile, 3] = count * work[tile, 1]
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
    """Have a packet go through the tree: where one ray goes, all do. Returns how many nodes and surfels were asked."""
    rays, inverse, way, ways = packet.rays, packet.inverse, packet.way[:count], packet.ways[:count]
    p_x, p_y, p_z = rays[0, :count], rays[1, :count], rays[2, :count]
    d_x, d_y, d_z = rays[3, :count], rays[4, :count], rays[5, :count]
    i_x, i_y, i_z = inverse[0, :count], inverse[1, :count], inverse[2, :count]
    node, bounded, asked = 0, 0, 0
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
            asked += 1
            f = nodes.triangle[s]
            if meets(p_x, p_y, p_z, d_x, d_y, d_z, triangles, f, ways):
                for k in range(count):
                    direction = (d_x[k], d_y[k], d_z[k])
                    if ways[k] < way[k] and stops(
                        cameras, triangles, materials, packet.camera[k], f, ways[k], direction
                    ):
                        way[k], packet.triangle[k] = ways[k], f
        node += 1
    return bounded, asked


@inlined
def _inverse(d: float, least: float) -> float:
    return 1.0 / d if abs(d) > least else math.copysign(1.0 / least, d)
