"""From where to search: the tree of ray cones is walked, and a cubic is solved at each piece that is left. Compiled."""

from __future__ import annotations

import math

import numpy as np

from anamorph.base.compiled import compiled, over_all_cores
from anamorph.base.vectors import Vector, along, dot
from anamorph.raytriangle.rows import CHANGE, FLAT, LENGTHS, MEAN, MIDDLE, PACE, PLANES, SHIFT, START, three
from anamorph.raytriangle.scaled import SPREAD
from anamorph.raytriangle.solve import COUNT, ROOT, ROOTS, VALID, solve_point
from anamorph.reflections.cone_tree import PAD, ConeTree, in_ball, may_reach
from anamorph.reflections.trims import DEPTH

GRAIN = 2048
"""Points that one core takes at a time."""

MOST = 4096
"""Starts for one point on one mirror: where there are more, whole curves or surfaces of the mirror show it."""

BEHIND = -1.0
"""How far behind its piece a ray may meet a point, in lengths of its direction: concave mirrors are behind theirs."""

THIN, MISS = 0.1, 0.04
"""How thin the triangle of a piece's rays has to be, as a share of how wide it could be, for its rays to say nothing of
where across it a point is seen; and how far the point may be from it then."""

FARTHEST = 1e6
"""Along the rays, in the units of their triangle: extrema of the cubic beyond are of no use."""

UP, SIDE, BACK = float(SPREAD[0, 1]), float(SPREAD[1, 1]), float(SPREAD[1, 2])


