"""How light paths begin: with the eye's rays through the pixels of tiles, or with given rays. Compiled."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from anamorph.base.compiled import compiled, inlined
from anamorph.base.vectors import Vector, dot, unit
from anamorph.frame import Status
from anamorph.methods.tracing.bounces import WORDS, Paths
from anamorph.scene.camera import Camera

Launch = Callable[[Paths, int, int, np.ndarray, np.ndarray], int]
"""Puts `count` paths, from number `first`, on their way, and says how many have begun; the last two are their records
as float32 and as uint32, for those that have not."""

_OUTSIDE = int(Status.OUTSIDE)


def from_eye(
    camera: Camera, size: tuple[int, int], corners: np.ndarray, tile: tuple[int, int], shift: tuple[float, float]
) -> Launch:
    """The eye's rays through the pixels of tiles."""
    eye, axes = np.asarray(camera.position, float), camera.axes()
    scale = 2.0 * np.tan(np.radians(camera.field_of_view) / 2.0) / size[1]
    extent, centers = np.asarray(size, float), corners + 0.5 + np.asarray(shift)

    def launch(paths: Paths, first: int, count: int, records: np.ndarray, words: np.ndarray) -> int:
        return _start(paths, eye, axes, scale, extent, centers, *tile, first, count)

    return launch


def along_rays(origins: np.ndarray, directions: np.ndarray) -> Launch:
    """The given rays."""

    def launch(paths: Paths, first: int, count: int, records: np.ndarray, words: np.ndarray) -> int:
        return _start_along(paths, origins, directions, first, count, records, words)

    return launch


@inlined
def _begin(paths: Paths, i: int, pixel: int, origin: Vector, direction: Vector) -> None:
    """Put path i, whose record is `pixel`, on its first ray: nothing is too near for it."""
    for axis in range(3):
        paths.origin[i, axis], paths.direction[i, axis], paths.throughput[i, axis] = origin[axis], direction[axis], 1.0
    paths.near[i], paths.pixel[i], paths.total[i], paths.dispersed[i] = 0.0, pixel, False, False
    paths.specular[i], paths.bounces[i], paths.left[i], paths.skin[i] = 0, 0, 0, 0.0


@compiled
def _start(
    paths: Paths,
    eye: np.ndarray,
    axes: np.ndarray,
    scale: float,
    size: np.ndarray,
    corners: np.ndarray,
    columns: int,
    rows: int,
    first: int,
    count: int,
) -> int:
    """Put the rays of `count` pixels on their way, from number `first` of tiles at `corners`, `columns` by `rows`."""
    for i in range(count):
        tile, number = divmod(first + i, columns * rows)
        row, column = divmod(number, columns)
        x = (corners[tile, 0] + column - size[0] / 2.0) * scale
        y = (size[1] / 2.0 - corners[tile, 1] - row) * scale
        direction = unit(
            (
                x * axes[0, 0] + y * axes[1, 0] + axes[2, 0],
                x * axes[0, 1] + y * axes[1, 1] + axes[2, 1],
                x * axes[0, 2] + y * axes[1, 2] + axes[2, 2],
            )
        )
        _begin(paths, i, i, (eye[0], eye[1], eye[2]), direction)
    return count


@compiled
def _start_along(
    paths: Paths,
    origins: np.ndarray,
    directions: np.ndarray,
    first: int,
    count: int,
    records: np.ndarray,
    words: np.ndarray,
) -> int:
    """Put `count` of the given rays, (N, 3) each, on their way, from number `first`, as unit directions.

    Where a direction has no length there is no ray: its record says OUTSIDE, and that no light arrives.

    Returns
    -------
    int
        How many paths have begun.
    """
    going = 0
    for i in range(count):
        row = first + i
        direction = (directions[row, 0], directions[row, 1], directions[row, 2])
        if dot(direction, direction) > 0.0:
            _begin(paths, going, i, (origins[row, 0], origins[row, 1], origins[row, 2]), unit(direction))
            going += 1
            continue
        for word in range(WORDS):
            records[i, word] = 0.0
        words[i, 3], words[i, 7] = np.uint32(0xFFFFFFFF), np.uint32(_OUTSIDE << 16)
        records[i, 11] = np.inf
    return going
