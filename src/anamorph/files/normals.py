"""Normals of triangle meshes: for models that bring none, and for vertices whose normal is no direction."""

from __future__ import annotations

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from anamorph.scene.triangles import doubled_areas, turned_over

CREASE = 40.0
"""Edges bent by more than this, in degrees, stay sharp."""


def corner_angles(positions: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """The angle at each corner, (F, 3) float64, radians."""
    corners = np.asarray(positions, float)[faces]
    one = np.roll(corners, -1, axis=1) - corners
    other = np.roll(corners, 1, axis=1) - corners
    across = np.linalg.norm(np.cross(one, other), axis=2)
    return np.arctan2(across, np.sum(one * other, axis=2))


def smooth_normals(positions: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Vertex normals, (V, 3) float64: the faces' unit normals weighted by their angle at the vertex.

    The weights are those of Thürmer and Wüthrich, "Computing vertex normals from polygonal facets" (1998).
    A vertex without a face of any area gets a zero normal.
    """
    faces = np.asarray(faces)
    normals = np.zeros((len(positions), 3))
    area = doubled_areas(positions, faces)
    unit = area / np.maximum(np.linalg.norm(area, axis=1, keepdims=True), np.finfo(float).tiny)
    np.add.at(normals, faces, corner_angles(positions, faces)[..., None] * unit[:, None])
    length = np.linalg.norm(normals, axis=1, keepdims=True)
    return np.divide(normals, length, out=np.zeros_like(normals), where=length > 1e-6)


def repaired(normals: np.ndarray, positions: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Unit normals, (V, 3) float64: where one has no direction, that of the faces around the vertex.

    Every vertex must have a face with an area; where its faces cancel each other out, one of them decides.
    """
    lengths = np.linalg.norm(normals, axis=1)
    broken = ~(np.isfinite(lengths) & (lengths > 0))
    if broken.any():
        around = smooth_normals(positions, faces)
        one_face = np.zeros_like(around)
        one_face[faces] = doubled_areas(positions, faces)[:, None]
        around = np.where(around.any(axis=1, keepdims=True), around, one_face)
        normals = np.where(broken[:, None], around, normals)
        lengths = np.linalg.norm(normals, axis=1)
    return normals / lengths[:, None]


def with_winding(normals: np.ndarray, positions: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Normals (V, 3), negated if most of the area is wound against them: the winding says which side is outside."""
    areas = np.linalg.norm(doubled_areas(positions, faces), axis=1)
    turned = turned_over(positions, faces, normals)
    return -normals if areas[turned].sum() > areas[~turned].sum() else normals


def creased(positions: np.ndarray, faces: np.ndarray, crease: float = CREASE) -> tuple[np.ndarray, ...]:
    """Split vertices along sharp edges, and give normals that are smooth everywhere else.

    Vertices at one place count as one, so that triangle soup and texture seams come out smooth. Linear in the
    number of triangles, however many meet at a vertex. Every triangle must have an area.

    Parameters
    ----------
    positions : (V, 3) array
    faces : (F, 3) int array
    crease : float
        Degrees.

    Returns
    -------
    source : (W,) int64
        The vertex that each new vertex is a copy of.
    faces : (F, 3) int64
        Into the new vertices.
    normals : (W, 3) float64
    """
    faces = np.asarray(faces)
    place = _places(np.asarray(positions))[faces]
    group = _smooth_corners(place, doubled_areas(positions, faces), crease)
    _, first = np.unique(group, return_index=True)
    points, triangles = np.asarray(positions, float)[faces.reshape(-1)][first], group.reshape(-1, 3)
    grouped = repaired(smooth_normals(points, triangles), points, triangles)
    # As one number each: rows take ten times as long to sort.
    key, copies = np.unique(faces.reshape(-1).astype(np.int64) * len(first) + group, return_inverse=True)
    source, own = np.divmod(key, len(first))
    return source, copies.reshape(-1, 3), grouped[own]


def _places(positions: np.ndarray) -> np.ndarray:
    """A number for each vertex, (V,) int64, that all at one place share."""
    order = np.lexsort(positions.T)
    ordered = positions[order]
    place = np.zeros(len(positions), np.int64)
    place[order[1:]] = np.cumsum((ordered[1:] != ordered[:-1]).any(axis=1))
    return place


def _smooth_corners(place: np.ndarray, area: np.ndarray, crease: float) -> np.ndarray:
    """Number the corners, (3 F,), so that those at one place joined by a chain of smooth edges share a number."""
    start, end = np.arange(place.size), np.roll(np.arange(place.size).reshape(-1, 3), -1, axis=1).reshape(-1)
    flat = place.reshape(-1)
    low, high = np.minimum(flat[start], flat[end]), np.maximum(flat[start], flat[end])
    edge = low.astype(np.int64) * (flat.max(initial=0) + 1) + high
    order = np.argsort(edge, kind="stable")
    one, other = order[:-1], order[1:]
    unit = area / np.maximum(np.linalg.norm(area, axis=1, keepdims=True), np.finfo(float).tiny)
    same_edge = edge[one] == edge[other]
    straight = np.sum(unit[one // 3] * unit[other // 3], axis=1) >= np.cos(np.radians(crease)) - 1e-9
    one, other = one[same_edge & straight], other[same_edge & straight]
    # The two triangles may run along their common edge either way; corners are joined where they are.
    along = flat[start[one]] == flat[start[other]]
    links_from = np.concatenate([start[one], end[one]])
    links_to = np.concatenate([np.where(along, start[other], end[other]), np.where(along, end[other], start[other])])
    graph = coo_array((np.ones(len(links_from)), (links_from, links_to)), shape=(place.size, place.size))
    return connected_components(graph, directed=False)[1]
