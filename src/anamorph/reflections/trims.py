"""Whether a place of a surface belongs to the mirror: the mesh ends, and the surface goes on. Compiled."""

from __future__ import annotations

import math

import numpy as np

from anamorph.base.compiled import compiled, over_all_cores
from anamorph.base.vectors import Vector, along, cross, dot
from anamorph.reflections.charts import Chart, Trim
from anamorph.reflections.cone_tree import in_ball
from anamorph.surfaces.intersection import NONE

DEPTH = 128
"""Nodes that wait on a walk down a tree, at most."""

GRAIN = 1024
"""Places that one core takes at a time."""

BESIDE = 1e-9
"""A weight this little below 0 is still on the edge, which two triangles share."""


@compiled
def _corner(triangles: np.ndarray, triangle: int, corner: int) -> Vector:
    return triangles[triangle, corner, 0], triangles[triangle, corner, 1], triangles[triangle, corner, 2]


@compiled
def in_triangle(kind: int, trim: Trim, triangle: int, place: Vector, position: Vector) -> bool:
    """Whether a place lies in a triangle of the mesh, or between its edge and the arc that this stands for.

    Edges are straight from place to place, which on a sphere are vectors from its center: there they are great circles.
    """
    if kind == NONE:
        return (
            int(place[2]) == triangle
            and place[0] >= -BESIDE
            and place[1] >= -BESIDE
            and place[0] + place[1] <= 1.0 + BESIDE
        )
    a, b, c = (
        _corner(trim.triangles, triangle, 0),
        _corner(trim.triangles, triangle, 1),
        _corner(trim.triangles, triangle, 2),
    )
    whole = dot(a, cross(b, c))
    if whole == 0.0:
        return False
    for corner in range(3):
        weight = dot(place, cross(b, c)) / whole
        arc = trim.arcs[triangle, corner]
        if arc == 0:
            if weight < -BESIDE:
                return False
        elif _outside(trim.circles, arc, position):
            return False
        a, b, c = b, c, a
    return True


@compiled
def _outside(circles: np.ndarray, arc: int, position: Vector) -> bool:
    circle = circles[abs(arc) - 1]
    axis, radius = (circle[3], circle[4], circle[5]), circle[6]
    away = along(position, -1.0, (circle[0], circle[1], circle[2]))
    height = dot(away, axis)
    if radius == 0.0:
        return height < 0.0 if arc > 0 else height > 0.0
    across = along(away, -height, axis)
    further = math.sqrt(dot(across, across)) - radius
    return further > BESIDE * radius if arc > 0 else further < -BESIDE * radius


def triangles_of(
    chart: Chart,
    order: np.ndarray,
    balls: np.ndarray,
    first: np.ndarray,
    places: np.ndarray,
    positions: np.ndarray,
) -> np.ndarray:
    """In which triangles places lie, (S,) int64; -1 for none.

    Parameters
    ----------
    chart : Chart
    order, balls
        Of its pieces: see `ConeTree`.
    first : (S,) int64
        The triangles to be tried first.
    places, positions : (S, 3) float64
    """
    triangles = first.copy()

    def work(start: int, stop: int) -> None:
        stack = np.zeros(DEPTH, np.int64)
        _belong(
            chart.kind, chart.trim, order, balls, chart.parents, places, positions, start, stop, stack, triangles
        )  # fmt: skip

    over_all_cores(work, len(places), GRAIN)
    return triangles


@compiled
def _belong(
    kind: int,
    trim: Trim,
    order: np.ndarray,
    balls: np.ndarray,
    parents: np.ndarray,
    places: np.ndarray,
    positions: np.ndarray,
    start: int,
    stop: int,
    stack: np.ndarray,
    triangles: np.ndarray,
) -> None:
    """Find in which triangle of the mesh places lie, start to stop.

    Parameters
    ----------
    kind, trim, order, balls, parents
        The mirror: see `Chart` and `ConeTree`.
    places, positions : (S, 3) float64
    stack : (128,) int64
        Work space.
    triangles : (S,) int64
        The triangle to be tried first, and then the one that holds the place: -1 for none.
    """
    leaves, count = len(balls) // 2, len(order)
    for i in range(start, stop):
        place, position = (
            (places[i, 0], places[i, 1], places[i, 2]),
            (positions[i, 0], positions[i, 1], positions[i, 2]),
        )
        if in_triangle(kind, trim, triangles[i], place, position):
            continue
        triangles[i] = -1
        waiting = 1 if kind != NONE else 0
        stack[0] = 1
        while waiting > 0:
            waiting -= 1
            node = stack[waiting]
            if not in_ball(balls, node, position[0], position[1], position[2]):
                continue
            if node < leaves:
                stack[waiting], stack[waiting + 1] = 2 * node, 2 * node + 1
                waiting += 2
                continue
            own = parents[order[(node - leaves) * count // leaves]]
            if in_triangle(kind, trim, own, place, position):
                triangles[i] = own
                break
