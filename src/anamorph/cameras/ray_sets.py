"""Cameras of rays that lie in no grid: a set of rays, and a surface of triangles with normals.

Source: Vallance and Calder, "Multi-perspective images for visualisation" (2001), appendix F of Vallance, "Trilinear
projection", section 3. Deviation: there a set of rays has a ray for every pixel, and here what lies between rays is
interpolated; and where in the image a surface of triangles lies the paper leaves open.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial import Delaunay, QhullError

from anamorph.base.errors import AnamorphError
from anamorph.base.vectors import Vector
from anamorph.cameras.grid import Size, checked_size
from anamorph.raymesh import RayMesh, RayStatus, check_ray_mesh


def from_rays(places: ArrayLike, origins: ArrayLike, directions: ArrayLike) -> RayMesh:
    """A camera of any rays at any places of the image, joined to triangles (Delaunay's) between which it interpolates.

    Parameters
    ----------
    places : (N, 2) array
        Where in the image each ray belongs, pixels from the top left; three at least, and not all on a line. What lies
        outside all of them is not seen.
    origins : (N, 3) array
        Where rays leave, metres.
    directions : (N, 3) array
        Of any length but 0.
    """
    points = _numbers("places", places, 2)
    if len(points) < 3:
        raise AnamorphError(f"camera: places are {len(points)}; give three at least")
    try:
        faces = Delaunay(points).simplices
    except QhullError:
        raise AnamorphError("camera: places lie on one line; give some beside it") from None
    return _joined(points, _numbers("origins", origins, 3), _numbers("directions", directions, 3), faces)


def from_triangles(
    positions: ArrayLike,
    normals: ArrayLike,
    faces: ArrayLike,
    size: Size,
    places: ArrayLike | None = None,
    up: Vector = (0.0, 1.0, 0.0),
) -> RayMesh:
    """What a surface of triangles sees along its normals, which are interpolated in each triangle as for shading.

    Parameters
    ----------
    positions, normals : (V, 3) array
        Metres, and directions of any length but 0.
    faces : (F, 3) array of int
        Turned either way.
    size : (width, height)
        Pixels.
    places : (V, 2) array, optional
        Where in the image the vertices are, in pixels from the top left. Where not given the surface fills the image
        as one sees it from behind, by parallel rays along the mean of its normals, and keeps its proportions. Where
        triangles then lie over each other the first is seen.
    up : three floats
        What points up in the image where `places` are not given.
    """
    points, rays = _numbers("positions", positions, 3), _numbers("normals", normals, 3)
    width, height = checked_size(size)
    image = _laid_flat(points, rays, up, (width, height)) if places is None else _numbers("places", places, 2)
    corners = np.asarray(faces)
    if corners.ndim != 2 or corners.shape[1] != 3 or corners.dtype.kind not in "iu":
        raise AnamorphError(f"camera: faces are {corners.shape} {corners.dtype}; give (F, 3) whole numbers")
    return _joined(image, points, rays, corners)


def _joined(places: np.ndarray, origins: np.ndarray, directions: np.ndarray, faces: np.ndarray) -> RayMesh:
    """The ray mesh, its faces turned as those of a grid are."""
    mesh = RayMesh(
        image=np.column_stack([places, np.ones(len(places))]),
        origins=origins,
        directions=directions,
        faces=faces.astype(np.int32),
        status=np.full(len(places), RayStatus.OK, np.uint8),
    )
    check_ray_mesh(mesh, "camera")
    turned = np.linalg.det(mesh.image[mesh.faces]) > 0.0
    mesh.faces[turned] = mesh.faces[turned][:, ::-1]
    return mesh


def _laid_flat(positions: np.ndarray, normals: np.ndarray, up: Vector, size: Size) -> np.ndarray:
    forward = normals.sum(axis=0)
    right = np.cross(forward, up)
    if np.linalg.norm(right) <= 1e-9 * np.linalg.norm(normals, axis=1).sum() * np.linalg.norm(up):
        raise AnamorphError("camera: up runs along the mean of the normals, or that is 0; give another up, or places")
    across = np.stack([right, np.cross(forward, right)])
    flat = positions @ (across / np.linalg.norm(across, axis=1, keepdims=True)).T
    low, extent = flat.min(axis=0), np.ptp(flat, axis=0)
    if not extent.all():
        raise AnamorphError("camera: seen along the mean of its normals the surface is a line; give places")
    return (flat - low - extent / 2.0) * np.min(size / extent) + np.divide(size, 2.0)


def _numbers(name: str, values: ArrayLike, width: int) -> np.ndarray:
    try:
        numbers = np.array(values, float)
    except (TypeError, ValueError):
        raise AnamorphError(f"camera: {name} are no array of numbers; give (N, {width})") from None
    if numbers.ndim != 2 or numbers.shape[1] != width or not np.isfinite(numbers).all():
        raise AnamorphError(f"camera: {name} are {numbers.shape}, or not all finite; give (N, {width}) finite numbers")
    return numbers
