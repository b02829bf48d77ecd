"""The errors of every pixel of a frame against the reference's last rays, compiled and on all the cores."""

from __future__ import annotations

import math

import numpy as np

from anamorph.base.compiled import compiled, inlined, over_all_cores
from anamorph.base.vectors import Vector, along, dot
from anamorph.measure.angles import angle_between, image_distance, length, unit_or_zero

ROWS = 16
"""Of the image, that one core takes at a time."""

NOTHING = -1
"""The surface of pixels that do not count."""


def pixel_errors(
    origins: np.ndarray, directions: np.ndarray, surface: np.ndarray, positions: np.ndarray, object_ids: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Angular errors, and errors in the image, of all pixels that count.

    Parameters
    ----------
    origins, directions : (H, W, 3)
        The reference's last rays; any length but zero where pixels count.
    surface : (H, W) int64
        Which specular surface each pixel looks at; `NOTHING` where pixels do not count.
    positions : (H, W, 3)
        World points that the frame sees, metres; directions where `object_ids` is 0.
    object_ids : (H, W)

    Returns
    -------
    angular : (H, W) float64
        Milliradians; zero where pixels do not count.
    pixels : (H, W) float64
        To first order, the image's diagonal at most.
    """
    angular, pixels = np.zeros((2, *surface.shape))
    rays = (np.ascontiguousarray(array, np.float32) for array in (origins, directions, positions))
    origins, directions, positions = rays
    seen = np.ascontiguousarray(object_ids, np.uint32)
    limit = math.hypot(*surface.shape)

    def work(start: int, stop: int) -> None:
        _measure_rows(origins, directions, surface, positions, seen, limit, angular, pixels, start, stop)

    over_all_cores(work, len(surface), ROWS)
    return angular, pixels


@inlined
def _vector(array: np.ndarray, row: int, column: int) -> Vector:
    return np.float64(array[row, column, 0]), np.float64(array[row, column, 1]), np.float64(array[row, column, 2])


@inlined
def _side(
    origins: np.ndarray,
    directions: np.ndarray,
    surface: np.ndarray,
    row: int,
    column: int,
    down: int,
    right: int,
    distance: float,
) -> tuple[float, Vector]:
    """How the point at a distance moves between a pixel and one beside it; infinitely far if another surface is."""
    there, beside = row + down, column + right
    inside = 0 <= there < surface.shape[0] and 0 <= beside < surface.shape[1]
    if not inside or surface[there, beside] != surface[row, column]:
        return math.inf, (0.0, 0.0, 0.0)
    sign = float(down + right)
    here = unit_or_zero(_vector(directions, row, column))
    turn = along(unit_or_zero(_vector(directions, there, beside)), -1.0, here)
    step = along((0.0, 0.0, 0.0), sign, turn)
    if not math.isinf(distance):
        step = along((0.0, 0.0, 0.0), distance, step)
        step = along(step, sign, along(_vector(origins, there, beside), -1.0, _vector(origins, row, column)))
    return length(step), step


@inlined
def footprint(
    origins: np.ndarray,
    directions: np.ndarray,
    surface: np.ndarray,
    row: int,
    column: int,
    down: int,
    right: int,
    distance: float,
) -> Vector:
    """How the point at a distance along a pixel's last ray moves when one moves by one pixel, `down` or `right`.

    Finite differences between neighbouring pixels of one specular surface: the mean of both sides; the side that
    exists at a border; the smaller one where the sides differ by more than a factor of two (an inner silhouette
    runs there). A pixel without neighbours has zero. Metres a pixel; radians a pixel where the distance is infinite.
    """
    ahead, ahead_step = _side(origins, directions, surface, row, column, down, right, distance)
    behind, behind_step = _side(origins, directions, surface, row, column, -down, -right, distance)
    if max(ahead, behind) <= 2.0 * min(ahead, behind) and not math.isinf(max(ahead, behind)):
        return along(along((0.0, 0.0, 0.0), 0.5, ahead_step), 0.5, behind_step)
    return ahead_step if ahead <= behind else behind_step


@compiled
def _measure_rows(
    origins: np.ndarray,
    directions: np.ndarray,
    surface: np.ndarray,
    positions: np.ndarray,
    object_ids: np.ndarray,
    limit: float,
    angular: np.ndarray,
    pixels: np.ndarray,
    start: int,
    stop: int,
) -> None:
    for row in range(start, stop):
        for column in range(surface.shape[1]):
            if surface[row, column] == NOTHING:
                continue
            origin = _vector(origins, row, column)
            direction = unit_or_zero(_vector(directions, row, column))
            seen = _vector(positions, row, column)
            offset = along(seen, -1.0, origin)
            sky = object_ids[row, column] == 0
            toward = unit_or_zero(seen if sky else offset)
            angular[row, column] = 1000.0 * angle_between(direction, toward)
            distance = dot(offset, direction)
            if sky or distance <= 0.0:
                distance = math.inf
            rightwards = footprint(origins, directions, surface, row, column, 0, 1, distance)
            downwards = footprint(origins, directions, surface, row, column, 1, 0, distance)
            pixels[row, column] = image_distance(origin, direction, toward, distance, rightwards, downwards, limit)
