"""Convex polygons of the image, held in arrays of `CAPACITY` corners and cut by half-planes. Compiled."""

from __future__ import annotations

import numpy as np

from anamorph.base.compiled import compiled, inlined

CAPACITY = 24
"""The most corners. A cut that would need more is left out, which keeps more than it must."""


@inlined
def cut(polygon: np.ndarray, count: int, other: np.ndarray, a: float, b: float, c: float) -> int:
    """Keep of `polygon` what has a x + b y + c >= 0; `other` is used on the way. Returns the corners that are left."""
    if count < 3 or count >= CAPACITY - 1:
        return count
    lowest = np.inf
    for k in range(count):
        lowest = min(lowest, a * polygon[k, 0] + b * polygon[k, 1] + c)
    if lowest >= 0.0:
        return count
    kept = 0
    last = count - 1
    x0, y0 = polygon[last, 0], polygon[last, 1]
    before = a * x0 + b * y0 + c
    for k in range(count):
        x1, y1 = polygon[k, 0], polygon[k, 1]
        here = a * x1 + b * y1 + c
        if (before >= 0.0) != (here >= 0.0):
            share = before / (before - here)
            other[kept, 0], other[kept, 1] = x0 + share * (x1 - x0), y0 + share * (y1 - y0)
            kept += 1
        if here >= 0.0:
            other[kept, 0], other[kept, 1] = x1, y1
            kept += 1
        x0, y0, before = x1, y1, here
    if kept < 3:
        return 0
    for k in range(kept):
        polygon[k, 0], polygon[k, 1] = other[k, 0], other[k, 1]
    return kept


@compiled
def area(polygon: np.ndarray, count: int) -> float:
    """The area of a convex polygon."""
    twice = 0.0
    for k in range(1, count - 1):
        x1, y1 = polygon[k, 0] - polygon[0, 0], polygon[k, 1] - polygon[0, 1]
        x2, y2 = polygon[k + 1, 0] - polygon[0, 0], polygon[k + 1, 1] - polygon[0, 1]
        twice += x1 * y2 - y1 * x2
    return 0.5 * abs(twice)


@inlined
def box(polygon: np.ndarray, count: int) -> tuple[float, float, float, float]:
    """Middle and half extents of a polygon's box."""
    low_x, high_x, low_y, high_y = polygon[0, 0], polygon[0, 0], polygon[0, 1], polygon[0, 1]
    for k in range(1, count):
        low_x, high_x = min(low_x, polygon[k, 0]), max(high_x, polygon[k, 0])
        low_y, high_y = min(low_y, polygon[k, 1]), max(high_y, polygon[k, 1])
    return 0.5 * (low_x + high_x), 0.5 * (low_y + high_y), 0.5 * (high_x - low_x), 0.5 * (high_y - low_y)


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
