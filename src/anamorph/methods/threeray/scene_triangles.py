"""The scene's triangles, and which of them a ray meets and ends at. Compiled.

A triangle is held as vectors that give numbers of a point, so that many rays are asked at once.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from anamorph.base.compiled import inlined
from anamorph.base.vectors import Vector, dot
from anamorph.methods.threeray.cameras_seen import Cameras
from anamorph.methods.threeray.objects import Materials
from anamorph.rays.caster import ROUNDING
from anamorph.raytriangle.camera_frames import vector

BORDER = 6e-8
"""How far beyond a triangle's border a ray still meets it, as a share of the triangle: half a float32's last place."""


class Triangles(NamedTuple):
    """The scene's triangles as compiled loops read them: vectors that give numbers of a point x, (F, 4) float64."""

    plane: np.ndarray
    """n and n . a: the normal, of the length of twice the area, and the first corner's height."""
    second: np.ndarray
    """m and m . a: m . x - m . a is the weight of the second corner at a point of the plane."""
    third: np.ndarray
    """The same of the third corner."""
    item: np.ndarray
    """(F,) int64: the object number."""


def triangles_of(corners: np.ndarray, face_object: np.ndarray) -> Triangles:
    """The triangles with these corners (F, 3, 3); those without an area are met by nothing."""
    a, b, c = np.moveaxis(corners, 1, 0)
    normal = np.cross(b - a, c - a)
    square = np.einsum("fi,fi->f", normal, normal)[:, None]
    square = np.where(square > 0.0, square, 1.0)
    vectors = normal, np.cross(c - a, normal) / square, np.cross(normal, b - a) / square
    rows = [np.column_stack([each, np.einsum("fi,fi->f", each, a)]) for each in vectors]
    return Triangles(rows[0], rows[1], rows[2], np.asarray(face_object).astype(np.int64))


@inlined
def meets(
    p_x: np.ndarray,
    p_y: np.ndarray,
    p_z: np.ndarray,
    d_x: np.ndarray,
    d_y: np.ndarray,
    d_z: np.ndarray,
    triangles: Triangles,
    f: int,
    ways: np.ndarray,
) -> bool:
    """Fill the `ways` t at which rays meet triangle f, infinite where they do not; whether any does."""
    n_x, n_y, n_z, n_a = triangles.plane[f, 0], triangles.plane[f, 1], triangles.plane[f, 2], triangles.plane[f, 3]
    u_x, u_y, u_z, u_a = triangles.second[f, 0], triangles.second[f, 1], triangles.second[f, 2], triangles.second[f, 3]
    v_x, v_y, v_z, v_a = triangles.third[f, 0], triangles.third[f, 1], triangles.third[f, 2], triangles.third[f, 3]
    some = False
    # Without a branch, and along slices, the processor asks several at once.
    for k in range(len(p_x)):
        t = (n_a - (n_x * p_x[k] + n_y * p_y[k] + n_z * p_z[k])) / (n_x * d_x[k] + n_y * d_y[k] + n_z * d_z[k])
        x, y, z = p_x[k] + t * d_x[k], p_y[k] + t * d_y[k], p_z[k] + t * d_z[k]
        u, v = u_x * x + u_y * y + u_z * z - u_a, v_x * x + v_y * y + v_z * z - v_a
        met = (u >= -BORDER) & (v >= -BORDER) & (u + v <= 1.0 + BORDER) & (t >= 0.0)
        ways[k] = t if met else np.inf
        some = some | met
    return some


@inlined
def stops(
    cameras: Cameras, triangles: Triangles, materials: Materials, c: int, f: int, t: float, direction: Vector
) -> bool:
    """Whether a ray of camera c that meets triangle f at t ends there.

    It does not where it has just started, nor where it passes the back of the surface that it leaves, as paths do in
    `methods.tracing.bounces`.
    """
    left, surface = cameras.left[c], materials.surface
    if t < cameras.near[c]:
        return False
    own = left > 0 and surface[left] == surface[triangles.item[f]]
    if not own or dot(vector(triangles.plane[f]), direction) <= 0.0:
        return True
    distance = t * math.sqrt(dot(direction, direction))
    if materials.curved[left]:
        return distance >= cameras.longest[c]
    rise = t * dot(direction, vector(cameras.normal[c]))
    return rise >= cameras.rounding[c] + ROUNDING * (distance + cameras.longest[c])
