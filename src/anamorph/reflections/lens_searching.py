"""All the refraction points of many points through one lens."""

from __future__ import annotations

from dataclasses import dataclass, replace
from weakref import WeakKeyDictionary

import numpy as np

from anamorph.base.compiled import over_all_cores
from anamorph.base.vectors import Vector
from anamorph.optics.borders import lens_borders
from anamorph.optics.laws import refract
from anamorph.optics.refraction import Refractor, refractor, to_far_face
from anamorph.reflections.charts import chart_of
from anamorph.reflections.cone_tree import ConeTree, CornerRays, balls_around, cone_tree, front_seen
from anamorph.reflections.distinct import distinct
from anamorph.reflections.pieces import Pieces
from anamorph.reflections.seeds import seeds_of
from anamorph.reflections.stationary import LENGTH, NORMAL, ORDER, PLACE, POSITION
from anamorph.reflections.through_lens import FAR_NORMAL, FAR_PLACE, FAR_POSITION, WORDS, settle_through
from anamorph.reflections.trims import GRAIN
from anamorph.scene.model import Mesh


@dataclass(frozen=True, eq=False)
class ThroughLens:
    """The refraction points of N points through one lens, by one of its faces first.

    Parameters
    ----------
    point : (M,) int64
    position, place : (M, 2, 3) float64
        On the face by which the eye's light enters, and on the other.
    length : (M,) float64
    order : (M,) int64
    triangle : (M, 2) int64
    full : (N,) bool
        Which points have more than are given.
    """

    point: np.ndarray
    position: np.ndarray
    place: np.ndarray
    length: np.ndarray
    order: np.ndarray
    triangle: np.ndarray
    full: np.ndarray


@dataclass(frozen=True, eq=False)
class LensFaces:
    """A lens that is looked through from one side, for any eye.

    Parameters
    ----------
    near, far : Pieces
        The one that is looked at, and the other.
    optics : Refractor
    """

    near: Pieces
    far: Pieces
    optics: Refractor

    @classmethod
    def of(cls, near: Mesh, far: Mesh, edge: Mesh | None) -> LensFaces:
        """Prepare a lens; what was prepared last for the near face is used again."""
        kept = _FACES.get(near)
        if kept is not None and kept[0] is far and kept[1] is edge:
            return kept[2]
        rounds = lens_borders(near, far, edge)
        one, other = (Pieces.of(each.surface, chart_of(each, rounds)) for each in (near, far))
        faces = cls(one, other, refractor(near, far))
        _FACES[near] = far, edge, faces
        return faces


