"""All the refraction points of many points through one lens."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from weakref import WeakKeyDictionary

import numpy as np

from anamorph.base.compiled import over_all_cores
from anamorph.base.vectors import tuple_of
from anamorph.optics.borders import RoundBorder, lens_borders
from anamorph.optics.laws import refract
from anamorph.optics.refraction import Refractor, refractor, to_far_face
from anamorph.reflections.beside import beside
from anamorph.reflections.charts import Chart, chart_of
from anamorph.reflections.cone_tree import ConeTree, LeavingRays, balls_around, cone_tree, front_seen, ordered
from anamorph.reflections.distinct import distinct
from anamorph.reflections.searching import GRAIN, ON
from anamorph.reflections.seeds import seeds_of
from anamorph.reflections.stationary import LENGTH, NORMAL, ORDER, PLACE, POSITION
from anamorph.reflections.through_lens import FAR_NORMAL, FAR_PLACE, FAR_POSITION, WORDS, settle_through
from anamorph.reflections.trims import triangles_of
from anamorph.scene.model import Mesh
from anamorph.surfaces.base import Surface

NOWHERE = (0.0, 0.0, 0.0)
"""The feet of points do not depend on an eye."""


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
class Face:
    """A face of a lens for the search: its surface and chart, the order of its pieces, and the balls around them."""

    surface: Surface
    chart: Chart
    order: np.ndarray
    balls: np.ndarray
    lengths: np.ndarray

    @classmethod
    def of(cls, mesh: Mesh, rounds: Sequence[RoundBorder]) -> Face:
        """A face that the borders `rounds` end."""
        assert mesh.surface is not None
        chart = chart_of(mesh, rounds)
        order = ordered(chart.positions)
        lengths = np.linalg.norm(chart.positions - np.roll(chart.positions, 1, axis=1), axis=2).max(axis=1)
        return cls(mesh.surface, chart, order, balls_around(order, chart.positions), lengths)

    def holding(self, first: np.ndarray, places: np.ndarray, positions: np.ndarray) -> np.ndarray:
        """In which triangles places (S, 3) lie, (S,), of which `first` are tried first; -1 for none."""
        return triangles_of(self.chart, self.order, self.balls, first, places, positions)

    def feet(self, points: np.ndarray, places: np.ndarray, lengths: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The feet of points (S, 3) that lie near `places` (S, 3), no further than twice `lengths` (S,) a step.

        Returns
        -------
        feet : (S, 6) float64
            The place and the position of each.
        away : (S,) float64
            How far the point is from it, metres; infinite where none was found.
        """
        chart, starts = self.chart, places.copy()
        feet, away = np.zeros((len(points), 6)), np.zeros(len(points))

        def work(start: int, stop: int) -> None:
            beside(
                chart.kind, chart.numbers, chart.size, NOWHERE, points, starts, lengths, start, stop, feet, away
            )  # fmt: skip

        over_all_cores(work, len(points), GRAIN)
        return feet, away

    def touched(self, points: np.ndarray) -> np.ndarray:
        """Which of points (N, 3) are on the face, (N,) bool."""
        count, chart = len(self.balls), self.chart
        cones = np.zeros((count, 5))
        cones[:, 3] = 2.0
        tree = ConeTree(self.order, self.balls, cones, np.zeros((0, 46)), np.full(len(self.order), -1))
        point, piece = seeds_of(tree, points)[0].T
        feet, away = self.feet(points[point], chart.corners[piece].mean(axis=1), self.lengths[piece])
        close = np.flatnonzero(away <= ON * chart.size)
        held = self.holding(chart.parents[piece[close]], feet[close, :3].copy(), feet[close, 3:].copy())
        return np.bincount(point[close[held >= 0]], minlength=len(points)) > 0


