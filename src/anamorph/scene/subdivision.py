"""Finer triangles where the exact surface is known: each is cut in four, and every new vertex lies on the surface."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from anamorph.base.errors import AnamorphError
from anamorph.scene.model import Mesh

MOST_LEVELS = 8

DECIMALS = 9
"""New positions are rounded to a nanometre, so that neighbours get the same along a border that they share."""


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
        The old vertices first, as they were, and the new ones in the order of `cut_ends`; the parts of each triangle
        in its place. New positions and normals are
        those of the exact surface, the normals on the side of the old ones; texture coordinates and colours are means.
    """
    if mesh.surface is None or mesh.parameters is None:
        raise AnamorphError(f"part '{mesh.name}': has no exact surface to be subdivided on; give a finer mesh")
    ends, number = cut_ends(mesh.faces, cut)
    middles = np.zeros(cut.shape, np.int64)
    middles[cut] = len(mesh.positions) + number
    parameters = mesh.surface.between(mesh.parameters[ends], mesh.positions[ends])
    normals = mesh.surface.normals_toward(parameters, mesh.normals[ends].sum(axis=1))

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


def cut_ends(faces: np.ndarray, cut: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The ends, (E, 2), of the edges of `faces` (F, 3) that are `cut` (F, 3), and each cut's number among them."""
    sides = np.sort(np.stack([faces, np.roll(faces, -1, axis=1)], axis=-1)[cut].astype(np.int64), axis=1)
    keys, number = np.unique(sides[:, 0] << 32 | sides[:, 1], return_inverse=True)
    return np.stack([keys >> 32, keys & 0xFFFFFFFF], axis=-1), number


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