@dataclass(frozen=True, eq=False)
class LensSearch:
    """A lens that an eye looks through, ready to be searched.

    Parameters
    ----------
    faces : LensFaces
    eye : three float64
    index : float
        Of the glass, for the light that is looked at.
    tree : ConeTree
    exits : (P, 3, 3) float64
        The places on the far face by which the rays of the corners of pieces leave.
    """

    faces: LensFaces
    eye: Vector
    index: float
    tree: ConeTree
    exits: np.ndarray

    @classmethod
    def of(cls, faces: LensFaces, eye: Vector, index: float) -> LensSearch:
        """Prepare the search; what was prepared last for the faces is used again."""
        kept = _SEARCHES.get(faces)
        if kept is not None and (kept.eye, kept.index) == (eye, index):
            return kept
        cut = replace(faces, near=faces.near.cut_beside(np.asarray(eye), flat=True))
        rays, exits = _leaving(cut, np.asarray(eye), index)
        order = cut.near.order
        search = cls(cut, eye, index, cone_tree(rays, order, balls_around(order, rays.origins, rays.seen)), exits)
        _SEARCHES[faces] = search
        return search

    def find(self, points: np.ndarray) -> ThroughLens:
        """The refraction points of points (N, 3)."""
        near, far = self.faces.near, self.faces.far
        chart, tree, exits = near.chart, self.tree, self.exits
        owners, weights, full = seeds_of(tree, points)
        point, piece = owners.T
        beside_far = np.flatnonzero(np.isnan(weights[:, 0]))
        weights[beside_far] = 1.0 / 3.0
        places = np.concatenate(
            [
                corners[:, 0] + np.einsum("sk,ski->si", weights, corners[:, 1:] - corners[:, :1])
                for corners in (chart.corners[piece], exits[piece])
            ],
            axis=1,
        )
        # Light that ends beside the far face leaves it near the point's foot.
        feet, away = far.feet(points[point[beside_far]], places[beside_far, 3:], near.lengths[piece[beside_far]])
        fits = np.isfinite(away)
        point, piece = (np.concatenate([each, each[beside_far[fits]]]) for each in (point, piece))
        started = np.concatenate([places[beside_far[fits], :3], feet[fits, :3]], axis=1)
        places = np.concatenate([places, started])

        def settled(
            point: np.ndarray, piece: np.ndarray, places: np.ndarray, at_folds: bool
        ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
            return self._settled(points, point, piece, places, at_folds)

        point, triangles, rows = distinct(settled, point, piece, places, chart.size)
        pairs = [
            np.stack([rows[:, first : first + 3], rows[:, second : second + 3]], axis=1)
            for first, second in ((POSITION, FAR_POSITION), (PLACE, FAR_PLACE))
        ]
        return ThroughLens(
            point=point,
            position=pairs[0],
            place=pairs[1],
            length=rows[:, LENGTH],
            order=rows[:, ORDER].astype(int),
            triangle=np.stack([chart.faces[triangles[:, 0]], far.chart.faces[triangles[:, 1]]], axis=1),
            full=full,
        )

    def _settled(
        self,
        points: np.ndarray,
        point: np.ndarray,
        piece: np.ndarray,
        places: np.ndarray,
        at_folds: bool,
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """The rows of what is found from some starts, its triangles, and the numbers of these starts."""
        faces = self.faces
        near, far = faces.near.chart, faces.far.chart
        rows, ok = np.zeros((len(point), WORDS)), np.zeros(len(point), bool)
        sought, lengths, eye = points[point], faces.near.lengths[piece], self.eye

        def work(start: int, stop: int) -> None:
            settle_through(
                near.kind, near.numbers, far.kind, far.numbers, self.index, near.size, eye, sought, places, lengths,
                at_folds, start, stop, rows, ok,
            )  # fmt: skip

        over_all_cores(work, len(point), GRAIN)
        entry, exit_ = rows[:, POSITION : POSITION + 3], rows[:, FAR_POSITION : FAR_POSITION + 3]
        for chart, normal, outside, inside in (
            (near, rows[:, NORMAL : NORMAL + 3], np.asarray(eye) - entry, exit_ - entry),
            (far, rows[:, FAR_NORMAL : FAR_NORMAL + 3], sought - exit_, entry - exit_),
        ):
            ok &= chart.side * np.einsum("si,si->s", normal, outside) > 0.0
            ok &= chart.side * np.einsum("si,si->s", normal, inside) < 0.0
        found = np.flatnonzero(ok)
        triangles = np.stack(
            [
                face.holding(first, rows[found, place : place + 3].copy(), rows[found, at : at + 3].copy())
                for face, first, place, at in (
                    (faces.near, near.parents[piece[found]], PLACE, POSITION),
                    (faces.far, np.zeros(len(found), np.int64), FAR_PLACE, FAR_POSITION),
                )
            ],
            axis=1,
        )
        held = (triangles >= 0).all(axis=1)
        return rows[found[held]], triangles[held], found[held]


def _leaving(faces: LensFaces, eye: np.ndarray, index: float) -> tuple[CornerRays, np.ndarray]:
    """What the lens makes of the rays of an eye, and the places (P, 3, 3) on the far face by which they leave."""
    chart, surface = faces.near.chart, faces.far.surface
    assert surface is not None
    offsets = chart.positions - eye
    seen = front_seen(chart, offsets)
    flat = offsets.reshape(-1, 3)
    distances = np.linalg.norm(flat, axis=1, keepdims=True)
    ways = flat / np.maximum(distances, np.finfo(float).tiny)
    positions, normals = chart.positions.reshape(-1, 3), chart.normals.reshape(-1, 3)
    inside, exits, far_normals, met = to_far_face(faces.optics, positions, normals, ways, index)
    leaving, total = refract(inside, far_normals, index)
    # Beside where reflection becomes total, light leaves along the surface.
    along = inside + np.einsum("ni,ni->n", -inside, far_normals)[:, None] * far_normals
    along /= np.maximum(np.linalg.norm(along, axis=1, keepdims=True), np.finfo(float).tiny)
    leaving = np.where(total[:, None], along, leaving)
    seen &= met.reshape(-1, 3).all(axis=1) & ~total.reshape(-1, 3).all(axis=1)
    exits = np.where(met[:, None], exits, positions)
    directions = np.where(met[:, None], leaving, inside) * distances
    places = surface.places(surface.parameters(exits))
    rays = CornerRays(exits.reshape(-1, 3, 3), directions.reshape(-1, 3, 3), seen)
    return rays, places.reshape(-1, 3, 3)


_FACES: WeakKeyDictionary[Mesh, tuple[Mesh, Mesh | None, LensFaces]] = WeakKeyDictionary()
_SEARCHES: WeakKeyDictionary[LensFaces, LensSearch] = WeakKeyDictionary()
"""As long as a near face lives, so does what was prepared for it: its arrays do not change."""
