"""One small triangle of a scene triangle divided on its barycentric grid (4.5.1 of the thesis), compiled.

With n steps a side there are n^2 of them, in n rows from the first corner to the opposite side, 2 r + 1 in row r. A
point of the grid comes out the same to the last bit in each small triangle that has it.
"""

from __future__ import annotations

import math

import numpy as np

from anamorph.base.compiled import compiled


@compiled
def small_triangle(corners: np.ndarray, steps: int, which: int, points: np.ndarray, within: np.ndarray) -> None:
    """The corners of small triangle `which` into `points` (3, 3), their second and third weights into `within` (3, 2).

    It turns the same way round as the whole one, whose `corners` are (3, 3).
    """
    row = int(math.sqrt(which))
    along = which - row * row
    half = along // 2
    upright = along % 2 == 0
    for k in range(3):
        down, across = row, half
        if k == 1 or (k == 2 and upright):
            down += 1
        if k == 2 or (k == 1 and not upright):
            across += 1
        within[k, 0], within[k, 1] = (down - across) / steps, across / steps
        first = (steps - down) / steps
        for axis in range(3):
            points[k, axis] = (
                first * corners[0, axis] + within[k, 0] * corners[1, axis] + within[k, 1] * corners[2, axis]
            )
