"""The order in which projected corners of one scene triangle are joined into shapes, as two chains a shape. Compiled.

Source: Vallance 2005, sections 4.1 to 4.3. The plane of the parametric triangle cuts the plane of the scene triangle in
a line, which sweeps as t grows. Whenever it meets a corner of the scene triangle, the two edges at that corner are
toggled: they begin or cease to be crossed. A shape lasts as long as two edges are crossed, and its outline is the two
chains of corners that the crossings leave, both from where the shape begins to where it ends, with rising t.

Deviations: an edge is crossed where its two corners lie on different sides, so that a sweep begins and ends rightly
where the line crosses edges at infinite t (rays parallel to one plane). And every link of a chain knows the scene edge
that is followed from it, which the printed listing takes from the two ends of a line: they may be the same corner.
"""

from __future__ import annotations

import math

import numpy as np

from anamorph.base.compiled import compiled
from anamorph.raytriangle.solve import BEFORE, COUNT, ROOT, ROOTS

CORNER, WHICH, EDGE = range(3)
"""Of a link: the corner of the scene triangle, which of its roots, and the edge followed from here, named by the corner
opposite; -1 after the last."""

OPEN = -1
"""In place of a corner: where the chain comes from t = -infinity or goes on to infinity."""

LINKS, SHAPES = 24, 8
"""Both chains of all shapes of nine corners fit, with their ends at infinity."""


@compiled
def connected(solved: np.ndarray, links: np.ndarray, ends: np.ndarray) -> int:
    """Join the corners into shapes, in the order in which they end; how many there are.

    Parameters
    ----------
    solved : (3, 18) float64
        The corners, from `solve_point`.
    links : (2, 24, 3) int64
        Both chains of all shapes, one after the other.
    ends : (8, 2) int64
        For each shape, one past the last link of each chain.
    """
    crossed = 0
    for edge in range(3):
        if (solved[(edge + 1) % 3, BEFORE] >= 0.0) != (solved[(edge + 2) % 3, BEFORE] >= 0.0):
            crossed |= 1 << edge
    left, right, lefts, rights, shapes = 0, 0, 0, 0, 0
    if crossed:
        left, right = _first(crossed), _last(crossed)
        _link(links, 0, 0, OPEN, 0, left)
        _link(links, 1, 0, OPEN, 0, right)
        lefts, rights = 1, 1
    taken0, taken1, taken2 = 0, 0, 0
    while True:
        t0, t1, t2 = _next(solved, 0, taken0), _next(solved, 1, taken1), _next(solved, 2, taken2)
        if t0 == t1 == t2 == math.inf:
            break
        if t0 <= t1 and t0 <= t2:
            corner, which = 0, taken0
            taken0 += 1
        elif t1 <= t2:
            corner, which = 1, taken1
            taken1 += 1
        else:
            corner, which = 2, taken2
            taken2 += 1
        here = 7 ^ (1 << corner)
        if crossed == 0:
            left, right = _first(here), _last(here)
            _link(links, 0, lefts, corner, which, left)
            _link(links, 1, rights, corner, which, right)
            lefts, rights = lefts + 1, rights + 1
        elif crossed == here:
            _link(links, 0, lefts, corner, which, -1)
            _link(links, 1, rights, corner, which, -1)
            lefts, rights = lefts + 1, rights + 1
            ends[shapes, 0], ends[shapes, 1] = lefts, rights
            shapes += 1
        elif (here >> left) & 1:
            left = _first(here & ~crossed)
            _link(links, 0, lefts, corner, which, left)
            lefts += 1
        else:
            right = _first(here & ~crossed)
            _link(links, 1, rights, corner, which, right)
            rights += 1
        crossed ^= here
    if crossed:
        _link(links, 0, lefts, OPEN, 1, -1)
        _link(links, 1, rights, OPEN, 1, -1)
        ends[shapes, 0], ends[shapes, 1] = lefts + 1, rights + 1
        shapes += 1
    return shapes


@compiled
def link_t(solved: np.ndarray, links: np.ndarray, side: int, k: int) -> float:
    """The scaled t of a link; infinite for an open end."""
    corner, which = links[side, k, CORNER], links[side, k, WHICH]
    if corner == OPEN:
        return math.inf if which else -math.inf
    return solved[corner, ROOTS + ROOT * which]


@compiled
def _link(links: np.ndarray, side: int, k: int, corner: int, which: int, edge: int) -> None:
    links[side, k, CORNER], links[side, k, WHICH], links[side, k, EDGE] = corner, which, edge


@compiled
def _next(solved: np.ndarray, corner: int, taken: int) -> float:
    return solved[corner, ROOTS + ROOT * taken] if taken < solved[corner, COUNT] else math.inf


@compiled
def _first(edges: int) -> int:
    return 0 if edges & 1 else 1 if edges & 2 else 2


@compiled
def _last(edges: int) -> int:
    return 2 if edges & 4 else 1 if edges & 2 else 0
