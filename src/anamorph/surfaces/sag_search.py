"""Where a ray meets a surface that is given by its sag: Newton's iteration along it; and derivatives. Compiled.

It is part of the machine code of each surface: what takes a function as an argument cannot be kept on disk alone.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from anamorph.base.compiled import inlined
from anamorph.base.vectors import Vector, along
from anamorph.surfaces.axes import into_axes, out_of_axes
from anamorph.surfaces.base import Expansion

Sag = tuple[bool, float, float, float]
"""Whether the surface reaches so far from its apex, its sag there, and the sag's slopes along x and y."""


@inlined
def _height(
    sag_at: Callable, shape: np.ndarray, origin: Vector, direction: Vector, distance: float
) -> tuple[bool, float, float, float, float]:
    """At `distance` along a ray: whether there is a surface, the height above it, its change, and the sag's slopes."""
    x = origin[0] + distance * direction[0]
    y = origin[1] + distance * direction[1]
    z = origin[2] + distance * direction[2]
    inside, sag, slope_x, slope_y = sag_at(shape, x, y)
    change = direction[2] + slope_x * direction[0] + slope_y * direction[1]
    return inside, z + sag, change, slope_x, slope_y


@inlined
def meet_sag(
    sag_at: Callable, numbers: np.ndarray, origin: Vector, direction: Vector, distance: float, facing: Vector
) -> tuple[bool, float, Vector]:
    """Refine a hit on a mesh to one on its exact surface, by its height above the surface, with halved steps.

    Parameters
    ----------
    sag_at : compiled function
        From a surface's shape and x, y in the plane that touches its apex: a `Sag`.
    numbers : float64 array
        `SagSurface.numbers`: apex, axes and shape.
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
    axes, shape = numbers[3:12], numbers[12:]
    origin = into_axes(axes, along(origin, -1.0, (numbers[0], numbers[1], numbers[2])))
    direction, facing = into_axes(axes, direction), into_axes(axes, facing)
    scale = abs(distance) + abs(origin[0]) + abs(origin[1]) + abs(origin[2])
    inside, height, change, slope_x, slope_y = _height(sag_at, shape, origin, direction, distance)
    side = 1.0 if facing[0] * slope_x + facing[1] * slope_y + facing[2] > 0.0 else -1.0
    met = False
    for _ in range(2):
        share = 1.0
        for _ in range(64):
            if not inside or abs(height) <= 1e-16 * scale or share < 1e-3 or change == 0.0:
                break
            tried = distance - share * height / change
            fits, next_height, next_change, next_x, next_y = _height(sag_at, shape, origin, direction, tried)
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
        fits, _, next_change, _, _ = _height(sag_at, shape, origin, direction, distance - side * step)
        bend = (change - next_change) / (side * step)
        if not fits or bend == 0.0:
            break
        distance -= 2.0 * change / bend
        inside, height, change, slope_x, slope_y = _height(sag_at, shape, origin, direction, distance)
    length = math.sqrt(1.0 + slope_x * slope_x + slope_y * slope_y)
    return met, distance, out_of_axes(axes, (slope_x / length, slope_y / length, 1.0 / length))


@inlined
def expand_sag(sag_at: Callable, bends_at: Callable, numbers: np.ndarray, place: Vector) -> Expansion:
    """The position at x and y of `place`, and its derivatives; of no use beyond the end of the surface."""
    axes, shape, zero = numbers[3:12], numbers[12:], (0.0, 0.0, 0.0)
    inside, sag, slope_x, slope_y = sag_at(shape, place[0], place[1])
    if not inside:
        return False, zero, zero, zero, zero, zero, zero
    xx, xy, yy = bends_at(shape, place[0], place[1])
    inward = (-axes[6], -axes[7], -axes[8])
    return (
        True,
        along((numbers[0], numbers[1], numbers[2]), 1.0, out_of_axes(axes, (place[0], place[1], -sag))),
        out_of_axes(axes, (1.0, 0.0, -slope_x)),
        out_of_axes(axes, (0.0, 1.0, -slope_y)),
        along(zero, xx, inward),
        along(zero, xy, inward),
        along(zero, yy, inward),
    )
