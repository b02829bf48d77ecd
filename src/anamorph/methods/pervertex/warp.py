"""Where a map is seen from, and which place of it each vertex shows: steps 1 to 3 of per-vertex reflection.

Source: Kakimoto, Tatsukawa, Chun, Nishita, "Real-time reflection and refraction on a per-vertex basis" (2007),
sections 3.1 to 3.4, 4.2 and 4.3; the steps keep that paper's numbers. The near region of converging rays, which it
leaves out, after Vallance, "Trilinear projection" (2005), appendix G.

Deviations. The texture coordinates are projective, (s q, t q, q), which makes a flat mirror exact where plain (s, t)
bends its image. The near clipping plane lies along the mirror and not across the view, and vertex rays start at it,
so that the map and the rays see the same scene. Rays count by the pixels around their vertices. The view volume holds
only the places where hit points project.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from anamorph.methods.pervertex.bundle import areas_of, crossings, find_hits, part_of, past_frame, pixel_weights
from anamorph.methods.pervertex.mounting import size_of
from anamorph.methods.pervertex.options import Options
from anamorph.methods.pervertex.surroundings import Surroundings
from anamorph.optics.ray_meshes import BodyRays
from anamorph.optics.viewpoint import virtual_viewpoint
from anamorph.projection import MapFrame, Projection, far_projection, map_frame, map_projection
from anamorph.raymesh import RayMesh, RayStatus
from anamorph.scene.camera import Eye

WIDEST = 4.0
"""Tangent of the half angle that a map may cover; vertices beyond it have no place in the map."""

NARROWINGS = 4
"""How often the rays that a map cannot hold are left out of its mean direction."""

ALL_AROUND = 1e-6
"""Unit directions go to all sides alike if their mean is shorter than this: vertices are not placed better."""

EDGE_MARGIN = 1.0
"""By how much of the fan of converging rays a hit near their crossing may lie outside it."""

CLEARANCE = 1e-4
"""Between the near plane and the vertices, in sizes of the patch."""

TEXELS_A_PIXEL = 6.0
"""Of a map for each pixel that shows it: what is seen most obliquely must do with less."""

ROUND = 1.02
"""How much longer than wide a bundle of rays must be for the map to be turned along it."""


@dataclass(frozen=True, eq=False)
class MapPlan:
    """One patch's map for one frame: steps 1 to 3 of the paper.

    Parameters
    ----------
    projections : tuple of Projection
        The map's view volume (3.3), or those of a cube map's faces. Of converging rays first the region beyond their
        crossing, then the one before it.
    viewpoint : (4,) float64
        The virtual viewpoint (3.2), homogeneous; lines of body_rays leave it in the first of the projections.
    vertices : (V,) int
        The patch's vertices in its ray mesh.
    lookups : (C, V, 4) float64
        (s q, t q, q, valid) of each vertex (3.4), for light of one colour or of green, red and blue; valid is 0 where
        the map has no place for it.
    texels : tuple of (width, height) float
        The size of each projection's map at one texel for each pixel that it fills.
    hits : (V, 3) float64
        Where the vertex rays meet the scene (step 3.1).
    distances : (V,) float64
        How far that is from the vertex; infinite for the sky.
    used : float
        The share of the map that the patch looks up.
    cube : tuple of int
        The numbers of the cube map's faces that the projections are; none where they are no cube map. Then the lookups
        are directions from the viewpoint.
    """

    projections: tuple[Projection, ...]
    viewpoint: np.ndarray
    vertices: np.ndarray
    lookups: np.ndarray
    texels: tuple[tuple[float, float], ...]
    hits: np.ndarray
    distances: np.ndarray
    used: float
    cube: tuple[int, ...] = ()

    def reversed(self, number: int) -> bool:
        """Whether projection `number` shows what lies before converging rays meet, towards the viewpoint."""
        return number > 0 and not self.cube

    def eye(self, number: int, size: tuple[int, int]) -> Eye:
        """The map's own eye in projection `number`, for a map of `size`: what it sees in other mirrors."""
        width, height = size
        x, y, _, w = self.projections[number].clip
        matrix = np.stack([width / 2.0 * (x + w), height / 2.0 * (w - y), w])
        return Eye(-self.viewpoint if self.reversed(number) else self.viewpoint, matrix, size)


