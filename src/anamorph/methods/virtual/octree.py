"""A grid that adapts itself: cells are divided until interpolation shows their vertices where the search does.

A cell is asked at its middle and at the middles of its faces and edges: where the images of what is interpolated and of
what is searched for differ by more than is allowed there, it is divided into eight. Vertices of cells that hold few of
them are searched for themselves.

Beyond Estalella et al. 2005, which names levels of detail as future work (section 8).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from anamorph.methods.virtual.mesh_grid import CORNERS, Grid

Search = Callable[[np.ndarray], np.ndarray]
"""Points (N, 3) go in; what is found of each comes out, (N, C), linear numbers that can be interpolated."""

Images = Callable[[np.ndarray], np.ndarray]
"""What was found or interpolated (N, C) goes in; image coordinates (N, 2) come out, pixels, or NaN."""

ASKED = (
    np.array([[i % 3, i // 3 % 3, i // 9] for i in range(27) if any(k == 1 for k in (i % 3, i // 3 % 3, i // 9))]) / 2.0
)
"""Where in a cell it is asked, (19, 3)."""

ALLOWED = 0.4
"""Pixels by which interpolation may differ where it is asked; between these places it may differ by more."""

FEW = 27
"""So many vertices, or fewer, are searched for themselves: a cell would cost more."""

DEEPEST = 12


@dataclass(frozen=True, eq=False)
class Adapted:
    """A grid, and what it took.

    Parameters
    ----------
    grid : Grid
    found : (K, C) float64
        What was found of the grid's points.
    searches, cells : int
        How many points were searched for, and in how many cells vertices are interpolated.
    largest : float
        By how much the two differ at most where it was asked in these cells, pixels.
    """

    grid: Grid
    found: np.ndarray
    searches: int
    cells: int
    largest: float


def adapted_grid(vertices: np.ndarray, search: Search, images: Images) -> Adapted:
    """Find the grid for the vertices (V, 3) of a mesh, as one eye sees them."""
    extent = max(float(np.ptp(vertices, axis=0).max()), np.finfo(float).tiny)
    low = 0.5 * (vertices.min(axis=0) + vertices.max(axis=0)) - 0.5 * extent
    asked = np.concatenate([CORNERS, ASKED])
    shares = np.where(CORNERS[None], ASKED[:, None], 1.0 - ASKED[:, None]).prod(axis=2)
    corners, places = np.empty((len(vertices), 8), np.int64), np.empty((len(vertices), 3))
    points, found = [np.zeros((0, 3))], [search(np.zeros((0, 3)))]
    left, count, cells, largest = np.arange(len(vertices)), 0, 0, 0.0
    for level in range(DEEPEST + 1):
        size = extent / 2**level
        steps = np.clip(((vertices[left] - low) / size).astype(np.int64), 0, 2**level - 1)
        cell, own, held = np.unique(steps, axis=0, return_inverse=True, return_counts=True)
        own = own.ravel()
        large = np.flatnonzero((held > FEW) & (level < DEEPEST))
        # Corners are shared by neighbours, and so are most of the places in between.
        halves = (2 * (cell[large, None] + asked)).round().astype(np.int64).reshape(-1, 3)
        unique, numbers = np.unique(halves, axis=0, return_inverse=True)
        numbers = numbers.reshape(-1, len(asked))
        points.append(low + 0.5 * size * unique)
        found.append(search(points[-1]))
        between = np.einsum("ac,nck->nak", shares, found[-1][numbers[:, :8]])
        apart = images(between.reshape(-1, found[-1].shape[1])) - images(found[-1])[numbers[:, 8:].ravel()]
        off = np.linalg.norm(apart, axis=1).reshape(-1, len(ASKED)).max(axis=1, initial=0.0)
        # Where there is no image the comparison fails.
        holds = (off <= ALLOWED) & np.isfinite(images(found[-1]))[numbers[:, :8]].all(axis=(1, 2))
        cells, largest = cells + int(holds.sum()), max(largest, off[holds].max(initial=0.0))
        row = np.full(len(cell), -1)
        row[large] = np.arange(len(large))
        settled, alone = np.zeros(len(cell), bool), np.ones(len(cell), bool)
        settled[large], alone[large] = holds, False
        chosen, place = left[settled[own]], own[settled[own]]
        corners[chosen] = count + numbers[row[place]][:, :8]
        places[chosen] = np.clip((vertices[chosen] - low) / size - cell[place], 0.0, 1.0)
        count += len(unique)
        chosen = left[alone[own]]
        corners[chosen], places[chosen] = count + np.arange(len(chosen))[:, None], 0.0
        points.append(vertices[chosen])
        found.append(search(points[-1]))
        count += len(chosen)
        left = left[~(settled | alone)[own]]
        if not len(left):
            break
    used, numbers = np.unique(corners, return_inverse=True)
    grid = Grid(np.concatenate(points)[used], numbers.reshape(-1, 8), places)
    return Adapted(grid, np.concatenate(found)[used], count, cells, largest)
