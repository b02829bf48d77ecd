"""Which samples of an image each three-ray camera owns. Compiled.

A camera is a triangle of a ray mesh. A sample belongs to the nearest triangle over its centre; of a ray mesh that is
itself the camera, to the first.

Source: Mei, Popescu and Sacks 2007, section 5: the image plane of a camera is the reflector's triangle.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from anamorph.base.compiled import compiled, over_all_cores
from anamorph.base.vectors import cross, dot

ROWS, CAMERAS = 16, 2048
"""Rows of samples, and cameras, that a core takes at a time."""

NOBODY, BACK = -1, -2
"""The owner of a sample over which there is no triangle, or one that turns its back."""

EDGE = 1e-9
"""The least weight over a triangle: on the edge between two, both may have a sample."""

FLAT = 1e-12
"""A triangle whose area is less than this share of its corners' distances is a line, but for rounding."""


class Places(NamedTuple):
    """Where cameras are in the image, as functions of the sample."""

    weights: np.ndarray
    """(K, 3, 3) float64: numbers (a, b, c) a corner, whose a x + b y + c, over their sum, is its weight at the sample x
    columns and y rows from the first of the box. The sum is one over the depth."""
    box: np.ndarray
    """(K, 4) int64: the first column and row of the samples around it, and the last ones and one; of no samples, 0."""
    front: np.ndarray
    """(K,) bool: whether it turns its front to the eye: it is then clockwise in the image, whose y points down."""


def sampled(image: np.ndarray, side: int, shift: tuple[float, float]) -> np.ndarray:
    """Image corners (K, 3, 3) in samples from the first one's centre, which `shift` moves in pixels."""
    to_samples = np.array([[side, 0, -side * shift[0] - 0.5], [0, side, -side * shift[1] - 0.5], [0, 0, 1]])
    return np.asarray(image, float) @ to_samples.T


def places_of(image: np.ndarray, size: tuple[int, int]) -> Places:
    """Where cameras with these homogeneous corners (K, 3, 3) are among `size` samples; without an area, nowhere."""
    count = len(image)
    places = Places(np.zeros((count, 3, 3)), np.zeros((count, 4), np.int64), np.zeros(count, bool))
    corners = np.ascontiguousarray(image, float)
    over_all_cores(lambda start, stop: _place(corners, *size, places, start, stop), count, CAMERAS)
    return places


@compiled
def _place(image: np.ndarray, width: int, height: int, places: Places, start: int, stop: int) -> None:
    for c in range(start, stop):
        ahead = 0
        low_x, low_y, high_x, high_y = math.inf, math.inf, -math.inf, -math.inf
        for i in range(3):
            w = image[c, i, 2]
            if w > 0.0:
                ahead += 1
                x, y = image[c, i, 0] / w, image[c, i, 1] / w
                low_x, low_y, high_x, high_y = min(low_x, x), min(low_y, y), max(high_x, x), max(high_y, y)
        if ahead == 0:
            continue
        x0, y0, x1, y1 = 0.0, 0.0, float(width), float(height)
        if ahead == 3:
            # Beyond the image, numbers may be too large for whole ones.
            x0, x1 = math.ceil(min(max(low_x - EDGE, x0), x1)), math.floor(min(max(high_x + EDGE, -1.0), x1 - 1.0)) + 1
            y0, y1 = math.ceil(min(max(low_y - EDGE, y0), y1)), math.floor(min(max(high_y + EDGE, -1.0), y1 - 1.0)) + 1
        if not (x0 < x1 and y0 < y1):
            continue
        # From the box's corner, so that numbers are small.
        a = (image[c, 0, 0] - x0 * image[c, 0, 2], image[c, 0, 1] - y0 * image[c, 0, 2], image[c, 0, 2])
        b = (image[c, 1, 0] - x0 * image[c, 1, 2], image[c, 1, 1] - y0 * image[c, 1, 2], image[c, 1, 2])
        d = (image[c, 2, 0] - x0 * image[c, 2, 2], image[c, 2, 1] - y0 * image[c, 2, 2], image[c, 2, 2])
        # The rows of the adjugate: q = sum of weights times corners.
        rows = cross(b, d), cross(d, a), cross(a, b)
        determinant = dot(a, rows[0])
        exists = abs(determinant) > FLAT * math.sqrt(dot(a, a) * dot(b, b) * dot(d, d))
        for i in range(3):
            for k in range(3):
                places.weights[c, i, k] = rows[i][k] / determinant
                exists &= math.isfinite(places.weights[c, i, k])
        if not exists:
            places.weights[c] = 0.0
            continue
        places.front[c] = determinant < 0.0
        places.box[c, 0], places.box[c, 1], places.box[c, 2], places.box[c, 3] = int(x0), int(y0), int(x1), int(y1)


def owners_of(
    places: Places, size: tuple[int, int], fronts: np.ndarray | None, depth: np.ndarray, owner: np.ndarray
) -> np.ndarray:
    """Find the camera of each sample; returns the numbers of those that own some.

    Parameters
    ----------
    places : Places
    size : (width, height)
    fronts : (K,) bool or None
        Which turn their front to the eye; None where the first of several owns a sample and not the nearest.
    depth : (height, width) float64
        Is filled with one over the depth of the triangle, 0 for none.
    owner : (height, width) int32
        Is filled with its number, or `NOBODY` or `BACK`.
    """
    depth[:], owner[:] = 0.0, NOBODY
    first = fronts is None
    shown = np.ones(len(places.box), bool) if fronts is None else fronts
    owns = np.zeros(len(places.box), bool)
    over_all_cores(
        lambda start, stop: _own(places.weights, places.box, first, shown, depth, owner, owns, start, stop),
        size[1],
        ROWS,
    )
    return np.flatnonzero(owns)


@compiled
def _own(
    weights: np.ndarray,
    box: np.ndarray,
    first: bool,
    fronts: np.ndarray,
    depth: np.ndarray,
    owner: np.ndarray,
    owns: np.ndarray,
    first_row: int,
    stop_row: int,
) -> None:
    for c in range(len(box)):
        x0, y0, x1 = box[c, 0], box[c, 1], box[c, 2]
        a_0, a_1, a_2 = weights[c, 0, 0], weights[c, 1, 0], weights[c, 2, 0]
        for row in range(max(y0, first_row), min(box[c, 3], stop_row)):
            y = row - y0
            at_0 = weights[c, 0, 1] * y + weights[c, 0, 2]
            at_1 = weights[c, 1, 1] * y + weights[c, 1, 2]
            at_2 = weights[c, 2, 1] * y + weights[c, 2, 2]
            for column in range(x0, x1):
                x = column - x0
                w_0, w_1, w_2 = a_0 * x + at_0, a_1 * x + at_1, a_2 * x + at_2
                total = w_0 + w_1 + w_2
                covered = total > 0.0 and min(w_0, w_1, w_2) >= -EDGE * total
                if covered and (owner[row, column] == NOBODY if first else total > depth[row, column]):
                    depth[row, column] = total
                    owner[row, column] = c if fronts[c] else BACK
                    owns[c] = owns[c] or fronts[c]
