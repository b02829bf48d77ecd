"""All the real roots of many cubics at once, whatever their degree turns out to be.

The parameter line is a circle: from -1 to 1 the cubic is used as it is, beyond it is used in 1 / t, with its
coefficients in reverse. A vanishing leading coefficient is then a root at 1 / t = 0 and no special case, and a
quadratic or a line comes out by itself. Between two extrema a cubic runs one way, so that the signs at the extrema say
where its roots are, and Newton's steps kept between those ends find each.
"""

from __future__ import annotations

import numpy as np

STEPS = 100
"""More than bisection needs to halve the distance from -1 to 1 down to a rounding error, some way towards 0."""


def real_roots(coefficients: np.ndarray, noise: np.ndarray, reach: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The real roots of c0 + c1 t + c2 t^2 + c3 t^3 from -reach to reach, in ascending order.

    A root that the cubic only touches counts twice. Where it misses touching by no more than `noise`, rounding cannot
    tell, and it counts as touching: a root may be one too many there, but none is missed.

    Parameters
    ----------
    coefficients : (N, 4) float64
        c0 to c3.
    noise : (N,) float64
        By how much the sum of the coefficients' terms may be off, for t from -1 to 1.
    reach : (N,) float64
        At least 1; a root beyond it counts as one at infinity.

    Returns
    -------
    roots : (N, 3) float64
        0 where there is none; those that are there come first.
    real : (N, 3) bool
    """
    near, near_crossed, near_touch, near_touched = _between_ends(coefficients, noise, 1.0, coefficients)
    far, far_crossed, far_touch, far_touched = _between_ends(coefficients[:, ::-1], noise, -1.0, coefficients)
    far, far_touch = _reciprocal(far, reach[:, None]), _reciprocal(far_touch, reach)
    crossed = np.concatenate([near_crossed, far_crossed], axis=1)
    # One more double root fits only where there is one simple root at most, however often rounding sees it.
    touched = (near_touched | far_touched) & (crossed.sum(axis=1) <= 1)
    touch = np.where(touched, np.where(near_touched, near_touch, far_touch), np.inf)[:, None]
    crossings = np.where(crossed, np.concatenate([near, far], axis=1), np.inf)
    roots = np.sort(np.concatenate([crossings, touch, touch], axis=1), axis=1)[:, :3]
    real = np.isfinite(roots)
    return np.where(real, roots, 0.0), real


def values_before(coefficients: np.ndarray, reach: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The cubics (N, 4) at -reach, before their first roots, and at reach, divided by reach cubed: (N,) each."""
    return -_value(coefficients[:, ::-1], -1.0 / reach), _value(coefficients[:, ::-1], 1.0 / reach)


def _reciprocal(x: np.ndarray, reach: np.ndarray) -> np.ndarray:
    """1 / x, or infinity where that is beyond `reach`."""
    return np.where(np.abs(x) * reach >= 1.0, 1.0 / np.where(x == 0.0, 1.0, x), np.inf)


def _between_ends(
    coefficients: np.ndarray, noise: np.ndarray, turned: float, forward: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Where a cubic crosses zero from -1 to 1 (N, 3), in which of its stretches it does, where it touches (N,), if so.

    Both halves of the circle take the signs at -1 and 1 from the `forward` cubic, so that a root there is found by
    one of them. In 1 / t the cubic is divided by t^3, so that its sign at -1 is `turned`.
    """
    extrema = np.clip(_extrema(coefficients), -1.0, 1.0)
    edge = np.ones((len(extrema), 1))
    ends = np.concatenate([-edge, extrema, edge], axis=1)
    values = _value(coefficients[:, None], extrema)
    first = (_value(forward[:, None], -edge) >= 0.0) == (turned > 0.0)
    last = _value(forward[:, None], edge) >= 0.0
    middle = np.where(extrema <= -1.0, first, np.where(extrema >= 1.0, last, values >= 0.0))
    positive = np.concatenate([first, middle, last], axis=1)
    crossed = positive[:, 1:] != positive[:, :-1]
    roots = np.zeros(crossed.shape)
    rows, stretches = np.nonzero(crossed)
    roots[crossed] = _safe_newton(
        coefficients[rows], ends[rows, stretches], ends[rows, stretches + 1], positive[rows, stretches + 1]
    )
    touched = (np.abs(extrema) < 1.0) & (np.abs(values) <= noise[:, None]) & ~crossed[:, :-1] & ~crossed[:, 1:]
    touch = np.where(touched[:, 0], extrema[:, 0], extrema[:, 1])
    return roots, crossed, touch, touched.any(axis=1)


def _value(coefficients: np.ndarray, t: np.ndarray) -> np.ndarray:
    c0, c1, c2, c3 = np.moveaxis(coefficients, -1, 0)
    return c0 + t * (c1 + t * (c2 + t * c3))


def _slope(coefficients: np.ndarray, t: np.ndarray) -> np.ndarray:
    _, c1, c2, c3 = np.moveaxis(coefficients, -1, 0)
    return c1 + t * (2.0 * c2 + t * 3.0 * c3)


def _extrema(coefficients: np.ndarray) -> np.ndarray:
    """Where the slope vanishes, ascending (N, 2); beyond the ends where it does not."""
    _, c, half_b, a = coefficients.T
    a = 3.0 * a
    root = np.sqrt(np.maximum(half_b * half_b - a * c, 0.0))
    real = half_b * half_b - a * c >= 0.0
    # The sum that does not cancel; the other root is the product of the roots divided by this one.
    larger = -(half_b + np.copysign(root, half_b))
    # A division that would overflow is a root far beyond the ends.
    first = np.where(np.abs(larger) < 2.0 * np.abs(a), larger, 2.0 * np.abs(a)) / np.where(a == 0.0, 1.0, a)
    first = np.where(a == 0.0, 2.0, first)
    second = np.where(np.abs(c) < 2.0 * np.abs(larger), c, 2.0 * np.abs(larger)) / np.where(larger == 0.0, 1.0, larger)
    # Both c and half_b vanish: a t^2 has its double root at 0.
    second = np.where(larger == 0.0, np.where(a == 0.0, 2.0, 0.0), second)
    return np.sort(np.where(real[:, None], np.stack([first, second], axis=1), 2.0), axis=1)


def _safe_newton(coefficients: np.ndarray, low: np.ndarray, high: np.ndarray, rising: np.ndarray) -> np.ndarray:
    """The root of each cubic between `low` and `high`, over which its sign changes once, from - to + where `rising`."""
    t = 0.5 * (low + high)
    active = np.arange(len(t))
    for _ in range(STEPS):
        here, cubic = t[active], coefficients[active]
        value, slope = _value(cubic, here), _slope(cubic, here)
        beyond = (value >= 0.0) == rising[active]
        high[active] = np.where(beyond, here, high[active])
        low[active] = np.where(beyond, low[active], here)
        steep = np.abs(value) < 4.0 * np.abs(slope)
        step = here - np.where(steep, value, 0.0) / np.where(steep, slope, 1.0)
        kept = steep & (step >= low[active]) & (step <= high[active])
        following = np.where(kept, step, 0.5 * (low[active] + high[active]))
        t[active] = following
        active = active[(value != 0.0) & (np.abs(following - here) > 2.0 * np.finfo(float).eps * np.abs(following))]
        if len(active) == 0:
            break
    return t