def seeds_of(tree: ConeTree, points: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Where to search for the reflection points of `points` (N, 3).

    Returns
    -------
    owners : (S, 2) int64
        The point and the piece of each seed, points ascending.
    weights : (S, 2) float64
        Of the piece's second and third corner; NaN where the point lies beside the piece, so that the piece is close to
        it and says little.
    full : (N,) bool
        Points with more seeds than are given.
    """
    full = np.zeros(len(points), bool)
    pieces: dict[int, list[tuple[np.ndarray, np.ndarray]]] = {}

    def work(start: int, stop: int) -> None:
        spaces, parts = (np.zeros(8), np.zeros(ROOTS + 5 * ROOT), np.zeros(DEPTH, np.int64)), []
        first = start
        while first < stop:
            room = MOST + 4 * (stop - first)
            owners, weights = np.zeros((room, 2), np.int64), np.zeros((room, 2))
            first, count = _walk(tree, points, first, stop, *spaces, owners, weights, full)
            parts.append((owners[:count], weights[:count]))
        pieces[start] = parts

    over_all_cores(work, len(points), GRAIN)
    parts = [part for start in sorted(pieces) for part in pieces[start]]
    return (
        np.concatenate([np.zeros((0, 2), np.int64), *(owners for owners, _ in parts)]),
        np.concatenate([np.zeros((0, 2)), *(weights for _, weights in parts)]),
        full,
    )


@compiled
def _walk(
    tree: ConeTree,
    points: np.ndarray,
    start: int,
    stop: int,
    found: np.ndarray,
    solved: np.ndarray,
    stack: np.ndarray,
    owners: np.ndarray,
    weights: np.ndarray,
    full: np.ndarray,
) -> tuple[int, int]:
    """Fill seeds for points `start` to `stop`, or until there is no room: where it ended, and how many there are.

    `found` (8,), `solved` (26,) and `stack` (128,) are work space.
    """
    count, leaves, pieces = 0, len(tree.balls) // 2, len(tree.order)
    for k in range(start, stop):
        if count + MOST > len(owners):
            return k, count
        x, y, z = points[k, 0], points[k, 1], points[k, 2]
        last = count + MOST - 6
        waiting = 1
        stack[0] = 1
        while waiting > 0:
            waiting -= 1
            node = stack[waiting]
            beside = in_ball(tree.balls, node, x, y, z)
            if not beside and not may_reach(tree.balls, tree.cones, node, x, y, z):
                continue
            if node < leaves:
                stack[waiting], stack[waiting + 1] = 2 * node, 2 * node + 1
                waiting += 2
                continue
            first = (node - leaves) * pieces // leaves
            if first == (node - leaves + 1) * pieces // leaves:
                continue
            if count >= last:
                full[k] = True
                break
            piece = tree.order[first]
            row = tree.row_of[piece]
            if beside:
                owners[count, 0], owners[count, 1] = k, piece
                weights[count, 0] = weights[count, 1] = np.nan
                count += 1
            if row < 0:
                continue
            solve_point(tree.rows[row], x, y, z, found, solved)
            point, roots = (solved[0], solved[1], solved[2]), int(solved[COUNT])
            for root in range(_with_extrema(tree.rows[row], point, roots, solved)):
                at = ROOTS + ROOT * root
                t, u, v = solved[at], solved[at + 1], solved[at + 2]
                if not (t + tree.rows[row, SHIFT]) * tree.rows[row, PACE] > BEHIND:
                    continue
                if not (solved[at + 3] == VALID and _inside(u, v)):
                    u, v, near = _nearest(tree.rows[row], point, t, root < roots)
                    if not (near and _inside(u, v)):
                        continue
                owners[count, 0], owners[count, 1] = k, piece
                weights[count, 0], weights[count, 1] = u, v
                count += 1
    return stop, count


@compiled
def _inside(u: float, v: float) -> bool:
    return u >= -PAD and v >= -PAD and u + v <= 1.0 + PAD


@compiled
def _with_extrema(row: np.ndarray, point: Vector, roots: int, solved: np.ndarray) -> int:
    """Add to the roots of a point the extrema of its cubic: how many there are then.

    The exact surface may have the two roots that the cubic just misses.
    """
    n1, n2 = three(row, PLANES + 3), three(row, PLANES + 6)
    b, c, d = dot(point, n1) - row[MIDDLE], dot(point, n2) - row[MIDDLE + 1], -row[MIDDLE + 2]
    inside = c * c - 3.0 * d * b
    if row[FLAT] != 0.0 or not inside > 0.0:
        return roots
    larger = -(c + math.copysign(math.sqrt(inside), c))
    for first in (True, False):
        over, under = (b, larger) if first else (larger, 3.0 * d)
        if abs(over) < FARTHEST * abs(under):
            solved[ROOTS + ROOT * roots], solved[ROOTS + ROOT * roots + 3] = over / under, 0.0
            roots += 1
    return roots


@compiled
def _nearest(row: np.ndarray, point: Vector, t: float, thin: bool) -> tuple[float, float, bool]:
    """The weights at t of the ray that passes by a point, and whether they are of use: by damped least squares.

    Near a caustic the piece's rays at t lie almost in a line. Across it they hardly say where the point is seen, and
    the damping leaves the weights in the middle. Where `thin` is asked for and they do not, there is nothing of use.
    """
    off = along(point, -t, three(row, MEAN))
    e = along(three(row, START), t, three(row, CHANGE))
    g = along(three(row, START + 3), t, three(row, CHANGE + 3))
    wide = row[LENGTHS] + row[LENGTHS + 1] + abs(t) * (row[LENGTHS + 2] + row[LENGTHS + 3])
    damping = (THIN * wide) ** 2
    ee, eg, gg = dot(e, e), dot(e, g), dot(g, g)
    if thin and not ee * gg - eg * eg <= 2.0 * damping * (ee + gg):
        return 0.0, 0.0, False
    ee, gg = ee + damping, gg + damping
    determinant = ee * gg - eg * eg
    one, other = dot(e, off), dot(g, off)
    first, second = (gg * one - eg * other) / determinant, (ee * other - eg * one) / determinant
    left = along(along(off, -first, e), -second, g)
    u, v = 1.0 / 3.0 + UP * first + SIDE * second, 1.0 / 3.0 + BACK * second
    return u, v, dot(left, left) <= (MISS * wide) ** 2
