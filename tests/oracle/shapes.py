"""Where a ray meets a trimmed shape of any kind, and the shape's normal there."""

from __future__ import annotations

import math

import numpy as np

from oracle import trims
from oracle.quadrics import coefficients, quadric_normal, quadric_roots
from oracle.sags import ASPHERE, TOROID, next_crossing, sag, sag_numbers
from oracle.scene import Shape, Trim
from oracle.trims import inside_polygon, stretch
from oracle.vectors import along, compiled, into, out_of, scaled, unit, vector

QUADRIC = 0
WORDS, TRIM = 64, trims.WORDS


def packed(shape: Shape, trim: Trim) -> np.ndarray:
    """A shape as the compiled loop reads it: kind, side, origin, axes, trim, numbers."""
    kind = {"toroid": TOROID, "asphere": ASPHERE}.get(shape.kind, QUADRIC)
    numbers = coefficients(shape) if kind == QUADRIC else sag_numbers(shape)
    row = np.concatenate([[kind, shape.side], shape.origin, np.ravel(shape.axes), trims.packed(trim), numbers])
    return np.pad(row, (0, WORDS - len(row)))


@compiled
def meet_shape(row, origin, direction, best, leaving):
    """The distance at which a ray meets a trimmed shape before `best`; infinite where it does not."""
    trim = row[14 : 14 + TRIM]
    start, end = stretch(trim, origin, direction)
    end = min(end, best)
    if not start < end:
        return math.inf
    place, way = into(row[5:14], along(origin, -1.0, vector(row, 2))), into(row[5:14], direction)
    numbers = row[14 + TRIM :]
    if row[0] == QUADRIC:
        for distance in quadric_roots(numbers, place, way, leaving):
            ahead = 0.0 < distance < best and start <= distance <= end
            if ahead and inside_polygon(trim, along(origin, distance, direction)):
                return distance
        return math.inf
    kind = int(row[0])
    if end == math.inf:
        return math.inf
    distance = next_crossing(kind, numbers, place, way, start, end, leaving and start == 0.0)
    while distance < best and not inside_polygon(trim, along(origin, distance, direction)):
        distance = next_crossing(kind, numbers, place, way, distance, end, True)
    return distance if distance < best else math.inf


@compiled
def shape_normal(row, point):
    """The unit normal of a shape, toward the part's outside, at a point on it."""
    place, numbers = into(row[5:14], along(point, -1.0, vector(row, 2))), row[14 + TRIM :]
    if row[0] == QUADRIC:
        local = quadric_normal(numbers, place)
    else:
        _, _, slope_x, slope_y = sag(int(row[0]), numbers, place[0], place[1])
        local = slope_x, slope_y, 1.0
    return unit(scaled(row[1], out_of(row[5:14], local)))
