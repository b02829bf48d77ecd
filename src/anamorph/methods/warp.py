"""Where a mirror's map is seen from, and which place of it each vertex shows: steps 1 to 3 of per-vertex reflection.

Source: Kakimoto, Tatsukawa, Chun, Nishita, "Real-time reflection and refraction on a per-vertex basis" (2007),
sections 3.1 to 3.4; the steps keep that paper's numbers.

Deviations. The texture coordinates are projective, (s q, t q, q), which makes a flat mirror exact where plain (s, t)
bends its picture. The near clipping plane lies along the mirror and not across the view, and vertex rays start at it,
so that the map and the rays see the same scene. Rays count by the pixels around their vertices. The view volume holds
only the places where hit points project.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from anamorph.optics.reflection import Reflector
from anamorph.optics.viewpoint import virtual_viewpoint
from anamorph.projection import MapFrame, Projection, map_frame, map_projection
from anamorph.raymesh import RayMesh, RayStatus
from anamorph.rays import Caster
from anamorph.scene.geometry import Geometry

WIDEST = 4.0
"""Tangent of the half angle that a map may cover; vertices beyond it have no place in the map."""

NARROWINGS = 4
"""How often the rays that a map cannot hold are left out of its mean direction."""

FARTHEST = 1e4
"""How far away the sky is, in diagonals of the scene."""

MAXIMUM_LAYERS = 8
"""How many surfaces of a mirror's rim a ray may pass through."""


@dataclass(frozen=True, eq=False)
class MapPlan:
    """One reflector's map for one frame: steps 1 to 3 of the paper.

    Parameters
    ----------
    projection : Projection
        The map's view volume (3.3).
    lookups : (V, 4) float64
        (s q, t q, q, valid) of each vertex (3.4); valid is 0 where the map has no place for it.
    texels : (width, height) float
        The map's size at one texel for each pixel that it fills.
    hits : (V, 3) float64
        Where the vertex rays meet the scene (step 3.1).
    distances : (V,) float64
        How far that is from the vertex; infinite for the sky.
    """

    projection: Projection
    lookups: np.ndarray
    texels: tuple[float, float]
    hits: np.ndarray
    distances: np.ndarray


@dataclass(frozen=True, eq=False)
class World:
    """What vertex rays may hit.

    Parameters
    ----------
    caster : Caster
    face_object : (F,) uint32
        The object of each triangle that it casts at.
    corners : (8, 3) float64
        Corners of a box around the scene.
    """

    caster: Caster
    face_object: np.ndarray
    corners: np.ndarray


def world_of(geometry: Geometry) -> World:
    """The world of a scene's geometry."""
    low, high = geometry.positions.min(axis=0), geometry.positions.max(axis=0)
    corners = np.stack(np.meshgrid(*np.stack([low, high], axis=1)), axis=-1).reshape(-1, 3).astype(float)
    return World(Caster(geometry), geometry.face_object, corners)


