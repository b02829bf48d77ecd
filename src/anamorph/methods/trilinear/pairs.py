"""Which scene triangles a ray triangle may see: down the tree of boxes, and then a look at each. Compiled."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from anamorph.base.compiled import compiled, inlined
from anamorph.base.vectors import Vector
from anamorph.methods.trilinear.beams import Beams
from anamorph.methods.trilinear.box_tree import BoxTree
from anamorph.methods.trilinear.sights import Sights
from anamorph.methods.trilinear.terms import ACROSS, AHEAD, TERMS, lies_beyond
from anamorph.raytriangle.bounds import seen_weights
from anamorph.raytriangle.camera_frames import Frames, vector

FEW = 160
"""The rays of so many samples or fewer go down the tree themselves: they pass less than bounds let pass."""

LARGEST_BOX = 1024
"""Samples of a box in which few are looked for."""

LEAST_SLOPE = 1e-30
"""A direction's coordinate of a smaller share of it is as if it were this."""

DEEPEST = 64
"""Blocks of samples that may wait: each halving leaves one."""

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


class Workspace(NamedTuple):
    """Arrays to be filled, for one thread."""

    terms: np.ndarray
    """(P, 24) float64"""
    pair: np.ndarray
    """(P, 3) int32: ray triangle (its place in `Beams`), scene triangle, and 1 where it is seen from its front."""
    rays: np.ndarray
    """(6, FEW) float64: origins of samples' rays, and one over their directions."""
    blocks: np.ndarray
    """(DEEPEST, 4) int64: blocks of samples that wait for their turn."""


def make_workspace(pairs: int) -> Workspace:
    """Arrays for so many pairs."""
    return Workspace(
        np.empty((pairs, TERMS)), np.empty((pairs, 3), np.int32), np.empty((6, FEW)), np.empty((DEEPEST, 4), np.int64)
    )


@inlined
def _gather(beams: Beams, sights: Sights, k: int, work: Workspace) -> int:
    """Put the rays of a ray triangle's samples together; returns how many these are, or 0 if they are not few."""
    count = 0
    x0, y0, x1, y1 = beams.box[k]
    if (x1 - x0) * (y1 - y0) > LARGEST_BOX:
        return 0
    rays, origin, direction, scale = work.rays, beams.origin[k], beams.direction[k], beams.scale[k]
    for row in range(y0, y1):
        y = float(row - beams.center[k, 1])
        for column in range(x0, x1):
            if sights.owner[row, column] == beams.number[k]:
                if count == FEW:
                    return 0
                x = float(column - beams.center[k, 0])
                share = 1.0 / (scale[0] * x + scale[1] * y + scale[2])
                total = 0.0
                for axis in range(3):
                    at = origin[axis, 0] * x + origin[axis, 1] * y + origin[axis, 2]
                    rays[axis, count] = beams.anchor[k, axis] + share * at
                    rays[3 + axis, count] = direction[axis, 0] * x + direction[axis, 1] * y + direction[axis, 2]
                    total += abs(rays[3 + axis, count])
                for axis in range(3):
                    slope, least = rays[3 + axis, count], LEAST_SLOPE * total
                    rays[3 + axis, count] = 1.0 / slope if abs(slope) > least else math.copysign(1.0 / least, slope)
                count += 1
    return count


@inlined
def _passes(work: Workspace, count: int, middle: Vector, half: Vector) -> bool:
    """Whether a ray passes a box."""
    rays = work.rays[:, :count]
    p_x, p_y, p_z, i_x, i_y, i_z = rays[0], rays[1], rays[2], rays[3], rays[4], rays[5]
    some = False
    # Without a branch, and along slices, the processor asks several at once.
    for k in range(count):
        middle_x, middle_y, middle_z = (
            (middle[0] - p_x[k]) * i_x[k],
            (middle[1] - p_y[k]) * i_y[k],
            (middle[2] - p_z[k]) * i_z[k],
        )
        half_x, half_y, half_z = half[0] * abs(i_x[k]), half[1] * abs(i_y[k]), half[2] * abs(i_z[k])
        near = max(0.0, max(middle_x - half_x, max(middle_y - half_y, middle_z - half_z)))
        some = some | (near <= min(middle_x + half_x, min(middle_y + half_y, middle_z + half_z)))
    return some


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
) -> int:
    """Add what ray triangle k may see of a scene triangle. Pairs with those before; -1 if they do not fit."""
    face = tree.faces[place]
    if face == own.face[k]:
        return pairs
    sees = own.sees[k] if group[face] == own.group[k] else ALL
    if sees == NONE:
        return pairs
    if pairs + 2 > len(work.pair):
        return -1
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
    ahead0 = height * scale[0] - n0 * origin[0, 0] - n1 * origin[1, 0] - n2 * origin[2, 0] - beams.near[k] * across0
    ahead1 = height * scale[1] - n0 * origin[0, 1] - n1 * origin[1, 1] - n2 * origin[2, 1] - beams.near[k] * across1
    ahead2 = height * scale[2] - n0 * origin[0, 2] - n1 * origin[1, 2] - n2 * origin[2, 2] - beams.near[k] * across2
    x, y, half_x, half_y = beams.extent[k]
    middle, reach = across0 * x + across1 * y + across2, abs(across0) * half_x + abs(across1) * half_y
    way, ways = ahead0 * x + ahead1 * y + ahead2, abs(ahead0) * half_x + abs(ahead1) * half_y
    for side in range(2):
        # From the back first: N > 0.
        sign = 1.0 - 2.0 * side
        if not (sign * middle + reach >= 0.0 and sign * way + ways >= 0.0) or (side == 0 and sees == FRONTS):
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
        work.pair[pairs, 0], work.pair[pairs, 1], work.pair[pairs, 2] = k, face, side
        pairs += 1
    return pairs


@compiled
def fill(
    beams: Beams,
    frames: Frames,
    tree: BoxTree,
    group: np.ndarray,
    own: Own,
    sights: Sights,
    by_rays: bool,
    first: int,
    stop: int,
    work: Workspace,
) -> tuple[int, int]:
    """What ray triangles from `first` to `stop` may see of the triangles of a tree.

    Parameters
    ----------
    beams, frames
    tree : BoxTree
    group : (M,) int32
        The group that each scene triangle belongs to, by the caller's numbers.
    own : Own
    sights : Sights
        Tells which samples each ray triangle has.
    by_rays : bool
        Whether boxes that no sample's ray passes are left out, too.
    first, stop : int
    work : Workspace
        Filled.

    Returns
    -------
    following, pairs : int
        The ray triangle whose pairs no longer fitted, or `stop`; and how many there are.
    """
    pairs = 0
    for k in range(first, stop):
        whole = pairs
        count = _gather(beams, sights, k, work) if by_rays else 0
        node = 0
        while node < len(tree.size):
            half = vector(tree.half[node])
            # Without a triangle there is a single node, and an empty one.
            passed = half[0] >= 0.0
            if passed and count > 0:
                passed = _passes(work, count, vector(tree.middle[node]), half)
            elif passed:
                shape = (half[0], half[1], half[2], 0.0, 0.0, 0.0)
                passed = seen_weights(frames, k, vector(tree.middle[node]), shape, True)[0]
            if not passed:
                node += tree.size[node]
                continue
            for place in range(tree.first[node], tree.first[node] + tree.held[node]):
                pairs = _meet(beams, tree, group, own, k, place, work, pairs)
                if pairs < 0:
                    return k, whole
            node += 1
    return stop, pairs
