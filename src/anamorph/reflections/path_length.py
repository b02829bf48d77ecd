"""The length of the path from an eye over a mirror to a point, and how it changes. Compiled.

By Fermat's principle a mirror shows the point where the length |E-R| + |R-V| is stationary on its surface. Its slopes
there are taken along two perpendicular unit vectors of the tangent plane, so that steps are metres.

Of a plain mesh the surface is flat in each triangle and its normal interpolated. There the same sum of unit vectors is
to have no part across the normal; that is no length's slope, but Newton's iteration does not ask for one.
"""

from __future__ import annotations

import math

import numpy as np

from anamorph.base.compiled import compiled, inlined
from anamorph.base.vectors import Vector, along, cross, dot
from anamorph.surfaces.expansion import expand
from anamorph.surfaces.intersection import NONE

Frame = tuple[float, float, float]
"""What makes metres in the tangent plane of the two parameters: the length of the slope a, and the parts of the slope b
along it and across."""

Slopes = tuple[float, float, float, float, float, float]
"""The length's slopes along the two unit vectors, and the slopes of these: 1, 2, 11, 12, 21, 22."""


@inlined
def _off(vector: Vector, direction: Vector) -> Vector:
    """The part of a vector across a unit vector."""
    return along(vector, -dot(vector, direction), direction)


@inlined
def _triangle(numbers: np.ndarray, place: Vector) -> tuple[Vector, Vector, Vector, Vector, Vector, Vector]:
    """Of a plain mesh: position, edges a and b, unit normal, and its slopes along a and b."""
    first, zero = 18 * int(place[2]), (0.0, 0.0, 0.0)
    p = (numbers[first], numbers[first + 1], numbers[first + 2])
    a = along((numbers[first + 3], numbers[first + 4], numbers[first + 5]), -1.0, p)
    b = along((numbers[first + 6], numbers[first + 7], numbers[first + 8]), -1.0, p)
    n = (numbers[first + 9], numbers[first + 10], numbers[first + 11])
    n_a = along((numbers[first + 12], numbers[first + 13], numbers[first + 14]), -1.0, n)
    n_b = along((numbers[first + 15], numbers[first + 16], numbers[first + 17]), -1.0, n)
    normal = along(along(n, place[0], n_a), place[1], n_b)
    share = 1.0 / math.sqrt(dot(normal, normal))
    normal = along(zero, share, normal)
    n_a, n_b = along(zero, share, _off(n_a, normal)), along(zero, share, _off(n_b, normal))
    return along(along(p, place[0], a), place[1], b), a, b, normal, n_a, n_b


@inlined
def _projected(edge: Vector, normal: Vector, change: Vector) -> Vector:
    """How the part of an edge across a unit normal changes when the normal does."""
    return along(along((0.0, 0.0, 0.0), -dot(edge, normal), change), -dot(edge, change), normal)


@inlined
def frame_of(a: Vector, b: Vector) -> Frame:
    """The frame of two slopes."""
    length = math.sqrt(dot(a, a))
    skew = dot(a, b) / length
    return length, skew, math.sqrt(max(dot(b, b) - skew * skew, 0.0))


@inlined
def in_parameters(frame: Frame, x: float, y: float) -> tuple[float, float]:
    """A step in metres along the two unit vectors as one of the parameters."""
    step = y / frame[2]
    return (x - frame[1] * step) / frame[0], step


@compiled
def slopes_at(
    kind: int, numbers: np.ndarray, place: Vector, eye: Vector, point: Vector
) -> tuple[bool, Vector, Vector, Frame, Slopes]:
    """How the length of the path changes around a place.

    Returns
    -------
    ok : bool
        False where there is no surface, no tangent plane, or an end of the path.
    position, normal : three float64
        The normal is unit, of either side.
    frame : Frame
    slopes : Slopes
    """
    nothing = (0.0, 0.0, 0.0)
    if kind == NONE:
        position, a, b, normal, n_a, n_b = _triangle(numbers, place)
        ok, s, t = True, _off(a, normal), _off(b, normal)
        s_a, s_b = _projected(a, normal, n_a), _projected(a, normal, n_b)
        t_a, t_b = _projected(b, normal, n_a), _projected(b, normal, n_b)
    else:
        ok, position, a, b, s_a, s_b, t_b = expand(kind, numbers, place)
        s, t, t_a, normal = a, b, s_b, cross(a, b)
    from_eye, from_point = along(position, -1.0, eye), along(position, -1.0, point)
    far, near = math.sqrt(dot(from_eye, from_eye)), math.sqrt(dot(from_point, from_point))
    if not ok or dot(a, a) == 0.0 or far == 0.0 or near == 0.0:
        return False, position, nothing, nothing, (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    frame = frame_of(a, b)
    if frame[2] <= 1e-12 * math.sqrt(dot(b, b)):
        return False, position, nothing, nothing, (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    from_eye, from_point = along(nothing, 1.0 / far, from_eye), along(nothing, 1.0 / near, from_point)
    both = along(from_eye, 1.0, from_point)
    both_a = along(along(nothing, 1.0 / far, _off(a, from_eye)), 1.0 / near, _off(a, from_point))
    both_b = along(along(nothing, 1.0 / far, _off(b, from_eye)), 1.0 / near, _off(b, from_point))
    length, skew, across = frame
    # By the parameters first; then along the unit vectors, moves and tests alike.
    one, other = dot(both, s) / length, dot(both, t)
    one_a, one_b = (dot(both_a, s) + dot(both, s_a)) / length, (dot(both_b, s) + dot(both, s_b)) / length
    other_a, other_b = dot(both_a, t) + dot(both, t_a), dot(both_b, t) + dot(both, t_b)
    one_1, other_1 = one_a / length, other_a / length
    one_2, other_2 = (one_b - skew * one_1) / across, (other_b - skew * other_1) / across
    other, other_1, other_2 = (
        (other - skew * one) / across,
        (other_1 - skew * one_1) / across,
        (other_2 - skew * one_2) / across,
    )
    normal = along(nothing, 1.0 / math.sqrt(dot(normal, normal)), normal)
    return True, position, normal, frame, (one, other, one_1, one_2, other_1, other_2)


@compiled
def tangents_at(kind: int, numbers: np.ndarray, place: Vector) -> tuple[bool, Vector, Frame, Vector, Vector, Vector]:
    """Whether there is a tangent plane; position, frame, the two unit vectors, and a unit normal of the surface."""
    zero = (0.0, 0.0, 0.0)
    if kind == NONE:
        position, a, b, _, _, _ = _triangle(numbers, place)
        ok = True
    else:
        ok, position, a, b, _, _, _ = expand(kind, numbers, place)
    normal = cross(a, b)
    area = math.sqrt(dot(normal, normal))
    if not ok or area <= 1e-12 * dot(b, b):
        return False, position, zero, zero, zero, zero
    frame = frame_of(a, b)
    one = along(zero, 1.0 / frame[0], a)
    other = along(zero, 1.0 / frame[2], along(b, -frame[1], one))
    return True, position, frame, one, other, along(zero, 1.0 / area, normal)
