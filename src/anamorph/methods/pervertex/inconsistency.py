"""Occlusion inconsistency: where what a map shows is not what the rays meet, because something hides it from there.

Source: Kakimoto et al. 2007, section 6 and Figure 16, which shows it and leaves it open. Here it is found at vertices;
fragments that do not show what their rays meet are tinted by inconsistency.wgsl.
"""

from __future__ import annotations

import numpy as np

from anamorph.methods.pervertex.cube_plan import FORWARD
from anamorph.methods.pervertex.seen import Seen
from anamorph.methods.pervertex.surroundings import Surroundings
from anamorph.methods.pervertex.warp import MapPlan
from anamorph.projection import Projection
from anamorph.raymesh import RayStatus

NEARER = 1e-3
"""By what part of the way to a vertex's hit the map must see something nearer."""


def map_lines(plan: MapPlan, lookups: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The lines through the map's viewpoint that its places see along.

    Parameters
    ----------
    plan : MapPlan
    lookups : (N, 4) float64
        (s q, t q, q, valid); of a cube map directions from its viewpoint, and valid.

    Returns
    -------
    starts, lines : (N, 3) float64
        Where they enter the map, and unit vectors along them.
    """
    if plan.cube:
        return _cube_lines(plan, lookups[:, :3])
    # Of converging rays the last projection is the one before their crossing: there the lines enter.
    return _lines(plan.projections[-1], (2.0 * lookups[:, :2] / lookups[:, 2:3] - 1.0) * [1.0, -1.0])


def _cube_lines(plan: MapPlan, directions: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    origins = np.tile(plan.viewpoint[:3], (len(directions), 1))
    lines = directions / np.linalg.norm(directions, axis=1, keepdims=True)
    face = (directions @ FORWARD.T).argmax(axis=1)
    for number, projection in zip(plan.cube, plan.projections, strict=True):
        clip = directions[face == number] @ projection.clip[:, :3].T
        origins[face == number], lines[face == number] = _lines(projection, clip[:, :2] / clip[:, 3:])
    return origins, lines


def _lines(projection: Projection, places: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Starts on the near plane, and unit vectors, of the lines through places (N, 2) from -1 to 1, y up."""
    near = np.column_stack([places, np.ones((len(places), 2))]) @ np.linalg.inv(projection.clip).T
    lines = projection.base + places @ np.stack([projection.right, projection.up])
    return near[:, :3] / near[:, 3:], lines / np.linalg.norm(lines, axis=1, keepdims=True)


def shown_distances(
    origins: np.ndarray, lines: np.ndarray, meshes: tuple[int, ...], surroundings: Surroundings
) -> np.ndarray:
    """How far along its lines a map sees, (N,), infinite for the sky; it does not see the `meshes` of its own body."""
    distances, _ = surroundings.cast_past(origins, lines, np.zeros(len(origins)), tuple(mesh + 1 for mesh in meshes))
    return distances


def inconsistent_vertices(seen: Seen, surroundings: Surroundings) -> np.ndarray:
    """Which vertices of a body do not show what their rays meet, (V,) bool: a map sees something nearer there."""
    rays = seen.body_rays.rays
    inconsistent = np.zeros(len(rays.origins), bool)
    for plan in seen.plans:
        known = (plan.lookups[0, :, 3] > 0.0) & (rays.status[plan.vertices] == RayStatus.OK)
        origins, lines = map_lines(plan, plan.lookups[0, known])
        shown = shown_distances(origins, lines, seen.body_rays.body.meshes, surroundings)
        met = np.einsum("ij,ij->i", plan.hits[known] - origins, lines)
        sky = ~np.isfinite(plan.distances[known])
        inconsistent[plan.vertices[known]] |= np.where(sky, np.isfinite(shown), shown < (1.0 - NEARER) * met)
    return inconsistent
