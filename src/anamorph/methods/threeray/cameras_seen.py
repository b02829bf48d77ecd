"""The three-ray cameras of an image: triangles of ray meshes.

What triangle of the scene each one is, and how its rays leave it, goes with it.

Source: Mei, Popescu and Sacks 2007, section 5: the image plane of a camera is the reflector's triangle.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from anamorph.optics.ray_meshes import Body, Line, side_rays
from anamorph.raymesh import RayMesh, RayStatus
from anamorph.rays.caster import LEAST_STEP, ROUNDING
from anamorph.raytriangle.owners import sampled
from anamorph.scene.camera import Eye
from anamorph.scene.geometry import Geometry


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
    parts = [
        _side_cameras(body, number, geometry, eye, side, shift, line)
        for body in bodies
        for number in range(len(body.sides))
    ]
    return Cameras(*(np.concatenate(columns) for columns in zip(*parts, strict=True)))


def _side_cameras(
    body: Body, number: int, geometry: Geometry, eye: Eye, side: int, shift: tuple[float, float], line: Line
) -> Cameras:
    own, far = body.sides[number], body.sides[number - 1]
    rays = side_rays(own, eye, line)
    faces, count = rays.faces, len(rays.faces)
    item = geometry.face_object[own.triangles].astype(np.int64)
    stays = ~np.isin(np.asarray(rays.status), (RayStatus.OK, RayStatus.BACK_FACING))
    corners = np.asarray(own.optics.positions, float)[faces]
    edges = np.roll(corners, -1, axis=1) - corners
    normal = np.cross(edges[:, 0], edges[:, 1])
    largest = np.abs(rays.origins[faces]).max(axis=(1, 2))
    rounding = np.maximum(ROUNDING * largest, LEAST_STEP)
    return Cameras(
        sampled(rays.image[faces], side, shift),
        rays.origins[faces],
        rays.directions[faces],
        np.ones((count, 3)) if rays.transmittance is None else rays.transmittance[faces],
        stays[faces].any(axis=1) if own.refracts else np.zeros(count, bool),
        item,
        np.full(count, far.objects[0], np.int64) if own.refracts else item,
        np.full(count, 2 if own.refracts else 1, np.int64),
        rounding,
        rounding / np.maximum(np.linalg.norm(rays.directions[faces], axis=2).min(axis=1), np.finfo(float).tiny),
        np.linalg.norm(edges, axis=2).max(axis=1),
        normal / np.maximum(np.linalg.norm(normal, axis=1), np.finfo(float).tiny)[:, None],
    )