def plan_map(
    body_rays: BodyRays, faces: np.ndarray, occluder: np.ndarray, surroundings: Surroundings, options: Options
) -> MapPlan | None:
    """Find a patch's virtual viewpoint, view volume and texture coordinates; None where no map can show it.

    Parameters
    ----------
    body_rays : BodyRays
        A body's rays (step 1).
    faces : (F,) int
        The patch, by the numbers of its faces in the ray mesh.
    occluder : (V,) int
        The object that hides each vertex of the ray mesh from the eye, or 0.
    surroundings : Surroundings
        What the rays may hit.
    options : Options

    Returns
    -------
    MapPlan or None
        None where only the body's back is seen, and where its rays go to all sides alike.
    """
    vertices, corners = np.unique(body_rays.rays.faces[faces], return_inverse=True)
    corners = corners.reshape(-1, 3)
    bundles = [part_of(rays, vertices, corners) for rays in (body_rays.rays, *body_rays.others)]
    rays, occluder, outward = bundles[0], occluder[vertices], body_rays.side.outward[vertices]
    facing = rays.status == RayStatus.OK
    if not facing.any():
        return None
    directions = rays.unit_directions()
    weights = pixel_weights(rays, facing)
    if np.linalg.norm(weights @ directions[facing]) < ALL_AROUND:
        return None
    weights = narrowed(weights, directions[facing])
    viewpoint, frame = frame_of(rays.origins[facing], directions[facing], weights, options.align)
    normal = near_normal(weights, outward[facing], directions[facing], frame)
    own, mounting = body_rays.side.objects, surroundings.mountings[body_rays.side]
    past, top = past_frame(
        rays, directions, np.where(np.isin(occluder, own), 0, occluder), facing, normal, surroundings
    )
    from_inside = mounting.closed and frame.convergence > 0.0
    if from_inside and surroundings.sees(viewpoint[:3] / viewpoint[3], rays.origins[facing], own):
        # Nothing is behind the surface of a closed body: the map sees all from its viewpoint on.
        normal = frame.axes[2]
        height = float(viewpoint[:3] @ normal / viewpoint[3])
        near_plane = np.append(normal, -height - 1e2 * CLEARANCE * size_of(rays.origins))
    else:
        near_plane = near_plane_of(normal, rays.origins[facing], mounting.behind[vertices][facing], viewpoint, frame)
    if np.isfinite(top):
        foremost = (rays.origins[facing] @ normal).max()
        near_plane[3] = -max(foremost, top) - CLEARANCE * size_of(rays.origins[facing])

    # Steps 3.1 to 3.3: where the lines from the viewpoint to the hits cross the projection plane.
    found = [_looked_up(each, frame, facing, near_plane, past, own, surroundings) for each in bundles]
    hits, distances, places, inside = (np.stack(parts) for parts in zip(*found, strict=True))
    if not (inside & facing).any():
        return None
    # What is seen of a triangle may reach up to its vertices that are not.
    seen = inside & (facing | (_beside(facing, corners) & (rays.status != RayStatus.TOTAL_REFLECTION)))
    bounds = bounds_of(places[seen])
    valid = inside & (places >= bounds[0]).all(axis=2) & (places <= bounds[1]).all(axis=2)

    # Step 3.4. The row of the map counts downward.
    texcoords = (places - bounds[0]) / np.ptp(bounds, axis=0)
    texcoords[..., 1] = 1.0 - texcoords[..., 1]
    # q is the depth of a ray as long as the eye's distance. On a flat mirror that is the vertex's own depth in the
    # virtual camera; on a curved one it follows the rays between vertices about three times closer than that depth.
    weight = rays.directions @ frame.axes[2]
    if not options.projective or weight[valid[0]].min(initial=np.inf) <= 0.0:
        weight = np.ones(len(weight))
    lookups = np.concatenate(
        [texcoords * weight[:, None], np.broadcast_to(weight, valid.shape)[..., None], valid[..., None]], axis=2
    )
    lookups[~valid, :2], lookups[~valid, 2] = 0.5, 1.0
    projections = [map_projection(frame, bounds, near_plane, surroundings.corners)]
    if frame.convergence < 0.0:
        projections.insert(0, far_projection(frame, bounds))
        if not np.delete(surroundings.visible(projections[1].clip), body_rays.side.meshes).any():
            projections.pop()
    texels, used = texels_of(rays, texcoords[0], valid[0] & facing, np.ptp(bounds, axis=0))
    sizes = (texels,) * len(projections)
    return MapPlan(tuple(projections), viewpoint, vertices, lookups, sizes, hits[0], distances[0], used)


