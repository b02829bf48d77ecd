"""All the rays of one ray triangle that pass through one point. Compiled.

Source: Vallance 2005, sections 3.1 to 3.6 and 3.8. The ray at weights (1 - u - v, u, v) is

    ray(u, v, t) = (1 - u - v) p1 + u p2 + v p3 + t ((1 - u - v) n1 + u n2 + v n3)

and the t at which one passes through a point are roots of a cubic; u and v follow in the plane of that t.

Deviations: the cubic is formed in the triangle's own units (`scaled`), and what its rays alone make vanish is divided
out (`factors`); its roots are kept between its extrema instead of taken from a formula (`roots`), and polished on the
determinant as the product (s - t m) . N(t), which loses less than its expanded terms. The thesis leaves open below
which area a triangle counts as degenerate. Here the question does not arise: a root is valid where its ray passes
through the point, rounding included.
"""

from __future__ import annotations

import math

import numpy as np

from anamorph.base.compiled import compiled
from anamorph.base.vectors import Vector, along, cross, dot
from anamorph.raytriangle.factors import SAME
from anamorph.raytriangle.roots import cubic_roots, cubic_value
from anamorph.raytriangle.rows import (
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
    local,
    normal,
    three,
)
from anamorph.raytriangle.scaled import ROUNDING, SPREAD

REACH = 1e-9
"""How near a valid ray passes by its point, as a share of the greater distance of point and origins from the middle."""

INFINITE = 1e10
"""Times the distance of point or origins from the middle, in scaled units: a t beyond is at infinity. No ray with such
a t is valid, since a rounding error of t carries it further from its point than `REACH`."""

OUTERMOST = 1e8
"""A greater weight is noise: its ray would be this many times further from the middle than the triangle is wide."""

BEFORE, AFTER, COUNT, ROOTS, ROOT = 3, 4, 5, 6, 4
"""In the row of a solved point, after its three scaled coordinates: how far it is from the plane at t = -infinity and
at infinity, how many roots it has, and for each of them the scaled t, u, v and what is known of the ray:"""

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
    backward = (cubic[3], cubic[2], cubic[1], cubic[0])
    solved[BEFORE], solved[AFTER] = -cubic_value(backward, -1.0 / reach), cubic_value(backward, 1.0 / reach)
    solved[COUNT] = 0.0
    # Neither a flat ray triangle nor a point in all its planes has any t of its own.
    largest = max(max(abs(cubic[0]), abs(cubic[1])), max(abs(cubic[2]), abs(cubic[3])))
    if row[FLAT] != 0.0 or not largest > ROUNDING * distance:
        return
    count = cubic_roots(cubic, row[NOISE] * distance, reach, found)
    for k in range(count):
        t = _polished(row, point, found[k])
        u, v, known = ray_through(row, point, t)
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
    upright, off = normal(row, t), along(point, -t, mean)
    value = dot(off, upright)
    for _ in range(2):
        slope = dot(off, along(n1, 2.0 * t, n2)) - dot(mean, upright)
        if slope == 0.0 or value == 0.0:
            return t
        step = t - value / slope
        upright, off = normal(row, step), along(point, -step, mean)
        following = dot(off, upright)
        if not abs(following) < abs(value):
            return t
        t, value = step, following
    return t


@compiled
def ray_through(row: np.ndarray, point: Vector, t: float) -> tuple[float, float, float]:
    """u and v of the ray through a point in the plane at the scaled t, and what is known of it.

    Where many rays pass through the point, because the parametric triangle is a line or a point there, it is the one
    nearest to the triangle's middle. u and v are 0 where there is no ray.
    """
    off = along(point, -t, three(row, MEAN))
    e = along(three(row, START), t, three(row, CHANGE))
    g = along(three(row, START + 3), t, three(row, CHANGE + 3))
    # What the two sums would be without cancelling is what their rounding errors are to be measured by.
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
        left = along(along(off, -first, e), -second, g)
        first += dot(upright, cross(left, g)) / area
        second += dot(upright, cross(e, left)) / area
    elif not together:
        # On a line, the least change of the weights that leads to the point; at a point, no change.
        first, second = dot(e, off) / extent, dot(g, off) / extent
    left = along(along(off, -first, e), -second, g)
    # What float64 loses in t and in the weights themselves.
    weights = abs(first) + abs(second)
    spans = full_e + full_g + row[EXTENT] + abs(row[SHIFT]) + abs(t)
    lost = weights * row[BLUR] + ROUNDING * ((1.0 + weights) * spans + math.sqrt(dot(point, point)))
    missed = math.sqrt(dot(left, left)) + lost
    u, v = 1.0 / 3.0 + _UP * first + _SIDE * second, 1.0 / 3.0 + _BACK * second
    size = along(point, row[SHIFT], three(row, MEAN))
    near = missed <= REACH * max(math.sqrt(dot(size, size)), row[EXTENT]) + row[BLUR]
    if not max(abs(1.0 - u - v), max(abs(u), abs(v))) <= OUTERMOST or (thin and not near):
        return 0.0, 0.0, NOWHERE
    return u, v, VALID if near else FAR
