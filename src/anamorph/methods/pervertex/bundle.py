"""A patch's bundle of rays: how much of the image each counts for, and what it hits.

Source: Kakimoto et al. 2007, sections 3.1 and 3.2.
"""

from __future__ import annotations

import numpy as np

from anamorph.methods.pervertex.mounting import size_of
from anamorph.methods.pervertex.surroundings import Surroundings
from anamorph.raymesh import RayMesh, RayStatus
from anamorph.rays.caster import beyond

FARTHEST = 1e4
"""How far away the sky is, in diagonals of the scene."""

MAXIMUM_LAYERS = 8
"""How many surfaces of a mirror's rim a ray may pass through."""


def part_of(rays: RayMesh, vertices: np.ndarray, faces: np.ndarray) -> RayMesh:
    """Some of a ray mesh's vertices, and the `faces` between them."""
    image, origins, directions, status = (
        values[vertices] for values in (rays.image, rays.origins, rays.directions, rays.status)
    )
    return RayMesh(image, origins, directions, faces, status)


def pixel_weights(rays: RayMesh, facing: np.ndarray) -> np.ndarray:
    """The share of the mirror's image around each vertex that faces the eye: all that is seen counts alike."""
    places = rays.places()
    faces = rays.faces[(facing & (rays.image[:, 2] > 0.0))[rays.faces].all(axis=1)]
    areas = np.bincount(faces.ravel(), np.repeat(areas_of(places[faces]), 3), len(facing))[facing]
    return areas / areas.sum() if areas.sum() > 0.0 else np.full(len(areas), 1.0 / len(areas))


def find_hits(
    rays: RayMesh, nearest: np.ndarray, own: tuple[int, ...], surroundings: Surroundings
) -> tuple[np.ndarray, np.ndarray]:
    """Step 3.1: what rays hit beyond `nearest` (V,), but for the objects `own`, (V, 3); and how far that is, (V,)."""
    directions = rays.unit_directions()
    # No one sees what catches the rays that miss the far face of a lens: it must not be what frames the lens.
    lost = np.isin(rays.status, (RayStatus.LEFT_BY_EDGE, RayStatus.TOTAL_REFLECTION))
    start = nearest + np.where(lost, size_of(rays.origins), 0.0)
    distances, _ = surroundings.cast_past(rays.origins, directions, start, own)
    return rays.origins + np.minimum(distances, FARTHEST * surroundings.diagonal)[:, None] * directions, distances


def past_frame(
    rays: RayMesh,
    directions: np.ndarray,
    occluder: np.ndarray,
    facing: np.ndarray,
    normal: np.ndarray,
    surroundings: Surroundings,
) -> tuple[np.ndarray, float]:
    """How far along each ray what frames the mirror is passed, (V,), and how high along `normal` that reaches.

    A rim over the mirror's border hides vertices from the eye. It must not hide the scene from them as well: no one
    sees where their rays meet the rim, but all that is interpolated towards it would be wrong. A frame reaches back to
    the mirror; what stands free before it is seen in it.
    """
    start, top = beyond(rays.origins, directions), -np.inf
    if not occluder.any():
        return start, top
    size = size_of(rays.origins)
    reaches = (surroundings.mesh_corners @ normal).min(axis=1) < float((rays.origins @ normal).max())
    hidden = (occluder > 0) & reaches[np.maximum(occluder, 1) - 1] & facing
    for _ in range(MAXIMUM_LAYERS if hidden.any() else 0):
        hits = surroundings.caster.cast(rays.origins, directions, start)
        framed = hidden & (hits.distance < size) & (surroundings.face_object[hits.triangle] == occluder)
        if not framed.any():
            break
        start = np.where(framed, beyond(rays.origins, directions, hits.distance), start)
        top = max(top, float(((rays.origins + start[:, None] * directions) @ normal)[framed].max()))
    return start, top


def crossings(origins: np.ndarray, directions: np.ndarray, plane: np.ndarray) -> np.ndarray:
    """How far each ray goes before it crosses a plane that it starts behind; 0 for one that runs along it."""
    rise = directions @ plane[:3]
    behind = -(origins @ plane[:3] + plane[3])
    return np.where(rise > 1e-3, behind / np.maximum(rise, 1e-3), 0.0)


def areas_of(corners: np.ndarray) -> np.ndarray:
    """Areas of plane triangles (F, 3, 2)."""
    a, b = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    return np.abs(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]) / 2.0
