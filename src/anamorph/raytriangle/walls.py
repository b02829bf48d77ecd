"""Whether a box meets the volume that a camera's rays fill, by the volume's three side walls. Compiled.

The wall between the rays p_j + t d_j and p_k + t d_k is ruled: its lines join the two points of one t. A box meets the
volume where one of these meets it, and else nowhere:

1. the triangle of the origins p_i, which is the volume's end; the box around it is asked in its place;
2. one of the three rays;
3. a wall, which then cuts an edge of the box, because what it cuts out of a face is bounded by the face's frame or by
   one of the above;
4. or a corner of the box lies in the volume: the box is inside it, or a part of the box is where the sweeping triangle
   touches it with its middle and turns back.

Source: Mei, Popescu and Sacks 2007, section 5.2. Deviation: the paper has 3, and 4 for any one corner. Without 1, it
would miss boxes at the origins; without 2, faces from whose middle a wall cuts a piece; without the other corners of 4,
boxes of which a part is seen twice. Boxes are widened by what rounding takes, and what lies beyond a plane of the
camera's hull is told before.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from anamorph.base.compiled import compiled, inlined, over_all_cores
from anamorph.base.vectors import Vector, along
from anamorph.raytriangle.bounds import PAD, ROUNDING, before_hull, size_of
from anamorph.raytriangle.camera_frames import Frames, vector
from anamorph.raytriangle.rows import SHIFT, packed
from anamorph.raytriangle.scaled import scaled_rays
from anamorph.raytriangle.solve import COUNT, NOWHERE, ROOT, ROOTS, WORDS, solve_point

GRAIN = 1024

NOISE = 1e-13
"""A sum of less than this share of its terms is rounding."""

OPPOSITE = -1.0 + 1e-9
"""The cosine between two directions of which, somewhere in the wall between them, nothing is left."""

OUTSIDE = 1e-9
"""How far beyond 0 and 1 the weights of a ray in the volume may be."""

SPACE = WORDS + 8
"""Numbers of work space, for a corner's projections."""


class Walls(NamedTuple):
    """Cameras, K of them, as this test reads them besides their frames."""

    origins: np.ndarray
    """(K, 3, 3) float64: the p_i from the camera's origin."""
    directions: np.ndarray
    """(K, 3, 3) float64"""
    rows: np.ndarray
    """(K, 46) float64: see `anamorph.raytriangle.rows`."""
    broken: np.ndarray
    """(K,) bool: whether a wall has a line without a direction, so that nothing is told of the camera."""


def walls_of(origins: np.ndarray, directions: np.ndarray) -> Walls:
    """The walls of cameras with these rays, (K, 3, 3) float64 each."""
    lengths = np.linalg.norm(directions, axis=2)
    cosine = np.einsum("kij,kij->ki", directions, np.roll(directions, 1, axis=1))
    broken = ~(cosine > OPPOSITE * lengths * np.roll(lengths, 1, axis=1)).all(axis=1)
    solvable = np.where(broken[:, None, None], np.eye(3), directions)
    around = origins - origins.sum(axis=1, keepdims=True) / 3.0
    return Walls(around, np.ascontiguousarray(directions, float), packed(scaled_rays(around, solvable)), broken)


@inlined
def meets_volume(frames: Frames, walls: Walls, c: int, middle: Vector, half: Vector, space: np.ndarray) -> bool:
    """Whether a box meets the volume of camera c; `space` (26,) float64 is work space."""
    place = along(middle, -1.0, vector(frames.origin[c]))
    size = size_of(frames, c, place)
    if before_hull(frames, c, place, (half[0], half[1], half[2], 0.0, 0.0, 0.0), True, size):
        return False
    if walls.broken[c]:
        return True
    pad = ROUNDING * size
    reach = ((1.0 + PAD) * half[0] + pad, (1.0 + PAD) * half[1] + pad, (1.0 + PAD) * half[2] + pad)
    low, high = along(place, -1.0, reach), along(place, 1.0, reach)
    p, d = walls.origins[c], walls.directions[c]
    if _meets_origins(p, low, high):
        return True
    for i in range(3):
        if _ray_meets(vector(p[i]), vector(d[i]), low, high):
            return True
    for i in range(3):
        if _cuts_edges(vector(p[i]), vector(p[i - 1]), vector(d[i]), vector(d[i - 1]), low, high):
            return True
    return _corner_seen(walls.rows[c], low, high, space[:WORDS], space[WORDS:])


@inlined
def _meets_origins(p: np.ndarray, low: Vector, high: Vector) -> bool:
    meets = True
    for k in range(3):
        meets &= min(p[0, k], p[1, k], p[2, k]) <= high[k] and max(p[0, k], p[1, k], p[2, k]) >= low[k]
    return meets


