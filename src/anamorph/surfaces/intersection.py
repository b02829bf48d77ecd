"""Where a ray meets the exact surface that a mesh approximates.

A ray is cast at the mesh first; what it hits there is the start from which the hit on the exact surface is found. The
compiled functions take one ray, so that other compiled loops can use them; `intersect` takes arrays.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from anamorph.base.compiled import compiled
from anamorph.base.errors import AnamorphError
from anamorph.base.vectors import Vector, along, cross, dot, unit
from anamorph.surfaces.nurbs import NurbsSurface
from anamorph.surfaces.nurbs_pieces import HEAD, pieces, point_and_tangents
from anamorph.surfaces.sag import EvenAsphere, Toroid
from anamorph.surfaces.sag_intersection import meet_sag
from anamorph.surfaces.shapes import BezierPatch, Plane, Sphere, Surface

NONE, PLANE, SPHERE, BEZIER, NURBS, TOROID, ASPHERE = range(7)
NUMBERS = 48
"""Of a Bezier patch."""


def pack(surface: Surface | None) -> tuple[int, np.ndarray]:
    """The kind of `surface` and its numbers, (N,) float64, as the compiled functions read them."""
    match surface:
        case None:
            return NONE, np.zeros(0)
        case Plane():
            return PLANE, np.concatenate([surface.origin, surface.normal(np.zeros((1, 2)))[0]])
        case Sphere():
            return SPHERE, np.append(np.asarray(surface.center, float), surface.radius)
        case BezierPatch():
            return BEZIER, np.ravel(np.asarray(surface.control, float))
        case NurbsSurface():
            return NURBS, np.append(pieces(surface), surface.sign)
        case Toroid():
            curvatures = [surface.base_curvature, surface.cross_curvature]
            return TOROID, np.concatenate([surface.apex, np.ravel(surface.axes), curvatures])
        case EvenAsphere():
            count = len(surface.coefficients)
            shape = [surface.curvature, surface.conic, count, *surface.coefficients]
            return ASPHERE, np.concatenate([surface.apex, np.ravel(surface.axes), shape])
    raise AnamorphError(f"surface: rays cannot be bent at a {type(surface).__name__}; leave the mesh's surface out")


@compiled
def _cubic(t: float) -> tuple[tuple[float, float, float, float], tuple[float, float, float, float]]:
    """The four Bernstein polynomials at t, and their derivatives."""
    s = 1.0 - t
    values = (s * s * s, 3.0 * s * s * t, 3.0 * s * t * t, t * t * t)
    slopes = (-3.0 * s * s, 3.0 * s * (s - 2.0 * t), 3.0 * t * (2.0 * s - t), 3.0 * t * t)
    return values, slopes


@compiled
def _patch(control: np.ndarray, u: float, v: float) -> tuple[Vector, Vector, Vector]:
    """Position on a Bezier patch of 48 numbers, and its derivatives along u and v."""
    (a, da), (b, db) = _cubic(u), _cubic(v)
    position, along_u, along_v = (0.0, 0.0, 0.0), (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)
    for i in range(4):
        for j in range(4):
            first = 3 * (4 * i + j)
            point = (control[first], control[first + 1], control[first + 2])
            position = along(position, a[i] * b[j], point)
            along_u = along(along_u, da[i] * b[j], point)
            along_v = along(along_v, a[i] * db[j], point)
    return position, along_u, along_v


@compiled
def _at(kind: int, numbers: np.ndarray, u: float, v: float) -> tuple[Vector, Vector, Vector]:
    """Position and derivatives on a patch, by parameters from 0 to 1."""
    if kind == NURBS:
        return point_and_tangents(numbers, u, v)
    return _patch(numbers, u, v)


@compiled
def _meet_patch(
    kind: int,
    numbers: np.ndarray,
    origin: Vector,
    direction: Vector,
    u: float,
    v: float,
) -> tuple[bool, float, Vector]:
    """Newton's iteration in (u, v) on the two components of S(u, v) - origin across the ray, with halved steps."""
    if abs(direction[0]) < 0.6:
        across_1 = unit(cross(direction, (1.0, 0.0, 0.0)))
    else:
        across_1 = unit(cross(direction, (0.0, 1.0, 0.0)))
    across_2 = cross(direction, across_1)
    extent, turn = 0.0, 1.0
    if kind == NURBS:
        extent, turn = numbers[HEAD - 1], numbers[-1]
        u, v = (u - numbers[4]) / numbers[5], (v - numbers[6]) / numbers[7]
    else:
        for number in range(3, NUMBERS):
            extent = max(extent, abs(numbers[number] - numbers[number % 3]))

    position, along_u, along_v = _at(kind, numbers, u, v)
    offset = along(position, -1.0, origin)
    started = dot(offset, direction)
    f, g = dot(offset, across_1), dot(offset, across_2)
    share = 1.0
    for _ in range(48):
        fu, fv, gu, gv = dot(along_u, across_1), dot(along_v, across_1), dot(along_u, across_2), dot(along_v, across_2)
        determinant = fu * gv - fv * gu
        found = f * f + g * g <= (1e-14 * extent) ** 2
        if found or share < 1e-3 or abs(determinant) <= 1e-12 * extent * extent:
            break
        # A little beyond the border, because the mesh there may stand before the neighbouring patch.
        next_u = min(max(u - share * (f * gv - fv * g) / determinant, -0.05), 1.05)
        next_v = min(max(v - share * (fu * g - f * gu) / determinant, -0.05), 1.05)
        position, next_along_u, next_along_v = _at(kind, numbers, next_u, next_v)
        next_offset = along(position, -1.0, origin)
        next_f, next_g = dot(next_offset, across_1), dot(next_offset, across_2)
        if next_f * next_f + next_g * next_g < f * f + g * g:
            u, v, f, g, offset, along_u, along_v = (
                next_u,
                next_v,
                next_f,
                next_g,
                next_offset,
                next_along_u,
                next_along_v,
            )
            share = min(2.0 * share, 1.0)
        else:
            share *= 0.5
    distance = dot(offset, direction)
    normal = cross(along_u, along_v)
    normal = (turn * normal[0], turn * normal[1], turn * normal[2])
    # Far from where the mesh was hit lies another sheet of the patch; a vanishing normal is a pole.
    met = (
        f * f + g * g <= (1e-9 * extent) ** 2
        and abs(distance - started) <= 0.25 * extent
        and dot(normal, normal) > (1e-7 * extent * extent) ** 2
    )
    return met, distance, unit(normal) if met else (0.0, 0.0, 0.0)


