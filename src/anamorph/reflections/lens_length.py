"""The optical length of the path from an eye through a lens to a point, and how it changes. Compiled.

By Fermat's principle light enters by F and leaves by B where |E-F| + n |F-B| + |B-V| is stationary, with F on the near
face and B on the far one. For each F there is a B at which it is, as far as B can tell. So what is left is a function
of F alone, which is to be stationary, as the length of the path over a mirror is; its slopes are what is left of the
length's own when B follows.
"""

from __future__ import annotations

import math

import numpy as np

from anamorph.base.compiled import compiled, inlined
from anamorph.base.vectors import Vector, along, cross, dot
from anamorph.reflections.path_length import Frame, Slopes, frame_of
from anamorph.surfaces.expansion import expand

Pair = tuple[float, float]
Square = tuple[float, float, float, float]
"""A matrix of two by two: 11, 12, 21, 22."""

Place = tuple[Vector, Vector, Frame]
"""Position, unit normal of either side, and frame."""


@inlined
def _across(p: Vector, q: Vector, way: Vector) -> float:
    """The product of what two vectors have across a unit vector."""
    return dot(p, q) - dot(p, way) * dot(q, way)


@inlined
def _in_frame(slopes: Pair, frame: Frame) -> Pair:
    """Slopes along the parameters as slopes along the two unit vectors of a frame."""
    length, skew, across = frame
    one = slopes[0] / length
    return one, (slopes[1] - skew * one) / across


@inlined
def _between_frames(square: Square, first: Frame, second: Frame) -> Square:
    """Second derivatives by parameters of two surfaces as those along their unit vectors."""
    one, two = _in_frame((square[0], square[1]), second), _in_frame((square[2], square[3]), second)
    left, right = _in_frame((one[0], two[0]), first), _in_frame((one[1], two[1]), first)
    return left[0], right[0], left[1], right[1]


@compiled
def lens_slopes(
    near_kind: int,
    near_numbers: np.ndarray,
    far_kind: int,
    far_numbers: np.ndarray,
    index: float,
    near_place: Vector,
    far_place: Vector,
    eye: Vector,
    point: Vector,
) -> tuple[bool, Place, Place, float, Slopes, Pair, Square, bool]:
    """How the length of the path changes around two places.

    Parameters
    ----------
    near_kind, near_numbers, far_kind, far_numbers
        The exact surfaces of the two faces, from `intersection.pack`.
    index : float
        Refractive index.
    near_place, far_place : three float64
    eye, point : three float64

    Returns
    -------
    ok : bool
        False where there is no surface, no tangent plane, an end of the path, or a far face that focuses F on the
        point; then F says nothing of B.
    near, far : Place
    length : float
        Of the path, each part times its refractive index; metres.
    slopes : Slopes
        Of the length, along the two unit vectors of the near frame, if B follows.
    offset, follows : Pair, Square
        A step d of F on the near face has B step by -(offset + follows d) on the far face.
    turned : bool
        Whether B's own bends have two signs.
    """
    nothing = (0.0, 0.0, 0.0)
    lost = (nothing, nothing, (0.0, 0.0, 0.0))
    failed = (False, lost, lost, 0.0, (0.0, 0.0, 0.0, 0.0, 0.0, 0.0), (0.0, 0.0), (0.0, 0.0, 0.0, 0.0), False)
    fits, f, a, b, a_a, a_b, b_b = expand(near_kind, near_numbers, near_place)
    fits_too, g, c, d, c_c, c_d, d_d = expand(far_kind, far_numbers, far_place)
    if not (fits and fits_too):
        return failed
    come, inside, gone = along(f, -1.0, eye), along(g, -1.0, f), along(g, -1.0, point)
    coming, within, going = math.sqrt(dot(come, come)), math.sqrt(dot(inside, inside)), math.sqrt(dot(gone, gone))
    if min(coming, within, going, dot(a, a), dot(c, c)) == 0.0:
        return failed
    near, far = frame_of(a, b), frame_of(c, d)
    if near[2] <= 1e-12 * math.sqrt(dot(b, b)) or far[2] <= 1e-12 * math.sqrt(dot(d, d)):
        return failed
    come, inside = along(nothing, 1.0 / coming, come), along(nothing, 1.0 / within, inside)
    gone = along(nothing, 1.0 / going, gone)
    enters, leaves = along(come, -index, inside), along(gone, index, inside)
    glass = index / within
    one_one = _between_frames(
        (
            _across(a, a, come) / coming + glass * _across(a, a, inside) + dot(a_a, enters),
            _across(a, b, come) / coming + glass * _across(a, b, inside) + dot(a_b, enters),
            _across(a, b, come) / coming + glass * _across(a, b, inside) + dot(a_b, enters),
            _across(b, b, come) / coming + glass * _across(b, b, inside) + dot(b_b, enters),
        ),
        near,
        near,
    )
    one_two = _between_frames(
        (
            -glass * _across(a, c, inside),
            -glass * _across(a, d, inside),
            -glass * _across(b, c, inside),
            -glass * _across(b, d, inside),
        ),
        near,
        far,
    )
    p, q, _, r = _between_frames(
        (
            _across(c, c, gone) / going + glass * _across(c, c, inside) + dot(c_c, leaves),
            _across(c, d, gone) / going + glass * _across(c, d, inside) + dot(c_d, leaves),
            _across(c, d, gone) / going + glass * _across(c, d, inside) + dot(c_d, leaves),
            _across(d, d, gone) / going + glass * _across(d, d, inside) + dot(d_d, leaves),
        ),
        far,
        far,
    )
    determinant = p * r - q * q
    if abs(determinant) <= 1e-14 * (p * p + 2.0 * q * q + r * r):
        return failed
    first = _in_frame((dot(enters, a), dot(enters, b)), near)
    second = _in_frame((dot(leaves, c), dot(leaves, d)), far)
    offset = (r * second[0] - q * second[1]) / determinant, (p * second[1] - q * second[0]) / determinant
    xx, xy, yx, yy = one_two
    follows = (
        (r * xx - q * xy) / determinant,
        (r * yx - q * yy) / determinant,
        (p * xy - q * xx) / determinant,
        (p * yy - q * yx) / determinant,
    )
    slopes = (
        first[0] - xx * offset[0] - xy * offset[1],
        first[1] - yx * offset[0] - yy * offset[1],
        one_one[0] - xx * follows[0] - xy * follows[2],
        one_one[1] - xx * follows[1] - xy * follows[3],
        one_one[2] - yx * follows[0] - yy * follows[2],
        one_one[3] - yx * follows[1] - yy * follows[3],
    )
    normal, other = cross(a, b), cross(c, d)
    entry = (f, along(nothing, 1.0 / math.sqrt(dot(normal, normal)), normal), near)
    exit_ = (g, along(nothing, 1.0 / math.sqrt(dot(other, other)), other), far)
    return True, entry, exit_, coming + index * within + going, slopes, offset, follows, determinant < 0.0