@inlined
def _ray_meets(p: Vector, d: Vector, low: Vector, high: Vector) -> bool:
    first, last = 0.0, math.inf
    for k in range(3):
        if d[k] == 0.0:
            if p[k] < low[k] or p[k] > high[k]:
                return False
        else:
            one, other = (low[k] - p[k]) / d[k], (high[k] - p[k]) / d[k]
            first, last = max(first, min(one, other)), min(last, max(one, other))
    return first <= last


@inlined
def _cuts_edges(p: Vector, q: Vector, d: Vector, e: Vector, low: Vector, high: Vector) -> bool:
    """Whether the wall between two rays meets an edge of a box."""
    to, turn = along(q, -1.0, p), along(e, -1.0, d)
    for k in range(3):
        i, j = (k + 1) % 3, (k + 2) % 3
        for corner in range(4):
            away_i, away_j = (high if corner & 1 else low)[i] - p[i], (high if corner & 2 else low)[j] - p[j]
            # On the line along axis k, away - a to = t (d + a turn) for the coordinates i and j: t is eliminated.
            at_0 = away_i * d[j], away_j * d[i]
            first = away_i * turn[j], away_j * turn[i], to[i] * d[j], to[j] * d[i]
            second = to[j] * turn[i], to[i] * turn[j]
            c, b, a = at_0[0] - at_0[1], first[0] - first[1] - first[2] + first[3], second[0] - second[1]
            lost_c, lost_a = NOISE * (abs(at_0[0]) + abs(at_0[1])), NOISE * (abs(second[0]) + abs(second[1]))
            lost_b = NOISE * (abs(first[0]) + abs(first[1]) + abs(first[2]) + abs(first[3]))
            if abs(c) <= lost_c and abs(b) <= lost_b and abs(a) <= lost_a:
                # Rounding cannot tell the line from one in the wall.
                return True
            square = b * b - 4.0 * a * c
            if square < -2.0 * (abs(b) * lost_b + 2.0 * (abs(a) * lost_c + abs(c) * lost_a)):
                continue
            larger = -0.5 * (b + math.copysign(math.sqrt(max(square, 0.0)), b))
            for weight in (larger / a, c / larger):
                if -OUTSIDE <= weight <= 1.0 + OUTSIDE:
                    slope_i, slope_j = d[i] + weight * turn[i], d[j] + weight * turn[j]
                    upright = abs(slope_i) >= abs(slope_j)
                    t = (away_i - weight * to[i]) / slope_i if upright else (away_j - weight * to[j]) / slope_j
                    place = p[k] + weight * to[k] + t * (d[k] + weight * turn[k])
                    if t >= 0.0 and low[k] <= place <= high[k]:
                        return True
    return False


@inlined
def _corner_seen(row: np.ndarray, low: Vector, high: Vector, solved: np.ndarray, found: np.ndarray) -> bool:
    """Whether a corner of a box has a projection in the volume."""
    for corner in range(8):
        x, y, z = (high if corner & 1 else low)[0], (high if corner & 2 else low)[1], (high if corner & 4 else low)[2]
        solve_point(row, x, y, z, found, solved)
        for k in range(ROOTS, ROOTS + ROOT * int(solved[COUNT]), ROOT):
            t, u, v = solved[k] + row[SHIFT], solved[k + 1], solved[k + 2]
            if solved[k + 3] != NOWHERE and t >= 0.0 and min(u, v, 1.0 - u - v) >= -OUTSIDE:
                return True
    return False


def volumes_met(frames: Frames, walls: Walls, camera: np.ndarray, middle: np.ndarray, half: np.ndarray) -> np.ndarray:
    """Whether box n meets the volume of camera[n], (N,) bool.

    Parameters
    ----------
    frames : Frames
    walls : Walls
        Of the same cameras.
    camera : (N,) int64
    middle, half : (N, 3) float64
        The boxes' middles, and half their sides, metres.
    """
    met = np.zeros(len(camera), bool)

    def work(start: int, stop: int) -> None:
        _meet(frames, walls, camera, middle, half, np.empty(SPACE), met, start, stop)

    over_all_cores(work, len(camera), GRAIN)
    return met


@compiled
def _meet(
    frames: Frames,
    walls: Walls,
    camera: np.ndarray,
    middle: np.ndarray,
    half: np.ndarray,
    space: np.ndarray,
    met: np.ndarray,
    start: int,
    stop: int,
) -> None:
    for n in range(start, stop):
        met[n] = meets_volume(frames, walls, camera[n], vector(middle[n]), vector(half[n]), space)
