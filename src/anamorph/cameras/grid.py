"""Rays at the points of a grid that fills an image: what every camera of this room is built on."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from anamorph.base.errors import AnamorphError
from anamorph.raymesh import RayMesh, RayStatus

Size = tuple[int, int]

OPPOSITE = 1e-9 - 1.0
"""The least cosine between the directions of two corners of a triangle."""


def from_grid(
    origins: ArrayLike,
    directions: ArrayLike,
    size: Size,
    columns: ArrayLike | None = None,
    rows: ArrayLike | None = None,
) -> RayMesh:
    """A camera of two triangles to each quad of a grid of rays; inside a triangle rays are interpolated.

    Parameters
    ----------
    origins : (R, C, 3) array
        Where rays leave, metres; row 0 is the top of the image, column 0 its left. What lies before the origins is
        not seen.
    directions : (R, C, 3) array
        Of any length but 0; where neighbours' lengths differ, the longer one weighs more between them.
    size : (width, height)
        Of the image, pixels.
    columns, rows : (C,) and (R,) array, optional
        Where the grid's lines are, in pixels from the left and from the top, increasing; evenly over the image
        where not given.

    Returns
    -------
    RayMesh
        Vertices row by row; 2 (R - 1) (C - 1) triangles, each quad cut from its top left to its bottom right.
    """
    width, height = checked_size(size)
    grid_origins, grid_directions = _numbers("origins", origins), _numbers("directions", directions)
    if (
        grid_origins.ndim != 3
        or grid_origins.shape[2] != 3
        or min(grid_origins.shape[:2]) < 2
        or grid_origins.shape != grid_directions.shape
    ):
        raise AnamorphError(
            f"camera: origins are {grid_origins.shape} and directions {grid_directions.shape}; "
            "give both as (rows, columns, 3), at least 2 of each"
        )
    lengths = np.linalg.norm(grid_directions, axis=2)
    if not lengths.all():
        row, column = np.argwhere(lengths == 0.0)[0]
        raise AnamorphError(f"camera: directions at row {row}, column {column} are 0; give the way that the ray goes")
    faces = _faces(*grid_origins.shape[:2])
    units = (grid_directions / lengths[..., None]).reshape(-1, 3)[faces]
    if (np.sum(units * np.roll(units, 1, axis=1), axis=2) < OPPOSITE).any():
        raise AnamorphError(
            "camera: directions of neighbours are opposite, with none between; give more rows or columns"
        )
    image = np.ones(grid_origins.shape)
    image[..., 0] = _lines("columns", columns, grid_origins.shape[1], width)
    image[..., 1] = _lines("rows", rows, grid_origins.shape[0], height)[:, None]
    return RayMesh(
        image=image.reshape(-1, 3),
        origins=grid_origins.reshape(-1, 3),
        directions=grid_directions.reshape(-1, 3),
        faces=faces,
        status=np.full(grid_origins.shape[0] * grid_origins.shape[1], RayStatus.OK, np.uint8),
    )


def grid_points(size: Size, quads: tuple[int, int]) -> np.ndarray:
    """The points, (R, C, 2) pixels, of a grid of `quads` (across, down) that fills an image of `size`."""
    width, height = checked_size(size)
    across, down = quads
    x, y = np.linspace(0.0, width, across + 1), np.linspace(0.0, height, down + 1)
    return np.stack(np.meshgrid(x, y), axis=-1)


def checked_size(size: Size) -> Size:
    """An image's size, or the error that says what is wrong with it."""
    if np.shape(size) != (2,) or any(not np.isfinite(side) or side != int(side) or side < 1 for side in size):
        raise AnamorphError(f"camera: size is {size}; give the image's width and height in whole pixels")
    return int(size[0]), int(size[1])


def checked_count(name: str, count: int, least: int = 1) -> int:
    """A number of quads, or the error that says what is wrong with it."""
    if not np.isfinite(count) or count != int(count) or count < least:
        raise AnamorphError(f"camera: {name} is {count}; give a whole number, {least} or more")
    return int(count)


def checked_number(name: str, value: float, low: float, high: float, unit: str = "") -> float:
    """A number strictly between two others, or the error that says what is wrong with it."""
    if not low < value < high:
        bounds = f"above {low:g}" if np.isinf(high) else f"between {low:g} and {high:g}"
        raise AnamorphError(f"camera: {name} is {value}; give {unit + ' ' if unit else 'a number '}{bounds}")
    return float(value)


def _numbers(name: str, values: ArrayLike) -> np.ndarray:
    try:
        numbers = np.array(values, float)
    except (TypeError, ValueError):
        raise AnamorphError(f"camera: {name} are no array of numbers; give (rows, columns, 3)") from None
    if not np.isfinite(numbers).all():
        raise AnamorphError(f"camera: {name} have NaN or infinite numbers; give finite ones")
    return numbers


def _lines(name: str, places: ArrayLike | None, count: int, extent: int) -> np.ndarray:
    if places is None:
        return np.linspace(0.0, extent, count)
    lines = _numbers(name, places)
    if lines.shape != (count,) or (np.diff(lines) <= 0.0).any():
        raise AnamorphError(f"camera: {name} are {lines.tolist()}; give {count} places in pixels, increasing")
    return lines


def _faces(rows: int, columns: int) -> np.ndarray:
    """Counter-clockwise as one looks at the image, as those of a mirror are that shows its front."""
    vertex = np.arange(rows * columns).reshape(rows, columns)
    here, beside, below, across = vertex[:-1, :-1], vertex[:-1, 1:], vertex[1:, :-1], vertex[1:, 1:]
    faces = np.stack([here, below, across, here, across, beside], axis=-1)
    return faces.reshape(-1, 3).astype(np.int32)
