"""Which part of the image is each ray triangle's own: convex polygons, and the boxes around them."""

from __future__ import annotations

import numpy as np

PADDING = 1.0 / 32.0
"""Pixels by which whatever is drawn reaches beyond what must be: more than rounding and the rasterizer's grid take."""

MOST_CORNERS = 8
"""Of the image's rectangle after three cuts, with one to spare."""

LEAST_SCALE = 2.0**-10
"""A given part of the image is cut off where s falls below this share of its most: there the rays are none."""


def own_domains(inverse: np.ndarray, size: tuple[int, int]) -> tuple[np.ndarray, np.ndarray]:
    """The image's rectangle cut along the sides of each triangle: corners (K, 8, 2), and how many there are."""
    width, height = size
    count = len(inverse)
    polygon = np.zeros((count, MOST_CORNERS, 2))
    polygon[:, :4] = [(-1.0, -1.0), (width + 1.0, -1.0), (width + 1.0, height + 1.0), (-1.0, height + 1.0)]
    corners = np.full(count, 4)
    for side in range(3):
        gradient = inverse[:, :2, side]
        offset = inverse[:, 2, side] + PADDING * np.linalg.norm(gradient, axis=1)
        polygon, corners = _cut(polygon, corners, gradient, offset)
    return polygon, corners


def given_domains(
    domain: np.ndarray, scale: np.ndarray, start: np.ndarray, size: tuple[int, int]
) -> tuple[np.ndarray, np.ndarray]:
    """Given domains (K, C, 2), relative to `start`, as far as the image goes and s is positive: see `own_domains`."""
    count, given = domain.shape[:2]
    following = np.roll(domain, -1, axis=1)
    extent = np.sum(domain[..., 0] * following[..., 1] - domain[..., 1] * following[..., 0], axis=1)
    most = (np.einsum("kci,ki->kc", domain, scale[:, :2]) + scale[:, 2:]).max(axis=1)
    polygon = np.zeros((count, given + 6, 2))
    polygon[:, :given] = domain
    corners = np.where((extent != 0.0) & (most > 0.0), given, 0)
    for axis in range(2):
        outward = np.zeros((count, 2))
        outward[:, axis] = 1.0
        polygon, corners = _cut(polygon, corners, outward, start[:, axis] + 1.0)
        polygon, corners = _cut(polygon, corners, -outward, size[axis] + 1.0 - start[:, axis])
    return _cut(polygon, corners, scale[:, :2], scale[:, 2] - LEAST_SCALE * most)


def extent_of(part: np.ndarray, corners: np.ndarray) -> np.ndarray:
    """Middles and half extents (K, 4) of the boxes around polygons."""
    used = np.where((np.arange(part.shape[1]) < corners[:, None])[..., None], part, part[:, :1])
    low, high = used.min(axis=1), used.max(axis=1)
    return np.concatenate([0.5 * (low + high), 0.5 * (high - low)], axis=1)


def _cut(
    polygon: np.ndarray, corners: np.ndarray, gradient: np.ndarray, offset: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """What of convex polygons (K, C, 2) has gradient . place + offset >= 0."""
    count, capacity = polygon.shape[:2]
    rows, slots = np.arange(count), np.arange(capacity)
    following = np.where(slots + 1 < corners[:, None], slots + 1, 0)
    height = np.einsum("ksi,ki->ks", polygon, gradient) + offset[:, None]
    ahead = height[rows[:, None], following]
    used = slots < corners[:, None]
    kept, crosses = used & (height >= 0.0), used & ((height >= 0.0) != (ahead >= 0.0))
    # Each corner gives up to two: itself, and the crossing that follows.
    share = np.where(crosses, height / np.where(crosses, height - ahead, 1.0), 0.0)
    crossing = polygon + share[..., None] * (polygon[rows[:, None], following] - polygon)
    both = np.stack([polygon, crossing], axis=2).reshape(count, 2 * capacity, 2)
    wanted = np.stack([kept, crosses], axis=2).reshape(count, 2 * capacity)
    order = np.argsort(~wanted, axis=1, kind="stable")[:, :capacity]
    return both[rows[:, None], order], wanted.sum(axis=1)
