"""A tree of ray cones: which pieces of a mirror or a lens may send a ray of the eye to a point.

Each node holds a ball around where the rays of its pieces leave the mirror or the lens, a cone around their directions
there, and whether a piece turns its front to the eye. A ray that starts in the ball and goes in a direction of the cone
can reach a point only under one condition. Seen from the ball's middle, the angle between the cone's axis and the point
must not exceed the angles of the cone and the ball together.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from anamorph.base.compiled import compiled
from anamorph.optics.laws import reflect
from anamorph.raytriangle.rows import packed
from anamorph.raytriangle.scaled import scaled_rays
from anamorph.reflections.charts import Chart

PAD = 0.2
"""How far outside a piece, in its weights, a ray may start that is still the piece's own."""

WIDER = 1.0 + 3.0 * PAD
"""How much larger a triangle is whose weights may be below 0 by that."""

SLACK = 1.04
"""Balls and cones hold the curved piece between its corners, too."""


class ConeTree(NamedTuple):
    """The pieces of a mirror or a lens before an eye.

    Parameters
    ----------
    order : (P,) int64
        The pieces, so that each node of the tree has a range of them.
    balls : (2 L, 4) float64
        Middle and radius of each node, the root at 1 and the children of i at 2 i and 2 i + 1; a radius below 0 is no
        ball. Of L leaves each has one piece or none.
    cones : (2 L, 5) float64
        Axis, cosine and sine of the angle; cosine below -1 holds all directions, and above 1 none: no front is seen.
    rows : (R, 46) float64
        The ray triangles of pieces whose front is seen.
    row_of : (P,) int64
        Which of these each piece has; -1 for none.
    """

    order: np.ndarray
    balls: np.ndarray
    cones: np.ndarray
    rows: np.ndarray
    row_of: np.ndarray


class CornerRays(NamedTuple):
    """The rays of an eye that leave a mirror or a lens, at the corners of the pieces they came by.

    Parameters
    ----------
    origins, directions : (P, 3, 3) float64
        Directions as long as the eye's distance from where its ray came by.
    seen : (P,) bool
        Whether the front of a piece is seen.
    """

    origins: np.ndarray
    directions: np.ndarray
    seen: np.ndarray


def reflected(chart: Chart, eye: np.ndarray) -> CornerRays:
    """What a mirror makes of the rays of an eye at (3,)."""
    offsets = chart.positions - eye
    directions = reflect(offsets.reshape(-1, 3), chart.normals.reshape(-1, 3)).reshape(offsets.shape)
    return CornerRays(chart.positions, directions, front_seen(chart, offsets))


def front_seen(chart: Chart, offsets: np.ndarray) -> np.ndarray:
    """Of which pieces an eye sees the front, (P,) bool, if `offsets` (P, 3, 3) lead from it to their corners."""
    distances = np.linalg.norm(offsets, axis=2)
    facing = -np.einsum("pki,pki->pk", offsets, chart.normals) / np.maximum(distances, np.finfo(float).tiny)
    # Where the front of a piece is seen between its corners only, one of them is not far from showing it.
    return facing.max(axis=1) + PAD * np.ptp(facing, axis=1) > 0.0


def ordered(positions: np.ndarray) -> np.ndarray:
    """The order of pieces with corners at `positions` (P, 3, 3), (P,): the same for all eyes."""
    count = len(positions)
    middles = positions.mean(axis=1)
    leaves = 1 << max(count - 1, 0).bit_length()
    order = np.arange(count)
    parts = 1
    while parts < leaves:
        starts = np.arange(parts + 1) * count // parts
        part = np.repeat(np.arange(parts), np.diff(starts))
        own = middles[order]
        filled = starts[:-1][np.diff(starts) > 0]
        spread = np.zeros((parts, 3))
        spread[np.diff(starts) > 0] = np.maximum.reduceat(own, filled) - np.minimum.reduceat(own, filled)
        along = own[np.arange(count), spread.argmax(axis=1)[part]]
        order = order[np.lexsort([along, part])]
        parts *= 2
    return order


def balls_around(order: np.ndarray, positions: np.ndarray, seen: np.ndarray | None = None) -> np.ndarray:
    """The balls of the tree of pieces in their `order`, around corners at `positions` (P, 3, 3).

    Only pieces that are `seen`, (P,) bool, have one; without it all have.
    """
    middles = positions.mean(axis=1)
    radii = WIDER * SLACK * np.linalg.norm(positions - middles[:, None], axis=2).max(axis=1)
    leaves = 1 << max(len(order) - 1, 0).bit_length()
    balls = np.full((2 * leaves, 4), -1.0)
    piece = _leaves(order, leaves)
    held = piece >= 0 if seen is None else (piece >= 0) & seen[piece]
    balls[leaves:][held, :3], balls[leaves:][held, 3] = middles[piece[held]], radii[piece[held]]
    _join_balls(balls, leaves)
    return balls