def plan_map(
    mirror: Reflector, rays: RayMesh, eye: np.ndarray, world: World, projective: bool = True, strict: bool = False
) -> MapPlan | None:
    """Find a mirror's virtual viewpoint, view volume and texture coordinates; None where no map can show it.

    Parameters
    ----------
    mirror : Reflector
    rays : RayMesh
        Its reflected rays (step 1).
    eye : (3,) float64
    world : World
        What the rays may hit.
    projective : bool
    strict : bool
        Whether the map must show all that the mirror does: then it shows what frames the mirror, and a vertex whose
        ray meets something before the near plane has no place in it.

    Returns
    -------
    MapPlan or None
        None where only the mirror's back is seen, and where its rays go to all sides alike.
    """
    facing = rays.status == RayStatus.OK
    if not facing.any():
        return None
    directions = rays.unit_directions()
    weights = _narrowed(_pixel_weights(rays, facing), directions[facing])
    if np.linalg.norm(weights @ directions[facing]) < 1e-9:
        return None
    frame = _map_frame(rays.origins[facing], directions[facing], weights)
    normal = _near_normal(weights, mirror.normals[facing], directions[facing], frame)
    hider = _hiders(rays.origins, eye, world)
    near_plane, rim_plane = _near_planes(normal, rays.origins[facing], directions[facing], hider[facing], world)
    start = np.maximum(_crossings(rays.origins, directions, rim_plane), world.caster.near)
    distances = world.caster.cast(rays.origins, directions, start).distance
    sky = FARTHEST * float(np.linalg.norm(np.ptp(world.corners, axis=0)))
    hits = rays.origins + np.minimum(distances, sky)[:, None] * directions

    # Step 3.2 and 3.3: where the lines from the viewpoint to the hits cross the projection plane.
    projected = frame.project(hits)
    ahead = projected[:, 2] > 0.0
    places = projected[:, :2] / np.where(ahead, projected[:, 2], 1.0)[:, None]
    inside = ahead & (np.abs(frame.convergence * places - frame.slope).max(axis=1) < WIDEST)
    if strict:
        first = world.caster.cast(rays.origins, directions, world.caster.near).distance
        inside &= (hider > 0) | (first >= _crossings(rays.origins, directions, near_plane))
    if not (inside & facing).any():
        return None
    bounds = _bounds(places[inside & facing])
    valid = inside & (places >= bounds[0]).all(axis=1) & (places <= bounds[1]).all(axis=1)

    # Step 3.4. The row of the map counts downward.
    texcoords = (places - bounds[0]) / np.ptp(bounds, axis=0)
    texcoords[:, 1] = 1.0 - texcoords[:, 1]
    # q is the depth of a ray as long as the eye's distance. On a flat mirror that is the vertex's own depth in the
    # virtual camera; on a curved one it follows the rays between vertices about three times closer than that depth.
    weight = rays.directions @ frame.axes[2]
    if not projective or weight[valid].min() <= 0.0:
        weight = np.ones(len(weight))
    lookups = np.column_stack([texcoords * weight[:, None], weight, valid])
    lookups[~valid, :2], lookups[~valid, 2] = 0.5, 1.0
    return MapPlan(
        projection=map_projection(frame, bounds, near_plane if strict else rim_plane, world.corners),
        lookups=lookups,
        texels=_texels(rays, texcoords, valid & facing, np.ptp(bounds, axis=0)),
        hits=hits,
        distances=distances,
    )


def _pixel_weights(rays: RayMesh, facing: np.ndarray) -> np.ndarray:
    """The share of the mirror's picture around each vertex that faces the eye: all that is seen counts alike."""
    places = rays.picture[:, :2] / np.where(rays.picture[:, 2:] > 0.0, rays.picture[:, 2:], 1.0)
    faces = rays.faces[(facing & (rays.picture[:, 2] > 0.0))[rays.faces].all(axis=1)]
    areas = np.bincount(faces.ravel(), np.repeat(_areas(places[faces]), 3), len(facing))[facing]
    return areas / areas.sum() if areas.sum() > 0.0 else np.full(len(areas), 1.0 / len(areas))


def _narrowed(weights: np.ndarray, directions: np.ndarray) -> np.ndarray:
    """The weights without the rays that no map around the others' mean direction can hold."""
    narrowed = weights
    for _ in range(NARROWINGS):
        forward = narrowed @ directions
        held = directions @ forward > np.linalg.norm(forward) / np.hypot(1.0, WIDEST)
        if held.all() or not (weights * held).any():
            break
        narrowed = weights * held / (weights @ held)
    return narrowed


def _map_frame(origins: np.ndarray, directions: np.ndarray, weights: np.ndarray) -> MapFrame:
    """Step 2: the virtual viewpoint (3.2), and an image plane across the mean direction, before the mirror (3.3)."""
    forward = weights @ directions
    forward /= np.linalg.norm(forward)
    up = np.array([0.0, 1.0, 0.0]) if abs(forward[1]) < 0.99 else np.array([0.0, 0.0, 1.0])
    right = np.cross(forward, up)
    right /= np.linalg.norm(right)
    axes = np.stack([right, np.cross(right, forward), forward])
    middle = origins.mean(axis=0)
    radius = float(np.linalg.norm(origins - middle, axis=1).max()) or 1.0
    viewpoint = virtual_viewpoint(origins, directions, weights)
    if forward @ (viewpoint[3] * middle - viewpoint[:3]) <= 0.0:
        # Converging rays, of a concave mirror, meet before it: see the scene from the mirror itself instead.
        viewpoint = np.append(middle, 1.0)
    return map_frame(viewpoint, middle + radius * forward, axes)


