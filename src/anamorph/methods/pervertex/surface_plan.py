"""Maps of surfaces: where each is seen from, what it must hold, and what it cannot see.

A map shows which triangle of the scene each of its texels sees, and each pixel follows its own ray through it
(search.wgsl). So nothing has to be known of what vertex rays hit: a map holds their whole ways, from its near plane to
the end of the scene. What stands where a map does not look, before its near plane or where rays converge, is listed for
each triangle of the body.

Source: Kakimoto et al. 2007, sections 3.2, 3.3, 4.2 and 4.3 for the viewpoint and the view volume.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from anamorph.methods.pervertex.bundle import crossings, pixel_weights
from anamorph.methods.pervertex.mounting import size_of
from anamorph.methods.pervertex.options import Options
from anamorph.methods.pervertex.surroundings import Surroundings
from anamorph.methods.pervertex.unseen import listed, parts_of
from anamorph.methods.pervertex.visible_rays import visible_rays
from anamorph.methods.pervertex.warp import (
    ALL_AROUND,
    WIDEST,
    bounds_of,
    frame_of,
    narrowed,
    near_normal,
    near_plane_of,
    texels_of,
)
from anamorph.optics.ray_meshes import BodyRays
from anamorph.projection import MapFrame, Projection, far_projection, map_projection
from anamorph.raymesh import RayMesh, RayStatus

MARGIN = 0.04
"""By how much of its extent a map is wider on each side than what the vertex rays need."""

SPARE = 1.1
"""How much further than at its corners rays are listed for on a triangle."""


@dataclass(frozen=True, eq=False)
class SurfacePlan:
    """One patch's maps for one frame.

    Parameters
    ----------
    projections : tuple of Projection
        Of converging rays first the region beyond their crossing, then the one before it.
    texels : (width, height) float
        The size of each map at one texel for each pixel that it fills.
    ranges : (F, 3) float64
        Of each triangle: so far from their starts, and from here to there, its rays' ways are listed; metres.
    first, unseen : (F + 1,), (N,) int32
        Triangle f's list is unseen[first[f]:first[f + 1]]: the triangles of the scene, from 1, that may stand there.
    farthest : float
        No ray of the scene is longer, metres.
    """

    projections: tuple[Projection, ...]
    texels: tuple[float, float]
    ranges: np.ndarray
    first: np.ndarray
    unseen: np.ndarray
    farthest: float


def plan_surfaces(
    body_rays: BodyRays,
    faces: np.ndarray,
    size: tuple[int, int],
    surroundings: Surroundings,
    options: Options,
    corners: np.ndarray,
    own: np.ndarray,
) -> SurfacePlan | None:
    """Plan the maps of a patch; None where no map can show it.

    Parameters
    ----------
    body_rays : BodyRays
    faces : (F,) int
        The patch, by the numbers of its faces in the ray mesh.
    size : (width, height)
        Of the image, pixels.
    surroundings : Surroundings
    options : Options
    corners : (T, 3, 3) float32
        The triangles of the scene.
    own : (T,) bool
        Which of them are the body's.
    """
    shown = visible_rays(body_rays.rays, faces, size)
    rays, local = shown.rays, shown.rays.faces
    if not len(local):
        return None
    outward = shown.blended(body_rays.side.outward)
    facing = rays.status == RayStatus.OK
    directions = rays.unit_directions()
    if not facing.any():
        return None
    weights = pixel_weights(rays, facing)
    if np.linalg.norm(weights @ directions[facing]) < ALL_AROUND:
        return None
    weights = narrowed(weights, directions[facing])
    viewpoint, frame = frame_of(rays.origins[facing], directions[facing], weights, options.align)
    normal = near_normal(weights, outward[facing], directions[facing], frame)
    mounting = surroundings.mountings[body_rays.side]
    near_plane = near_plane_of(normal, rays.origins[facing], shown.least(mounting.beneath)[facing], viewpoint, frame)

    farthest = surroundings.diagonal + size_of(rays.origins)
    nearest = np.maximum(crossings(rays.origins, directions, near_plane), 0.0)
    begins = frame.project(rays.origins + nearest[:, None] * directions)
    ends = frame.project(rays.origins + farthest * directions)
    converges = frame.convergence < 0.0
    usable = facing & (begins[:, 2] > 0.0) & ((ends[:, 2] < 0.0) if converges else (ends[:, 2] > 0.0))
    places = [each[:, :2] / np.where(usable, each[:, 2], 1.0)[:, None] for each in (begins, ends)]
    for place in places:
        usable &= np.abs(frame.convergence * place - frame.slope).max(axis=1) < WIDEST
    if not usable.any():
        return None
    bounds = bounds_of(np.concatenate([place[usable] for place in places]))
    bounds = bounds + MARGIN * np.ptp(bounds, axis=0) * np.array([[-1.0], [1.0]])
    projections = [map_projection(frame, bounds, near_plane, surroundings.corners)]
    if converges:
        projections.insert(0, far_projection(frame, bounds))
    texcoords = (places[1] - bounds[0]) / np.ptp(bounds, axis=0)
    texels, _ = texels_of(rays, texcoords, usable, np.ptp(bounds, axis=0))

    gap = _gaps(rays, directions, frame, bounds, nearest, farthest) if converges else np.zeros((len(rays.origins), 2))
    reach = np.where(usable, nearest, np.inf)
    # What is cut away of a triangle is not seen, and needs no list.
    ranges = np.zeros((len(faces), 3))
    ranges[:, 1] = farthest
    np.maximum.at(ranges[:, 0], shown.parent, SPARE * reach[local].max(axis=1))
    np.minimum.at(ranges[:, 1], shown.parent, gap[local, 0].min(axis=1) / SPARE)
    np.maximum.at(ranges[:, 2], shown.parent, SPARE * gap[local, 1].max(axis=1))
    whole = body_rays.rays.faces[faces]
    all_directions = body_rays.rays.unit_directions()[whole]
    first, unseen, listed_faces = listed(
        *parts_of(body_rays.rays.origins[whole], all_directions, ranges), corners, ~own
    )
    ranges[~listed_faces] = -1.0, 0.0, farthest if converges else 0.0
    # Of a triangle with a corner whose ray no map shows, nothing is listed.
    ranges[np.isinf(ranges[:, 0]), 0] = -1.0
    return SurfacePlan(tuple(projections), texels, ranges, first, unseen, farthest)


def _gaps(
    rays: RayMesh,
    directions: np.ndarray,
    frame: MapFrame,
    bounds: np.ndarray,
    nearest: np.ndarray,
    farthest: float,
) -> np.ndarray:
    """From where to where, (V, 2), neither map of converging rays sees a vertex's ray: around their crossing."""
    origin = frame.project(rays.origins)
    change = frame.project(rays.origins + directions) - origin
    heights, slopes = [], []
    for axis in range(2):
        for bound, sign in zip(bounds[:, axis], (1.0, -1.0), strict=True):
            heights.append(sign * (origin[:, axis] - bound * origin[:, 2]))
            slopes.append(sign * (change[:, axis] - bound * change[:, 2]))
    heights, slopes = [*heights, origin[:, 2]], [*slopes, change[:, 2]]
    height, slope = np.stack(heights), np.stack(slopes)
    roots = np.where(slope < 0.0, -height / np.where(slope < 0.0, slope, -1.0), np.nan)
    # All five are positive where the near map sees the ray, and all negative where the far one does.
    leaves, enters = np.nanmin(roots, axis=0, initial=farthest), np.nanmax(roots, axis=0, initial=0.0)
    return np.column_stack([np.clip(leaves, nearest, farthest), np.clip(enters, nearest, farthest)])
