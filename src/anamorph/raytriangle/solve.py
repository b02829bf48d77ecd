"""Which rays of one ray triangle pass through one point, compiled: what `points` does for many at once.

The same steps as there, deviations included. What is found is written into a row of numbers, from which the outlines
of scene triangles are made.
"""

from __future__ import annotations

import math

import numpy as np

from anamorph.base.compiled import compiled
from anamorph.raytriangle.coefficients import ROUNDING, SAME, SPREAD
from anamorph.raytriangle.packed import (
    BLUR,
    CHANGE,
    EXTENT,
    FLAT,
    LENGTHS,
    MEAN,
    MIDDLE,
    NOISE,
    PLANES,
    SHIFT,
    START,
    Vector,
    cross,
    dot,
    local,
    normal,
    plus,
    three,
)
from anamorph.raytriangle.points import INFINITE, OUTERMOST, REACH
from anamorph.raytriangle.roots import cubic_roots, cubic_value

POINT, BEFORE, AFTER, COUNT, ROOTS, ROOT = 0, 3, 4, 5, 6, 4
"""In the row of a solved point: it in the frame, how far it is from the plane at t = -infinity and infinity, how many
roots it has, and for each of them the frame's t, u, v and what is known of the ray:"""

NOWHERE, FAR, VALID = 0.0, 1.0, 2.0
"""No ray, for the parametric triangle is a line or a point there; a ray that float64 cannot tell to `REACH`; a ray."""

WORDS = 18

_UP, _SIDE, _BACK = float(SPREAD[0, 1]), float(SPREAD[1, 1]), float(SPREAD[1, 2])


@compiled
def solve_point(row: np.ndarray, x: float, y: float, z: float, found: np.ndarray, solved: np.ndarray) -> None:
    """All roots of a world point in the ray triangle of `row`, into `solved` (18,); `found` (8,) is work space."""
    point = local(row, x, y, z)
    n0, n1, n2 = three(row, PLANES), three(row, PLANES + 3), three(row, PLANES + 6)
    cubic = (dot(point, n0), dot(point, n1) - row[MIDDLE], dot(point, n2) - row[MIDDLE + 1], -row[MIDDLE + 2])
    distance = 1.0 + math.sqrt(dot(point, point))
    reach = INFINITE * distance
    solved[0], solved[1], solved[2] = point
    turned = (cubic[3], cubic[2], cubic[1], cubic[0])
    solved[BEFORE], solved[AFTER] = -cubic_value(turned, -1.0 / reach), cubic_value(turned, 1.0 / reach)
    solved[COUNT] = 0.0
    largest = max(max(abs(cubic[0]), abs(cubic[1])), max(abs(cubic[2]), abs(cubic[3])))
    if row[FLAT] != 0.0 or not largest > ROUNDING * distance:
        return
    count = cubic_roots(cubic, row[NOISE] * distance, reach, found)
    off = plus(point, row[SHIFT], three(row, MEAN))
    allowed = REACH * max(math.sqrt(dot(off, off)), row[EXTENT]) + row[BLUR]
    for k in range(count):
        t = _polished(row, point, found[k])
        u, v, missed = ray_through(row, point, t)
        known = NOWHERE if math.isnan(missed) else VALID if missed <= allowed else FAR
        # Polishing may swap neighbours.
        place = k
        while place > 0 and solved[ROOTS + ROOT * (place - 1)] > t:
            to, come = ROOTS + ROOT * place, ROOTS + ROOT * (place - 1)
            for word in range(ROOT):
                solved[to + word] = solved[come + word]
            place -= 1
        at = ROOTS + ROOT * place
        solved[at], solved[at + 1], solved[at + 2], solved[at + 3] = t, u, v, known
    solved[COUNT] = count


@compiled
def _polished(row: np.ndarray, point: Vector, t: float) -> float:
    """A root after two of Newton's steps on the product (s - t m) . N(t), each taken where it comes nearer to zero."""
    mean, n1, n2 = three(row, MEAN), three(row, PLANES + 3), three(row, PLANES + 6)
    upright, off = normal(row, t), plus(point, -t, mean)
    value = dot(off, upright)
    for _ in range(2):
        slope = dot(off, plus(n1, 2.0 * t, n2)) - dot(mean, upright)
        if slope == 0.0 or value == 0.0:
            return t
        step = t - value / slope
        upright, off = normal(row, step), plus(point, -step, mean)
        following = dot(off, upright)
        if not abs(following) < abs(value):
            return t
        t, value = step, following
    return t


@compiled
def ray_through(row: np.ndarray, point: Vector, t: float) -> tuple[float, float, float]:
    """u and v of the ray through a point in the plane at the frame's t, and by how much at most it passes by.

    Not a number where the parametric triangle is a line or a point and the point is not on it, or so far off that no
    ray is left; u and v are 0 then.
    """
    off = plus(point, -t, three(row, MEAN))
    e = plus(three(row, START), t, three(row, CHANGE))
    g = plus(three(row, START + 3), t, three(row, CHANGE + 3))
    full_e = row[LENGTHS] + abs(t) * row[LENGTHS + 2]
    full_g = row[LENGTHS + 1] + abs(t) * row[LENGTHS + 3]
    ee, gg = dot(e, e), dot(g, g)
    extent = ee + gg
    upright = cross(e, g)
    area = dot(upright, upright)
    together = extent <= max(SAME * (full_e + full_g), row[BLUR]) ** 2
    thin = together or area <= (SAME * (full_e * math.sqrt(gg) + math.sqrt(ee) * full_g)) ** 2
    first, second = 0.0, 0.0
    if not thin:
        first, second = dot(upright, cross(off, g)) / area, dot(upright, cross(e, off)) / area
        left = plus(plus(off, -first, e), -second, g)
        first += dot(upright, cross(left, g)) / area
        second += dot(upright, cross(e, left)) / area
    elif not together:
        first, second = dot(e, off) / extent, dot(g, off) / extent
    left = plus(plus(off, -first, e), -second, g)
    weights = abs(first) + abs(second)
    spans = full_e + full_g + row[EXTENT] + abs(row[SHIFT]) + abs(t)
    lost = weights * row[BLUR] + ROUNDING * ((1.0 + weights) * spans + math.sqrt(dot(point, point)))
    missed = math.sqrt(dot(left, left)) + lost
    u, v = 1.0 / 3.0 + _UP * first + _SIDE * second, 1.0 / 3.0 + _BACK * second
    if not max(abs(1.0 - u - v), max(abs(u), abs(v))) <= OUTERMOST:
        return 0.0, 0.0, math.nan
    if thin:
        off_size = plus(point, row[SHIFT], three(row, MEAN))
        if missed > REACH * max(math.sqrt(dot(off_size, off_size)), row[EXTENT]) + row[BLUR]:
            return 0.0, 0.0, math.nan
    return u, v, missed