def _near_normal(weights: np.ndarray, normals: np.ndarray, directions: np.ndarray, frame: MapFrame) -> np.ndarray:
    """Where the near plane faces: as the mirror does, or across the view where the mirror bends rays behind itself."""
    normal = weights @ normals
    ahead = (directions[weights > 0.0] @ normal).min() > 0.0
    return normal / np.linalg.norm(normal) if ahead else frame.axes[2]


def _hiders(origins: np.ndarray, eye: np.ndarray, world: World) -> np.ndarray:
    """The object that hides each vertex from the eye, (V,); 0 for none."""
    sight = world.caster.cast(np.broadcast_to(eye, origins.shape), origins - eye)
    hidden = (sight.triangle >= 0) & (sight.distance < 1.0 - 1e-4)
    return np.where(hidden, world.face_object[sight.triangle], 0)


def _near_planes(
    normal: np.ndarray, origins: np.ndarray, directions: np.ndarray, hider: np.ndarray, world: World
) -> tuple[np.ndarray, np.ndarray]:
    """The planes along the mirror just before its foremost vertex, and just before what frames it, (4,) each.

    A rim over the mirror's border hides vertices from the eye. It must not hide the scene from them as well: no one
    sees where their rays meet the rim, but all that is interpolated towards it would be wrong.
    """
    diagonal = float(np.linalg.norm(np.ptp(origins, axis=0)))
    foremost = top = float((origins @ normal).max())

    caster = world.caster
    start = np.full(len(origins), caster.near)
    for _ in range(MAXIMUM_LAYERS):
        hits = caster.cast(origins, directions, start)
        framed = (hider > 0) & (hits.distance < diagonal) & (world.face_object[hits.triangle] == hider)
        if not framed.any():
            break
        start = np.where(framed, hits.distance + caster.near, start)
        top = max(top, float(((origins + start[:, None] * directions) @ normal)[framed].max()))
    clearance = 1e-4 * diagonal
    return np.append(normal, -(foremost + clearance)), np.append(normal, -(top + clearance))


def _crossings(origins: np.ndarray, directions: np.ndarray, plane: np.ndarray) -> np.ndarray:
    """How far each ray goes before it crosses a plane that it starts behind; 0 for one that runs along it."""
    rise = directions @ plane[:3]
    behind = -(origins @ plane[:3] + plane[3])
    return np.where(rise > 1e-3, behind / np.maximum(rise, 1e-3), 0.0)


def _bounds(places: np.ndarray) -> np.ndarray:
    """The rectangle around places in the image plane, (2, 2), a little larger, and never empty."""
    low, high = places.min(axis=0), places.max(axis=0)
    margin = 0.01 * np.maximum(high - low, 1e-3 * (high - low).max() or 1e-6)
    return np.stack([low - margin, high + margin])


def _texels(rays: RayMesh, texcoords: np.ndarray, valid: np.ndarray, extent: np.ndarray) -> tuple[float, float]:
    """The map's size at which nine tenths of the mirror's picture have a texel for each pixel."""
    faces = rays.faces[(valid & (rays.picture[:, 2] > 0.0))[rays.faces].all(axis=1)]
    if not len(faces):
        return (64.0, 64.0)
    pixels = _areas((rays.picture[:, :2] / rays.picture[:, 2:])[faces])
    density = pixels / np.maximum(_areas(texcoords[faces]), 1e-12)
    order = np.argsort(density)
    covered = np.cumsum(pixels[order])
    texels = density[order][np.searchsorted(covered, 0.9 * covered[-1])]
    aspect = np.clip(extent[0] / extent[1], 0.1, 10.0)
    return float(np.sqrt(texels * aspect)), float(np.sqrt(texels / aspect))


def _areas(corners: np.ndarray) -> np.ndarray:
    """Areas of plane triangles (F, 3, 2)."""
    a, b = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    return np.abs(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]) / 2.0
