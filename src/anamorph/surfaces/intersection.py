"""Where a ray meets the exact surface that a mesh approximates, of whatever kind that is.

A ray is cast at the mesh first; what it hits there is the start from which the hit on the exact surface is found. The
compiled functions take one ray, so that other compiled loops can use them; `intersect` takes arrays.
"""

from __future__ import annotations

from collections.abc import Callable

import numba
import numpy as np
from numpy.typing import ArrayLike

from anamorph.base.compiled import compiled
from anamorph.base.errors import AnamorphError
from anamorph.base.vectors import Vector, along
from anamorph.surfaces.base import Surface
from anamorph.surfaces.bezier import BezierPatch
from anamorph.surfaces.even_asphere import EvenAsphere
from anamorph.surfaces.nurbs import NurbsSurface
from anamorph.surfaces.patch import Patch
from anamorph.surfaces.plane import Plane
from anamorph.surfaces.sphere import Sphere
from anamorph.surfaces.toroid import Toroid

SURFACES: tuple[type[Surface], ...] = (Plane, Sphere, BezierPatch, NurbsSurface, Toroid, EvenAsphere)
"""Every kind of exact surface; compiled loops know each by its number, from 1."""

NONE = 0
PLANE = 1 + SURFACES.index(Plane)
PATCHES = tuple(kind for kind, surface in enumerate(SURFACES, start=1) if issubclass(surface, Patch))
"""The kinds of which several make one body, border to border."""


def pack(surface: Surface | None) -> tuple[int, np.ndarray]:
    """The kind of `surface` and its numbers, (N,) float64, as the compiled functions read them."""
    if surface is None:
        return NONE, np.zeros(0)
    if type(surface) not in SURFACES:
        raise AnamorphError(f"surface: rays cannot be bent at a {type(surface).__name__}; leave the mesh's surface out")
    return 1 + SURFACES.index(type(surface)), surface.numbers


def dispatch(surfaces: tuple[type[Surface], ...]) -> Callable:
    """A compiled function that takes a kind and what `Surface.meet` takes, and calls that of the surface of this kind.

    Machine code calls only what it knows beforehand, so each surface hands on to the next what is not of its kind.
    """
    found = _none
    for kind in range(len(surfaces), 0, -1):
        name = "_or_".join(each.__name__ for each in surfaces[kind - 1 :])
        found = _own_or_other(name, kind, surfaces[kind - 1].meet, found)
    return found


@compiled
def _none(kind, numbers, origin, direction, distance, u, v, facing):
    return False, distance, (0.0, 0.0, 0.0)


def _own_or_other(name: str, own_kind: int, own: Callable, other: Callable) -> Callable:
    def own_or_other(kind, numbers, origin, direction, distance, u, v, facing):
        if kind == own_kind:
            return own(numbers, origin, direction, distance, u, v, facing)
        return other(kind, numbers, origin, direction, distance, u, v, facing)

    # Machine code that was kept on disk finds a function by its name and a number that each process counts from the
    # start: of two that have one name it can take the wrong one.
    own_or_other.__qualname__ = name
    # Part of the machine code of `meet`, which is kept on disk; on its own it could not be found there again.
    return numba.njit(own_or_other, nogil=True, error_model="numpy", _nrt=False)


_meet_any = dispatch(SURFACES)


@compiled
def meet(
    kind: int,
    numbers: np.ndarray,
    origin: Vector,
    direction: Vector,
    distance: float,
    u: float,
    v: float,
    facing: Vector,
) -> tuple[bool, float, Vector]:
    """Refine a hit on the mesh to one on the exact surface.

    Parameters
    ----------
    kind, numbers
        The surface, from `pack`.
    origin, direction : three float64 each
        The ray; unit direction.
    distance, u, v : float
        Where it hits the mesh: along the ray, and on the surface.
    facing : three float64
        The mesh's normal there, against the ray. It tells which of two hits is meant.

    Returns
    -------
    met : bool
        False where the ray passes the surface by, or the search fails.
    distance : float
    normal : three float64
        Unit, pointing outside.
    """
    met, distance, normal = _meet_any(kind, numbers, origin, direction, distance, u, v, facing)
    return met and distance > 0.0, distance, normal


@compiled
def meet_all(
    kind: int,
    numbers: np.ndarray,
    origins: np.ndarray,
    directions: np.ndarray,
    distances: np.ndarray,
    parameters: np.ndarray,
    facing: np.ndarray,
    positions: np.ndarray,
    normals: np.ndarray,
    ok: np.ndarray,
) -> None:
    """`meet` for N rays: fills `positions` (N, 3), `normals` (N, 3) and `ok` (N,)."""
    for i in range(len(origins)):
        origin = (origins[i, 0], origins[i, 1], origins[i, 2])
        direction = (directions[i, 0], directions[i, 1], directions[i, 2])
        ok[i], distance, normal = meet(
            kind,
            numbers,
            origin,
            direction,
            distances[i],
            parameters[i, 0],
            parameters[i, 1],
            (facing[i, 0], facing[i, 1], facing[i, 2]),
        )
        point = along(origin, distance, direction)
        for axis in range(3):
            positions[i, axis], normals[i, axis] = point[axis], normal[axis]


def intersect(
    surface: Surface, origins: ArrayLike, directions: ArrayLike, start_parameters: ArrayLike
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Refine hits on a mesh to hits on its exact surface.

    Parameters
    ----------
    surface : Surface
        One of `SURFACES`.
    origins, directions : (N, 3) array
        Unit directions.
    start_parameters : (N, 2) array
        (u, v) of the hits on the mesh. Of several hits on the surface, the one nearest to these is found.

    Returns
    -------
    positions, normals : (N, 3) float64
        Metres; unit normals pointing outside.
    ok : (N,) bool
        False where a ray passes the surface by or starts beyond it, or the search fails: use the mesh there.
    """
    kind, numbers = pack(surface)
    origins = np.array(origins, float).reshape(-1, 3)
    directions = np.array(directions, float).reshape(-1, 3)
    parameters = np.array(start_parameters, float).reshape(-1, 2)
    distances = np.sum((surface.position(parameters) - origins) * directions, axis=1)
    facing = surface.normal(parameters)
    facing = np.where(np.sum(facing * directions, axis=1, keepdims=True) > 0.0, -facing, facing)
    positions, normals, ok = np.empty_like(origins), np.empty_like(origins), np.empty(len(origins), bool)
    meet_all(kind, numbers, origins, directions, distances, parameters, facing, positions, normals, ok)
    return positions, normals, ok