@compiled
def _turn(axes: np.ndarray, vector: Vector) -> Vector:
    """A vector in a surface's own coordinates; `axes` are nine numbers, right, up and outward."""
    return (
        axes[0] * vector[0] + axes[1] * vector[1] + axes[2] * vector[2],
        axes[3] * vector[0] + axes[4] * vector[1] + axes[5] * vector[2],
        axes[6] * vector[0] + axes[7] * vector[1] + axes[8] * vector[2],
    )


@compiled
def _turn_back(axes: np.ndarray, vector: Vector) -> Vector:
    return (
        axes[0] * vector[0] + axes[3] * vector[1] + axes[6] * vector[2],
        axes[1] * vector[0] + axes[4] * vector[1] + axes[7] * vector[2],
        axes[2] * vector[0] + axes[5] * vector[1] + axes[8] * vector[2],
    )


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
        The mesh's normal there, against the ray. It tells which side of a sphere the mesh is: near a silhouette the
        distances do not.

    Returns
    -------
    met : bool
        False where the ray passes the surface by, or the search fails.
    distance : float
    normal : three float64
        Unit, pointing outside.
    """
    met, normal = False, (0.0, 0.0, 0.0)
    if kind == PLANE:
        normal = (numbers[3], numbers[4], numbers[5])
        slope = dot(direction, normal)
        if abs(slope) > 1e-12:
            distance = dot(along((numbers[0], numbers[1], numbers[2]), -1.0, origin), normal) / slope
            met = True
    elif kind == SPHERE:
        to_center = along((numbers[0], numbers[1], numbers[2]), -1.0, origin)
        middle = dot(to_center, direction)
        across = along(to_center, -middle, direction)
        square = numbers[3] * numbers[3] - dot(across, across)
        if square >= 0.0:
            half = math.sqrt(square)
            from_center = along(along((0.0, 0.0, 0.0), distance, direction), -1.0, to_center)
            distance = middle - half if dot(from_center, facing) > 0.0 else middle + half
            normal = unit(along(along((0.0, 0.0, 0.0), distance, direction), -1.0, to_center))
            met = True
    elif kind in (BEZIER, NURBS):
        met, distance, normal = _meet_patch(kind, numbers, origin, direction, u, v)
    elif kind in (TOROID, ASPHERE):
        axes = numbers[3:12]
        met, distance, normal = meet_sag(
            kind == TOROID,
            numbers[12:],
            _turn(axes, along(origin, -1.0, (numbers[0], numbers[1], numbers[2]))),
            _turn(axes, direction),
            distance,
            _turn(axes, facing),
        )
        normal = _turn_back(axes, normal)
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
    surface : Plane, Sphere, BezierPatch, NurbsSurface, Toroid or EvenAsphere
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
