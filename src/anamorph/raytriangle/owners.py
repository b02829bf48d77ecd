"""Which samples of an image each three-ray camera owns. Compiled.

A camera is a triangle of a ray mesh. A sample belongs to the nearest triangle over its centre; of a ray mesh that is
itself the camera, to the first.

Source: Mei, Popescu and Sacks 2007, section 5: the image plane of a camera is the reflector's triangle.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from anamorph.base.compiled import compiled, over_all_cores

ROWS = 16
"""Rows of samples that a core takes at a time."""

NOBODY, BACK = -1, -2
"""The owner of a sample over which there is no triangle, or one that turns its back."""

EDGE = 1e-9
"""The least weight over a triangle: on the edge between two, both may have a sample."""


class Places(NamedTuple):
    """Where cameras are in the image, as functions of the sample."""

    weights: np.ndarray
    """(K, 3, 3) float64: numbers (a, b, c) a corner, whose a x + b y + c, over their sum, is its weight at the sample x
    columns and y rows from the first of the box. The sum is one over the depth."""
    box: np.ndarray
    """(K, 4) int64: the first column and row of the samples around it, and the last ones and one."""


def sampled(image: np.ndarray, side: int, shift: tuple[float, float]) -> np.ndarray:
    """Image corners (K, 3, 3) in samples from the first one's centre, which `shift` moves in pixels."""
    to_samples = np.array([[side, 0, -side * shift[0] - 0.5], [0, side, -side * shift[1] - 0.5], [0, 0, 1]])
    return np.asarray(image, float) @ to_samples.T


def places_of(image: np.ndarray, size: tuple[int, int]) -> Places:
    """Where cameras with these homogeneous corners (K, 3, 3) are among `size` samples; without an area, nowhere."""
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        ahead = np.greater(image[..., 2], 0.0)
        before, some = np.all(ahead, axis=1), np.any(ahead, axis=1)
        places = image[..., :2] / image[..., 2:]
        low = np.where(before[:, None], np.ceil(places.min(axis=1) - EDGE), 0.0)
        high = np.where(before[:, None], np.floor(places.max(axis=1) + EDGE) + 1.0, size)
        box = np.concatenate([np.clip(low, 0, size), np.clip(high, 0, size)], axis=1).astype(np.int64)
        # From the box's corner, so that numbers are small.
        corners = image.copy()
        corners[..., :2] -= box[:, None, :2] * image[..., 2:]
        determinant = np.linalg.det(corners)
        # The rows of the adjugate: q = sum of weights times corners.
        rows = np.cross(np.roll(corners, -1, axis=1), np.roll(corners, -2, axis=1))
        weights = rows / determinant[:, None, None]
    exists = some & np.isfinite(weights).all(axis=(1, 2))
    weights[~exists], box[~exists] = 0.0, 0
    return Places(weights, box)


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
    over_all_cores(lambda start, stop: _own(*places, first, shown, depth, owner, owns, start, stop), size[1], ROWS)
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
