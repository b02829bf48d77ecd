"""The position on an exact surface and its derivatives, of whatever kind it is, for compiled loops."""

from __future__ import annotations

from collections.abc import Callable

import numba
import numpy as np

from anamorph.base.compiled import compiled
from anamorph.base.vectors import Vector, across, along, unit
from anamorph.surfaces.base import Expansion, Surface
from anamorph.surfaces.intersection import SURFACES
from anamorph.surfaces.sphere import Sphere

SPHERE = 1 + SURFACES.index(Sphere)


def dispatched(surfaces: tuple[type[Surface], ...]) -> Callable:
    """A compiled function that takes a kind and what `Surface.expand` takes, and calls that of the surface of this
    kind, as `intersection.dispatch` does it with `meet`."""
    found = _nothing
    for kind in range(len(surfaces), 0, -1):
        found = _own_or_other("_".join(each.__name__ for each in surfaces[kind - 1 :]), kind, surfaces[kind - 1], found)
    return found


@compiled
def _nothing(kind, numbers, place):
    zero = (0.0, 0.0, 0.0)
    return False, zero, zero, zero, zero, zero, zero


def _own_or_other(name: str, own_kind: int, surface: type[Surface], other: Callable) -> Callable:
    own = surface.expand

    def own_or_other(kind, numbers, place):
        if kind == own_kind:
            return own(numbers, place)
        return other(kind, numbers, place)

    # Of two functions of one name, machine code that was kept on disk can take the wrong one.
    own_or_other.__qualname__ = f"expand_{name}"
    return numba.njit(own_or_other, nogil=True, error_model="numpy", _nrt=False)


_expand_any = dispatched(SURFACES)


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
    return _expand_any(kind, numbers, place)


@compiled
def shifted(kind: int, place: Vector, a: float, b: float) -> Vector:
    """A place moved by a and b, to second order."""
    if kind == SPHERE:
        out = unit(place)
        right, up = across(out)
        return unit(along(along(out, a, right), b, up))
    return (place[0] + a, place[1] + b, place[2])
