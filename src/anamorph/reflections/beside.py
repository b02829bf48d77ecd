"""Points beside a mirror: which of them are on it, and where to search for the others. Compiled.

A point that is nearer to a mirror than the mirror's pieces are large lies on neither side of a piece for sure, and the
rays of the piece say little. What does is the plane that touches the mirror at the point's foot.
"""

from __future__ import annotations

import math

import numpy as np

from anamorph.base.compiled import compiled
from anamorph.base.vectors import Vector, along, dot
from anamorph.reflections.path_length import in_parameters, tangents_at
from anamorph.surfaces.expansion import shifted

STEPS = 16
CLOSE = 1e-12
"""A step shorter than this share of the mirror's size is the last."""


@compiled
def beside(
    kind: int,
    numbers: np.ndarray,
    size: float,
    eye: Vector,
    points: np.ndarray,
    places: np.ndarray,
    lengths: np.ndarray,
    start: int,
    stop: int,
    feet: np.ndarray,
    away: np.ndarray,
) -> None:
    """Find the feet of points, start to stop, and from there the places where planes that touch the mirror show them.

    Parameters
    ----------
    kind, numbers, size
        The mirror.
    eye : three float64
    points : (S, 3) float64
    places : (S, 3) float64
        Where to search; replaced by where the plane reflects each point, two planes one after the other.
    lengths : (S,) float64
        Of the piece beside which the point is: no step is longer than twice that.
    feet : (S, 6) float64
        Filled with the place and the position of each foot.
    away : (S,) float64
        Filled with how far the point is from it, metres; infinite where none was found.
    """
    for i in range(start, stop):
        point, limit = (points[i, 0], points[i, 1], points[i, 2]), 2.0 * lengths[i]
        place = (places[i, 0], places[i, 1], places[i, 2])
        # Gauss and Newton's method to the foot, then twice to the plane's reflection point.
        length, steps, planes, moving = math.inf, 0, 0, True
        away[i] = math.inf
        while moving:
            ok, position, frame, one, other, normal = tangents_at(kind, numbers, place)
            if not ok:
                break
            offset = along(point, -1.0, position)
            height, over = dot(offset, normal), dot(along(eye, -1.0, position), normal)
            if planes == 0 and (length <= CLOSE * size or steps == STEPS):
                if length > 1e-3 * limit:
                    break
                planes, away[i] = 1, math.sqrt(dot(offset, offset))
                for axis in range(3):
                    feet[i, axis], feet[i, 3 + axis] = place[axis], position[axis]
            if planes > 0:
                if height * over <= 0.0:
                    break
                # Between the feet of eye and point, as their heights divide it.
                offset = along(offset, -height / (height + over), along(point, -1.0, eye))
                planes += 1
                moving = planes < 3
            x, y = dot(offset, one), dot(offset, other)
            length = math.hypot(x, y)
            share = limit / length if length > limit else 1.0
            a, b = in_parameters(frame, share * x, share * y)
            place = shifted(kind, place, a, b)
            steps += 1
        for axis in range(3):
            places[i, axis] = place[axis]
