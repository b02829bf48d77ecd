"""A shape's two chains as points of the image: corners, and places on scene edges where more are wanted.

More are wanted where a chain is cut, at extra levels of t (4.5.2 of the thesis), and where it leaves the ray triangle
(5.2). All are found alike: at any t of a chain, the scene edge that it follows meets the plane of the parametric
triangle in one place, and that has a u and v.

Deviations: 5.2.2 leaves out what lies beyond the ray triangle's corners. Here the sides go on without end: between two
points of the chain none of u, v and 1 - u - v changes its sign then, and no straight line between them cuts across a
corner. A place to which no ray leads (at the eye of a pinhole, say) is replaced by one just beside it.
"""

from __future__ import annotations

import math

import numpy as np

from anamorph.base.compiled import compiled, inlined
from anamorph.base.vectors import along, cross, dot
from anamorph.methods.trilinear.straight.chains import CORNER, EDGE, OPEN, WHICH, link_t
from anamorph.methods.trilinear.straight.swept_sides import SIDE, SIDES
from anamorph.raytriangle.roots import insert
from anamorph.raytriangle.rows import MEAN, normal, three
from anamorph.raytriangle.solve import NOWHERE, ROOT, ROOTS, ray_through

T, U, V, SECOND, THIRD = range(5)
"""Of a point of a trace: the scaled t, u and v, and its weights on the scene triangle's second and third corner."""

TRACE = 5

CUTS = 6
"""Where one scene edge meets the surfaces of all three sides, at most."""

BESIDE = 1e-6
"""The share of the way to the next point at which one replaces a place without a ray."""


@compiled
def side_crossings(row: np.ndarray, solved: np.ndarray, cuts: np.ndarray) -> None:
    """The scaled t at which each edge of a scene triangle meets the three sides, ascending into `cuts` (3, 6)."""
    for edge in range(3):
        a, b = three(solved[(edge + 1) % 3], 0), three(solved[(edge + 2) % 3], 0)
        way = along(b, -1.0, a)
        moment = cross(way, a)
        count = 0
        for side in range(3):
            first = SIDES + SIDE * side
            one, other = quadratic_roots(
                dot(way, three(row, first)) + dot(moment, three(row, first + 9)),
                dot(way, three(row, first + 3)) + dot(moment, three(row, first + 12)),
                dot(way, three(row, first + 6)),
            )
            if math.isfinite(one):
                count = insert(cuts[edge], count, one)
            if math.isfinite(other):
                count = insert(cuts[edge], count, other)
        for k in range(count, CUTS):
            cuts[edge, k] = math.inf


@compiled
def quadratic_roots(c0: float, c1: float, c2: float) -> tuple[float, float]:
    """The real roots of c0 + c1 t + c2 t^2; infinite or not a number where there is none."""
    inside = c1 * c1 - 4.0 * c0 * c2
    if inside < 0.0:
        return math.nan, math.nan
    # The sum that does not cancel; the other root is the product of the roots divided by this one.
    larger = -0.5 * (c1 + math.copysign(math.sqrt(inside), c1))
    return larger / c2, c0 / larger


@inlined
def edge_weight(at_a: float, at_b: float) -> float:
    """The weight of the first of an edge's ends where it meets the plane from which they are so far away."""
    # Ends that rounding no longer sets apart: the whole edge lies in the plane, and its middle does for a point.
    return min(max(at_b / (at_b - at_a), 0.0), 1.0) if at_b != at_a else 0.5


@compiled
def edge_ray(row: np.ndarray, solved: np.ndarray, edge: int, t: float) -> tuple[float, float, float, float]:
    """Where a scene edge meets the plane at the scaled t: the weight of its first end; then as `ray_through`."""
    i, j = (edge + 1) % 3, (edge + 2) % 3
    upright, middle = normal(row, t), three(row, MEAN)
    a, b = three(solved[i], 0), three(solved[j], 0)
    weight = edge_weight(dot(along(a, -t, middle), upright), dot(along(b, -t, middle), upright))
    point = (
        weight * a[0] + (1.0 - weight) * b[0],
        weight * a[1] + (1.0 - weight) * b[1],
        weight * a[2] + (1.0 - weight) * b[2],
    )
    u, v, known = ray_through(row, point, t)
    return weight, u, v, known


