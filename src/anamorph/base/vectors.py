"""Vectors of three as tuples, which compiled loops keep in registers. Compiled."""

from __future__ import annotations

import math
from collections.abc import Iterable

from anamorph.base.compiled import compiled

Vector = tuple[float, float, float]


def tuple_of(values: Iterable[float]) -> Vector:
    """Three numbers, such as an array's, as a tuple of Python's."""
    x, y, z = (float(value) for value in values)
    return (x, y, z)


@compiled
def dot(a: Vector, b: Vector) -> float:
    """Scalar product of two tuples of three."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@compiled
def along(origin: Vector, distance: float, direction: Vector) -> Vector:
    """The point `distance` along a ray."""
    return (
        origin[0] + distance * direction[0],
        origin[1] + distance * direction[1],
        origin[2] + distance * direction[2],
    )


@compiled
def cross(a: Vector, b: Vector) -> Vector:
    """Vector product of two tuples of three."""
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


@compiled
def unit(a: Vector) -> Vector:
    """A tuple of three at length one."""
    scale = 1.0 / math.sqrt(dot(a, a))
    return (a[0] * scale, a[1] * scale, a[2] * scale)


@compiled
def across(a: Vector) -> tuple[Vector, Vector]:
    """Two unit vectors that make a right-handed frame with a unit vector, which is the third."""
    first = unit(cross((0.0, 1.0, 0.0), a)) if abs(a[1]) < 0.8 else unit(cross((1.0, 0.0, 0.0), a))
    return first, cross(a, first)
