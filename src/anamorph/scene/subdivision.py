"""Finer triangles where the exact surface is known: each is cut in four, and every new vertex lies on the surface."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from anamorph.base.errors import AnamorphError
from anamorph.scene.model import Mesh
from anamorph.surfaces.nurbs import NurbsSurface
from anamorph.surfaces.shapes import BezierPatch, Sphere, Surface

MOST_LEVELS = 8

DECIMALS = 9
"""New positions are rounded to a nanometre, so that neighbours get the same along a border that they share."""

POLE = 1e-6
"""A parameter moves nothing where the surface moves by less than this share of its size over all of its range."""


def subdivided(mesh: Mesh, levels: int) -> Mesh:
    """A mesh with each triangle cut in four, `levels` times, and all new vertices on its exact surface.

    On a trimmed face the border stays a line of straight pieces in (u, v).

    Parameters
    ----------
    mesh : Mesh
        With its surface and parameters. Where these jump, as at the back of a sphere, it does no harm.
    levels : int
        From 0 to 8.

    Returns
    -------
    Mesh
        As from `split`. The four parts of triangle i are 4 i to 4 i + 3, the middle one last.
    """
    if not 0 <= levels <= MOST_LEVELS:
        raise AnamorphError(f"part '{mesh.name}': levels is {levels}; give a whole number from 0 to {MOST_LEVELS}")
    for _ in range(levels):
        mesh = split(mesh, np.ones((len(mesh.faces), 3), bool))
    return mesh


def split(mesh: Mesh, cut: np.ndarray) -> Mesh:
    """A mesh with some edges halved, and the triangles at them cut in two, three or four.

    A new vertex depends on the ends of its edge alone. So there are no cracks, neither inside the mesh nor along a
    border whose vertices another mesh has too, as long as all triangles at one edge agree whether it is cut.

    Parameters
    ----------
    mesh : Mesh
        With its surface and parameters.
    cut : (F, 3) bool
        Of each triangle, the edges from its first corner to its second, on to its third, and back.

    Returns
    -------
    Mesh
        The old vertices first, as they were; the parts of each triangle in its place. New positions and normals are
        those of the exact surface, the normals on the side of the old ones; texture coordinates and colours are means.
    """
    if mesh.surface is None or mesh.parameters is None:
        raise AnamorphError(f"part '{mesh.name}': has no exact surface to be subdivided on; give a finer mesh")
    sides = np.sort(np.stack([mesh.faces, np.roll(mesh.faces, -1, axis=1)], axis=-1)[cut].astype(np.int64), axis=1)
    keys, number = np.unique(sides[:, 0] << 32 | sides[:, 1], return_inverse=True)
    ends = np.stack([keys >> 32, keys & 0xFFFFFFFF], axis=-1)
    middles = np.zeros(cut.shape, np.int64)
    middles[cut] = len(mesh.positions) + number
    parameters = between(mesh.surface, mesh.parameters[ends], mesh.positions[ends])
    normals = turned_normals(mesh.surface, parameters, mesh.normals[ends].sum(axis=1))

    def mean(old: np.ndarray | None) -> np.ndarray | None:
        return None if old is None else _with(old, np.mean(old[ends], axis=1))

    return replace(
        mesh,
        positions=_with(mesh.positions, np.round(mesh.surface.position(parameters), DECIMALS)),
        normals=_with(mesh.normals, normals),
        parameters=_with(mesh.parameters, parameters),
        texcoords=mean(mesh.texcoords),
        colors=mean(mesh.colors),
        faces=_parts(mesh.faces, cut, middles).astype(np.int32),
    )


def _with(old: np.ndarray, new: np.ndarray) -> np.ndarray:
    return np.concatenate([old, new]).astype(old.dtype)


def _parts(faces: np.ndarray, cut: np.ndarray, middles: np.ndarray) -> np.ndarray:
    """Triangles for each of `faces` (F, 3), whose edges have vertices `middles` (F, 3) where they are `cut` (F, 3)."""
    count = cut.sum(axis=1)
    # Turned so that the first edge is cut, and the last is not if another is.
    start = np.where(count == 2, (~cut).argmax(axis=1) + 1, cut.argmax(axis=1))
    turn = (start[:, None] + np.arange(3)) % 3
    a, b, c = np.take_along_axis(faces, turn, axis=1).T
    ab, bc, ca = np.take_along_axis(middles, turn, axis=1).T
    patterns = (
        [(a, b, c)],
        [(a, ab, c), (ab, b, c)],
        [(a, ab, bc), (a, bc, c), (ab, b, bc)],
        [(a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)],
    )
    found, owner = [], []
    for number, pattern in enumerate(patterns):
        own = np.flatnonzero(count == number)
        found.append(np.stack([np.stack(part, axis=-1)[own] for part in pattern], axis=1).reshape(-1, 3))
        owner.append(np.repeat(own, len(pattern)))
    return np.concatenate(found)[np.argsort(np.concatenate(owner), kind="stable")]


def turned_normals(surface: Surface, parameters: np.ndarray, side: np.ndarray) -> np.ndarray:
    """The exact normals, (N, 3) float64, at parameters (N, 2), on the side to which vectors (N, 3) point."""
    normals = surface.normal(parameters)
    return np.where(np.sum(normals * side, axis=1, keepdims=True) < 0.0, -normals, normals)


def between(surface: Surface, parameters: np.ndarray, positions: np.ndarray) -> np.ndarray:
    """Parameters, (N, 2) float64, of a point of the surface in the middle of K others each.

    Parameters
    ----------
    surface : Surface
    parameters : (N, K, 2) array
        Of the K points. They may lie on both sides of a seam, and on a pole one of the two may be anything.
    positions : (N, K, 3) array
        The K points, metres.
    """
    match surface:
        case Sphere():
            middle = np.mean(np.asarray(positions, float), axis=1)
            if (np.linalg.norm(middle - surface.center, axis=1) < 1e-3 * surface.radius).any():
                raise AnamorphError("sphere: an edge of its mesh goes through its centre; give it more triangles")
            return surface.parameters(middle)
        case BezierPatch() | NurbsSurface():
            return _between_on_patch(surface, np.asarray(parameters, float))
    return np.mean(np.asarray(parameters, float), axis=1)


def _between_on_patch(surface: BezierPatch | NurbsSurface, uv: np.ndarray) -> np.ndarray:
    if isinstance(surface, NurbsSurface):
        (low, high), extent = surface.domain, surface.extent
    else:
        low, high, extent = np.zeros(2), np.ones(2), float(np.ptp(np.reshape(surface.control, (-1, 3)), axis=0).max())
    size = high - low

    # At a pole, where a parameter has no meaning, the other points' value counts.
    weight = np.ones(uv.shape)
    border = ((uv <= low) | (uv >= high)).any(axis=-1)
    for axis, orders in enumerate(((1, 0), (0, 1))):
        moves = np.linalg.norm(surface.derivative(uv[border], *orders), axis=1) * size[axis]
        weight[border, axis] = moves > POLE * extent
    weight[:] = np.where(weight.any(axis=1, keepdims=True), weight, 1.0)

    closed = _closed(surface, low, high, extent)
    first = np.take_along_axis(uv, weight.argmax(axis=1)[:, None], axis=1)
    uv = uv - np.where(closed, size * np.round((uv - first) / size), 0.0)
    middle = np.sum(weight * uv, axis=1) / np.sum(weight, axis=1)
    return np.where(middle < low, middle + size, np.where(middle > high, middle - size, middle))


def _closed(surface: BezierPatch | NurbsSurface, low: np.ndarray, high: np.ndarray, extent: float) -> np.ndarray:
    """Whether the surface ends where it starts along u and along v, (2,) bool."""
    starts = low + np.linspace(0.0, 1.0, 7)[:, None] * (high - low)
    found = np.zeros(2, bool)
    for axis in range(2):
        ends = np.stack([starts, starts])
        ends[:, :, axis] = np.stack([low, high])[:, axis : axis + 1]
        found[axis] = np.abs(surface.position(ends[0]) - surface.position(ends[1])).max() <= POLE * extent
    return found
