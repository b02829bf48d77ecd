"""The three-ray cameras of an image, and which of its samples each of them owns. Compiled.

A camera is a triangle of a ray mesh. A sample belongs to the nearest triangle over its centre; of a ray mesh that is
itself the camera, to the first. What triangles of the scene each one is, and how its rays leave it, goes with it.

Source: Mei, Popescu and Sacks 2007, section 5: the image plane of a camera is the reflector's triangle.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from anamorph.base.compiled import compiled, over_all_cores
from anamorph.optics.ray_meshes import Body, Line, side_rays
from anamorph.raymesh import RayMesh, RayStatus
from anamorph.rays.caster import LEAST_STEP, ROUNDING
from anamorph.scene.camera import Eye
from anamorph.scene.geometry import Geometry

ROWS = 16
"""Rows of samples that a core takes at a time."""

NOBODY, BACK = -1, -2
"""The owner of a sample over which there is no triangle, or one that turns its back."""

EDGE = 1e-9
"""The least weight over a triangle: on the edge between two, both may have a sample."""


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


class Places(NamedTuple):
    """Where cameras are in the image, as functions of the sample."""

    weights: np.ndarray
    """(K, 3, 3) float64: numbers (a, b, c) a corner, whose a x + b y + c, over their sum, is its weight at the sample x
    columns and y rows from the first of the box. The sum is one over the depth."""
    box: np.ndarray
    """(K, 4) int64: the first column and row of the samples around it, and the last ones and one."""


def mesh_cameras(rays: RayMesh, side: int, shift: tuple[float, float]) -> Cameras:
    """The triangles of a ray mesh that is the camera, at `side` samples a pixel's side."""
    count = len(rays.faces)
    nothing, zeros = np.zeros(count, np.int64), np.zeros(count)
    directions = np.asarray(rays.directions, float)[rays.faces]
    return Cameras(
        _sampled(rays.image[rays.faces], side, shift), np.asarray(rays.origins, float)[rays.faces], directions,
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
        _sampled(rays.image[faces], side, shift),
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


def _sampled(image: np.ndarray, side: int, shift: tuple[float, float]) -> np.ndarray:
    """Image corners (K, 3, 3) in samples from the first one's centre, which `shift` moves in pixels."""
    to_samples = np.array([[side, 0, -side * shift[0] - 0.5], [0, side, -side * shift[1] - 0.5], [0, 0, 1]])
    return np.asarray(image, float) @ to_samples.T


def places_of(image: np.ndarray, size: tuple[int, int]) -> Places:
    """Where cameras with these homogeneous corners (K, 3, 3) are among `size` samples; without an area, nowhere."""
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        ahead = np.greater(image[..., 2], 0.0)
        before, some = np.all(ahead, axis=1), np.any(ahead, axis=1)
        places = image[..., :2] / image[..., 2:]
        low = np.where(before[:, None], np.ceil(places.min(axis=1) - EDGE), 0.0)
        high = np.where(before[:, None], np.floor(places.max(axis=1) + EDGE) + 1.0, size)
        box = np.concatenate([np.clip(low, 0, size), np.clip(high, 0, size)], axis=1).astype(np.int64)
        # From the box's corner, so that numbers are small.
        corners = image.copy()
        corners[..., :2] -= box[:, None, :2] * image[..., 2:]
        determinant = np.linalg.det(corners)
        # The rows of the adjugate: q = sum of weights times corners.
        rows = np.cross(np.roll(corners, -1, axis=1), np.roll(corners, -2, axis=1))
        weights = rows / determinant[:, None, None]
    exists = some & np.isfinite(weights).all(axis=(1, 2))
    weights[~exists], box[~exists] = 0.0, 0
    return Places(weights, box)


def owners_of(
    places: Places, size: tuple[int, int], fronts: np.ndarray | None, depth: np.ndarray, owner: np.ndarray
) -> np.ndarray:
    """Find the camera of each sample; returns the numbers of those that own some.

    Parameters
    ----------
    places : Places
    size : (width, height)
    fronts : (K,) bool or None
        Which turn their front to the eye; None where the first of several owns a sample and not the nearest.
    depth : (height, width) float64
        Is filled with one over the depth of the triangle, 0 for none.
    owner : (height, width) int32
        Is filled with its number, or `NOBODY` or `BACK`.
    """
    depth[:], owner[:] = 0.0, NOBODY
    first = fronts is None
    shown = np.ones(len(places.box), bool) if fronts is None else fronts
    owns = np.zeros(len(places.box), bool)
    over_all_cores(lambda start, stop: _own(*places, first, shown, depth, owner, owns, start, stop), size[1], ROWS)
    return np.flatnonzero(owns)


@compiled
def _own(
    weights: np.ndarray,
    box: np.ndarray,
    first: bool,
    fronts: np.ndarray,
    depth: np.ndarray,
    owner: np.ndarray,
    owns: np.ndarray,
    first_row: int,
    stop_row: int,
) -> None:
    for c in range(len(box)):
        x0, y0, x1 = box[c, 0], box[c, 1], box[c, 2]
        a_0, a_1, a_2 = weights[c, 0, 0], weights[c, 1, 0], weights[c, 2, 0]
        for row in range(max(y0, first_row), min(box[c, 3], stop_row)):
            y = row - y0
            at_0 = weights[c, 0, 1] * y + weights[c, 0, 2]
            at_1 = weights[c, 1, 1] * y + weights[c, 1, 2]
            at_2 = weights[c, 2, 1] * y + weights[c, 2, 2]
            for column in range(x0, x1):
                x = column - x0
                w_0, w_1, w_2 = a_0 * x + at_0, a_1 * x + at_1, a_2 * x + at_2
                total = w_0 + w_1 + w_2
                covered = total > 0.0 and min(w_0, w_1, w_2) >= -EDGE * total
                if covered and (owner[row, column] == NOBODY if first else total > depth[row, column]):
                    depth[row, column] = total
                    owner[row, column] = c if fronts[c] else BACK
                    owns[c] = owns[c] or fronts[c]