def _beside(chosen: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """The vertices of faces of which some vertex is `chosen`, (V,) bool."""
    beside = np.zeros(len(chosen), bool)
    beside[faces[chosen[faces].any(axis=1)]] = True
    return beside


def _looked_up(
    rays: RayMesh,
    frame: MapFrame,
    facing: np.ndarray,
    near_plane: np.ndarray,
    past: np.ndarray,
    own: tuple[int, ...],
    surroundings: Surroundings,
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Hits (V, 3) and their distances (V,), their places in the image plane (V, 2), and which of these are usable."""
    directions = rays.unit_directions()
    nearest = np.maximum(crossings(rays.origins, directions, near_plane), past)
    hits, distances = find_hits(rays, nearest, own, surroundings)
    projected = frame.project(hits)
    crossed = projected[:, 2] < 0.0 if frame.convergence < 0.0 else np.zeros(len(hits), bool)
    usable = (projected[:, 2] > 0.0) | crossed
    places = projected[:, :2] / np.where(usable, projected[:, 2], 1.0)[:, None]
    if frame.convergence < 0.0:
        # Near their crossing the rays' own scatter is larger than the fan: a hit there says nothing of the place.
        fan = frame.vanishing(directions)
        low, high = fan[facing].min(axis=0), fan[facing].max(axis=0)
        margin = EDGE_MARGIN * (high - low).max()
        places = np.clip(np.where(usable[:, None], places, fan), low - margin, high + margin)
        usable = directions @ frame.axes[2] > 0.0
    usable &= np.abs(frame.convergence * places - frame.slope).max(axis=1) < WIDEST
    return hits, distances, places, usable


def narrowed(weights: np.ndarray, directions: np.ndarray) -> np.ndarray:
    """The weights without the rays that no map around the others' mean direction can hold."""
    narrowed = weights
    for _ in range(NARROWINGS):
        forward = narrowed @ directions
        length = np.linalg.norm(forward)
        held = directions @ forward > length / np.hypot(1.0, WIDEST)
        if length < ALL_AROUND or held.all() or not (weights * held).any():
            break
        narrowed = weights * held / (weights @ held)
    return narrowed


def frame_of(
    origins: np.ndarray, directions: np.ndarray, weights: np.ndarray, align: bool
) -> tuple[np.ndarray, MapFrame]:
    """Step 2: the virtual viewpoint (3.2), and an image plane across the mean direction, before the mirror (3.3)."""
    forward = weights @ directions
    forward /= np.linalg.norm(forward)
    up = np.array([0.0, 1.0, 0.0]) if abs(forward[1]) < 0.99 else np.array([0.0, 0.0, 1.0])
    right = np.cross(forward, up)
    right /= np.linalg.norm(right)
    axes = np.stack([right, np.cross(right, forward), forward])
    if align:
        axes = aligned(axes, directions, weights)
    middle = origins.mean(axis=0)
    radius = float(np.linalg.norm(origins - middle, axis=1).max()) or 1.0
    viewpoint = virtual_viewpoint(origins, directions, weights)
    # The image plane stands clear of the viewpoint; all planes across one direction give the same image.
    ahead = viewpoint[:3] @ forward - viewpoint[3] * (middle @ forward)
    side = -1.0 if 0.0 < ahead < 2.0 * radius * viewpoint[3] else 1.0
    return viewpoint, map_frame(viewpoint, middle + side * radius * forward, axes)


def aligned(axes: np.ndarray, directions: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """The axes turned by up to 45 degrees, to the principal directions of the rays' slopes (4.3).

    They stay where that does not make the rectangle around the slopes smaller.
    """
    across, along = directions @ axes[:2].T, directions @ axes[2]
    ahead = along > 1e-3
    slopes = across[ahead] / along[ahead, None]
    shares = weights[ahead] / (weights[ahead].sum() or 1.0)
    slopes = slopes - shares @ slopes
    values, vectors = np.linalg.eigh((shares[:, None] * slopes).T @ slopes)
    if values[1] <= ROUND**2 * values[0]:
        return axes
    angle = np.arctan2(vectors[1, 1], vectors[0, 1])
    # Half a quarter turn, of a square on its corner, is one way on every processor.
    angle -= 0.5 * np.pi * np.rint(angle / (0.5 * np.pi) - 5e-10)
    cosine, sine = np.cos(angle), np.sin(angle)
    counted = slopes[shares > 0.0]
    turned = counted @ np.array([[cosine, -sine], [sine, cosine]])
    if np.ptp(turned, axis=0).prod() >= np.ptp(counted, axis=0).prod():
        return axes
    return np.stack([cosine * axes[0] + sine * axes[1], cosine * axes[1] - sine * axes[0], axes[2]])


def near_normal(weights: np.ndarray, normals: np.ndarray, directions: np.ndarray, frame: MapFrame) -> np.ndarray:
    """Where the near plane faces: as the mirror does, or across the view where the mirror bends rays behind itself."""
    normal = weights @ normals
    ahead = (directions[weights > 0.0] @ normal).min() > 0.0
    return normal / np.linalg.norm(normal) if ahead else frame.axes[2]


def near_plane_of(
    normal: np.ndarray, origins: np.ndarray, behind: np.ndarray, viewpoint: np.ndarray, frame: MapFrame
) -> np.ndarray:
    """The plane along the mirror, (4,), that hides what stands behind it, and little of what stands before it.

    At most it lies just before the foremost vertex. `behind` says how far behind each vertex something stands.
    """
    heights = origins @ normal
    clearance = CLEARANCE * size_of(origins)
    # Half the way to what stands behind: between the vertices it may be nearer.
    level = max(float(heights.min()) - clearance, float((heights - 0.5 * behind).max()))
    if frame.convergence != 0.0:
        # Lines of body_rays leave the viewpoint before they cross the plane, or end there after it.
        limit = float(viewpoint[:3] @ normal / viewpoint[3]) + 1e2 * clearance * np.sign(frame.convergence)
        level = max(level, limit) if frame.convergence > 0.0 else min(level, limit)
    return np.append(normal, -min(level, float(heights.max()) + clearance))


def bounds_of(places: np.ndarray) -> np.ndarray:
    """The rectangle around places in the image plane, (2, 2), a little larger, and never empty."""
    low, high = places.min(axis=0), places.max(axis=0)
    margin = 0.01 * np.maximum(high - low, 1e-3 * (high - low).max() or 1e-6)
    return np.stack([low - margin, high + margin])


def texels_of(
    rays: RayMesh, texcoords: np.ndarray, valid: np.ndarray, extent: np.ndarray
) -> tuple[tuple[float, float], float]:
    """The map's size at which nine tenths of the image have a texel for each pixel, and the share that is used."""
    faces = rays.faces[(valid & (rays.image[:, 2] > 0.0))[rays.faces].all(axis=1)]
    if not len(faces):
        return (64.0, 64.0), 0.0
    places = rays.places()
    pixels, shares = areas_of(places[faces]), areas_of(texcoords[faces])
    density = pixels / np.maximum(shares, 1e-12)
    order = np.argsort(density)
    covered = np.cumsum(pixels[order])
    texels = min(density[order][np.searchsorted(covered, 0.9 * covered[-1])], TEXELS_A_PIXEL * covered[-1])
    aspect = np.clip(extent[0] / extent[1], 0.1, 10.0)
    return (float(np.sqrt(texels * aspect)), float(np.sqrt(texels / aspect))), float(shares.sum())
