"""The ray triangles of an image: those of its mirrors and lenses as the eye sees them, or of a ray mesh as camera.

Source: Vallance 2005, sections 7.2 (mirrors), 7.3 (refraction) and chapter 6 (cameras made by hand).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from anamorph.methods.trilinear.pairs import ALL, FRONTS, NONE
from anamorph.optics.ray_meshes import Body, Side, rays_of
from anamorph.raymesh import RayMesh, RayStatus
from anamorph.scene.camera import Eye
from anamorph.scene.geometry import Geometry


@dataclass(frozen=True, eq=False)
class RayTriangles:
    """Ray triangles of light of one colour, K of them.

    Parameters
    ----------
    image, origins, directions : (K, 3, 3) float64
        As in a `RayMesh`, for the three corners.
    transmittance : (K, 3) float64
        What share of the light goes this way; 1 for mirrors, whose reflectance the pixels find for themselves.
    exists : (K,) bool
        Whether there are rays at all.
    total, by_edge : (K,) bool
        Whether reflection in the glass is total, and whether some rays leave it by its edge.
    face : (K,) int32
        The triangle of the scene that each one is, or -1.
    object : (K,) int32
        The object number of that; 0 for none.
    group, sees : (K,) int32
        The group of scene triangles that the rays leave, and what they see of it: ALL, FRONTS or NONE.
    lens : (K,) int32
        The row, from 1, of the lens in `lens_edges`; 0 for none.
    """

    image: np.ndarray
    origins: np.ndarray
    directions: np.ndarray
    transmittance: np.ndarray
    exists: np.ndarray
    total: np.ndarray
    by_edge: np.ndarray
    face: np.ndarray
    object: np.ndarray
    group: np.ndarray
    sees: np.ndarray
    lens: np.ndarray

    def chosen(self, rows: np.ndarray) -> RayTriangles:
        """Some of them."""
        return RayTriangles(*(getattr(self, name)[rows] for name in self.__dataclass_fields__))


def camera_triangles(rays: RayMesh) -> RayTriangles:
    """The ray triangles of a ray mesh that is itself the camera."""
    count = len(rays.faces)
    nothing, never = np.zeros(count, np.int32), np.zeros(count, bool)
    return RayTriangles(
        *_corners(rays), np.ones((count, 3)), _any_direction(rays), never, never,
        np.full(count, -1, np.int32), nothing, np.full(count, -1, np.int32), np.full(count, ALL, np.int32), nothing,
    )  # fmt: skip


def body_triangles(bodies: Sequence[Body], geometry: Geometry, eye: Eye, dispersion: bool) -> list[RayTriangles]:
    """The ray triangles of all bodies: of green light or all, then of red and blue where glass disperses."""
    lens = {side: row for row, side in enumerate(_lens_sides(bodies), start=1)}
    lines: list[list[RayTriangles]] = [[], [], []]
    for group, body in enumerate(bodies, start=1):
        found = rays_of(body, eye, dispersion)
        for line, rays in zip(lines, (found.rays, *found.others), strict=False):
            line.append(_side_triangles(found.side, rays, geometry, group, lens.get(found.side, 0)))
    return [_joined(line) for line in lines if line]


def body_groups(bodies: Sequence[Body], geometry: Geometry) -> tuple[np.ndarray, np.ndarray]:
    """What the scene's triangles have of the bodies that they belong to.

    Returns
    -------
    group : (F,) int32
        The body of each triangle, from 1; 0 for what is not specular.
    normals : (F, 3, 3) float64
        Unit vectors at the corners of mirrors' triangles, exact where the surface is; zeros elsewhere.
    """
    group, normals = np.zeros(len(geometry.faces), np.int32), np.zeros((len(geometry.faces), 3, 3))
    for number, body in enumerate(bodies, start=1):
        for side in body.sides:
            group[side.triangles] = number
            if not side.refracts:
                normals[side.triangles] = side.optics.normals[side.optics.faces]
    return group, normals


def lens_edges(bodies: Sequence[Body]) -> np.ndarray:
    """The edges of all lenses as `Side.lens_edge` has them, (lenses, 2, 4): two for each lens, one for either side."""
    return np.array([side.lens_edge() for side in _lens_sides(bodies)]).reshape(-1, 2, 4)


def _lens_sides(bodies: Sequence[Body]) -> list[Side]:
    return [side for body in bodies for side in body.sides if side.refracts]


def _side_triangles(side: Side, rays: RayMesh, geometry: Geometry, group: int, lens: int) -> RayTriangles:
    count = len(rays.faces)
    return RayTriangles(
        *_corners(rays),
        np.ones((count, 3)) if rays.transmittance is None else rays.transmittance[rays.faces],
        _any_direction(rays),
        (rays.status == RayStatus.TOTAL_REFLECTION)[rays.faces].any(axis=1),
        _beyond_edge(side, rays.origins)[rays.faces].any(axis=1) if lens else np.zeros(count, bool),
        side.triangles.astype(np.int32),
        geometry.face_object[side.triangles].astype(np.int32),
        np.full(count, group, np.int32),
        np.full(count, NONE if lens else FRONTS, np.int32),
        np.full(count, lens, np.int32),
    )


def _corners(rays: RayMesh) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    return rays.image[rays.faces], rays.origins[rays.faces], rays.directions[rays.faces]


def _any_direction(rays: RayMesh) -> np.ndarray:
    return rays.directions[rays.faces].any(axis=(1, 2))


def _beyond_edge(side: Side, origins: np.ndarray) -> np.ndarray:
    """Whether rays start farther from a lens's axis than its edge is, but for the rounding of f32."""
    (*middle, _), (*axis, radius) = side.lens_edge()
    offset = origins - middle
    return np.linalg.norm(offset - np.outer(offset @ axis, axis), axis=1) > 0.999 * radius


def _joined(parts: list[RayTriangles]) -> RayTriangles:
    names = RayTriangles.__dataclass_fields__
    return RayTriangles(*(np.concatenate([getattr(part, name) for part in parts]) for name in names))
