"""A cube map at a body's virtual viewpoint: one plan for a body whose rays no single view volume can hold.

Source: the viewpoint after Kakimoto et al. 2007, section 3.2; cube maps after Greene, "Environment mapping and other
applications of world projections" (1986). Deviations: vertices look up the direction from the viewpoint to what their
rays hit, not the rays' own direction; of each face only the part that is looked up is drawn.
"""

from __future__ import annotations

import numpy as np

from anamorph.methods.pervertex.bundle import areas_of, crossings, find_hits, part_of, past_frame, pixel_weights
from anamorph.methods.pervertex.mounting import size_of
from anamorph.methods.pervertex.options import Options
from anamorph.methods.pervertex.surroundings import Surroundings
from anamorph.methods.pervertex.warp import CLEARANCE, TEXELS_A_PIXEL, MapPlan
from anamorph.optics.ray_meshes import BodyRays
from anamorph.optics.viewpoint import virtual_viewpoint
from anamorph.projection import Projection, pinhole_projection
from anamorph.raymesh import RayMesh, RayStatus

FORWARD = np.array([[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]], float)
"""The way each face looks, in the shaders' order."""

UP = np.roll(np.abs(FORWARD), 1, axis=1)
RIGHT = np.cross(FORWARD, UP)

OVERLAP = 1.0 / 64.0
"""By how much of their half width faces reach beyond their borders, so that texels blend without a seam there."""

MARGIN = 0.03
"""By how much what is drawn of a face reaches beyond what the vertices look up, in tangents."""

FARTHEST_VIEWPOINT = 4.0
"""How far from the body its viewpoint may lie, in the body's sizes: beyond, its lines converge nowhere."""

NEAREST = 1e-3
"""Of the near planes, in sizes of the body."""


def plan_cube(
    body_rays: BodyRays, faces: np.ndarray, occluder: np.ndarray, surroundings: Surroundings, options: Options
) -> MapPlan | None:
    """Find a body's virtual viewpoint, the parts of a cube map around it that are looked up, and the lookups.

    Parameters are those of `plan_map`.

    Returns
    -------
    MapPlan or None
        None where only the body's back is seen, and where its rays do not spread from a point behind it.
    """
    vertices, corners = np.unique(body_rays.rays.faces[faces], return_inverse=True)
    corners = corners.reshape(-1, 3)
    bundles = [part_of(rays, vertices, corners) for rays in (body_rays.rays, *body_rays.others)]
    rays, occluder, outward = bundles[0], occluder[vertices], body_rays.side.outward[vertices]
    facing = rays.status == RayStatus.OK
    viewpoint = cube_viewpoint(rays, facing) if facing.any() else None
    if viewpoint is None:
        return None
    directions = rays.unit_directions()
    behind = surroundings.mountings[body_rays.side].behind[vertices]
    near = _near(rays, outward, behind, facing, viewpoint, corners)
    past, _ = past_frame(
        rays, directions, occluder, facing, pixel_weights(rays, facing) @ outward[facing], surroundings
    )

    own = body_rays.side.objects
    lookups, found = [], []
    for each in bundles:
        directions = each.unit_directions()
        crossing = _near_crossings(each.origins, directions, viewpoint, near)
        hits, distances = find_hits(each, np.maximum(crossing, past), own, surroundings)
        valid = each.status != RayStatus.TOTAL_REFLECTION
        # As long as the ray to the eye: on a flat mirror that is the vertex's own offset from the viewpoint.
        towards = hits - viewpoint
        towards /= np.maximum(np.linalg.norm(towards, axis=1, keepdims=True), 1e-12)
        length = np.linalg.norm(rays.directions, axis=1) if options.projective else np.ones(len(rays.directions))
        lookups.append(np.column_stack([length[:, None] * towards, valid]))
        found.append((hits, distances))
    shown = [len(vertices) * number + corners[each[corners, 3].all(axis=1)] for number, each in enumerate(lookups)]
    needed, bounds = _needed(np.concatenate(lookups)[:, :3], np.concatenate(shown))
    if not len(needed):
        return None
    projections = tuple(
        _projection(face, each, viewpoint, near[face]) for face, each in zip(needed, bounds, strict=True)
    )
    extents = np.ptp(bounds, axis=1)
    density, used = _density(rays, lookups[0], facing, extents)
    texels = tuple((float(width), float(height)) for width, height in extents * density)
    return MapPlan(
        projections, np.append(viewpoint, 1.0), vertices, np.stack(lookups), texels, *found[0], used, tuple(needed)
    )


def cube_viewpoint(rays: RayMesh, facing: np.ndarray) -> np.ndarray | None:
    """The least-squares point of the rays that face the eye, (3,); None where it is not behind them, and near."""
    origins, directions = rays.origins[facing], rays.unit_directions()[facing]
    weights = pixel_weights(rays, facing)
    homogeneous = virtual_viewpoint(origins, directions, weights)
    middle = weights @ origins
    reach = FARTHEST_VIEWPOINT * size_of(origins)
    if np.linalg.norm(homogeneous[:3] - homogeneous[3] * middle) > reach * homogeneous[3]:
        return None
    viewpoint = homogeneous[:3] / homogeneous[3]
    ahead = np.einsum("i,ij,ij->", weights, origins - viewpoint, directions)
    return viewpoint if ahead > 0.0 else None


