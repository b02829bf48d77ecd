"""A mirror, or a face of a lens, as a tree of pieces: which of them hold a place, and which points are on it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from anamorph.base.compiled import over_all_cores
from anamorph.reflections.beside import beside
from anamorph.reflections.charts import Chart, cut_beside, longest
from anamorph.reflections.cone_tree import ConeTree, balls_around, ordered
from anamorph.reflections.seeds import seeds_of
from anamorph.reflections.trims import GRAIN, triangles_of
from anamorph.surfaces.base import Surface

ON = 1e-9
"""A point nearer to a surface than this share of its size is on it."""

NOWHERE = (0.0, 0.0, 0.0)
"""The feet of points do not depend on an eye."""


@dataclass(frozen=True, eq=False)
class Pieces:
    """The pieces of a mirror, or of a face of a lens, in a tree of balls.

    Parameters
    ----------
    surface : Surface, optional
        The exact one, if the mesh has parameters on it.
    chart : Chart
    order : (P,) int64
        That of the tree: see `ConeTree`.
    balls : (2 L, 4) float64
    lengths : (P,) float64
        The longest edge of each piece, metres.
    """

    surface: Surface | None
    chart: Chart
    order: np.ndarray
    balls: np.ndarray
    lengths: np.ndarray

    @classmethod
    def of(cls, surface: Surface | None, chart: Chart) -> Pieces:
        """Put the pieces of a chart into a tree."""
        order = ordered(chart.positions)
        return cls(surface, chart, order, balls_around(order, chart.positions), longest(chart.positions))

    def cut_beside(self, eye: np.ndarray, flat: bool = False) -> Pieces:
        """Smaller pieces where an eye at (3,) is close, as `charts.cut_beside` makes them."""
        chart = cut_beside(self.chart, eye, flat)
        return self if chart is self.chart else Pieces.of(self.surface, chart)

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

    def placed(self, places: np.ndarray) -> np.ndarray:
        """The (u, v), (S, 2), of places (S, 3); of a plain mesh, two weights: see `ReflectionPoints`."""
        return places[:, :2] if self.surface is None else self.surface.placed(places)

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
