"""Grids around meshes: only their corners are searched for, and vertices between them are interpolated.

Source: Estalella et al. 2005, section 5. Deviation: a cell with a corner inside of the reflector, which has no virtual
point, is not interpolated: its vertices are searched for themselves.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from anamorph.base.errors import AnamorphError

CORNERS = np.array([[i & 1, i >> 1 & 1, i >> 2 & 1] for i in range(8)])
"""Of a cell, (8, 3): x changes first."""


@dataclass(frozen=True, eq=False)
class Grid:
    """What is searched for in place of V vertices.

    Parameters
    ----------
    points : (K, 3) float64
        Metres.
    corners : (V, 8) int64
        The points around each vertex, in the order of `CORNERS`; all the same for one that is searched for itself.
    places : (V, 3) float64
        Where each vertex is in its cell, 0 to 1 along each axis.
    """

    points: np.ndarray
    corners: np.ndarray
    places: np.ndarray

    def interpolated(self, values: np.ndarray) -> np.ndarray:
        """Values of the vertices, (V, C), from those of the points (K, C)."""
        shares = np.where(CORNERS[None], self.places[:, None], 1.0 - self.places[:, None]).prod(axis=2)
        return np.einsum("vc,vck->vk", shares, values[self.corners])

    def without(self, points: np.ndarray, vertices: np.ndarray) -> Grid:
        """The same, but vertices (V, 3) in cells with a corner among `points` (K,) bool are searched for themselves."""
        alone = np.flatnonzero(points[self.corners].any(axis=1))
        corners, places = self.corners.copy(), self.places.copy()
        corners[alone] = len(self.points) + np.arange(len(alone))[:, None]
        places[alone] = 0.0
        return _compact(np.concatenate([self.points, vertices[alone]]), corners, places)


def direct(vertices: np.ndarray) -> Grid:
    """No grid: each of the vertices (V, 3) is searched for."""
    return Grid(vertices, np.repeat(np.arange(len(vertices))[:, None], 8, axis=1), np.zeros((len(vertices), 3)))


def joined(grids: list[Grid]) -> Grid:
    """One grid for the vertices of several."""
    first = np.cumsum([0, *(len(grid.points) for grid in grids)])
    return Grid(
        np.concatenate([grid.points for grid in grids]),
        np.concatenate([grid.corners + start for grid, start in zip(grids, first, strict=False)]),
        np.concatenate([grid.places for grid in grids]),
    )


def regular_grid(vertices: np.ndarray, share: float) -> Grid:
    """The grid of a mesh whose cells are near to cubes, and about `share` of the vertices (V, 3) in number.

    Raises
    ------
    AnamorphError
        The share is not above 0 and at most 1.
    """
    if not 0.0 < share <= 1.0:
        raise AnamorphError(f"share is {share}; give the cells of a grid as a share of its mesh's vertices, up to 1")
    low, extent = vertices.min(axis=0), np.ptp(vertices, axis=0)
    counts = _counts(extent, share * len(vertices))
    sizes = np.where(extent > 0.0, extent, 1.0) / counts
    cell = np.clip(((vertices - low) / sizes).astype(np.int64), 0, counts - 1)
    places = np.clip((vertices - low) / sizes - cell, 0.0, 1.0)
    row, plane = counts[0] + 1, (counts[0] + 1) * (counts[1] + 1)
    numbers = (cell[:, None] + CORNERS) @ np.array([1, row, plane])
    used, corners = np.unique(numbers, return_inverse=True)
    steps = np.stack([used % row, used // row % (counts[1] + 1), used // plane], axis=1)
    grid = Grid(low + sizes * steps, corners.reshape(-1, 8), places)
    # A grid with more corners than there are vertices saves nothing.
    return grid if len(grid.points) < len(vertices) else direct(vertices)


def _counts(extent: np.ndarray, cells: float) -> np.ndarray:
    """How many cells go along each axis of a box, so that they are near to cubes and about so many in all."""
    counts = np.ones(3, np.int64)
    axes = np.flatnonzero(extent > 0.0)
    # The thinnest first: an axis thinner than a cell has one, and the others share the rest.
    for done, axis in enumerate(axes[np.argsort(extent[axes])]):
        others = axes[np.argsort(extent[axes])][done:]
        size = (extent[others].prod() / max(cells / counts.prod(), 1.0)) ** (1.0 / len(others))
        counts[axis] = max(round(extent[axis] / size), 1)
    return counts


def _compact(points: np.ndarray, corners: np.ndarray, places: np.ndarray) -> Grid:
    used, numbers = np.unique(corners, return_inverse=True)
    return Grid(points[used], numbers.reshape(-1, 8), places)