def cone_tree(rays: CornerRays, order: np.ndarray, balls: np.ndarray) -> ConeTree:
    """The tree of pieces in their `order`, with `balls` around where their rays leave."""
    seen = rays.seen
    row_of = np.full(len(seen), -1)
    row_of[seen] = np.arange(seen.sum())
    rows = packed(scaled_rays(rays.origins[seen], rays.directions[seen])) if seen.any() else np.zeros((0, 46))
    lengths = np.linalg.norm(rays.directions, axis=2, keepdims=True)
    units = rays.directions / np.maximum(lengths, np.finfo(float).tiny)
    axes = units.sum(axis=1)
    lengths = np.linalg.norm(axes, axis=1, keepdims=True)
    axes /= np.maximum(lengths, np.finfo(float).tiny)
    chords = np.linalg.norm(units - axes[:, None], axis=2).max(axis=1)
    angles = np.where(lengths[:, 0] < 0.5, np.pi, WIDER * SLACK * 2.0 * np.arcsin(np.minimum(chords / 2.0, 1.0)) + 1e-7)
    leaves = len(balls) // 2
    cones = np.zeros((2 * leaves, 5))
    cones[:, 3] = 2.0
    piece = _leaves(order, leaves)
    held = np.flatnonzero((piece >= 0) & seen[piece])
    own = piece[held]
    wide = angles[own] >= np.pi / 2.0
    cones[leaves + held, :3] = axes[own]
    cones[leaves + held, 3] = np.where(wide, -2.0, np.cos(angles[own]))
    cones[leaves + held, 4] = np.sin(angles[own])
    _join_cones(cones, leaves)
    return ConeTree(order, balls, cones, rows, row_of)


def _leaves(order: np.ndarray, leaves: int) -> np.ndarray:
    """The piece of each leaf, or -1."""
    starts = np.arange(leaves + 1) * len(order) // leaves
    return np.where(np.diff(starts) > 0, order[np.minimum(starts[:-1], len(order) - 1)], -1)


@compiled
def _join_balls(balls: np.ndarray, leaves: int) -> None:
    for node in range(leaves - 1, 0, -1):
        one, other = 2 * node, 2 * node + 1
        if balls[one, 3] < balls[other, 3]:
            one, other = other, one
        x, y, z = (balls[other, 0] - balls[one, 0], balls[other, 1] - balls[one, 1], balls[other, 2] - balls[one, 2])
        apart = math.sqrt(x * x + y * y + z * z)
        share, radius = 0.0, balls[one, 3]
        if balls[other, 3] >= 0.0 and apart + balls[other, 3] > radius:
            radius = 0.5 * (apart + balls[one, 3] + balls[other, 3])
            share = (radius - balls[one, 3]) / apart
        balls[node, 0] = balls[one, 0] + share * x
        balls[node, 1] = balls[one, 1] + share * y
        balls[node, 2] = balls[one, 2] + share * z
        balls[node, 3] = radius * (1.0 + 1e-12)


@compiled
def _join_cones(cones: np.ndarray, leaves: int) -> None:
    for node in range(leaves - 1, 0, -1):
        one, other = 2 * node, 2 * node + 1
        if cones[one, 3] > cones[other, 3]:
            one, other = other, one
        for k in range(5):
            cones[node, k] = cones[one, k]
        if cones[one, 3] < -1.0 or cones[other, 3] > 1.0:
            continue
        cosine = cones[one, 0] * cones[other, 0] + cones[one, 1] * cones[other, 1] + cones[one, 2] * cones[other, 2]
        apart = math.acos(min(max(cosine, -1.0), 1.0))
        wide, narrow = math.acos(cones[one, 3]), math.acos(cones[other, 3])
        if apart + narrow <= wide:
            continue
        angle = 0.5 * (apart + wide + narrow)
        if angle >= 0.5 * math.pi:
            cones[node, 3] = -2.0
            continue
        # Turned from the wider cone's axis towards the other's.
        turn = angle - wide
        a, b = math.sin(apart - turn) / math.sin(apart), math.sin(turn) / math.sin(apart)
        for k in range(3):
            cones[node, k] = a * cones[one, k] + b * cones[other, k]
        cones[node, 3], cones[node, 4] = math.cos(angle + 1e-9), math.sin(angle + 1e-9)


@compiled
def may_reach(balls: np.ndarray, cones: np.ndarray, node: int, x: float, y: float, z: float) -> bool:
    """Whether a ray of a node may pass through a point."""
    if cones[node, 3] > 1.0:
        return False
    x, y, z = x - balls[node, 0], y - balls[node, 1], z - balls[node, 2]
    beyond = x * x + y * y + z * z - balls[node, 3] * balls[node, 3]
    if beyond <= 0.0 or cones[node, 3] < -1.0:
        return True
    ahead = x * cones[node, 0] + y * cones[node, 1] + z * cones[node, 2]
    return ahead >= cones[node, 3] * math.sqrt(beyond) - cones[node, 4] * balls[node, 3]


@compiled
def in_ball(balls: np.ndarray, node: int, x: float, y: float, z: float) -> bool:
    """Whether a point is in the ball of a node."""
    radius = balls[node, 3]
    x, y, z = x - balls[node, 0], y - balls[node, 1], z - balls[node, 2]
    return radius >= 0.0 and x * x + y * y + z * z <= radius * radius
