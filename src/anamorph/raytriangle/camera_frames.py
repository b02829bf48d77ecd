"""What of a three-ray camera does not depend on what it looks at: its axis, hull and gradients. Compiled.

A camera is a ray triangle: rays p_i + t d_i at three corners, and between them the rays with the weights w_i. At one t
its points are linear in the weights: they are the sweeping triangle of Mei, Popescu and Sacks 2007, section 5.1. With D
the mean direction and r_i = p_i + t d_i, a point that moves by x across D changes the weight of corner i by

    g_i(t) . x,    g_i(t) = D x (r_k - r_j) / det(t),    det(t) = D . (r_1 - r_0) x (r_2 - r_0),

with (i, j, k) in turn. The numerators are linear in t, so that two vectors a corner hold them. All is float64, and
relative to the camera's origin, the middle of the p_i.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from anamorph.base.compiled import compiled, inlined, over_all_cores
from anamorph.base.vectors import Vector, along, cross, dot

GRAIN = 256

WIDE = 0.02
"""A camera is wide where a direction runs along the axis by less than this share of the longest: it has no slab."""

SIDEWAYS = 1e-4
"""Two directions have a plane between them if their product's length is at least this share of their lengths'."""

SINGULAR = 1e-12
"""A determinant of less than this share of its factors' lengths is rounding."""


class Frames(NamedTuple):
    """Cameras, K of them, as compiled loops read them."""

    origin: np.ndarray
    """(K, 3): the middle of the p_i, metres."""
    axis: np.ndarray
    """(K, 3): the unit vector along the directions."""
    reach: np.ndarray
    """(K, 4): the least and the greatest p_i along the axis, then of the d_i; these are 0 for a wide camera."""
    planes: np.ndarray
    """(K, 4, 4): vectors m and numbers h: all rays stay where m . x >= h. Without a plane they are 0."""
    gradients: np.ndarray
    """(K, 3, 2, 3): the numerator of g_i at t = 0, and what a unit of t adds to it."""
    products: np.ndarray
    """(K, 3, 2, 3, 2): these two, times each p_j and each d_j."""
    determinant: np.ndarray
    """(K, 3): det as a polynomial of t."""
    factors: np.ndarray
    """(K, 3): lengths by which det is judged: D's, and the longest of the r_i - r_0 at t = 0 and of what t adds."""
    size: np.ndarray
    """(K,): how large the coordinates are that all of this was computed from, metres."""


def frames_of(origins: np.ndarray, directions: np.ndarray) -> Frames:
    """The frames of cameras with these rays, (K, 3, 3) float64 each; directions may have any length."""
    shapes = (3,), (3,), (4,), (4, 4), (3, 2, 3), (3, 2, 3, 2), (3,), (3,), ()
    frames = Frames(*(np.zeros((len(origins), *shape)) for shape in shapes))
    origins, directions = np.ascontiguousarray(origins, float), np.ascontiguousarray(directions, float)
    over_all_cores(lambda start, stop: _fill(origins, directions, frames, start, stop), len(origins), GRAIN)
    return frames


@inlined
def vector(values: np.ndarray) -> Vector:
    """Three numbers of an array as a tuple."""
    return (values[0], values[1], values[2])


@compiled
def _length(a: Vector) -> float:
    return math.sqrt(dot(a, a))


@inlined
def _put(array: np.ndarray, values: Vector) -> None:
    array[0], array[1], array[2] = values[0], values[1], values[2]


@compiled
def _fill(origins: np.ndarray, directions: np.ndarray, frames: Frames, start: int, stop: int) -> None:
    for c in range(start, stop):
        for k in range(3):
            frames.origin[c, k] = (origins[c, 0, k] + origins[c, 1, k] + origins[c, 2, k]) / 3.0
        origin = vector(frames.origin[c])
        for i in range(3):
            for k in range(3):
                frames.size[c] = max(frames.size[c], 3.0 * abs(origins[c, i, k]))
        p = (
            along(vector(origins[c, 0]), -1.0, origin),
            along(vector(origins[c, 1]), -1.0, origin),
            along(vector(origins[c, 2]), -1.0, origin),
        )
        d = (vector(directions[c, 0]), vector(directions[c, 1]), vector(directions[c, 2]))
        _fill_hull(frames, c, p, d)
        _fill_gradients(frames, c, p, d)