@compiled
def _place(
    row: np.ndarray, solved: np.ndarray, within: np.ndarray, edge: int, t: float, trace: np.ndarray, count: int
) -> int:
    """Add where a scene edge meets the plane at t, if a ray leads there; how many points the trace has then."""
    weight, u, v, known = edge_ray(row, solved, edge, t)
    if known == NOWHERE:
        return count
    i, j = (edge + 1) % 3, (edge + 2) % 3
    second = weight * within[i, 0] + (1.0 - weight) * within[j, 0]
    third = weight * within[i, 1] + (1.0 - weight) * within[j, 1]
    return _add(trace, count, t, u, v, second, third)


@inlined
def _add(trace: np.ndarray, count: int, t: float, u: float, v: float, second: float, third: float) -> int:
    trace[count, T], trace[count, U], trace[count, V] = t, u, v
    trace[count, SECOND], trace[count, THIRD] = second, third
    return count + 1


@compiled
def has_ray(solved: np.ndarray, links: np.ndarray, side: int, k: int) -> bool:
    """Whether a link is a corner to which a ray leads."""
    corner = links[side, k, CORNER]
    return corner != OPEN and solved[corner, ROOTS + ROOT * links[side, k, WHICH] + 3] != NOWHERE


@compiled
def _corner(solved: np.ndarray, within: np.ndarray, corner: int, which: int, trace: np.ndarray, count: int) -> int:
    at = ROOTS + ROOT * which
    known = solved[corner]
    return _add(trace, count, known[at], known[at + 1], known[at + 2], within[corner, 0], within[corner, 1])


@compiled
def levels_of(
    solved: np.ndarray,
    links: np.ndarray,
    start: np.ndarray,
    stop: np.ndarray,
    low: float,
    high: float,
    slices: int,
    cuts: np.ndarray,
    levels: np.ndarray,
) -> int:
    """The scaled t between `low` and `high` at which both traces of a shape get a point, ascending; how many.

    They are `slices` evenly spaced ones, those of corners on either chain, and those of `cuts` on an edge that a chain
    is on then. start, stop : (2,) int64, of the chains.
    """
    count = slices
    for k in range(slices):
        levels[k] = low + (high - low) * (k + 1) / (slices + 1)
    for side in range(2):
        for k in range(start[side], stop[side] - 1):
            first, last = link_t(solved, links, side, k), link_t(solved, links, side, k + 1)
            if low < last < high:
                count = insert(levels, count, last)
            for t in cuts[links[side, k, EDGE]]:
                if max(first, low) < t < min(last, high):
                    count = insert(levels, count, t)
    return count


@compiled
def traced(
    row: np.ndarray,
    solved: np.ndarray,
    within: np.ndarray,
    links: np.ndarray,
    side: int,
    start: int,
    stop: int,
    low: float,
    high: float,
    levels: np.ndarray,
    trace: np.ndarray,
) -> int:
    """What a chain leaves in the image between two t; how many points.

    Parameters
    ----------
    row, solved : the ray triangle and the scene triangle's corners, as in `solve_point`
    within : (3, 2) float64
        The corners' weights on the scene triangle that they are part of.
    links, side, start, stop : the chain, as from `connected`
    low, high : float
        The scaled t between which the shape is kept; within the shape's own.
    levels : (L,) float64
        Where to add points, ascending.
    trace : (N, 5) float64
        Written.
    """
    count, level = 0, 0
    for k in range(start, stop - 1):
        edge = links[side, k, EDGE]
        first, last = link_t(solved, links, side, k), link_t(solved, links, side, k + 1)
        if last < low or first > high:
            continue
        a, b = max(first, low), min(last, high)
        beside = BESIDE * (b - a)
        if first < low:
            count = _place(row, solved, within, edge, low, trace, count)
        elif has_ray(solved, links, side, k):
            count = _corner(solved, within, links[side, k, CORNER], links[side, k, WHICH], trace, count)
        else:
            count = _place(row, solved, within, edge, a + beside, trace, count)
        while level < len(levels) and levels[level] < b:
            if levels[level] > a:
                a = levels[level]
                count = _place(row, solved, within, edge, a, trace, count)
            level += 1
        if last > high:
            count = _place(row, solved, within, edge, high, trace, count)
        elif not has_ray(solved, links, side, k + 1):
            count = _place(row, solved, within, edge, b - beside, trace, count)
        elif k == stop - 2:
            count = _corner(solved, within, links[side, k + 1, CORNER], links[side, k + 1, WHICH], trace, count)
    return count
