"""Triangles, and the tree of boxes that finds those in a ray's way."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from oracle.scene import Mesh
from oracle.vectors import along, compiled, cross, dot

LEAF = 4
"""Triangles that a box may hold without being divided."""

ROUNDING = 1e-15
"""By how much rounding may change a number, as a share of the numbers that it is made of."""

OVERLAP = 1e-7
"""The most by which triangles may overlap, in barycentric coordinates, so that no ray slips through between two."""


class Triangles(NamedTuple):
    """All triangles of a scene, in the order of the tree's leaves."""

    corners: np.ndarray
    """(F, 3, 3) float64: one corner, and the edges from it to the two others."""
    normals: np.ndarray
    """(F, 3, 3) float64, at the corners."""
    part: np.ndarray
    """(F,) int64: the object's number."""
    low: np.ndarray
    """(B, 3) float64: the boxes."""
    high: np.ndarray
    children: np.ndarray
    """(B, 4) int64: the lower child and the other, -1 for a leaf; the first triangle, and how many."""
    axis: np.ndarray
    """(B,) int64: along which it is divided."""


def triangles_of(meshes: list[tuple[int, Mesh]]) -> Triangles:
    """The triangles of meshes with their objects' numbers, and the tree over them."""
    corners = [mesh.positions[mesh.faces] for _, mesh in meshes] or [np.zeros((0, 3, 3))]
    normals = [mesh.normals[mesh.faces] for _, mesh in meshes] or [np.zeros((0, 3, 3))]
    part = [np.full(len(mesh.faces), number) for number, mesh in meshes] or [np.zeros(0, np.int64)]
    points, directions, owner = np.concatenate(corners), np.concatenate(normals), np.concatenate(part)
    order, low, high, children, axis = _tree(points.min(axis=1), points.max(axis=1))
    points = points[order]
    edges = np.stack([points[:, 0], points[:, 1] - points[:, 0], points[:, 2] - points[:, 0]], axis=1)
    return Triangles(edges, directions[order], owner[order].astype(np.int64), low, high, children, axis)


def _tree(low: np.ndarray, high: np.ndarray) -> tuple[np.ndarray, ...]:
    """Boxes over boxes, divided at the median of their middles along the longest side."""
    middle, order = 0.5 * (low + high), np.arange(len(low))
    rows, lows, highs, axes = [[-1, -1, 0, len(low)]], [np.full(3, np.inf)], [np.full(3, -np.inf)], [0]
    waiting = [0] if len(low) else []
    while waiting:
        box = waiting.pop()
        first, count = rows[box][2:]
        own = order[first : first + count]
        room = ROUNDING * np.maximum(np.abs(low[own]), np.abs(high[own])).max()
        lows[box], highs[box] = low[own].min(axis=0) - room, high[own].max(axis=0) + room
        if count <= LEAF:
            continue
        axes[box] = int(np.ptp(middle[own], axis=0).argmax())
        half = count // 2
        order[first : first + count] = own[np.argpartition(middle[own, axes[box]], half)]
        rows[box][:2] = len(rows), len(rows) + 1
        waiting += rows[box][:2]
        rows += [[-1, -1, first, half], [-1, -1, first + half, count - half]]
        lows, highs, axes = [*lows, None, None], [*highs, None, None], [*axes, 0, 0]
    return order, np.array(lows), np.array(highs), np.array(rows, np.int64), np.array(axes, np.int64)


@compiled
def _enters(low, high, origin, inverse, best):
    """Whether a ray is in a box before the distance `best`."""
    start, end = 0.0, best
    for axis in range(3):
        one, other = (low[axis] - origin[axis]) * inverse[axis], (high[axis] - origin[axis]) * inverse[axis]
        start, end = max(start, min(one, other)), min(end, max(one, other))
    return start <= end + 1e-12 * abs(end)


@compiled
def meet_triangle(corners, origin, direction):
    """The distance of a triangle along a ray, not positive where it is missed, and the other corners' weights."""
    a = corners[0, 0], corners[0, 1], corners[0, 2]
    edge_1 = corners[1, 0], corners[1, 1], corners[1, 2]
    edge_2 = corners[2, 0], corners[2, 1], corners[2, 2]
    turned = cross(direction, edge_2)
    volume = dot(edge_1, turned)
    if volume == 0.0:
        return -1.0, 0.0, 0.0
    offset = along(origin, -1.0, a)
    u = dot(offset, turned) / volume
    size = (abs(offset[0]) + abs(offset[1]) + abs(offset[2])) / abs(volume)
    edges = max(abs(edge_1[0]) + abs(edge_1[1]) + abs(edge_1[2]), abs(edge_2[0]) + abs(edge_2[1]) + abs(edge_2[2]))
    overlap = min(ROUNDING * size * edges, OVERLAP)
    if u < -overlap or u > 1.0 + overlap:
        return -1.0, 0.0, 0.0
    lifted = cross(offset, edge_1)
    v = dot(direction, lifted) / volume
    if v < -overlap or u + v > 1.0 + overlap:
        return -1.0, 0.0, 0.0
    return dot(edge_2, lifted) / volume, u, v


@compiled
def meet_triangles(triangles, origin, direction, best, left, left_part):
    """The triangle that a ray meets first before the distance `best`: distance, triangle (-1: none) and weights.

    The triangle `left` is the one that the ray leaves: it is not met. Others of the same part are met only where
    rounding cannot have put the origin behind them.
    """
    found, found_u, found_v = -1, 0.0, 0.0
    largest = max(abs(origin[0]), abs(origin[1]), abs(origin[2]))
    inverse = np.empty(3)
    for axis in range(3):
        inverse[axis] = 1.0 / direction[axis] if direction[axis] != 0.0 else 1e300
    waiting = np.empty(64, np.int64)
    waiting[0], count = 0, 1
    while count:
        count -= 1
        box = waiting[count]
        if not _enters(triangles.low[box], triangles.high[box], origin, inverse, best):
            continue
        if triangles.children[box, 0] >= 0:
            lower = 0 if direction[triangles.axis[box]] > 0.0 else 1
            waiting[count] = triangles.children[box, 1 - lower]
            waiting[count + 1] = triangles.children[box, lower]
            count += 2
            continue
        first = triangles.children[box, 2]
        for triangle in range(first, first + triangles.children[box, 3]):
            if triangle == left:
                continue
            distance, u, v = meet_triangle(triangles.corners[triangle], origin, direction)
            nearest = 4.0 * ROUNDING * largest if triangles.part[triangle] == left_part else 0.0
            if nearest < distance < best:
                best, found, found_u, found_v = distance, triangle, u, v
    return best, found, found_u, found_v
