"""A tree over the tiles of an image: what bounds the rays that leave through each, and through many together. Compiled.

A node holds a ball around the starts of its rays and a cone around their directions: all that its rays can meet is in
the cone that is as much wider as the ball is large.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from anamorph.base.compiled import compiled
from anamorph.base.vectors import Vector, dot

TILE_RAYS = np.dtype(
    [("low", "f4", 3), ("count", "u4"), ("high", "f4", 3), ("cosine", "f4"), ("axis", "f4", 3), ("padding", "u4")]
)
"""`TileRays` of tiles.wgsl."""

ROUNDING = 1e-6
"""Of starts, as a share of their coordinates, and of directions, radians: what is packed for the device is rounded."""

THIN = 1e-6
"""Sine of an angle of a triangle that rounding alone may have made: it has no plane."""

WIDEST = 0.5 * math.pi
"""Angle of a cone that bounds nothing."""


class TileTree(NamedTuple):
    """Nodes of all levels, the tiles first: N of them.

    Parameters
    ----------
    columns, first : (levels + 1,) int64
        How many nodes each row of a level has, and the number of its first one; the last one has none.
    balls : (N, 4) float64
        Middle and radius, metres; a radius below 0 has no rays.
    cones : (N, 5) float64
        Axis, and cosine and sine of the angle; a cosine of 0 holds all directions.
    """

    columns: np.ndarray
    first: np.ndarray
    balls: np.ndarray
    cones: np.ndarray


def tile_tree(rays: np.ndarray) -> TileTree:
    """The tree over tiles (rows, columns) of TILE_RAYS."""
    rows, columns = rays.shape
    widths, heights = [columns], [rows]
    while widths[-1] > 1 or heights[-1] > 1:
        widths.append(-(-widths[-1] // 2))
        heights.append(-(-heights[-1] // 2))
    first = np.concatenate([[0], np.cumsum(np.multiply(widths, heights))])
    balls, cones = np.full((first[-1], 4), -1.0), np.zeros((first[-1], 5))
    count = rows * columns
    low, high = (rays[name].reshape(count, 3).astype(float) for name in ("low", "high"))
    held = rays["count"].ravel() > 0
    middle = 0.5 * (low + high)
    radius = 0.5 * np.linalg.norm(high - low, axis=1) + ROUNDING * np.abs(middle).max(axis=1)
    balls[:count][held] = np.column_stack([middle, radius])[held]
    axis = rays["axis"].reshape(count, 3).astype(float)
    angle = np.arccos(np.clip(rays["cosine"].ravel().astype(float), -1.0, 1.0)) + 1e3 * ROUNDING
    cones[:count, :3] = axis / np.maximum(np.linalg.norm(axis, axis=1, keepdims=True), np.finfo(float).tiny)
    cones[:count, 3], cones[:count, 4] = np.cos(angle), np.sin(angle)
    cones[:count][angle >= WIDEST, 3:] = 0.0, 1.0
    tree = TileTree(np.array([*widths, 0]), first, balls, cones)
    for level in range(1, len(widths)):
        _join(tree, level, heights[level - 1])
    return tree


@compiled
def _join(tree: TileTree, level: int, rows: int) -> None:
    """Fill a level from the one below it, which has so many rows."""
    columns, below = tree.columns[level], tree.columns[level - 1]
    for node in range(tree.first[level], tree.first[level + 1]):
        place = node - tree.first[level]
        row, column = place // columns, place % columns
        for i in range(2 * row, min(2 * row + 2, rows)):
            for j in range(2 * column, min(2 * column + 2, below)):
                _widen(tree, node, tree.first[level - 1] + i * below + j)


@compiled
def _widen(tree: TileTree, node: int, other: int) -> None:
    """Have a node hold another one, too."""
    balls, cones = tree.balls, tree.cones
    if balls[other, 3] < 0.0:
        return
    if balls[node, 3] < 0.0:
        for k in range(4):
            balls[node, k] = balls[other, k]
        for k in range(5):
            cones[node, k] = cones[other, k]
        return
    x, y, z = balls[other, 0] - balls[node, 0], balls[other, 1] - balls[node, 1], balls[other, 2] - balls[node, 2]
    apart = math.sqrt(x * x + y * y + z * z)
    if apart + balls[other, 3] > balls[node, 3]:
        if apart + balls[node, 3] <= balls[other, 3]:
            share, radius = 1.0, balls[other, 3]
        else:
            radius = 0.5 * (apart + balls[node, 3] + balls[other, 3])
            share = (radius - balls[node, 3]) / apart
        balls[node, 0] += share * x
        balls[node, 1] += share * y
        balls[node, 2] += share * z
        balls[node, 3] = radius * (1.0 + 1e-12)
    if cones[node, 3] <= 0.0 or cones[other, 3] <= 0.0:
        cones[node, 3], cones[node, 4] = 0.0, 1.0
        return
    cosine = cones[node, 0] * cones[other, 0] + cones[node, 1] * cones[other, 1] + cones[node, 2] * cones[other, 2]
    apart = math.acos(min(max(cosine, -1.0), 1.0))
    one, two = math.atan2(cones[node, 4], cones[node, 3]), math.atan2(cones[other, 4], cones[other, 3])
    if apart + two <= one:
        return
    if apart + one <= two:
        for k in range(5):
            cones[node, k] = cones[other, k]
        return
    angle = 0.5 * (apart + one + two)
    if angle >= WIDEST - 1e-6:
        cones[node, 3], cones[node, 4] = 0.0, 1.0
        return
    # Turned from its axis towards the other's.
    turn = angle - one
    a, b = math.sin(apart - turn) / math.sin(apart), math.sin(turn) / math.sin(apart)
    for k in range(3):
        cones[node, k] = a * cones[node, k] + b * cones[other, k]
    cones[node, 3], cones[node, 4] = math.cos(angle + 1e-9), math.sin(angle + 1e-9)


@compiled
def may_reach(tree: TileTree, node: int, x: float, y: float, z: float, size: float) -> bool:
    """Whether rays of a node may meet a ball around (x, y, z), of radius `size`."""
    radius = tree.balls[node, 3]
    if radius < 0.0:
        return False
    x, y, z = x - tree.balls[node, 0], y - tree.balls[node, 1], z - tree.balls[node, 2]
    reach = radius + size
    beyond = x * x + y * y + z * z - reach * reach
    cosine = tree.cones[node, 3]
    if beyond <= 0.0 or cosine <= 0.0:
        return True
    ahead = x * tree.cones[node, 0] + y * tree.cones[node, 1] + z * tree.cones[node, 2]
    return ahead >= cosine * math.sqrt(beyond) - tree.cones[node, 4] * reach


@compiled
def may_meet(tree: TileTree, node: int, a: Vector, b: Vector, c: Vector) -> bool:
    """Whether rays of a node may meet the triangle a, b, c, as far as planes through its sides and its own tell."""
    radius = tree.balls[node, 3]
    start = (tree.balls[node, 0], tree.balls[node, 1], tree.balls[node, 2])
    axis = (tree.cones[node, 0], tree.cones[node, 1], tree.cones[node, 2])
    sine = tree.cones[node, 4]
    if tree.cones[node, 3] <= 0.0:
        return True
    e = (b[0] - a[0], b[1] - a[1], b[2] - a[2])
    f = (c[0] - a[0], c[1] - a[1], c[2] - a[2])
    normal = (e[1] * f[2] - e[2] * f[1], e[2] * f[0] - e[0] * f[2], e[0] * f[1] - e[1] * f[0])
    length = math.sqrt(dot(normal, normal))
    if length > THIN * math.sqrt(dot(e, e) * dot(f, f)):
        # All rays start on one side of its plane, and none comes nearer to it.
        height = dot(normal, (start[0] - a[0], start[1] - a[1], start[2] - a[2]))
        slope = dot(normal, axis)
        if abs(height) > radius * length and (slope if height > 0.0 else -slope) >= sine * length:
            return False
    return not (
        _passes(start, radius, axis, sine, a, b, c)
        or _passes(start, radius, axis, sine, b, c, a)
        or _passes(start, radius, axis, sine, c, a, b)
    )


@compiled
def _passes(start: Vector, radius: float, axis: Vector, sine: float, p: Vector, q: Vector, other: Vector) -> bool:
    """Whether a plane through an edge p, q has the triangle on one side, and all rays on the other."""
    e = (q[0] - p[0], q[1] - p[1], q[2] - p[2])
    square = dot(e, e)
    if square == 0.0:
        return False
    w = (start[0] - p[0], start[1] - p[1], start[2] - p[2])
    share = dot(w, e) / square
    w = (w[0] - share * e[0], w[1] - share * e[1], w[2] - share * e[2])
    away = math.sqrt(dot(w, w))
    if not away > radius:
        return False
    w = (w[0] / away, w[1] / away, w[2] / away)
    scale = 1.0 / math.sqrt(square)
    u = (scale * (e[1] * w[2] - e[2] * w[1]), scale * (e[2] * w[0] - e[0] * w[2]), scale * (e[0] * w[1] - e[1] * w[0]))
    # Of the planes that do not cut the ball, the one from which the axis leads away most.
    up, side = dot(axis, w), dot(axis, u)
    length = math.sqrt(up * up + side * side)
    if not length > 0.0:
        return False
    up, side = up / length, side / length
    if up * away < radius:
        up = radius / away
        side = math.copysign(math.sqrt(max(1.0 - up * up, 0.0)), side)
    m = (up * w[0] + side * u[0], up * w[1] + side * u[1], up * w[2] + side * u[2])
    if dot(axis, m) < sine:
        return False
    return dot(m, (other[0] - p[0], other[1] - p[1], other[2] - p[2])) <= 0.0
