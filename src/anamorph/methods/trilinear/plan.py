"""What all ray triangles of an image may see, and what their samples see of it, on all the cores."""

from __future__ import annotations

import threading
from collections.abc import Callable, Generator
from typing import NamedTuple

import numpy as np

from anamorph.base.compiled import cores, steps_over_all_cores
from anamorph.methods.trilinear.beams import Beams
from anamorph.methods.trilinear.box_tree import BoxTree
from anamorph.methods.trilinear.pairs import Own, Workspace, fill, make_workspace
from anamorph.methods.trilinear.sample_sights import keep_shown, look
from anamorph.methods.trilinear.sights import Sights
from anamorph.raytriangle.camera_frames import Frames

FIRST_PAIRS = 1024
"""For which a thread's arrays have room at first."""

SHARES_A_CORE = 4
"""Into how many shares the ray triangles are divided for each core at least: they are not all equally much work."""

LARGEST_SHARE = 64
"""Ray triangles: a share is worked out to its end once it is begun."""


class Plan(NamedTuple):
    """Pairs of a ray triangle and a scene triangle that it may see."""

    pair: np.ndarray
    """(P, 3) int32: the ray triangle, by its place in the `Beams`; the scene triangle; and 1 where that is seen from
    its front."""
    terms: np.ndarray
    """(P, 24) float64, in places relative to the ray triangle's center: six terms (x x, x y, y y, x, y, 1) each of the
    quadratics whose shares of their sum are the weights of the scene triangle's corners; three (x, y, 1) of N, and of
    N (t - near). Inside, none of these is negative."""


class Planner:
    """Finds what ray triangles see, in arrays that it keeps from one frame to the next."""

    def __init__(self) -> None:
        self._thread = threading.local()

    def planning(
        self, beams: Beams, frames: Frames, tree: BoxTree, group: np.ndarray, own: Own
    ) -> Generator[None, None, Plan]:
        """Find the pairs of ray triangles and the triangles of a tree, in steps; each belongs to a `group` (M,)."""
        found: dict[int, Plan] = {}

        def keep(first: int, work: Workspace, pairs: int) -> None:
            kept = keep_shown(beams, work, pairs)
            found[first] = Plan(work.pair[:kept].copy(), work.terms[:kept].copy())

        yield from self._going(beams, frames, tree, group, own, Sights.reserved((0, 0)), False, keep)
        parts = [found[first] for first in sorted(found)] or [Plan(*make_workspace(0)[1::-1])]
        return Plan(*(np.concatenate(columns) for columns in zip(*parts, strict=True)))

    def looking(
        self,
        beams: Beams,
        frames: Frames,
        tree: BoxTree,
        group: np.ndarray,
        own: Own,
        words: np.ndarray,
        sights: Sights,
    ) -> Generator[None, None, int]:
        """Find what samples see, in steps: see `look`. Returns how many pairs were asked."""
        asked: list[int] = []

        def ask(first: int, work: Workspace, pairs: int) -> None:
            look(beams, words, work, pairs, sights)
            asked.append(pairs)

        yield from self._going(beams, frames, tree, group, own, sights, True, ask)
        return sum(asked)

    def _going(
        self,
        beams: Beams,
        frames: Frames,
        tree: BoxTree,
        group: np.ndarray,
        own: Own,
        sights: Sights,
        by_rays: bool,
        use: Callable[[int, Workspace, int], None],
    ) -> Generator[None, None, None]:
        """Call use(first, work, pairs) for the ray triangles from `first` on, as many as fit into a workspace."""
        count = len(beams.number)
        grain = min(max(1, -(-count // (SHARES_A_CORE * cores()))), LARGEST_SHARE)

        def share(start: int, stop: int) -> None:
            while start < stop:
                work = self._workspace()
                following, pairs = fill(beams, frames, tree, group, own, sights, by_rays, start, stop, work)
                if following == start:
                    self._thread.work = make_workspace(2 * len(work.pair))
                elif pairs:
                    use(start, work, pairs)
                start = following

        yield from steps_over_all_cores(share, count, grain)

    def _workspace(self) -> Workspace:
        """The calling thread's own arrays, as large as they have had to be."""
        if not hasattr(self._thread, "work"):
            self._thread.work = make_workspace(FIRST_PAIRS)
        work: Workspace = self._thread.work
        return work
