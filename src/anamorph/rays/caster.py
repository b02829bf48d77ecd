"""Casting rays at a scene: which triangle each of them hits first.

Embree does the work: through its C interface on all the cores where a check at start shows that this gives the same
answers as the wrapper `embreex`, and otherwise through the wrapper. ANAMORPH_RAYS=embreex asks for the wrapper.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache

import numpy as np
from embreex.mesh_construction import TriangleMesh
from embreex.rtcore_scene import EmbreeScene
from numpy.typing import ArrayLike

from anamorph.base.compiled import over_all_cores
from anamorph.base.errors import AnamorphError
from anamorph.rays import embree
from anamorph.scene.geometry import Geometry

GRAIN = 8192

ROUNDING = 4.0 * 2.0**-23
"""What float32 may put a place off by, on a ray, as a share of its coordinates: four units in the last place."""

LEAST_STEP = 1e-12
"""Metres: a ray goes on by this at least, where its coordinates are zeros."""


@dataclass(frozen=True, eq=False)
class Hits:
    """What N rays hit first.

    Parameters
    ----------
    distance : (N,) float64
        In lengths of the ray's direction; infinite for a miss.
    triangle : (N,) int32
        Index into `Geometry.faces`, or -1 for a miss.
    barycentric : (N, 2) float64
        Weights of the triangle's second and third vertex; zeros for a miss.
    """

    distance: np.ndarray
    triangle: np.ndarray
    barycentric: np.ndarray

    @classmethod
    def empty(cls, count: int) -> Hits:
        """Space for `count` rays, not filled."""
        return cls(np.empty(count), np.empty(count, np.int32), np.empty((count, 2)))


class _Wrapper:
    """The tree as `embreex` offers it: one core, one ray at a time, the interpreter lock held."""

    def __init__(self, positions: np.ndarray, faces: np.ndarray) -> None:
        self._scene = EmbreeScene()
        self._mesh = TriangleMesh(self._scene, positions[faces])

    def cast(
        self,
        origins: np.ndarray,
        directions: np.ndarray,
        near: np.ndarray,
        coherent: bool,
        distance: np.ndarray,
        triangle: np.ndarray,
        barycentric: np.ndarray,
    ) -> None:
        distance[:], triangle[:], barycentric[:] = np.inf, -1, 0.0
        # The wrapper knows no near distance: the rays start further on instead.
        origins = (origins + near[:, None] * directions).astype(np.float32)
        found = self._scene.run(origins, directions.astype(np.float32), query="INTERSECT", output=True)
        hit = found["primID"] >= 0
        triangle[hit] = found["primID"][hit]
        distance[hit] = found["tfar"][hit] + near[hit]
        barycentric[hit] = np.stack([found["u"], found["v"]], axis=-1)[hit]


@cache
def direct_works() -> bool:
    """Whether Embree's C interface gives the wrapper's answers on a small known scene."""
    x, y = np.meshgrid(np.arange(6.0), np.arange(6.0))
    positions = np.stack([x, y, 0.3 * np.sin(3.0 * x + y)], axis=-1).reshape(-1, 3).astype(np.float32)
    corner = (np.arange(5)[:, None] * 6 + np.arange(5)).ravel()
    faces = np.concatenate([corner[:, None] + [0, 1, 7], corner[:, None] + [0, 7, 6]]).astype(np.int32)
    random = np.random.default_rng(1)
    origins = np.column_stack([random.uniform(-1.0, 6.0, (301, 2)), np.full(301, 3.0)])
    directions = random.normal(size=(301, 3)) * 0.2 - [0.0, 0.0, 1.0]
    near = np.where(np.arange(301) % 7, 0.0, 9.0)
    numbers = np.arange(len(faces), dtype=np.int32)
    parts = numbers[1::2], numbers[::2]
    try:
        trees = [embree.EmbreeForest([embree.EmbreeTree(positions, faces[part]) for part in parts], parts)]
        for upkeep in (embree.Upkeep.REFIT, embree.Upkeep.REBUILD):
            tree = embree.EmbreeTree(np.roll(positions, 1, axis=1), faces, upkeep)
            tree.move(positions)
            trees.append(embree.EmbreeForest([tree], [numbers]))
    except embree.EmbreeUnavailable:
        return False

    def hits_of(tree: embree.EmbreeForest | _Wrapper) -> Hits:
        hits = Hits.empty(301)
        tree.cast(origins, directions, near, False, hits.distance, hits.triangle, hits.barycentric)
        return hits

    expected = hits_of(_Wrapper(positions, faces))
    return all(
        (expected.triangle == found.triangle).mean() > 0.99
        and np.isclose(expected.distance, found.distance, rtol=1e-4).all()
        and np.isclose(expected.barycentric, found.barycentric, atol=1e-3).all(axis=1).mean() > 0.99
        for found in map(hits_of, trees)
    )


def beyond(origins: ArrayLike, directions: ArrayLike, distances: ArrayLike = 0.0) -> np.ndarray:
    """The near distances, (N,), of rays that go on beyond what they met at `distances`: at their origins by default.

    It is the rounding of the ray's own place that they pass, however large the scene is.
    """
    origins, directions = np.asarray(origins, float), np.asarray(directions, float)
    lengths = np.linalg.norm(directions, axis=1)
    places = np.abs(origins).max(axis=1, initial=0.0) / np.where(lengths > 0.0, lengths, 1.0)
    return distances + np.maximum(ROUNDING * (places + distances), LEAST_STEP)


def _standing(geometry: Geometry) -> embree.EmbreeForest:
    """A tree for each kind of mesh: where only a mirror is edited, that over all that stands around it stays."""
    trees, numbers = [], []
    for kind in np.unique(geometry.kind[np.diff(geometry.first_face) > 0]):
        vertices, faces, own, count = [], [], [], 0
        for mesh in np.flatnonzero(geometry.kind == kind):
            start, stop = geometry.first_vertex[mesh : mesh + 2]
            first, last = geometry.first_face[mesh : mesh + 2]
            vertices.append(geometry.positions[start:stop])
            faces.append(geometry.faces[first:last] + int(count - start))
            own.append(np.arange(first, last, dtype=np.int32))
            count += int(stop - start)
        numbers.append(np.concatenate(own))
        trees.append(embree.tree_over(embree.EmbreeTriangles(np.concatenate(vertices), np.concatenate(faces))))
    return embree.EmbreeForest(trees, numbers)


class Caster:
    """Trees over all triangles of a scene, ready to cast rays at.

    Parameters
    ----------
    geometry : Geometry

    Attributes
    ----------
    way : str
        "embree" (the C interface, all the cores) or "embreex" (the wrapper, one core).
    """

    def __init__(self, geometry: Geometry) -> None:
        wanted = os.environ.get("ANAMORPH_RAYS", "embree")
        if wanted not in ("embree", "embreex"):
            raise AnamorphError(f"ANAMORPH_RAYS is {wanted!r}; set it to embree or embreex, or unset it")
        self.way = "embree" if wanted == "embree" and direct_works() else "embreex"
        self._faces = geometry.faces
        self._tree = self._embree(lambda: _standing(geometry)) or _Wrapper(geometry.positions, geometry.faces)

    def _embree(self, make: Callable[[], embree.EmbreeForest]) -> embree.EmbreeForest | None:
        """What is made for the C interface; None where that cannot be used, or no longer."""
        if self.way == "embree":
            try:
                return make()
            except embree.EmbreeUnavailable:
                self.way = "embreex"
        return None

    def moved(self, positions: np.ndarray, rebuild: bool = False) -> None:
        """Follow the scene's vertices to `positions` (V, 3) float32, while no ray is on its way.

        The first move builds one tree for it; later ones refit that tree, or `rebuild` it. A refitted tree is right
        wherever the vertices go, but slows the rays the more the further neighbours part. The wrapper builds anew.
        """
        upkeep = embree.Upkeep.REBUILD if rebuild else embree.Upkeep.REFIT
        self._tree = self._embree(lambda: self._follow(positions, upkeep)) or _Wrapper(positions, self._faces)

    def _follow(self, positions: np.ndarray, upkeep: embree.Upkeep) -> embree.EmbreeForest:
        trees = self._tree
        if isinstance(trees, embree.EmbreeForest) and trees.trees and trees.trees[0].upkeep is upkeep:
            trees.trees[0].move(positions)
            return trees
        # Of its own: what stands may be in other casters, too.
        tree = embree.EmbreeTree(positions, self._faces, upkeep)
        return embree.EmbreeForest([tree], [np.arange(len(self._faces), dtype=np.int32)])

    def cast(self, origins: ArrayLike, directions: ArrayLike, near: ArrayLike = 0.0, coherent: bool = False) -> Hits:
        """Find what each ray hits first.

        Parameters
        ----------
        origins, directions : (N, 3) array
        near : float or (N,) array
            Hits nearer than this do not count. Rays that leave a surface start where `beyond` says.
        coherent : bool
            Neighbours in the arrays are neighbours in space, as pixels are: twice as fast where it is so.

        Returns
        -------
        Hits
        """
        origins, directions = np.asarray(origins, float), np.asarray(directions, float)
        nears = np.broadcast_to(np.asarray(near, float), len(origins)).copy()
        hits = Hits.empty(len(origins))

        def work(start: int, stop: int) -> None:
            piece = slice(start, stop)
            self.fill(
                origins[piece], directions[piece], nears[piece], coherent,
                hits.distance[piece], hits.triangle[piece], hits.barycentric[piece],
            )  # fmt: skip

        over_all_cores(work, len(origins), GRAIN)
        return hits

    @property
    def fill(self) -> Callable[..., None]:
        """What casts float64 rays on the calling thread, into the arrays of a `Hits`: see `EmbreeForest.cast`."""
        return self._tree.cast
