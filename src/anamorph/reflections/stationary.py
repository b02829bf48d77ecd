"""Newton's iteration from many starts, to where the length of the path is stationary. Compiled.

Where two reflection points are about to merge, both may lie near the same start, which leads to one of them. So for
each that is found a start is named for its twin: along the way in which the length bends least, if this bend is b and
changes by c a metre, the twin is -2 b / c away.

Between two such places the length hardly bends, and Newton's steps from there lead anywhere. A start that leads nowhere
is tried again with steps that take the slope for a parabola.
"""

from __future__ import annotations

import math

import numpy as np

from anamorph.base.compiled import compiled
from anamorph.base.vectors import Vector, along, dot
from anamorph.reflections.path_length import Frame, Slopes, in_parameters, slopes_at, tangents_at
from anamorph.surfaces.expansion import shifted

STEPS = 16
FOLD_STEPS = 12
CLOSE = 1e-12
"""A step shorter than this share of the mirror's size is the last."""
NEAR = 1e-9
"""A search that ends with a longer step has found nothing."""
LEVEL = 1e-8
"""The greatest slope that counts as none: beside a fold the length has places without a bend that have a slope."""

DAMPING = 1e-7
"""The share of the greatest bend below which the length counts as flat, and no step is taken."""

FLAT = 1e-6
"""The least bend below which a reflection point is a focus, as a share of that on a flat mirror in its direction."""

AT_TWIN = 3.0
"""Pieces: a twin further away has been found by itself."""

AHEAD = 0.25
"""Pieces: how far away the change of the bend is measured."""

POSITION, PLACE, NORMAL, LENGTH, ORDER, TWIN, WORDS = 0, 3, 6, 9, 10, 11, 14
"""Where the numbers of a reflection point are in its row. The place of a twin that is not sought is NaN."""


@compiled
def settle(
    kind: int,
    numbers: np.ndarray,
    size: float,
    eye: Vector,
    points: np.ndarray,
    places: np.ndarray,
    lengths: np.ndarray,
    at_folds: bool,
    start: int,
    stop: int,
    out: np.ndarray,
    ok: np.ndarray,
) -> None:
    """Search from `places`, start to stop.

    Parameters
    ----------
    kind, numbers, size
        The mirror.
    eye : three float64
    points, places : (S, 3) float64
        What is sought, and where the search starts.
    lengths : (S,) float64
        Of the piece that it starts in: no step is longer than twice that.
    at_folds : bool
        Whether to search only where two places may be about to merge, and first by steps that know of both.
    out : (S, 14) float64
        Filled.
    ok : (S,) bool
        Whether something was found.
    """
    for i in range(start, stop):
        point = (points[i, 0], points[i, 1], points[i, 2])
        place = (places[i, 0], places[i, 1], places[i, 2])
        length = math.inf
        steps = -FOLD_STEPS if at_folds else 0
        ahead = AHEAD * lengths[i]
        while True:
            fine, position, normal, frame, slopes = slopes_at(kind, numbers, place, eye, point)
            if not fine or length <= CLOSE * size or steps == STEPS:
                break
            if steps < 0:
                weak, x, y = bends(slopes)
                change = _change(kind, numbers, place, eye, point, frame, ahead, x, y)
                if steps == -FOLD_STEPS and abs(weak) > AT_TWIN * lengths[i] * abs(change):
                    fine = False
                    break
                x, y = folded(slopes, weak, x, y, change)
            else:
                x, y = newton(slopes)
            length = math.hypot(x, y)
            share = 2.0 * lengths[i] / length if length > 2.0 * lengths[i] else 1.0
            a, b = in_parameters(frame, share * x, share * y)
            place = shifted(kind, place, a, b)
            steps += 1
        ok[i] = fine and length <= NEAR * size and math.hypot(slopes[0], slopes[1]) <= LEVEL
        if not ok[i]:
            continue
        weak, x, y = bends(slopes)
        to_eye, to_point = along(eye, -1.0, position), along(point, -1.0, position)
        far, near = math.sqrt(dot(to_eye, to_eye)), math.sqrt(dot(to_point, to_point))
        _, _, _, one, other, _ = tangents_at(kind, numbers, place)
        way = along(along((0.0, 0.0, 0.0), x, one), y, other)
        spread = (1.0 - (dot(way, to_eye) / far) ** 2) / far + (1.0 - (dot(way, to_point) / near) ** 2) / near
        focus = abs(weak) <= FLAT * spread
        change = _change(kind, numbers, place, eye, point, frame, ahead, x, y)
        twin = (np.nan, np.nan, np.nan)
        if not focus and 2.0 * abs(weak) <= AT_TWIN * lengths[i] * abs(change):
            a, b = in_parameters(frame, -2.0 * weak / change * x, -2.0 * weak / change * y)
            twin = shifted(kind, place, a, b)
        for axis in range(3):
            out[i, POSITION + axis], out[i, PLACE + axis] = position[axis], place[axis]
            out[i, NORMAL + axis], out[i, TWIN + axis] = normal[axis], twin[axis]
        out[i, LENGTH] = far + near
        out[i, ORDER] = 0.0 if focus else math.copysign(1.0, slopes[2] * slopes[5] - slopes[3] * slopes[4])


