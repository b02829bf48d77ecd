"""Whether single points of the picture see a pair's scene triangle, in compiled loops."""

from __future__ import annotations

import numpy as np

from anamorph.base.compiled import inlined


@inlined
def is_inside(terms: np.ndarray, x: float, y: float) -> bool:
    """Whether a ray triangle's ray at (x, y) meets a pair's scene triangle."""
    for first in (0, 6, 12):
        xx, xy, yy = terms[first], terms[first + 1], terms[first + 2]
        if (xx * x + xy * y + terms[first + 3]) * x + (yy * y + terms[first + 4]) * y + terms[first + 5] < 0.0:
            return False
    across = terms[18] * x + terms[19] * y + terms[20]
    ahead = terms[21] * x + terms[22] * y + terms[23]
    return across >= 0.0 and ahead >= 0.0


@inlined
def span(polygon: np.ndarray, count: int, y: float) -> tuple[float, float]:
    """Where a convex polygon is crossed by the line at y: least and greatest x."""
    low, high = np.inf, -np.inf
    last = count - 1
    for k in range(count):
        x0, y0, x1, y1 = polygon[last, 0], polygon[last, 1], polygon[k, 0], polygon[k, 1]
        last = k
        if (y0 <= y) != (y1 <= y):
            x = x0 + (y - y0) / (y1 - y0) * (x1 - x0)
            low, high = min(low, x), max(high, x)
    return low, high
