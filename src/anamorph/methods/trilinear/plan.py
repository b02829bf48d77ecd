"""What all ray triangles of an image see: the pairs of ray triangle and scene triangle, on all the cores."""

from __future__ import annotations

import threading
from collections.abc import Generator
from dataclasses import dataclass

import numpy as np

from anamorph.base.compiled import cores, steps_over_all_cores
from anamorph.methods.trilinear.beams import Beams
from anamorph.methods.trilinear.box_tree import BoxTree
from anamorph.methods.trilinear.pairs import Own, fill
from anamorph.methods.trilinear.pieces import Workspace, make_workspace

PIECES_A_PAIR = 4
SHARES_A_CORE = 4
"""Into how many shares the ray triangles are divided for each core at least: they are not all equally much work."""

LARGEST_SHARE = 64
"""Ray triangles: a share is worked out to its end once it is begun."""


@dataclass(frozen=True, eq=False)
class Plan:
    """Pairs of a ray triangle and a scene triangle that it may see, and where in the image.

    Parameters
    ----------
    pair : (P, 3) int32
        The ray triangle, by its place in the `Beams`; the scene triangle; and 1 where that is seen from its front.
    terms : (P, 24) float64
        In places relative to the ray triangle's center: six terms (x x, x y, y y, x, y, 1) each of the quadratics whose
        shares of their sum are the weights of the scene triangle's corners; three (x, y, 1) of N, and of N (t - near).
        Inside, none of these is negative.
    place : (T, 3, 2) float32
        Triangles of the image, in pixels from the ray triangle's center, which together hold all that is inside.
    owner : (T,) int32
        The pair that each of them belongs to.
    """

    pair: np.ndarray
    terms: np.ndarray
    place: np.ndarray
    owner: np.ndarray


class Planner:
    """Makes plans, in arrays that it keeps from one to the next."""

    def __init__(self) -> None:
        self._thread = threading.local()

    def planning(self, beams: Beams, tree: BoxTree, group: np.ndarray, own: Own) -> Generator[None, None, Plan]:
        """Find what each ray triangle sees of the triangles of a tree, in steps; each belongs to a `group` (M,)."""
        count = len(beams.number)
        grain = min(max(1, -(-count // (SHARES_A_CORE * cores()))), LARGEST_SHARE)
        found: dict[int, list[tuple[np.ndarray, ...]]] = {}

        def work(start: int, stop: int) -> None:
            found[start] = self._share(beams, tree, group, own, start, stop)

        yield from steps_over_all_cores(work, count, grain)
        parts = [part for start in sorted(found) for part in found[start]]
        if not parts:
            parts = [self._copied(make_workspace(1, 1), 0, 0)]
        first = np.cumsum([0, *(len(part[0]) for part in parts)])
        owner = np.concatenate([part[3] + offset for part, offset in zip(parts, first, strict=False)])
        pair, terms, place = (np.concatenate([part[i] for part in parts]) for i in range(3))
        return Plan(pair, terms, place, owner.astype(np.int32))

    def _share(
        self, beams: Beams, tree: BoxTree, group: np.ndarray, own: Own, start: int, stop: int
    ) -> list[tuple[np.ndarray, ...]]:
        work = self._workspace()
        parts = []
        while start < stop:
            following, pairs, pieces = fill(beams, tree, group, own, start, stop, work)
            if pairs:
                parts.append(self._copied(work, pairs, pieces))
            if following == start:
                work = self._thread.work = make_workspace(2 * len(work.pair), 2 * len(work.owner))
            start = following
        return parts

    def _workspace(self) -> Workspace:
        """The calling thread's own arrays, as large as they have had to be."""
        if not hasattr(self._thread, "work"):
            self._thread.work = make_workspace(1024, PIECES_A_PAIR * 1024)
        work: Workspace = self._thread.work
        return work

    @staticmethod
    def _copied(work: Workspace, pairs: int, pieces: int) -> tuple[np.ndarray, ...]:
        return (
            work.pair[:pairs].copy(), work.terms[:pairs].copy(),
            work.place[:pieces].copy(), work.owner[:pieces].copy(),
        )  # fmt: skip
