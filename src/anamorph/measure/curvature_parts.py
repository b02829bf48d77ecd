"""Mirrors parted by how they curve: convex, concave, saddle-shaped and flat parts.

Estalella et al. 2005, section 6.2, have reflectors parted by hand, and name this as future work. Nothing in this
package builds on the parts, because a point may be seen several times in one of them.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from anamorph.scene.model import Mesh

FLAT_TURN = 1e-4
"""Radians by which a part turns along the whole mirror, at most, where it counts as flat."""


class Form(IntEnum):
    """How a mirror curves, seen from its front."""

    FLAT = 0
    CONVEX = 1
    CONCAVE = 2
    SADDLE = 3


@dataclass(frozen=True, eq=False)
class CurvatureParts:
    """The parts of a mirror.

    Parameters
    ----------
    form : (F,) int64
        A `Form` of each triangle: CONVEX and CONCAVE where it curves one way, even if only along one direction.
    part : (F,) int64
        The part of each triangle, from 0: triangles of one form that hang together by edges.
    """

    form: np.ndarray
    part: np.ndarray


def curvature_parts(mesh: Mesh) -> CurvatureParts:
    """Part a mirror by the signs of its principal curvatures in the middle of each triangle.

    They are those of its exact surface, or of a plain mesh those of the interpolated normals.
    """
    curvatures = _exact(mesh) if mesh.surface is not None and mesh.parameters is not None else _interpolated(mesh)
    corners = np.asarray(mesh.positions, float)[mesh.faces]
    least = FLAT_TURN / max(float(np.ptp(corners.reshape(-1, 3), axis=0).max()), np.finfo(float).tiny)
    bends = (curvatures > least).any(axis=1), (curvatures < -least).any(axis=1)
    form = np.select([bends[0] & bends[1], *bends], [Form.SADDLE, Form.CONVEX, Form.CONCAVE], Form.FLAT)
    return CurvatureParts(form, _joined(corners, form))


def _exact(mesh: Mesh) -> np.ndarray:
    """Principal curvatures (F, 2) toward the front."""
    assert mesh.surface is not None and mesh.parameters is not None
    corners = np.asarray(mesh.positions, float)[mesh.faces]
    middles = mesh.surface.between(mesh.parameters[mesh.faces], corners)
    front = np.asarray(mesh.normals, float)[mesh.faces].sum(axis=1)
    side = np.sign(np.einsum("fi,fi->f", mesh.surface.normal(middles), front))
    return side[:, None] * mesh.surface.curvatures(middles)


def _interpolated(mesh: Mesh) -> np.ndarray:
    """Principal curvatures (F, 2) of a plain mesh: how normals change along each triangle."""
    a, b, c = np.moveaxis(np.asarray(mesh.positions, float)[mesh.faces], 1, 0)
    n = np.asarray(mesh.normals, float)[mesh.faces]
    area = np.cross(b - a, c - a)
    first = (b - a) / np.linalg.norm(b - a, axis=1, keepdims=True)
    second = np.cross(area, first)
    second /= np.maximum(np.linalg.norm(second, axis=1, keepdims=True), np.finfo(float).tiny)
    axes = np.stack([first, second], axis=1)
    # Columns are edges and changes of the normal, in the triangle's plane.
    edges = np.stack([axes @ (b - a)[..., None], axes @ (c - a)[..., None]], axis=-1)[:, :, 0]
    turns = np.stack([axes @ (n[:, 1] - n[:, 0])[..., None], axes @ (n[:, 2] - n[:, 0])[..., None]], axis=-1)[:, :, 0]
    shape = turns @ np.linalg.pinv(edges)
    return np.linalg.eigvalsh(0.5 * (shape + shape.swapaxes(1, 2)))


def _joined(corners: np.ndarray, form: np.ndarray) -> np.ndarray:
    """Numbers of parts (F,) of triangles (F, 3, 3) that share an edge and a form."""
    size = float(np.ptp(corners.reshape(-1, 3), axis=0).max())
    places = np.round((corners.reshape(-1, 3) - corners.reshape(-1, 3).min(axis=0)) / max(1e-7 * size, 1e-300))
    _, vertices = np.unique(places, axis=0, return_inverse=True)
    faces = vertices.reshape(-1, 3)
    edges = np.sort(np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]]), axis=1)
    owner = np.tile(np.arange(len(faces)), 3)
    order = np.lexsort(edges.T)
    same = (edges[order][1:] == edges[order][:-1]).all(axis=1)
    one, other = owner[order][:-1][same], owner[order][1:][same]
    alike = form[one] == form[other]
    one, other = one[alike], other[alike]
    graph = coo_array((np.ones(len(one)), (one, other)), shape=(len(faces), len(faces)))
    return connected_components(graph, directed=False)[1].astype(np.int64)