@inlined
def _fill_hull(frames: Frames, c: int, p: tuple[Vector, Vector, Vector], d: tuple[Vector, Vector, Vector]) -> None:
    """The axis, and the planes that bound what the directions span from the farthest back of the origins."""
    axis, longest = (0.0, 0.0, 0.0), 0.0
    for i in range(3):
        length = _length(d[i])
        longest = max(longest, length)
        if length > 0.0:
            axis = along(axis, 1.0 / length, d[i])
    length = _length(axis)
    if length > 0.0:
        axis = (axis[0] / length, axis[1] / length, axis[2] / length)
    _put(frames.axis[c], axis)
    heights, speeds = (
        (dot(axis, p[0]), dot(axis, p[1]), dot(axis, p[2])),
        (dot(axis, d[0]), dot(axis, d[1]), dot(axis, d[2])),
    )
    slowest, fastest = min(speeds[0], speeds[1], speeds[2]), max(speeds[0], speeds[1], speeds[2])
    wide = slowest <= WIDE * longest
    frames.reach[c, 0], frames.reach[c, 1] = (
        min(heights[0], heights[1], heights[2]),
        max(heights[0], heights[1], heights[2]),
    )
    frames.reach[c, 2], frames.reach[c, 3] = (0.0, 0.0) if wide else (slowest, fastest)
    if slowest >= 0.0:
        _put(frames.planes[c, 3], axis)
        frames.planes[c, 3, 3] = frames.reach[c, 0]
    for i in range(3):
        first, second, other = d[(i + 1) % 3], d[(i + 2) % 3], d[i]
        normal = cross(first, second)
        length = _length(normal)
        if length <= SIDEWAYS * _length(first) * _length(second):
            continue
        side = 1.0 / length if dot(normal, other) >= 0.0 else -1.0 / length
        normal = (side * normal[0], side * normal[1], side * normal[2])
        _put(frames.planes[c, i], normal)
        frames.planes[c, i, 3] = min(dot(normal, p[0]), dot(normal, p[1]), dot(normal, p[2]))


@inlined
def _fill_gradients(frames: Frames, c: int, p: tuple[Vector, Vector, Vector], d: tuple[Vector, Vector, Vector]) -> None:
    mean = along(along(d[0], 1.0, d[1]), 1.0, d[2])
    mean = (mean[0] / 3.0, mean[1] / 3.0, mean[2] / 3.0)
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        _put(frames.gradients[c, i, 0], cross(mean, along(p[k], -1.0, p[j])))
        _put(frames.gradients[c, i, 1], cross(mean, along(d[k], -1.0, d[j])))
        for power in range(2):
            numerator = vector(frames.gradients[c, i, power])
            for corner in range(3):
                frames.products[c, i, power, corner, 0] = dot(numerator, p[corner])
                frames.products[c, i, power, corner, 1] = dot(numerator, d[corner])
    # det = D . (r_1 - r_0) x (r_2 - r_0), that is the numerator of g_1 times r_1 - r_0.
    at_0, more = vector(frames.gradients[c, 1, 0]), vector(frames.gradients[c, 1, 1])
    side, spread = along(p[1], -1.0, p[0]), along(d[1], -1.0, d[0])
    frames.determinant[c, 0] = dot(at_0, side)
    frames.determinant[c, 1] = dot(at_0, spread) + dot(more, side)
    frames.determinant[c, 2] = dot(more, spread)
    other, other_spread = along(p[2], -1.0, p[0]), along(d[2], -1.0, d[0])
    frames.factors[c, 0] = _length(mean)
    frames.factors[c, 1] = max(_length(side), _length(other))
    frames.factors[c, 2] = max(_length(spread), _length(other_spread))
