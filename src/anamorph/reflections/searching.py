"""All the reflection points of many points on one mirror."""

from __future__ import annotations

from dataclasses import dataclass
from weakref import WeakKeyDictionary

import numpy as np

from anamorph.base.compiled import over_all_cores
from anamorph.base.vectors import Vector, tuple_of
from anamorph.reflections.beside import beside
from anamorph.reflections.charts import chart_of
from anamorph.reflections.cone_tree import ConeTree, cone_tree, reflected
from anamorph.reflections.distinct import distinct
from anamorph.reflections.pieces import ON, Pieces
from anamorph.reflections.seeds import seeds_of
from anamorph.reflections.stationary import LENGTH, NORMAL, ORDER, PLACE, POSITION, WORDS, settle
from anamorph.reflections.trims import GRAIN
from anamorph.scene.model import Mesh


@dataclass(frozen=True, eq=False)
class OnMirror:
    """The reflection points of N points on one mirror.

    Parameters
    ----------
    point : (M,) int64
    position, place : (M, 3) float64
    length : (M,) float64
    order : (M,) int64
        1, -1, or 0 at a focus.
    triangle : (M,) int64
    full, on : (N,) bool
        Which points have more than are given, and which are on the mirror.
    """

    point: np.ndarray
    position: np.ndarray
    place: np.ndarray
    length: np.ndarray
    order: np.ndarray
    triangle: np.ndarray
    full: np.ndarray
    on: np.ndarray


@dataclass(frozen=True, eq=False)
class MirrorSearch:
    """A mirror before an eye, ready to be searched."""

    pieces: Pieces
    tree: ConeTree
    eye: Vector

    @classmethod
    def of(cls, mesh: Mesh, eye: np.ndarray) -> MirrorSearch:
        """Prepare the search on a mirror for the eye at (3,); what was prepared last for the mesh is used again."""
        place = tuple_of(eye)
        search = _SEARCHES.get(mesh)
        if search is not None and search.eye == place:
            return search
        whole = _PIECES.get(mesh)
        if whole is None:
            exact = mesh.surface if mesh.parameters is not None else None
            whole = _PIECES[mesh] = Pieces.of(exact, chart_of(mesh))
        pieces = whole.cut_beside(eye)
        search = cls(pieces, cone_tree(reflected(pieces.chart, eye), pieces.order, pieces.balls), place)
        _SEARCHES[mesh] = search
        return search

    def find(self, points: np.ndarray) -> OnMirror:
        """The reflection points of points (N, 3)."""
        chart = self.pieces.chart
        owners, weights, full = seeds_of(self.tree, points)
        point, piece = owners.T
        near = np.isnan(weights[:, 0])
        weights[near] = 1.0 / 3.0
        corners = chart.corners[piece]
        places = corners[:, 0] + np.einsum("sk,ski->si", weights, corners[:, 1:] - corners[:, :1])
        on = np.zeros(len(points), bool)
        started = self._started(points, point, piece, places, np.flatnonzero(near), on)
        point, piece, places = point[started], piece[started], places[started]

        def settled(
            point: np.ndarray, piece: np.ndarray, places: np.ndarray, at_folds: bool
        ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
            return self._settled(points, point, piece, places, at_folds)

        point, triangles, rows = distinct(settled, point, piece, places, chart.size)
        return OnMirror(
            point=point,
            position=rows[:, POSITION : POSITION + 3],
            place=rows[:, PLACE : PLACE + 3],
            length=rows[:, LENGTH],
            order=rows[:, ORDER].astype(int),
            triangle=chart.faces[triangles[:, 0]],
            full=full,
            on=on,
        )

    def _started(
        self,
        points: np.ndarray,
        point: np.ndarray,
        piece: np.ndarray,
        places: np.ndarray,
        near: np.ndarray,
        on: np.ndarray,
    ) -> np.ndarray:
        """Which starts are good; those `near` the mirror, numbers (K,), get other places, and `on` is marked."""
        chart, started = self.pieces.chart, np.ones(len(point), bool)
        if not len(near):
            return started
        sought, starts, lengths = points[point[near]], places[near], self.pieces.lengths[piece[near]]
        feet, away = np.zeros((len(near), 6)), np.zeros(len(near))

        def work(start: int, stop: int) -> None:
            beside(
                chart.kind, chart.numbers, chart.size, self.eye, sought, starts, lengths, start, stop, feet, away
            )  # fmt: skip

        over_all_cores(work, len(near), GRAIN)
        touching = np.flatnonzero(away <= ON * chart.size)
        first = chart.parents[piece[near[touching]]]
        there = self.pieces.holding(first, feet[touching, :3].copy(), feet[touching, 3:].copy())
        on[point[near[touching[there >= 0]]]] = True
        places[near] = starts
        started[near] = np.isfinite(away) & (away > ON * chart.size)
        return started

    def _settled(
        self, points: np.ndarray, point: np.ndarray, piece: np.ndarray, places: np.ndarray, at_folds: bool
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """The rows of what is found from some starts, its triangles, and the numbers of these starts."""
        chart = self.pieces.chart
        rows, ok = np.zeros((len(point), WORDS)), np.zeros(len(point), bool)
        sought, lengths = points[point], self.pieces.lengths[piece]

        def work(start: int, stop: int) -> None:
            settle(
                chart.kind,
                chart.numbers,
                chart.size,
                self.eye,
                sought,
                places,
                lengths,
                at_folds,
                start,
                stop,
                rows,
                ok,
            )

        over_all_cores(work, len(point), GRAIN)
        position, normal = rows[:, POSITION : POSITION + 3], rows[:, NORMAL : NORMAL + 3]
        for end in (np.asarray(self.eye), sought):
            ok &= chart.side * np.einsum("si,si->s", normal, end - position) > 0.0
        found = np.flatnonzero(ok)
        places, positions = (rows[found, first : first + 3].copy() for first in (PLACE, POSITION))
        triangles = self.pieces.holding(chart.parents[piece[found]], places, positions)
        held = triangles >= 0
        return rows[found[held]], triangles[held, None], found[held]


_PIECES: WeakKeyDictionary[Mesh, Pieces] = WeakKeyDictionary()
_SEARCHES: WeakKeyDictionary[Mesh, MirrorSearch] = WeakKeyDictionary()
"""As long as a mesh lives, so does what was prepared for it: its arrays do not change."""
