"""A NURBS surface as the polynomials between its knots, in one array of numbers that compiled loops evaluate.

Each piece is written in powers of coordinates from -1 to 1 around its middle: that needs no room of its own, which a
recursion over B-splines would, and stays within rounding for the degrees of CAD files.
"""

from __future__ import annotations

from math import factorial

import numpy as np

from anamorph.base.compiled import compiled, inlined
from anamorph.base.vectors import Vector, along
from anamorph.surfaces.base import Expansion
from anamorph.surfaces.bsplines import basis

DEGREE_U, DEGREE_V, COUNT_U, COUNT_V, LOW_U, SIZE_U, LOW_V, SIZE_V, EXTENT, HEAD = range(10)
"""Where the numbers of a surface are; its borders and coefficients follow from HEAD on."""

Homogeneous = tuple[float, float, float, float]


def pieces(
    weighted: np.ndarray, knots: tuple[np.ndarray, np.ndarray], degrees: tuple[int, int], extent: float
) -> np.ndarray:
    """The numbers of a surface, (N,) float64, for `point_and_tangents`.

    Parameters
    ----------
    weighted : (P, Q, 4) array
        The poles' numerators and denominators: (w x, w y, w z, w).
    knots, degrees : two each
        Along u and along v.
    extent : float
        Metres.
    """
    sides, borders, domain = [], [], []
    for own, degree in zip(knots, degrees, strict=True):
        low, high = own[degree], own[-degree - 1]
        ends = np.unique(np.clip(own, low, high))
        middles, halves = (ends[1:] + ends[:-1]) / 2.0, np.diff(ends) / 2.0
        terms = [
            basis(own, degree, middles, order) * halves[:, None] ** order / factorial(order)
            for order in range(degree + 1)
        ]
        sides.append(np.stack(terms, axis=1))
        borders.append((ends - low) / (high - low))
        domain += [low, high - low]
    coefficients = np.einsum("apn,bqm,nmk->abpqk", *sides, weighted, optimize=True)
    head = [*degrees, len(borders[0]) - 1, len(borders[1]) - 1, *domain, extent]
    return np.concatenate([head, *borders, coefficients.ravel()])


@compiled
def _piece(numbers: np.ndarray, first: int, count: int, at: float) -> tuple[int, float, float]:
    """Which of `count` pieces holds `at`, its coordinate there from -1 to 1, and that coordinate's slope."""
    low, high = 0, count
    while high - low > 1:
        middle = (low + high) // 2
        if numbers[first + middle] <= at:
            low = middle
        else:
            high = middle
    start, stop = numbers[first + low], numbers[first + low + 1]
    slope = 2.0 / (stop - start)
    return low, (at - start) * slope - 1.0, slope


@inlined
def _placed(numbers: np.ndarray, u: float, v: float) -> tuple[int, int, int, float, float, float, float]:
    """The degrees, where the coefficients of the piece begin, and the coordinates in it with their slopes."""
    degree_u, degree_v = int(numbers[DEGREE_U]), int(numbers[DEGREE_V])
    count_u, count_v = int(numbers[COUNT_U]), int(numbers[COUNT_V])
    piece_u, s, slope_u = _piece(numbers, HEAD, count_u, u)
    piece_v, t, slope_v = _piece(numbers, HEAD + count_u + 1, count_v, v)
    first = HEAD + count_u + count_v + 2
    first += (piece_u * count_v + piece_v) * (degree_u + 1) * (degree_v + 1) * 4
    return degree_u, degree_v, first, s, slope_u, t, slope_v


@compiled
def _multiplied(a: Homogeneous, factor: float, b: Homogeneous) -> Homogeneous:
    """a * factor + b."""
    return (a[0] * factor + b[0], a[1] * factor + b[1], a[2] * factor + b[2], a[3] * factor + b[3])


@compiled
def _quotient_slope(slope: Homogeneous, position: Vector, weight: float, scale: float) -> Vector:
    factor = scale / weight
    return (
        (slope[0] - slope[3] * position[0]) * factor,
        (slope[1] - slope[3] * position[1]) * factor,
        (slope[2] - slope[3] * position[2]) * factor,
    )


@compiled
def point_and_tangents(numbers: np.ndarray, u: float, v: float) -> tuple[Vector, Vector, Vector]:
    """Position, and its derivatives along u and v, at parameters from 0 to 1 over the whole surface.

    A little outside, the outermost piece goes on.
    """
    degree_u, degree_v, first, s, slope_u, t, slope_v = _placed(numbers, u, v)
    zero = (0.0, 0.0, 0.0, 0.0)
    value, along_u, along_v = zero, zero, zero
    for i in range(degree_u, -1, -1):
        row, row_slope = zero, zero
        for j in range(degree_v, -1, -1):
            at = first + (i * (degree_v + 1) + j) * 4
            row_slope = _multiplied(row_slope, t, row)
            row = _multiplied(row, t, (numbers[at], numbers[at + 1], numbers[at + 2], numbers[at + 3]))
        along_u = _multiplied(along_u, s, value)
        value = _multiplied(value, s, row)
        along_v = _multiplied(along_v, s, row_slope)
    weight = value[3]
    position = (value[0] / weight, value[1] / weight, value[2] / weight)
    return (
        position,
        _quotient_slope(along_u, position, weight, slope_u),
        _quotient_slope(along_v, position, weight, slope_v),
    )


@compiled
def expand_pieces(numbers: np.ndarray, u: float, v: float) -> Expansion:
    """The same, and the second derivatives."""
    degree_u, degree_v, first, s, slope_u, t, slope_v = _placed(numbers, u, v)
    zero = (0.0, 0.0, 0.0, 0.0)
    value, along_u, along_v, uu, uv, vv = zero, zero, zero, zero, zero, zero
    for i in range(degree_u, -1, -1):
        row, row_slope, row_bend = zero, zero, zero
        for j in range(degree_v, -1, -1):
            at = first + (i * (degree_v + 1) + j) * 4
            row_bend = _multiplied(row_bend, t, row_slope)
            row_slope = _multiplied(row_slope, t, row)
            row = _multiplied(row, t, (numbers[at], numbers[at + 1], numbers[at + 2], numbers[at + 3]))
        uu = _multiplied(uu, s, along_u)
        along_u = _multiplied(along_u, s, value)
        value = _multiplied(value, s, row)
        uv = _multiplied(uv, s, along_v)
        along_v = _multiplied(along_v, s, row_slope)
        vv = _multiplied(vv, s, row_bend)
    weight = value[3]
    position = (value[0] / weight, value[1] / weight, value[2] / weight)
    by_u, by_v = (
        _quotient_slope(along_u, position, weight, slope_u),
        _quotient_slope(along_v, position, weight, slope_v),
    )
    to_u, to_v = along_u[3] * slope_u / weight, along_v[3] * slope_v / weight
    # Horner's scheme leaves half of the second derivatives.
    bend_u, bend_v = 2.0 * slope_u * slope_u, 2.0 * slope_v * slope_v
    return (
        True,
        position,
        by_u,
        by_v,
        along(_quotient_slope(uu, position, weight, bend_u), -2.0 * to_u, by_u),
        along(along(_quotient_slope(uv, position, weight, slope_u * slope_v), -to_u, by_v), -to_v, by_u),
        along(_quotient_slope(vv, position, weight, bend_v), -2.0 * to_v, by_v),
    )
