"""The three-ray cameras of an image: triangles of ray meshes.

What triangle of the scene each one is, and how its rays leave it, goes with it.

Source: Mei, Popescu and Sacks 2007, section 5: the image plane of a camera is the reflector's triangle.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from anamorph.base.compiled import compiled, over_all_cores
from anamorph.base.vectors import along, cross, dot
from anamorph.optics.ray_meshes import Body, Line, side_rays
from anamorph.raymesh import RayMesh, RayStatus
from anamorph.rays.caster import LEAST_STEP, ROUNDING
from anamorph.raytriangle.camera_frames import vector
from anamorph.raytriangle.owners import sampled
from anamorph.scene.camera import Eye
from anamorph.scene.geometry import Geometry

GRAIN = 1024
"""Cameras that a core fills at a time."""

TINY = float(np.finfo(float).tiny)


class Cameras(NamedTuple):
    """The triangles of ray meshes, K of them, as compiled loops read them."""

    image: np.ndarray
    """(K, 3, 3) float64: homogeneous image corners (x w, y w, w), samples from the first one's centre."""
    origins: np.ndarray
    """(K, 3, 3) float64"""
    directions: np.ndarray
    """(K, 3, 3) float64: of any length."""
    transmittance: np.ndarray
    """(K, 3) float64: what share of the light goes through a lens at each corner; 1 elsewhere."""
    traced: np.ndarray
    """(K,) bool: whether no ray is interpolated here, because a corner's stays in the glass."""
    item: np.ndarray
    """(K,) int64: the object number of the specular surface; 0 for none."""
    left: np.ndarray
    """(K,) int64: the object that its rays leave: of a lens, the far face; 0 for none."""
    bounces: np.ndarray
    """(K,) int64: how many interfaces a ray has met."""
    rounding: np.ndarray
    """(K,) float64: metres by which float32 may put the start of a ray off."""
    near: np.ndarray
    """(K,) float64: the t before which a ray meets nothing."""
    longest: np.ndarray
    """(K,) float64: the triangle's longest edge in space, metres."""
    normal: np.ndarray
    """(K, 3) float64: the unit normal of the triangle in space; zeros for none."""


def mesh_cameras(rays: RayMesh, side: int, shift: tuple[float, float]) -> Cameras:
    """The triangles of a ray mesh that is the camera, at `side` samples a pixel's side."""
    count = len(rays.faces)
    nothing, zeros = np.zeros(count, np.int64), np.zeros(count)
    directions = np.asarray(rays.directions, float)[rays.faces]
    return Cameras(
        sampled(rays.image[rays.faces], side, shift), np.asarray(rays.origins, float)[rays.faces], directions,
        np.ones((count, 3)), np.zeros(count, bool), nothing, nothing, nothing,
        zeros, zeros, zeros, np.zeros((count, 3)),
    )  # fmt: skip


def body_cameras(
    bodies: Sequence[Body],
    geometry: Geometry,
    eye: Eye,
    side: int,
    shift: tuple[float, float],
    line: Line = 1,
) -> Cameras:
    """The triangles of all mirrors and lenses as an eye sees them by light of one line, both sides of each lens."""
    sides = [(own, body.sides[number - 1]) for body in bodies for number, own in enumerate(body.sides)]
    counts = [len(own.triangles) for own, _ in sides]
    cameras = _reserved(sum(counts))
    for (own, far), stop, count in zip(sides, np.cumsum(counts), counts, strict=True):
        rays = side_rays(own, eye, line)
        stays = own.refracts & ~np.isin(np.asarray(rays.status), (RayStatus.OK, RayStatus.BACK_FACING))
        through = np.ones(len(rays.image)) if rays.transmittance is None else np.asarray(rays.transmittance, float)
        image = sampled(rays.image, side, shift)
        origins, directions = np.ascontiguousarray(rays.origins, float), np.ascontiguousarray(rays.directions, float)
        positions = np.ascontiguousarray(own.optics.positions, float)
        vertices = _Vertices(image, origins, directions, positions, through, stays)
        _fill_side(cameras, int(stop) - count, np.asarray(rays.faces), vertices)
        these = slice(stop - count, stop)
        cameras.item[these] = geometry.face_object[own.triangles]
        cameras.left[these] = far.objects[0] if own.refracts else cameras.item[these]
        cameras.bounces[these] = 2 if own.refracts else 1
    return cameras


class _Vertices(NamedTuple):
    """What a side's cameras have at their corners, by the numbers of vertices."""

    image: np.ndarray
    origins: np.ndarray
    directions: np.ndarray
    positions: np.ndarray
    transmittance: np.ndarray
    stays: np.ndarray


def _reserved(count: int) -> Cameras:
    shapes = (3, 3), (3, 3), (3, 3), (3,), (), (), (), (), (), (), (), (3,)
    kinds = {"traced": bool, "item": np.int64, "left": np.int64, "bounces": np.int64}
    named = zip(Cameras._fields, shapes, strict=True)
    return Cameras(*(np.zeros((count, *shape), kinds.get(name, float)) for name, shape in named))


def _fill_side(cameras: Cameras, first: int, faces: np.ndarray, vertices: _Vertices) -> None:
    over_all_cores(lambda start, stop: _fill(cameras, first, faces, vertices, start, stop), len(faces), GRAIN)


@compiled
def _fill(cameras: Cameras, first: int, faces: np.ndarray, vertices: _Vertices, start: int, stop: int) -> None:
    for f in range(start, stop):
        c, largest, shortest = first + f, 0.0, math.inf
        for i in range(3):
            v, square = faces[f, i], 0.0
            for k in range(3):
                cameras.image[c, i, k] = vertices.image[v, k]
                cameras.origins[c, i, k], cameras.directions[c, i, k] = (
                    vertices.origins[v, k],
                    vertices.directions[v, k],
                )
                largest, square = max(largest, abs(vertices.origins[v, k])), square + vertices.directions[v, k] ** 2
            shortest = min(shortest, math.sqrt(square))
            cameras.transmittance[c, i] = vertices.transmittance[v]
            cameras.traced[c] |= vertices.stays[v]
        cameras.rounding[c] = max(ROUNDING * largest, LEAST_STEP)
        cameras.near[c] = cameras.rounding[c] / max(shortest, TINY)
        p, q, r = vertices.positions[faces[f, 0]], vertices.positions[faces[f, 1]], vertices.positions[faces[f, 2]]
        one, other = along(vector(q), -1.0, vector(p)), along(vector(r), -1.0, vector(q))
        last = along(vector(p), -1.0, vector(r))
        cameras.longest[c] = math.sqrt(max(dot(one, one), dot(other, other), dot(last, last)))
        normal = cross(one, other)
        scale = 1.0 / max(math.sqrt(dot(normal, normal)), TINY)
        cameras.normal[c, 0], cameras.normal[c, 1], cameras.normal[c, 2] = along((0.0, 0.0, 0.0), scale, normal)
