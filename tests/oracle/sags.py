"""Where a ray meets a toroid or an even asphere, which are given by their sag below the plane at their apex."""

from __future__ import annotations

import math

from oracle.scene import Shape
from oracle.vectors import along, compiled

TOROID, ASPHERE = 1, 2

STEPS = 32
"""Into how many pieces the stretch of a ray is cut in which the surface can be."""


def sag_numbers(shape: Shape) -> tuple[float, ...]:
    """The shape's numbers as the compiled loop reads them."""
    if shape.kind == "toroid":
        return shape.numbers
    return *shape.numbers[:2], float(len(shape.numbers) - 2), *shape.numbers[2:]


@compiled
def sag(kind, numbers, x, y):
    """Whether the surface reaches so far from its axis, its depth there, and the depth's slopes along x and y.

    The toroid is an arc along y, 1/cross its radius, turned about an axis along y that is 1/base below the apex.
    """
    if kind == TOROID:
        base, cross = numbers[0], numbers[1]
        under = 1.0 - (cross * y) ** 2
        if under <= 0.0:
            return False, 0.0, 0.0, 0.0
        cosine = math.sqrt(under)
        arc = cross * y * y / (1.0 + cosine)
        lever = 1.0 - base * arc
        under = lever * lever - (base * x) ** 2
        if lever <= 0.0 or under <= 0.0:
            return False, 0.0, 0.0, 0.0
        turned = math.sqrt(under)
        depth = (arc * (2.0 - base * arc) + base * x * x) / (1.0 + turned)
        return True, depth, base * x / turned, lever * cross * y / (cosine * turned)
    curvature, conic = numbers[0], numbers[1]
    radius2 = x * x + y * y
    under = 1.0 - (1.0 + conic) * curvature * curvature * radius2
    if under <= 0.0:
        return False, 0.0, 0.0, 0.0
    cosine = math.sqrt(under)
    depth, slope = curvature * radius2 / (1.0 + cosine), curvature / cosine
    power = radius2
    for i in range(int(numbers[2])):
        slope += (4 + 2 * i) * numbers[3 + i] * power
        depth += numbers[3 + i] * power * radius2
        power *= radius2
    return True, depth, slope * x, slope * y


@compiled
def height(kind, numbers, origin, direction, distance):
    """Along a ray: whether the surface is below or above, the height above it, and that height's change."""
    x, y, z = along(origin, distance, direction)
    there, depth, slope_x, slope_y = sag(kind, numbers, x, y)
    return there, z + depth, direction[2] + slope_x * direction[0] + slope_y * direction[1]


@compiled
def turning(kind, numbers, origin, direction, low, high):
    """Where between two distances, at which the height changes in opposite ways, it does not change."""
    change = height(kind, numbers, origin, direction, low)[2]
    for _ in range(60):
        middle = 0.5 * (low + high)
        if (height(kind, numbers, origin, direction, middle)[2] < 0.0) == (change < 0.0):
            low = middle
        else:
            high = middle
    return 0.5 * (low + high)


@compiled
def crossing(kind, numbers, origin, direction, low, high, above):
    """Where between two distances the ray goes through the surface: Newton's steps, kept in by halving.

    `above` is whether the ray is above the surface just after `low`.
    """
    middle = 0.5 * (low + high)
    for _ in range(200):
        _, value, change = height(kind, numbers, origin, direction, middle)
        if value == 0.0:
            break
        if (value > 0.0) == above:
            low = middle
        else:
            high = middle
        following = middle - value / change if change != 0.0 else low
        if not low < following < high:
            following = 0.5 * (low + high)
        if abs(following - middle) <= 4e-16 * abs(middle) or following in (low, high):
            middle = following
            break
        middle = following
    return middle


@compiled
def next_crossing(kind, numbers, origin, direction, start, end, leaving):
    """The first distance between `start` and `end` at which a ray meets the surface; infinite where it does not.

    A ray that leaves the surface is, just after `start`, on the side to which the height changes there.
    """
    step = (end - start) / STEPS
    there, value, change = height(kind, numbers, origin, direction, start)
    above = change > 0.0 if leaving else value > 0.0
    for i in range(STEPS):
        low, high = start + i * step, start + (i + 1) * step if i + 1 < STEPS else end
        reaches, next_value, next_change = height(kind, numbers, origin, direction, high)
        if there and reaches:
            if (next_value > 0.0) != above:
                return crossing(kind, numbers, origin, direction, low, high, above)
            nearing = (change < 0.0) == above
            if nearing and (next_change < 0.0) != above:
                middle = turning(kind, numbers, origin, direction, low, high)
                if (height(kind, numbers, origin, direction, middle)[1] > 0.0) != above:
                    return crossing(kind, numbers, origin, direction, low, middle, above)
        there, value, change, above = reaches, next_value, next_change, next_value > 0.0
    return math.inf
