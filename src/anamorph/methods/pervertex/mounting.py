"""How a body is mounted in its scene: what stands behind it, and whether it has a frame.

Maps are seen from behind a mirror. What stands between them and the mirror must not hide what the mirror shows.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from anamorph.optics.ray_meshes import Side
from anamorph.optics.reflection import Reflector
from anamorph.rays.caster import Caster
from anamorph.scene.connected import welded

CLOSED = 0.9
"""The share of a closed surface behind which its own other side is."""

MOSTLY = 0.4
"""The share of a border beside which something stands where there is a frame."""

BESIDE = 0.1
"""How far from a surface's border, in its sizes, a frame stands."""


@dataclass(frozen=True, eq=False)
class Mounting:
    """What is around one side of a body.

    Parameters
    ----------
    behind : (V,) float64
        How far behind each vertex something else of the scene stands; infinite for nothing, 0 where the body has a
        frame.
    beneath : (V,) float64
        As `behind`, whether or not the body has a frame.
    closed : bool
        Whether the surface is closed, so that no map sees anything behind it.
    """

    behind: np.ndarray
    beneath: np.ndarray
    closed: bool


def mounting_of(side: Side, caster: Caster, face_object: np.ndarray) -> Mounting:
    """How a side is mounted in the scene that `caster` casts at; `face_object` (F,) has the object of each triangle.

    A lens counts as framed.
    """
    optics = side.optics
    if not isinstance(optics, Reflector):
        nothing = np.zeros(len(optics.positions))
        return Mounting(nothing, nothing, False)
    beneath, closed = what_is_behind(caster, face_object, optics.positions, optics.normals, side.objects)
    framed = _framed(caster, face_object, optics, side.objects)
    behind = np.zeros_like(beneath) if framed else beneath
    return Mounting(behind, beneath, closed)


def what_is_behind(
    caster: Caster, face_object: np.ndarray, points: np.ndarray, outward: np.ndarray, own: tuple[int, ...]
) -> tuple[np.ndarray, bool]:
    """How far behind a surface, at `points` (N, 3) with normals `outward`, something else stands, (N,).

    `own` are the numbers of its own objects; infinite where one of them comes first, or nothing. Also whether one
    of them comes first almost everywhere, because the surface is closed.
    """
    hits = caster.cast(points, -outward, 1e-4 * size_of(points))
    foreign = (hits.triangle >= 0) & ~np.isin(face_object[hits.triangle], own)
    closed = ((hits.triangle >= 0) & ~foreign).mean() > CLOSED
    return np.where(foreign & (not closed), hits.distance, np.inf), bool(closed)


def _framed(caster: Caster, face_object: np.ndarray, optics: Reflector, own: tuple[int, ...]) -> bool:
    """Whether something else stands close beside most of the border of a surface, as a frame does."""
    points, border = optics.positions, _border_vertices(optics)
    if not len(border):
        return False
    reach, outward = size_of(points), optics.normals[border]
    away = points[border] - points.mean(axis=0)
    away -= np.einsum("ni,ni->n", away, outward)[:, None] * outward
    away /= np.maximum(np.linalg.norm(away, axis=1, keepdims=True), 1e-12)
    # A little downward: a frame may be flush.
    hits = caster.cast(points[border] + 1e-3 * reach * outward, away - 0.3 * outward)
    foreign = (hits.triangle >= 0) & ~np.isin(face_object[hits.triangle], own)
    return bool((foreign & (hits.distance < BESIDE * reach)).mean() > MOSTLY)


def _border_vertices(optics: Reflector) -> np.ndarray:
    """The vertices, (B,), on edges that one triangle alone has."""
    place = welded(optics.positions)[optics.faces]
    edges = np.sort(np.concatenate([place[:, pair] for pair in ([0, 1], [1, 2], [2, 0])]), axis=1)
    _, kind, uses = np.unique(edges, axis=0, return_inverse=True, return_counts=True)
    vertices = np.concatenate([optics.faces[:, pair] for pair in ([0, 1], [1, 2], [2, 0])])
    return np.unique(vertices[uses[kind.ravel()] == 1])


def size_of(points: np.ndarray) -> float:
    """The diagonal of the box around points."""
    return float(np.linalg.norm(np.ptp(points, axis=0)))
