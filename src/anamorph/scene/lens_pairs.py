"""Which meshes of a scene are the two faces of one lens."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import KDTree

from anamorph.scene.model import Glass, Mesh, Scene
from anamorph.scene.triangles import doubled_areas


@dataclass(frozen=True)
class LensPair:
    """A lens among the meshes of a scene.

    Parameters
    ----------
    name : str
        What its meshes' names have in common, before the last "/".
    front, back : int
        Indices of the two faces of glass.
    edge : int, optional
        Index of the diffuse band between them; None where there is none.
    """

    name: str
    front: int
    back: int
    edge: int | None


@dataclass(frozen=True)
class SceneGlass:
    """Every mesh of glass in a scene, each in one of two places.

    Parameters
    ----------
    lenses : tuple of LensPair
        In the order of their fronts.
    others : tuple of int
        Indices of the meshes that are no face of a lens.
    """

    lenses: tuple[LensPair, ...]
    others: tuple[int, ...]


def scene_glass(scene: Scene) -> SceneGlass:
    """The glass of a scene, with its lenses found as `lens_pairs` does."""
    lenses = lens_pairs(scene.meshes)
    faces = {number for lens in lenses for number in (lens.front, lens.back)}
    others = (i for i, mesh in enumerate(scene.meshes) if isinstance(mesh.material, Glass) and i not in faces)
    return SceneGlass(lenses, tuple(others))


def lens_pairs(meshes: Sequence[Mesh]) -> tuple[LensPair, ...]:
    """Find the lenses among meshes, by the names that `lens_between` gives.

    NAME/front and NAME/back are a lens if both are of glass of the same index and Abbe number, both carry an exact
    surface, and the triangles of each have one border, a closed line. A name that several meshes share is no lens.
    """
    named = defaultdict(list)
    for number, mesh in enumerate(meshes):
        named[mesh.name].append(number)

    def alone(name: str) -> int | None:
        found = named.get(name, [])
        return found[0] if len(found) == 1 else None

    lenses = []
    for mesh in meshes:
        name, slash, side = mesh.name.rpartition("/")
        front, back, edge = (alone(f"{name}/{part}") for part in ("front", "back", "edge"))
        if slash + side != "/front" or front is None or back is None or not _faces_of_one(mesh, meshes[back]):
            continue
        diffuse = edge is not None and not meshes[edge].specular
        lenses.append(LensPair(name, front, back, edge if diffuse else None))
    return tuple(lenses)


def _faces_of_one(front: Mesh, back: Mesh) -> bool:
    glass, other = front.material, back.material
    if not isinstance(glass, Glass) or not isinstance(other, Glass):
        return False
    same = (glass.index, glass.abbe) == (other.index, other.abbe)
    exact = all(face.surface is not None and face.parameters is not None for face in (front, back))
    return same and exact and has_one_border(front) and has_one_border(back)


def has_one_border(mesh: Mesh) -> bool:
    """Whether the edges that only one triangle has form one closed line."""
    vertices, ends = np.unique(border_edges(mesh), return_inverse=True)
    if (np.bincount(ends.ravel()) != 2).any():
        return False
    start, stop = ends.reshape(2, -1)
    graph = coo_array((np.ones(len(start)), (start, stop)), shape=(len(vertices), len(vertices)))
    return bool(connected_components(graph, directed=False, return_labels=False) == 1)


def border_edges(mesh: Mesh) -> np.ndarray:
    """The ends, (2, E), of the edges that only one triangle has."""
    edges = np.sort(np.concatenate([mesh.faces[:, pair] for pair in ([0, 1], [1, 2], [2, 0])]), axis=1).astype(np.int64)
    # As single numbers: rows take ten times as long to sort.
    count = len(mesh.positions)
    numbers, uses = np.unique(edges[:, 0] * count + edges[:, 1], return_counts=True)
    return np.stack(np.divmod(numbers[uses == 1], count))


def least_edge(front: Mesh, back: Mesh) -> float:
    """How thick a lens is where its edge is thinnest, metres; negative where its faces cross there."""
    axis = doubled_areas(front.positions, front.faces).sum(axis=0)
    axis /= np.linalg.norm(axis)
    ahead, behind = (np.asarray(face.positions, float)[np.unique(border_edges(face))] for face in (front, back))
    heights = ahead @ axis, behind @ axis
    aside = ahead - np.outer(heights[0], axis), behind - np.outer(heights[1], axis)
    return float((heights[0] - heights[1][KDTree(aside[1]).query(aside[0])[1]]).min())
