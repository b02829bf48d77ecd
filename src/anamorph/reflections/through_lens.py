"""Newton's iteration from many starts, to where the length of the path through a lens is stationary. Compiled.

It is that of `stationary`, with a place on the near face that is sought and one on the far face that follows.
"""

from __future__ import annotations

import math

import numpy as np

from anamorph.base.compiled import compiled
from anamorph.base.vectors import Vector, along, dot
from anamorph.reflections.lens_length import Frame, Pair, Square, lens_slopes
from anamorph.reflections.path_length import in_parameters, tangents_at
from anamorph.reflections.stationary import (
    AHEAD,
    AT_TWIN,
    CLOSE,
    FLAT,
    FOLD_STEPS,
    LENGTH,
    LEVEL,
    NEAR,
    NORMAL,
    ORDER,
    PLACE,
    POSITION,
    STEPS,
    bends,
    folded,
    newton,
)
from anamorph.surfaces.expansion import shifted

FAR_POSITION, FAR_PLACE, FAR_NORMAL, TWINS, WORDS = 11, 14, 17, 20, 26
"""Where the numbers of the far face are in the row of a refraction point, after those that a reflection point has, and
the two places of its twin, last."""


@compiled
def settle_through(
    near_kind: int,
    near_numbers: np.ndarray,
    far_kind: int,
    far_numbers: np.ndarray,
    index: float,
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
    near_kind, near_numbers, far_kind, far_numbers, index
        The lens.
    size : float
        Metres.
    eye : three float64
    points : (S, 3) float64
        What is sought.
    places : (S, 6) float64
        Where the search starts: on the near face, and on the far one.
    lengths : (S,) float64
        Of the piece that it starts in: no step on the near face is longer than twice that.
    at_folds : bool
        As for `settle`.
    out : (S, 26) float64
        Filled.
    ok : (S,) bool
        Whether something was found.
    """
    for i in range(start, stop):
        point = (points[i, 0], points[i, 1], points[i, 2])
        place, other = (places[i, 0], places[i, 1], places[i, 2]), (places[i, 3], places[i, 4], places[i, 5])
        length = math.inf
        steps = -FOLD_STEPS if at_folds else 0
        ahead = AHEAD * lengths[i]
        while True:
            fine, near, far, path, slopes, offset, follows, turned = lens_slopes(
                near_kind, near_numbers, far_kind, far_numbers, index, place, other, eye, point
            )
            if not fine or length <= CLOSE * size or steps == STEPS:
                break
            if steps < 0:
                weak, x, y = bends(slopes)
                change = _change(
                    near_kind, near_numbers, far_kind, far_numbers, index, place, other, eye, point,
                    near[2], far[2], offset, follows, ahead, x, y,
                )  # fmt: skip
                if steps == -FOLD_STEPS and abs(weak) > AT_TWIN * lengths[i] * abs(change):
                    fine = False
                    break
                x, y = folded(slopes, weak, x, y, change)
            else:
                x, y = newton(slopes)
            length = math.hypot(x, y)
            share = 2.0 * lengths[i] / length if length > 2.0 * lengths[i] else 1.0
            x, y = share * x, share * y
            length = max(length, math.hypot(*_following(offset, follows, x, y)))
            place, other = _moved(near_kind, far_kind, place, other, near[2], far[2], offset, follows, x, y)
            steps += 1
        ok[i] = fine and length <= NEAR * size and math.hypot(slopes[0], slopes[1]) <= LEVEL
        if not ok[i]:
            continue
        weak, x, y = bends(slopes)
        # At a focus, what comes after the near face undoes the bend that the eye's own distance makes.
        _, _, _, right, up, _ = tangents_at(near_kind, near_numbers, place)
        way, to_eye = along(along((0.0, 0.0, 0.0), x, right), y, up), along(eye, -1.0, near[0])
        from_eye = math.sqrt(dot(to_eye, to_eye))
        focus = abs(weak) <= FLAT * (1.0 - (dot(way, to_eye) / from_eye) ** 2) / from_eye
        change = _change(
            near_kind, near_numbers, far_kind, far_numbers, index, place, other, eye, point,
            near[2], far[2], offset, follows, ahead, x, y,
        )  # fmt: skip
        twin, its_other = (np.nan, np.nan, np.nan), (np.nan, np.nan, np.nan)
        if not focus and 2.0 * abs(weak) <= AT_TWIN * lengths[i] * abs(change):
            away = -2.0 * weak / change
            twin, its_other = _moved(
                near_kind, far_kind, place, other, near[2], far[2], offset, follows, away * x, away * y
            )
        for axis in range(3):
            out[i, POSITION + axis], out[i, FAR_POSITION + axis] = near[0][axis], far[0][axis]
            out[i, PLACE + axis], out[i, FAR_PLACE + axis] = place[axis], other[axis]
            out[i, NORMAL + axis], out[i, FAR_NORMAL + axis] = near[1][axis], far[1][axis]
            out[i, TWINS + axis], out[i, TWINS + 3 + axis] = twin[axis], its_other[axis]
        bend = slopes[2] * slopes[5] - slopes[3] * slopes[4]
        out[i, LENGTH] = path
        out[i, ORDER] = 0.0 if focus else math.copysign(1.0, -bend if turned else bend)


@compiled
def _change(
    near_kind: int,
    near_numbers: np.ndarray,
    far_kind: int,
    far_numbers: np.ndarray,
    index: float,
    place: Vector,
    other: Vector,
    eye: Vector,
    point: Vector,
    near: Frame,
    far: Frame,
    offset: Pair,
    follows: Square,
    ahead: float,
    x: float,
    y: float,
) -> float:
    """How much the bend along (x, y) changes a metre, from places `ahead` on both sides, as in `stationary`."""
    a, b = in_parameters(near, ahead * x, ahead * y)
    change = 0.0
    for side in (-ahead, ahead):
        one, two = _moved(near_kind, far_kind, place, other, near, far, offset, follows, side * x, side * y)
        fits, there, _, _, slopes, _, _, _ = lens_slopes(
            near_kind, near_numbers, far_kind, far_numbers, index, one, two, eye, point
        )
        if fits:
            change += slopes[0] * (there[2][0] * a + there[2][1] * b) + slopes[1] * there[2][2] * b
    return change / (ahead * ahead * ahead)


@compiled
def _following(offset: Pair, follows: Square, x: float, y: float) -> Pair:
    """The step on the far face that goes with one on the near face, metres."""
    return -offset[0] - follows[0] * x - follows[1] * y, -offset[1] - follows[2] * x - follows[3] * y


@compiled
def _moved(
    near_kind: int,
    far_kind: int,
    place: Vector,
    other: Vector,
    near: Frame,
    far: Frame,
    offset: Pair,
    follows: Square,
    x: float,
    y: float,
) -> tuple[Vector, Vector]:
    """Both places after a step on the near face."""
    a, b = in_parameters(near, x, y)
    c, d = in_parameters(far, *_following(offset, follows, x, y))
    return shifted(near_kind, place, a, b), shifted(far_kind, other, c, d)
