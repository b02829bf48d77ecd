"""The numbers of a pair: the quadratics of its scene triangle's three sides, and two linear functions. Compiled.

In a ray triangle, the ray of an image point q = (x, y, 1) has Pluecker coordinates (L, M) quadratic in q (`beams`);
so has the side on which it passes an edge from a to b of the scene:

    E(q) = L . (a x b) - M . (b - a).

Around a scene triangle the three sides add up to s N, where N = d . n is linear in q and n = (b - a) x (c - a). The ray
goes through the triangle where all three have the sign of N, for s > 0 in the ray triangle's part of the image; their
shares of their sum are the weights of the opposite corners; and t = (s a - o) . n / N. That is exact: edges are curved,
as conics in the image, and nothing is projected.

Source: exact edges in place of Vallance 2005, chapter 4; three-ray cameras were drawn by vertex and fragment programs
before, with a bounding triangle an image, by Hou, Wei, Shum and Guo (2006).
"""

from __future__ import annotations

import numpy as np

from anamorph.base.compiled import inlined
from anamorph.methods.trilinear.beams import Beams

ROUNDING = 16.0 * 2.0**-53
"""What float64 may lose of a quadratic's value, as a share of its terms: sixteen roundings."""

TERMS = 24
"""Numbers a pair: the quadratics of its three corners' weights, times s N; N; and N (t - near)."""

ACROSS, AHEAD = 18, 21
"""Where the two linear functions begin."""


@inlined
def is_inside(terms: np.ndarray, x: float, y: float) -> bool:
    """Whether a ray triangle's ray at (x, y) meets a pair's scene triangle."""
    for first in (0, 6, 12):
        if quadratic(terms, first, x, y)[0] < 0.0:
            return False
    across = terms[18] * x + terms[19] * y + terms[20]
    ahead = terms[21] * x + terms[22] * y + terms[23]
    return across >= 0.0 and ahead >= 0.0


@inlined
def _edge(beams: Beams, k: int, a: np.ndarray, b: np.ndarray, sign: float, terms: np.ndarray, first: int) -> None:
    """The quadratic of the side of the edge from a to b, at terms[first:first + 6]; corners relative to the anchor."""
    m0, m1, m2 = a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]
    e0, e1, e2 = b[0] - a[0], b[1] - a[1], b[2] - a[2]
    for term in range(6):
        line, moment = beams.line[k, term], beams.moment[k, term]
        terms[first + term] = sign * (
            line[0] * m0 + line[1] * m1 + line[2] * m2 - moment[0] * e0 - moment[1] * e1 - moment[2] * e2
        )


@inlined
def quadratic(terms: np.ndarray, first: int, x: float, y: float) -> tuple[float, float, float]:
    """Value and gradient."""
    xx, xy, yy, cx, cy = terms[first], terms[first + 1], terms[first + 2], terms[first + 3], terms[first + 4]
    return (
        (xx * x + xy * y + cx) * x + (yy * y + cy) * y + terms[first + 5],
        2.0 * xx * x + xy * y + cx,
        xy * x + 2.0 * yy * y + cy,
    )


@inlined
def bending(terms: np.ndarray, first: int, x: float, y: float) -> float:
    """How far a quadratic rises above its tangent at most, within (x, y) of where that touches."""
    return max(terms[first], 0.0) * x * x + abs(terms[first + 1]) * x * y + max(terms[first + 2], 0.0) * y * y


@inlined
def _most(terms: np.ndarray, first: int, x: float, y: float, half_x: float, half_y: float) -> float:
    """What a quadratic is at most, and rounding, in a box of this middle and half these sides."""
    value, slope_x, slope_y = quadratic(terms, first, x, y)
    rise = abs(slope_x) * half_x + abs(slope_y) * half_y + bending(terms, first, half_x, half_y)
    return value + rise + _rounding(terms, first, abs(x) + half_x, abs(y) + half_y)


@inlined
def lies_beyond(beams: Beams, k: int, a: np.ndarray, b: np.ndarray, sign: float, terms: np.ndarray, first: int) -> bool:
    """Find the quadratic of an edge's side; whether it is negative all over the ray triangle's box of samples."""
    _edge(beams, k, a, b, sign, terms, first)
    x, y, half_x, half_y = beams.extent[k]
    return _most(terms, first, x, y, half_x, half_y) < 0.0


@inlined
def _rounding(terms: np.ndarray, first: int, x: float, y: float) -> float:
    """What float64 may lose of a quadratic within (x, y) of the center."""
    size = abs(terms[first]) * x * x + abs(terms[first + 1]) * x * y + abs(terms[first + 2]) * y * y
    return ROUNDING * (size + abs(terms[first + 3]) * x + abs(terms[first + 4]) * y + abs(terms[first + 5]))


@inlined
def falls_short(terms: np.ndarray, x: float, y: float, half_x: float, half_y: float) -> bool:
    """Whether one of a pair's functions is negative all over a box, by its middle and half its sides."""
    for first in (0, 6, 12):
        if _most(terms, first, x, y, half_x, half_y) < 0.0:
            return True
    for first in (ACROSS, AHEAD):
        a, b = terms[first], terms[first + 1]
        if a * x + b * y + terms[first + 2] + abs(a) * half_x + abs(b) * half_y < 0.0:
            return True
    return False
