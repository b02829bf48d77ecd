"""Each sample's own ray, interpolated in the camera that owns it. Compiled."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from anamorph.base.compiled import compiled, over_all_cores
from anamorph.gpu.visibility import Rectangle
from anamorph.methods.threeray.cameras_seen import Cameras
from anamorph.raytriangle.owners import Places

ROWS = 16
"""Rows of samples that a core takes at a time."""


class Samples(NamedTuple):
    """The samples of an image, (height, width) each, and what their rays meet."""

    owner: np.ndarray
    """int32: the camera, or `NOBODY` or `BACK`."""
    depth: np.ndarray
    """float64: one over the depth of the mirror or lens, 0 for none."""
    rays: np.ndarray
    """(6, height, width) float64: origins and directions, these of any length."""
    way: np.ndarray
    """float64: the t of what is met; infinite at first."""
    triangle: np.ndarray
    """int32: which triangle that is; -1 at first."""

    @classmethod
    def reserved(cls, size: tuple[int, int]) -> Samples:
        """Arrays for an image of `size`, not filled."""
        shape = size[1], size[0]
        numbers, floats = [np.empty(shape, np.int32) for _ in range(2)], [np.empty(shape) for _ in range(2)]
        return cls(numbers[0], floats[0], np.empty((6, *shape)), floats[1], numbers[1])


def interpolate(cameras: Cameras, places: Places, samples: Samples, rectangle: Rectangle) -> None:
    """Fill the rays of a rectangle, whose owners are known; nothing is met yet."""
    x0, y0, x1, y1 = rectangle

    def work(start: int, stop: int) -> None:
        _interpolate(cameras, places, samples, x0, x1, y0 + start, y0 + stop)

    over_all_cores(work, y1 - y0, ROWS)


@compiled
def _interpolate(
    cameras: Cameras,
    places: Places,
    samples: Samples,
    x0: int,
    x1: int,
    first_row: int,
    stop_row: int,
) -> None:
    for row in range(first_row, stop_row):
        for column in range(x0, x1):
            c = samples.owner[row, column]
            samples.way[row, column], samples.triangle[row, column] = np.inf, -1
            if c < 0:
                continue
            x, y = float(column - places.box[c, 0]), float(row - places.box[c, 1])
            w = places.weights[c]
            w_0, w_1 = w[0, 0] * x + w[0, 1] * y + w[0, 2], w[1, 0] * x + w[1, 1] * y + w[1, 2]
            w_2 = w[2, 0] * x + w[2, 1] * y + w[2, 2]
            scale = 1.0 / (w_0 + w_1 + w_2)
            w_0, w_1, w_2 = scale * w_0, scale * w_1, scale * w_2
            p, d = cameras.origins[c], cameras.directions[c]
            for k in range(3):
                samples.rays[k, row, column] = w_0 * p[0, k] + w_1 * p[1, k] + w_2 * p[2, k]
                samples.rays[3 + k, row, column] = w_0 * d[0, k] + w_1 * d[1, k] + w_2 * d[2, k]
