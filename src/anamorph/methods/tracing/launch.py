"""How light paths begin: with the eye's rays through the pixels of tiles, or with given rays. Compiled."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from anamorph.base.compiled import compiled, inlined
from anamorph.base.vectors import Vector, dot, unit
from anamorph.frame import Status
from anamorph.methods.tracing.bounces import WORDS, Paths
from anamorph.scene.camera import Camera

Rectangle = tuple[int, int, int, int]

Launch = Callable[[Paths, int, int, np.ndarray, np.ndarray], int]
"""Puts `count` paths, from number `first`, on their way, and says how many have begun; the last two are their records
as float32 and as uint32, for those that have not."""

_OUTSIDE = int(Status.OUTSIDE)


@dataclass(frozen=True, eq=False)
class EyeRays:
    """An eye's rays through the pixels of tiles of an image, tile by tile, each row by row.

    Parameters
    ----------
    camera : Camera
    size : (width, height)
        Of the whole image.
    corners : (T, 2) int
        The first column and row of each tile.
    tile : (columns, rows)
        The size of all tiles.
    shift : (right, down)
        Moves the rays from the pixels' centres, in pixels.
    """

    camera: Camera
    size: tuple[int, int]
    corners: np.ndarray
    tile: tuple[int, int]
    shift: tuple[float, float] = (0.0, 0.0)

    def __len__(self) -> int:
        return len(self.corners) * self.tile[0] * self.tile[1]

    def chosen(self, numbers: np.ndarray) -> EyeRays:
        """Some of the rays, through tiles of one pixel each."""
        columns, rows = self.tile
        number, place = np.divmod(numbers, columns * rows)
        row, column = np.divmod(place, columns)
        return replace(self, corners=self.corners[number] + np.stack([column, row], axis=-1), tile=(1, 1))

    def launch(self) -> Launch:
        """What puts paths on these rays."""
        eye, axes = np.asarray(self.camera.position, float), self.camera.axes()
        scale = 2.0 * np.tan(np.radians(self.camera.field_of_view) / 2.0) / self.size[1]
        extent, centers = np.asarray(self.size, float), self.corners + 0.5 + np.asarray(self.shift)

        def launch(paths: Paths, first: int, count: int, records: np.ndarray, words: np.ndarray) -> int:
            return _start(paths, eye, axes, scale, extent, centers, *self.tile, first, count)

        return launch


@dataclass(frozen=True, eq=False)
class GivenRays:
    """Given rays.

    Parameters
    ----------
    origins, directions : (N, 3) float64
        Directions may have any length; one of (0, 0, 0) is no ray. What lies at the origin itself is met: there is no
        near plane but the place where a ray begins.
    """

    origins: np.ndarray
    directions: np.ndarray

    def __len__(self) -> int:
        return len(self.origins)

    def chosen(self, numbers: np.ndarray) -> GivenRays:
        """Some of the rays."""
        return GivenRays(self.origins[numbers], self.directions[numbers])

    def launch(self) -> Launch:
        """What puts paths on these rays."""
        return partial(_start_along, self.origins, self.directions)


FirstRays = EyeRays | GivenRays
"""The rays that light paths begin with."""


def eye_rays(
    camera: Camera, size: tuple[int, int], rectangle: Rectangle | None = None, shift: tuple[float, float] = (0.0, 0.0)
) -> EyeRays:
    """The rays through a rectangle (x0, y0, x1, y1) of an image, its ends left out; through all of it by default."""
    x0, y0, x1, y1 = rectangle or (0, 0, *size)
    return EyeRays(camera, size, np.array([[x0, y0]]), (max(x1 - x0, 0), max(y1 - y0, 0)), shift)


@inlined
def _begin(paths: Paths, i: int, pixel: int, origin: Vector, direction: Vector) -> None:
    """Put path i, whose record is `pixel`, on its first ray: nothing is too near for it."""
    for axis in range(3):
        paths.origin[i, axis], paths.direction[i, axis], paths.throughput[i, axis] = origin[axis], direction[axis], 1.0
    paths.near[i], paths.pixel[i], paths.total[i], paths.dispersed[i] = 0.0, pixel, False, False
    paths.specular[i], paths.bounces[i], paths.left[i], paths.skin[i] = 0, 0, 0, 0.0
    paths.source[i] = -1


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
    origins: np.ndarray,
    directions: np.ndarray,
    paths: Paths,
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
