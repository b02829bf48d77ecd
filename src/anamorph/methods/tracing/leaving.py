"""How a ray leaves the triangle or surface where it has been bent: what it cannot meet there. Compiled.

It leaves by what it has left and by its own rounding, never by a share of the scene's size.
"""

from __future__ import annotations

import math

import numpy as np

from anamorph.base.compiled import inlined
from anamorph.base.vectors import Vector, along, cross, dot, unit
from anamorph.rays.caster import LEAST_STEP, ROUNDING

WITHIN = 2e-2
"""Barycentric weights, at least, of where a ray is put back into its lens."""

LEAST_CLIMB = 1e-6
"""The least slope, against a flat triangle, of a ray that leaves it: more than float32 makes of one along it."""


@inlined
def corner_of(positions: np.ndarray, vertex: int) -> Vector:
    return (np.float64(positions[vertex, 0]), np.float64(positions[vertex, 1]), np.float64(positions[vertex, 2]))


@inlined
def side_and_size(positions: np.ndarray, face: np.ndarray, direction: Vector) -> tuple[bool, float]:
    """Whether a ray hits a triangle's front, and the length of its longest edge."""
    a, b, c = corner_of(positions, face[0]), corner_of(positions, face[1]), corner_of(positions, face[2])
    edge_1, edge_2, edge_3 = along(b, -1.0, a), along(c, -1.0, b), along(a, -1.0, c)
    longest = math.sqrt(max(dot(edge_1, edge_1), dot(edge_2, edge_2), dot(edge_3, edge_3)))
    return dot(cross(edge_1, edge_2), direction) < 0.0, longest


@inlined
def rounding(origin: Vector, distance: float) -> float:
    """What float32 may put a place off by that lies `distance` along a ray."""
    return max(ROUNDING * (max(abs(origin[0]), abs(origin[1]), abs(origin[2])) + distance), LEAST_STEP)


@inlined
def climb(positions: np.ndarray, face: np.ndarray, left: int, direction: Vector) -> float:
    """The slope of a ray against the flat triangle that it leaves, on the side on which it does."""
    a = corner_of(positions, face[0])
    across = unit(cross(along(corner_of(positions, face[1]), -1.0, a), along(corner_of(positions, face[2]), -1.0, a)))
    return dot(across, direction) if left > 0 else -dot(across, direction)


@inlined
def put_back(positions: np.ndarray, face: np.ndarray, origin: Vector) -> Vector:
    """The point of a triangle that is next to where a ray has left its exact surface, a little within."""
    a, b, c = corner_of(positions, face[0]), corner_of(positions, face[1]), corner_of(positions, face[2])
    edge_1, edge_2, inside = along(b, -1.0, a), along(c, -1.0, a), along(origin, -1.0, a)
    area = cross(edge_1, edge_2)
    square = dot(area, area)
    u = max(dot(cross(inside, edge_2), area) / square, WITHIN)
    v = max(dot(cross(edge_1, inside), area) / square, WITHIN)
    w = max(1.0 - u - v, WITHIN)
    total = u + v + w
    return along(along(a, u / total, edge_1), v / total, edge_2)
