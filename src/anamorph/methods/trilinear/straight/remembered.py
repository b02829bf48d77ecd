"""Scene points solved once where many scene triangles of a ray triangle share them, compiled.

The corners of neighbouring triangles, or of the small triangles into which one is divided, are the same numbers to the
last bit. What was found for a point is kept in a cell that its bits choose, until another needs the cell: nothing has
to know the mesh, and the result does not depend on what was kept.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from anamorph.base.compiled import compiled
from anamorph.raytriangle.solve import WORDS, solve_point

CELLS = 512

_FIRST, _SECOND, _THIRD = 0x9E3779B1, 0x85EBCA77, 0xC2B2AE3D
"""Large odd numbers, so that bits that differ anywhere choose other cells."""


class Memory(NamedTuple):
    """What was found for points lately."""

    owner: np.ndarray
    """(CELLS,) int64: the ray triangle, or -1."""
    point: np.ndarray
    """(CELLS, 3) float64: the point."""
    solved: np.ndarray
    """(CELLS, 18) float64: as `solve_point` leaves it."""
    found: np.ndarray
    """(8,) float64: work space."""


def memory() -> Memory:
    """Empty."""
    return Memory(np.full(CELLS, -1), np.zeros((CELLS, 3)), np.zeros((CELLS, WORDS)), np.zeros(8))


@compiled
def solve_once(
    row: np.ndarray, owner: int, point: np.ndarray, bits: np.ndarray, kept: Memory, solved: np.ndarray
) -> None:
    """As `solve_point` for ray triangle `owner`; `bits` (3,) int64 are those of `point` (3,)."""
    x, y, z = bits[0], bits[1], bits[2]
    # Round numbers have nothing in their lower halves.
    mixed = (x ^ (x >> 32)) * _FIRST + (y ^ (y >> 32)) * _SECOND + (z ^ (z >> 32)) * _THIRD
    cell = ((mixed >> 40) ^ (mixed >> 20)) & (CELLS - 1)
    known = kept.point[cell]
    found = kept.solved[cell]
    if kept.owner[cell] != owner or known[0] != point[0] or known[1] != point[1] or known[2] != point[2]:
        solve_point(row, point[0], point[1], point[2], kept.found, found)
        kept.owner[cell] = owner
        known[0], known[1], known[2] = point[0], point[1], point[2]
    for word in range(WORDS):
        solved[word] = found[word]
