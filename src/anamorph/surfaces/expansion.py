"""The position on an exact surface and its derivatives, of whatever kind it is, for compiled loops."""

from __future__ import annotations

import numpy as np

from anamorph.base.compiled import compiled
from anamorph.base.vectors import Vector, across, along, unit
from anamorph.surfaces.base import Expansion
from anamorph.surfaces.bezier import BezierPatch
from anamorph.surfaces.even_asphere import EvenAsphere
from anamorph.surfaces.intersection import SURFACES
from anamorph.surfaces.nurbs import NurbsSurface
from anamorph.surfaces.plane import Plane
from anamorph.surfaces.sphere import Sphere
from anamorph.surfaces.toroid import Toroid

PLANE, SPHERE, BEZIER, NURBS, TOROID, ASPHERE = (
    1 + SURFACES.index(kind) for kind in (Plane, Sphere, BezierPatch, NurbsSurface, Toroid, EvenAsphere)
)

_of_plane, _of_sphere, _of_bezier = Plane.expand, Sphere.expand, BezierPatch.expand
_of_nurbs, _of_toroid, _of_asphere = NurbsSurface.expand, Toroid.expand, EvenAsphere.expand


@compiled
def expand(kind: int, numbers: np.ndarray, place: Vector) -> Expansion:
    """The position on a surface, and its derivatives along two parameters a and b that `shifted` changes.

    Parameters
    ----------
    kind, numbers
        The surface, from `intersection.pack`.
    place : three float64
        From `Surface.places`.

    Returns
    -------
    Expansion
    """
    if kind == PLANE:
        return _of_plane(numbers, place)
    if kind == SPHERE:
        return _of_sphere(numbers, place)
    if kind == BEZIER:
        return _of_bezier(numbers, place)
    if kind == NURBS:
        return _of_nurbs(numbers, place)
    if kind == TOROID:
        return _of_toroid(numbers, place)
    if kind == ASPHERE:
        return _of_asphere(numbers, place)
    zero = (0.0, 0.0, 0.0)
    return False, zero, zero, zero, zero, zero, zero


@compiled
def shifted(kind: int, place: Vector, a: float, b: float) -> Vector:
    """A place moved by a and b, to second order."""
    if kind == SPHERE:
        out = unit(place)
        right, up = across(out)
        return unit(along(along(out, a, right), b, up))
    return (place[0] + a, place[1] + b, place[2])