@dataclass(frozen=True, eq=False)
class LensSearch:
    """A lens that is looked through from one side, ready to be searched from any eye."""

    near: Face
    far: Face
    optics: Refractor

    @classmethod
    def of(cls, near: Mesh, far: Mesh, edge: Mesh | None) -> LensSearch:
        """Prepare the search; what was prepared last for the near face is used again."""
        kept = _KEPT.get(near)
        if kept is not None and kept[0] is far and kept[1] is edge:
            return kept[2]
        rounds = lens_borders(near, far, edge)
        search = cls(Face.of(near, rounds), Face.of(far, rounds), refractor(near, far))
        _KEPT[near] = far, edge, search
        return search

    def find(self, points: np.ndarray, eye: np.ndarray, index: float) -> ThroughLens:
        """The refraction points of points (N, 3), seen from (3,) in light of which the glass has this `index`."""
        chart, far = self.near.chart, self.far.chart
        rays, exits = self._leaving(eye, index)
        tree = cone_tree(rays, self.near.order, balls_around(self.near.order, rays.origins, rays.seen))
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
        feet, away = self.far.feet(
            points[point[beside_far]], places[beside_far, 3:], self.near.lengths[piece[beside_far]]
        )
        fits = np.isfinite(away)
        point, piece = (np.concatenate([each, each[beside_far[fits]]]) for each in (point, piece))
        started = np.concatenate([places[beside_far[fits], :3], feet[fits, :3]], axis=1)
        places = np.concatenate([places, started])

        def settled(
            point: np.ndarray, piece: np.ndarray, places: np.ndarray
        ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
            return self._settled(points, eye, index, point, piece, places)

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
            triangle=np.stack([chart.faces[triangles[:, 0]], far.faces[triangles[:, 1]]], axis=1),
            full=full,
        )

    def _leaving(self, eye: np.ndarray, index: float) -> tuple[LeavingRays, np.ndarray]:
        """What the lens makes of the rays of an eye, and the places (P, 3, 3) on the far face by which they leave."""
        chart, surface = self.near.chart, self.far.surface
        offsets = chart.positions - eye
        seen = front_seen(chart, offsets)
        flat = offsets.reshape(-1, 3)
        distances = np.linalg.norm(flat, axis=1, keepdims=True)
        ways = flat / np.maximum(distances, np.finfo(float).tiny)
        positions, normals = chart.positions.reshape(-1, 3), chart.normals.reshape(-1, 3)
        inside, exits, far_normals, met = to_far_face(self.optics, positions, normals, ways, index)
        leaving, total = refract(inside, far_normals, index)
        # Beside where reflection becomes total, light leaves along the surface.
        along = inside + np.einsum("ni,ni->n", -inside, far_normals)[:, None] * far_normals
        along /= np.maximum(np.linalg.norm(along, axis=1, keepdims=True), np.finfo(float).tiny)
        leaving = np.where(total[:, None], along, leaving)
        seen &= met.reshape(-1, 3).all(axis=1) & ~total.reshape(-1, 3).all(axis=1)
        exits = np.where(met[:, None], exits, positions)
        directions = np.where(met[:, None], leaving, inside) * distances
        places = surface.places(surface.parameters(exits))
        return LeavingRays(*(each.reshape(-1, 3, 3) for each in (exits, directions)), seen), places.reshape(-1, 3, 3)

    def _settled(
        self,
        points: np.ndarray,
        eye: np.ndarray,
        index: float,
        point: np.ndarray,
        piece: np.ndarray,
        places: np.ndarray,
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """The rows of what is found from some starts, its triangles, and the numbers of these starts."""
        near, far = self.near.chart, self.far.chart
        rows, ok = np.zeros((len(point), WORDS)), np.zeros(len(point), bool)
        sought, lengths, place = points[point], self.near.lengths[piece], tuple_of(eye)

        def work(start: int, stop: int) -> None:
            settle_through(
                near.kind, near.numbers, far.kind, far.numbers, index, near.size, place, sought, places, lengths,
                start, stop, rows, ok,
            )  # fmt: skip

        over_all_cores(work, len(point), GRAIN)
        entry, exit_ = rows[:, POSITION : POSITION + 3], rows[:, FAR_POSITION : FAR_POSITION + 3]
        for chart, normal, outside, inside in (
            (near, rows[:, NORMAL : NORMAL + 3], eye - entry, exit_ - entry),
            (far, rows[:, FAR_NORMAL : FAR_NORMAL + 3], sought - exit_, entry - exit_),
        ):
            ok &= chart.side * np.einsum("si,si->s", normal, outside) > 0.0
            ok &= chart.side * np.einsum("si,si->s", normal, inside) < 0.0
        found = np.flatnonzero(ok)
        triangles = np.stack(
            [
                face.holding(first, rows[found, place : place + 3].copy(), rows[found, at : at + 3].copy())
                for face, first, place, at in (
                    (self.near, near.parents[piece[found]], PLACE, POSITION),
                    (self.far, np.zeros(len(found), np.int64), FAR_PLACE, FAR_POSITION),
                )
            ],
            axis=1,
        )
        held = (triangles >= 0).all(axis=1)
        return rows[found[held]], triangles[held], found[held]


_KEPT: WeakKeyDictionary[Mesh, tuple[Mesh, Mesh | None, LensSearch]] = WeakKeyDictionary()
"""As long as a near face lives, so does what was prepared for it: its arrays do not change."""
