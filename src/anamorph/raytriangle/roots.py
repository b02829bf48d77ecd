"""All the real roots of a cubic, whatever its degree turns out to be. Compiled.

The parameter line is a circle: from -1 to 1 the cubic is used as it is, beyond it is used in 1 / t, with its
coefficients in reverse. A vanishing leading coefficient is then a root at 1 / t = 0 and no special case, and a
quadratic or a line comes out by itself. Between two extrema a cubic runs one way, so that the signs at the extrema say
where its roots are, and Newton's steps kept between those ends find each.
"""

from __future__ import annotations

import math

import numpy as np

from anamorph.base.compiled import compiled, inlined

Cubic = tuple[float, float, float, float]
"""c0 to c3 of c0 + c1 t + c2 t^2 + c3 t^3."""

STEPS = 100
"""More than bisection needs to halve the distance from -1 to 1 down to a rounding error, some way towards 0."""

_PRECISE = 2.0 * float(np.finfo(float).eps)


@inlined
def cubic_value(c: Cubic, t: float) -> float:
    """The cubic at t."""
    return c[0] + t * (c[1] + t * (c[2] + t * c[3]))


@inlined
def insert(ascending: np.ndarray, count: int, t: float) -> int:
    """Put t in its place among the first `count`."""
    k = count
    while k > 0 and ascending[k - 1] > t:
        ascending[k] = ascending[k - 1]
        k -= 1
    ascending[k] = t
    return count + 1


@compiled
def cubic_roots(c: Cubic, noise: float, reach: float, found: np.ndarray) -> int:
    """The real roots from -reach to reach, in ascending order; how many.

    A root that the cubic only touches counts twice. Where it misses touching by no more than `noise`, rounding cannot
    tell, and it counts as touching: a root may be one too many there, but none is missed.

    Parameters
    ----------
    c : Cubic
    noise : float
        By how much the sum of the cubic's terms may be off, for t from -1 to 1.
    reach : float
        At least 1; a root beyond it counts as one at infinity.
    found : (8,) float64
        Written; the first three hold the roots.
    """
    minus, plus = cubic_value(c, -1.0) >= 0.0, cubic_value(c, 1.0) >= 0.0
    backward = (c[3], c[2], c[1], c[0])
    count, near_crossed, near_touch = _half(c, noise, minus, plus, math.inf, found, 0)
    count, far_crossed, far_touch = _half(backward, noise, not minus, plus, reach, found, count)
    # One more double root fits only where there is one simple root at most, however often rounding sees it.
    if near_crossed + far_crossed <= 1:
        touch = near_touch if not math.isnan(near_touch) else far_touch
        if math.isfinite(touch):
            count = insert(found, insert(found, count, touch), touch)
    return min(count, 3)


@compiled
def _half(
    c: Cubic, noise: float, first: bool, last: bool, reach: float, found: np.ndarray, count: int
) -> tuple[int, int, float]:
    """Insert the roots between -1 and 1, or their reciprocals if `reach` is finite.

    Returns how many roots `found` holds now, how often the cubic crosses zero here, and where it touches it: not a
    number if nowhere, infinite if beyond reach.
    """
    # Both halves of the circle take the signs at -1 and 1 from the same values: a root there is found by one of them.
    first_extremum, second_extremum = _extrema(c)
    crossed, touch = 0, math.nan
    low, below, crossed_before = -1.0, first, False
    value_before = math.inf
    for stretch in range(3):
        high = 1.0 if stretch == 2 else min(max(second_extremum if stretch else first_extremum, -1.0), 1.0)
        value = math.inf
        above = last
        if high <= -1.0:
            above = first
        elif high < 1.0:
            value = cubic_value(c, high)
            above = value >= 0.0
        crosses = below != above
        if stretch > 0 and not crossed_before and not crosses and math.isnan(touch) and abs(value_before) <= noise:
            touch = low if reach == math.inf else _reciprocal(low, reach)
        if crosses:
            crossed += 1
            root = _newton(c, low, high, above)
            if reach < math.inf:
                root = _reciprocal(root, reach)
            if root < math.inf:
                count = insert(found, count, root)
        low, below, crossed_before, value_before = high, above, crosses, value
    return count, crossed, touch


@inlined
def _reciprocal(x: float, reach: float) -> float:
    return 1.0 / x if abs(x) * reach >= 1.0 else math.inf


@compiled
def _extrema(c: Cubic) -> tuple[float, float]:
    """Where the slope vanishes, ascending; beyond 1 where it does not."""
    half_b, a = c[2], 3.0 * c[3]
    inside = half_b * half_b - a * c[1]
    if inside < 0.0:
        return 2.0, 2.0
    # The sum that does not cancel; the other root is the product of the roots divided by this one.
    larger = -(half_b + math.copysign(math.sqrt(inside), half_b))
    if larger == 0.0:
        return (2.0, 2.0) if a == 0.0 else (0.0, 0.0)
    # A division that would overflow is a root far beyond the ends.
    first = larger / a if abs(larger) < 2.0 * abs(a) else 2.0
    second = c[1] / larger if abs(c[1]) < 2.0 * abs(larger) else 2.0
    return min(first, second), max(first, second)


@compiled
def _newton(c: Cubic, low: float, high: float, rising: bool) -> float:
    """The root between `low` and `high`, over which the sign changes once, from - to + where `rising`."""
    t = 0.5 * (low + high)
    for _ in range(STEPS):
        value = cubic_value(c, t)
        slope = c[1] + t * (2.0 * c[2] + t * 3.0 * c[3])
        if (value >= 0.0) == rising:
            high = t
        else:
            low = t
        following = 0.5 * (low + high)
        if abs(value) < 4.0 * abs(slope):
            step = t - value / slope
            if low <= step <= high:
                following = step
        done = value == 0.0 or abs(following - t) <= _PRECISE * abs(following)
        t = following
        if done:
            break
    return t