def _near(
    rays: RayMesh,
    outward: np.ndarray,
    behind: np.ndarray,
    facing: np.ndarray,
    viewpoint: np.ndarray,
    corners: np.ndarray,
) -> np.ndarray:
    """How far from the viewpoint each face begins to see, (6,): at the body's nearest vertex whose rays it shows.

    What is in the body and behind it must not hide what is before it. `behind` says how far behind each vertex
    something else stands.
    """
    size = size_of(rays.origins[facing])
    depths = (rays.origins - viewpoint) @ FORWARD.T
    # Half the way to what stands behind: between the vertices it may be nearer.
    upward = np.where(np.isfinite(behind)[:, None], np.maximum(outward @ FORWARD.T, 0.0), 0.0)
    clear = np.where(upward > 0.5, depths - 0.5 * np.where(np.isfinite(behind), behind, 0.0)[:, None] * upward, -np.inf)
    met = _met(rays.unit_directions(), corners) & facing
    near = np.full(6, NEAREST * size)
    for face in range(6):
        shown = met[face]
        if shown.any():
            level = max(depths[shown, face].min() - CLEARANCE * size, clear[shown, face].max())
            near[face] = max(min(level, depths[shown, face].max() + CLEARANCE * size), near[face])
    return near


def _near_crossings(origins: np.ndarray, directions: np.ndarray, viewpoint: np.ndarray, near: np.ndarray) -> np.ndarray:
    """How far each ray goes before it crosses the near plane of the face that it looks at, (N,)."""
    face = (directions @ FORWARD.T).argmax(axis=1)
    lengths = np.zeros(len(origins))
    for number in range(6):
        there = face == number
        plane = np.append(FORWARD[number], -(FORWARD[number] @ viewpoint + near[number]))
        lengths[there] = np.maximum(crossings(origins[there], directions[there], plane), 0.0)
    return lengths


def _met(directions: np.ndarray, corners: np.ndarray) -> np.ndarray:
    """Which vertices have triangles that may reach each face of a cube, (6, V) bool.

    Out of reach is a triangle of which all corners lie on the other side of one of the planes through a face's borders.

    Parameters
    ----------
    directions : (V, 3) float64
    corners : (F, 3) int
    """
    met = np.zeros((6, len(directions)), bool)
    for face in range(6):
        ahead = (1.0 + OVERLAP + 0.5 * MARGIN) * FORWARD[face, face // 2] * directions[:, face // 2]
        side, other = np.delete(directions, face // 2, axis=1).T
        inner = np.zeros(len(directions), np.uint8)
        for bit, way in enumerate((side, -side, other, -other)):
            inner |= (ahead + way >= 0.0).astype(np.uint8) << bit
        reaching = (inner[corners[:, 0]] | inner[corners[:, 1]] | inner[corners[:, 2]]) == 0b1111
        met[face, corners[reaching]] = True
    return met


def _needed(directions: np.ndarray, corners: np.ndarray) -> tuple[list[int], np.ndarray]:
    """The faces that triangles of directions reach, N of them, and which part of each, (N, 2, 2) tangents."""
    met = _met(directions, corners)
    needed = np.flatnonzero(met.any(axis=1)).tolist()
    bounds = np.empty((len(needed), 2, 2))
    bounds[:, 0], bounds[:, 1] = -1.0 - OVERLAP, 1.0 + OVERLAP
    for face, (low, high) in zip(needed, bounds, strict=True):
        reaching = directions[met[face]]
        ahead = reaching @ FORWARD[face]
        # A triangle that reaches behind the face may cross all of it.
        if (ahead > 0.1 * np.linalg.norm(reaching, axis=1)).all():
            places = np.column_stack([reaching @ RIGHT[face], reaching @ UP[face]]) / ahead[:, None]
            low[:], high[:] = (
                np.maximum(low, places.min(axis=0) - MARGIN),
                np.minimum(high, places.max(axis=0) + MARGIN),
            )
    return needed, bounds


def _projection(face: int, bounds: np.ndarray, viewpoint: np.ndarray, near: float) -> Projection:
    """The pinhole that sees the rectangle `bounds` (tangents) of a cube's face."""
    center, half = bounds.mean(axis=0), np.ptp(bounds, axis=0) / 2.0
    base = FORWARD[face] + center[0] * RIGHT[face] + center[1] * UP[face]
    return pinhole_projection(viewpoint, base, half[0] * RIGHT[face], half[1] * UP[face], near)


def _density(rays: RayMesh, lookups: np.ndarray, facing: np.ndarray, extents: np.ndarray) -> tuple[float, float]:
    """Texels for each unit of tangent at which nine tenths of the image have one a pixel; the share that is used."""
    faces = rays.faces[(facing & (lookups[:, 3] > 0.0) & (rays.image[:, 2] > 0.0))[rays.faces].all(axis=1)]
    if not len(faces):
        return 32.0, 0.0
    places = rays.places()
    units = lookups[:, :3] / np.maximum(np.linalg.norm(lookups[:, :3], axis=1, keepdims=True), 1e-12)
    corners = units[faces]
    middles = corners.sum(axis=1)
    middles /= np.maximum(np.linalg.norm(middles, axis=1, keepdims=True), 1e-12)
    # A face is finer towards its corners, by the cube of the distance from the viewpoint.
    shares = np.abs(np.linalg.det(corners)) / 2.0 / np.abs(middles).max(axis=1) ** 3
    pixels = areas_of(places[faces])
    density = pixels / np.maximum(shares, 1e-12)
    order = np.argsort(density)
    covered = np.cumsum(pixels[order])
    upward = float(extents.prod(axis=1).sum())
    texels = min(density[order][np.searchsorted(covered, 0.9 * covered[-1])], TEXELS_A_PIXEL * covered[-1] / upward)
    return float(np.sqrt(texels)), float(shares.sum() / upward)
