"""The part of a shape that is there: which stretch of a ray lies in its prism."""

from __future__ import annotations

import math

import numpy as np

from oracle.scene import Trim
from oracle.vectors import along, compiled, into, vector

WORDS = 17


def packed(trim: Trim) -> np.ndarray:
    """The trim as the compiled loop reads it, (17,) float64."""
    sizes = trim.radius, trim.low, trim.high, trim.corners, trim.phase
    return np.concatenate([trim.origin, np.ravel(trim.axes), sizes])


@compiled
def stretch(trim, origin, direction):
    """From where to where along a ray, not before its origin, it is in the prism's cylinder and between its ends."""
    start, end = 0.0, math.inf
    place, way = into(trim[3:12], along(origin, -1.0, vector(trim, 0))), into(trim[3:12], direction)
    if trim[13] > -math.inf or trim[14] < math.inf:
        if way[2] == 0.0:
            if place[2] < trim[13] or place[2] > trim[14]:
                return 1.0, 0.0
        else:
            one, other = (trim[13] - place[2]) / way[2], (trim[14] - place[2]) / way[2]
            start, end = max(start, min(one, other)), min(end, max(one, other))
    if trim[12] < math.inf:
        square = way[0] * way[0] + way[1] * way[1]
        half = place[0] * way[0] + place[1] * way[1]
        rest = place[0] * place[0] + place[1] * place[1] - trim[12] * trim[12]
        if square < 1e-30:
            return (start, end) if rest <= 0.0 else (1.0, 0.0)
        root = half * half - square * rest
        if root < 0.0:
            return 1.0, 0.0
        root = math.sqrt(root)
        start, end = max(start, (-half - root) / square), min(end, (-half + root) / square)
    return start, end


@compiled
def inside_polygon(trim, point):
    """Whether a point of the prism's cylinder is in its polygon."""
    if trim[15] == 0.0:
        return True
    place = into(trim[3:12], along(point, -1.0, vector(trim, 0)))
    half = math.pi / trim[15]
    angle = (math.atan2(place[1], place[0]) - trim[16]) % (2.0 * half) - half
    return math.hypot(place[0], place[1]) * math.cos(angle) <= trim[12] * math.cos(half)