@compiled
def _change(
    kind: int,
    numbers: np.ndarray,
    place: Vector,
    eye: Vector,
    point: Vector,
    frame: Frame,
    ahead: float,
    x: float,
    y: float,
) -> float:
    """How much the bend along (x, y) changes a metre, from places `ahead` on both sides: their slopes cancel but for
    that."""
    a, b = in_parameters(frame, ahead * x, ahead * y)
    change = 0.0
    for side in (-1.0, 1.0):
        fits, _, _, there, others = slopes_at(kind, numbers, shifted(kind, place, side * a, side * b), eye, point)
        if fits:
            change += others[0] * (there[0] * a + there[1] * b) + others[1] * there[2] * b
    return change / (ahead * ahead * ahead)


@compiled
def folded(slopes: Slopes, weak: float, x: float, y: float, change: float) -> tuple[float, float]:
    """A step to the nearer of two places that lie along (x, y), the direction of the least bend `weak`.

    Along it the slope is a parabola, because the bend changes; where it has no roots the step is to its top. Across it
    the step is Newton's.
    """
    slope, beside = slopes[0] * x + slopes[1] * y, slopes[1] * x - slopes[0] * y
    strong = slopes[2] + slopes[5] - weak
    inside = weak * weak - 2.0 * slope * change
    if inside > 0.0:
        step = -2.0 * slope / (weak + math.copysign(math.sqrt(inside), weak))
    else:
        step = -weak / change if change != 0.0 else 0.0
    aside = -beside / strong if strong != 0.0 else 0.0
    return step * x - aside * y, step * y + aside * x


@compiled
def newton(slopes: Slopes) -> tuple[float, float]:
    """The step to where both slopes vanish, by least squares with some damping: none along a curve of solutions."""
    one, other, xx, xy, yx, yy = slopes
    damping = (DAMPING * max(max(abs(xx), abs(xy)), max(abs(yx), abs(yy)))) ** 2
    p, q, r = xx * xx + yx * yx + damping, xx * xy + yx * yy, xy * xy + yy * yy + damping
    determinant = p * r - q * q
    if not determinant > 0.0:
        return 0.0, 0.0
    left, right = xx * one + yx * other, xy * one + yy * other
    return (q * right - r * left) / determinant, (q * left - p * right) / determinant


@compiled
def bends(slopes: Slopes) -> tuple[float, float, float]:
    """The least bend of the length of the path, and its direction."""
    xx, xy, yy = slopes[2], 0.5 * (slopes[3] + slopes[4]), slopes[5]
    middle, half = 0.5 * (xx + yy), math.hypot(0.5 * (xx - yy), xy)
    weak = middle - half if middle > 0.0 else middle + half
    # Either row of the matrix less this bend is at right angles to the direction; the longer one says it better.
    x, y = (-xy, xx - weak) if abs(xx - weak) > abs(yy - weak) else (yy - weak, -xy)
    length = math.hypot(x, y)
    if length == 0.0:
        return weak, 1.0, 0.0
    return weak, x / length, y / length
