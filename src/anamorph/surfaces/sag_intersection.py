"""Where a ray meets a toroid or an even asphere, in the surface's own coordinates. Compiled.

Newton's iteration along the ray on its height above the surface, with halved steps. The shapes are those of
surfaces/sag.py: x and y in the plane that touches the apex, z outward, z = -sag(x, y) on the surface.
"""

from __future__ import annotations

import math

import numpy as np

from anamorph.base.compiled import compiled
from anamorph.base.vectors import Vector

Sag = tuple[bool, float, float, float]
"""Whether the surface reaches so far from its apex, its sag there, and the sag's slopes along x and y."""


@compiled
def toroid(shape: np.ndarray, x: float, y: float) -> Sag:
    """`shape`: base curvature, cross curvature."""
    base, cross = shape[0], shape[1]
    arc_square = 1.0 - cross * cross * y * y
    if arc_square <= 0.0:
        return False, 0.0, 0.0, 0.0
    arc_root = math.sqrt(arc_square)
    arc = cross * y * y / (1.0 + arc_root)
    lever = 1.0 - base * arc
    square = lever * lever - base * base * x * x
    if square <= 0.0 or lever <= 0.0:
        return False, 0.0, 0.0, 0.0
    root = math.sqrt(square)
    sag = (2.0 * arc - base * arc * arc + base * x * x) / (1.0 + root)
    return True, sag, base * x / root, lever * cross * y / (arc_root * root)


@compiled
def asphere(shape: np.ndarray, x: float, y: float) -> Sag:
    """`shape`: curvature, conic constant, number of coefficients, coefficients."""
    distance = x * x + y * y
    square = 1.0 - (1.0 + shape[1]) * shape[0] * shape[0] * distance
    if square <= 0.0:
        return False, 0.0, 0.0, 0.0
    root = math.sqrt(square)
    value, slope = 0.0, 0.0
    for number in range(int(shape[2]) - 1, -1, -1):
        value = value * distance + shape[3 + number]
        slope = slope * distance + (number + 2) * shape[3 + number]
    sag = shape[0] * distance / (1.0 + root) + distance * distance * value
    steep = shape[0] / root + 2.0 * distance * slope
    return True, sag, steep * x, steep * y


@compiled
def _height(
    turned: bool, shape: np.ndarray, origin: Vector, direction: Vector, distance: float
) -> tuple[bool, float, float, float, float]:
    """At `distance` along a ray: whether there is a surface, the height above it, its change, and the sag's slopes."""
    x = origin[0] + distance * direction[0]
    y = origin[1] + distance * direction[1]
    z = origin[2] + distance * direction[2]
    inside, sag, slope_x, slope_y = toroid(shape, x, y) if turned else asphere(shape, x, y)
    change = direction[2] + slope_x * direction[0] + slope_y * direction[1]
    return inside, z + sag, change, slope_x, slope_y


@compiled
def meet_sag(
    turned: bool, shape: np.ndarray, origin: Vector, direction: Vector, distance: float, facing: Vector
) -> tuple[bool, float, Vector]:
    """Refine a hit on a mesh to one on its exact surface.

    Parameters
    ----------
    turned : bool
        Whether `shape` is that of a toroid; else that of an asphere.
    shape : float64 array
    origin, direction, facing : three float64 each
        The ray (unit direction), and the mesh's normal against it.
    distance : float
        Where the ray hits the mesh.

    Returns
    -------
    met : bool
    distance : float
    normal : three float64
        Unit, outward.
    """
    scale = abs(distance) + abs(origin[0]) + abs(origin[1]) + abs(origin[2])
    inside, height, change, slope_x, slope_y = _height(turned, shape, origin, direction, distance)
    side = 1.0 if facing[0] * slope_x + facing[1] * slope_y + facing[2] > 0.0 else -1.0
    met = False
    for _ in range(2):
        share = 1.0
        for _ in range(64):
            if not inside or abs(height) <= 1e-16 * scale or share < 1e-3 or change == 0.0:
                break
            tried = distance - share * height / change
            fits, next_height, next_change, next_x, next_y = _height(turned, shape, origin, direction, tried)
            if fits and abs(next_height) < abs(height):
                distance, height, change, slope_x, slope_y = tried, next_height, next_change, next_x, next_y
                share = min(2.0 * share, 1.0)
            else:
                share *= 0.5
        met = inside and abs(height) <= 1e-12 * scale
        if not met or side * change < 0.0:
            break
        # The ray leaves where it should enter, or the other way: the other root lies beyond the turning point.
        met = False
        step = 1e-5 * scale
        fits, _, next_change, _, _ = _height(turned, shape, origin, direction, distance - side * step)
        bend = (change - next_change) / (side * step)
        if not fits or bend == 0.0:
            break
        distance -= 2.0 * change / bend
        inside, height, change, slope_x, slope_y = _height(turned, shape, origin, direction, distance)
    length = math.sqrt(1.0 + slope_x * slope_x + slope_y * slope_y)
    return met, distance, (slope_x / length, slope_y / length, 1.0 / length)
