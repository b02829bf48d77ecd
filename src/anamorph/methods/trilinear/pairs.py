"""Which scene triangles a ray triangle sees: a walk down the tree of boxes, and then a look at each. Compiled."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from anamorph.base.compiled import compiled, inlined
from anamorph.methods.trilinear.beams import Beams
from anamorph.methods.trilinear.box_tree import LEAF, BoxTree
from anamorph.methods.trilinear.pieces import Workspace, find_pieces
from anamorph.methods.trilinear.terms import ACROSS, AHEAD, lies_beyond

ALL, FRONTS, NONE = range(3)
"""What a ray triangle sees of its own group of scene triangles."""


class Own(NamedTuple):
    """What each ray triangle sees of the surface that its rays leave."""

    face: np.ndarray
    """(K,) int32: the scene triangle that it is itself, or -1."""
    group: np.ndarray
    """(K,) int32"""
    sees: np.ndarray
    """(K,) int32: ALL, FRONTS or NONE of its group."""


@inlined
def _may_see(normals: np.ndarray, distances: np.ndarray, low: np.ndarray, high: np.ndarray) -> bool:
    for plane in range(len(distances)):
        furthest = 0.0
        for axis in range(3):
            normal = normals[plane, axis]
            furthest += normal * (high[axis] if normal > 0.0 else low[axis])
        # Written so that an empty box, whose sums are not numbers, is not seen.
        if not furthest >= distances[plane]:
            return False
    return True


@compiled
def _meet(
    beams: Beams,
    tree: BoxTree,
    group: np.ndarray,
    own: Own,
    k: int,
    place: int,
    work: Workspace,
    pairs: int,
    pieces: int,
) -> tuple[int, int]:
    """Add what ray triangle k sees of a scene triangle. Pairs and pieces with those before; -1 if they do not fit."""
    face = tree.faces[place]
    if face == own.face[k]:
        return pairs, pieces
    sees = own.sees[k] if group[face] == own.group[k] else ALL
    if sees == NONE:
        return pairs, pieces
    if pairs + 2 > len(work.pair):
        return -1, pieces
    corners, anchor = tree.corners[place], beams.anchor[k]
    a = (corners[0, 0] - anchor[0], corners[0, 1] - anchor[1], corners[0, 2] - anchor[2])
    b = (corners[1, 0] - anchor[0], corners[1, 1] - anchor[1], corners[1, 2] - anchor[2])
    c = (corners[2, 0] - anchor[0], corners[2, 1] - anchor[1], corners[2, 2] - anchor[2])
    e0, e1, e2 = b[0] - a[0], b[1] - a[1], b[2] - a[2]
    f0, f1, f2 = c[0] - a[0], c[1] - a[1], c[2] - a[2]
    n0, n1, n2 = e1 * f2 - e2 * f1, e2 * f0 - e0 * f2, e0 * f1 - e1 * f0
    height = a[0] * n0 + a[1] * n1 + a[2] * n2
    direction, origin, scale = beams.direction[k], beams.origin[k], beams.scale[k]
    across0 = n0 * direction[0, 0] + n1 * direction[1, 0] + n2 * direction[2, 0]
    across1 = n0 * direction[0, 1] + n1 * direction[1, 1] + n2 * direction[2, 1]
    across2 = n0 * direction[0, 2] + n1 * direction[1, 2] + n2 * direction[2, 2]
    ahead0 = height * scale[0] - n0 * origin[0, 0] - n1 * origin[1, 0] - n2 * origin[2, 0]
    ahead1 = height * scale[1] - n0 * origin[0, 1] - n1 * origin[1, 1] - n2 * origin[2, 1]
    ahead2 = height * scale[2] - n0 * origin[0, 2] - n1 * origin[1, 2] - n2 * origin[2, 2]
    low, high = np.inf, -np.inf
    ahead_low, ahead_high = np.inf, -np.inf
    for corner in range(beams.corners[k]):
        x, y = beams.domain[k, corner, 0], beams.domain[k, corner, 1]
        value = across0 * x + across1 * y + across2
        low, high = min(low, value), max(high, value)
        value = ahead0 * x + ahead1 * y + ahead2
        ahead_low, ahead_high = min(ahead_low, value), max(ahead_high, value)
    for side in range(2):
        # From the back first: N > 0.
        sign = 1.0 - 2.0 * side
        seen = (high > 0.0 and ahead_high > 0.0) if side == 0 else (low < 0.0 and ahead_low < 0.0)
        if not seen or (side == 0 and sees == FRONTS):
            continue
        terms = work.terms[pairs]
        if (
            lies_beyond(beams, k, b, c, sign, terms, 0)
            or lies_beyond(beams, k, c, a, sign, terms, 6)
            or lies_beyond(beams, k, a, b, sign, terms, 12)
        ):
            continue
        terms[ACROSS], terms[ACROSS + 1], terms[ACROSS + 2] = sign * across0, sign * across1, sign * across2
        terms[AHEAD], terms[AHEAD + 1], terms[AHEAD + 2] = sign * ahead0, sign * ahead1, sign * ahead2
        for term in range(3):
            terms[AHEAD + term] -= beams.near[k] * terms[ACROSS + term]
        work.pair[pairs, 0], work.pair[pairs, 1], work.pair[pairs, 2] = k, face, side
        after = find_pieces(beams, k, work, pairs, pieces)
        if after < 0:
            return -1, pieces
        if after > pieces:
            pairs, pieces = pairs + 1, after
    return pairs, pieces


@compiled
def fill(
    beams: Beams, tree: BoxTree, group: np.ndarray, own: Own, first: int, stop: int, work: Workspace
) -> tuple[int, int, int]:
    """What ray triangles from `first` to `stop` see of the triangles of a tree.

    Parameters
    ----------
    beams : Beams
    tree : BoxTree
    group : (M,) int32
        The group that each scene triangle belongs to, by the caller's numbers.
    own : Own
    first, stop : int
    work : Workspace
        Filled.

    Returns
    -------
    following, pairs, pieces : int
        The ray triangle whose pairs or pieces no longer fitted, or `stop`; and how many there are.
    """
    pairs, pieces = 0, 0
    leaves = len(tree.low) // 2
    for k in range(first, stop):
        whole_pairs, whole_pieces = pairs, pieces
        work.stack[0] = 1
        waiting = 1
        while waiting > 0:
            waiting -= 1
            node = work.stack[waiting]
            if not _may_see(beams.normals[k], beams.distances[k], tree.low[node], tree.high[node]):
                continue
            if node < leaves:
                work.stack[waiting], work.stack[waiting + 1] = 2 * node + 1, 2 * node
                waiting += 2
                continue
            start = (node - leaves) * LEAF
            for place in range(start, min(start + LEAF, len(tree.faces))):
                pairs, pieces = _meet(beams, tree, group, own, k, place, work, pairs, pieces)
                if pairs < 0:
                    return k, whole_pairs, whole_pieces
    return stop, pairs, pieces
