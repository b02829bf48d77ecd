"""The planes of parametric triangles without the factors that their rays alone make vanish.

Where the points r_i(t0) fall on one line or together, N(t0) = 0 and every point would have the root t0, though no ray
leads to it. That factor is divided out beforehand: a pinhole leaves a linear equation, as it should. Not in the thesis.
"""

from __future__ import annotations

import numpy as np

SAME = 1e-13
"""Below this, in its own units, the parametric triangle has no extent: it is a point, or a line. Sixty times what
float64 loses in the products that say so."""


def without_common_factors(planes: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The planes divided by (t - t0) for each t0 at which the parametric triangle is a line, what that drops, t0."""
    remains, lines = np.zeros(planes.shape[:-2]), []
    for _ in range(2):
        t0, exists = _line(planes)
        remains = remains + np.where(exists, np.linalg.norm(_normal(planes, t0), axis=-1), 0.0)
        planes = np.where(exists[..., None, None], _divided(planes, t0), planes)
        lines.append(np.where(exists, t0, np.inf))
    return planes, remains, np.stack(lines, axis=-1)


def _normal(planes: np.ndarray, t: np.ndarray) -> np.ndarray:
    t = t[..., None]
    return planes[..., 0, :] + t * (planes[..., 1, :] + t * planes[..., 2, :])


def _longest(planes: np.ndarray) -> np.ndarray:
    index = np.linalg.norm(planes, axis=-1).argmax(axis=-1)
    return np.take_along_axis(planes, index[..., None, None], axis=-2)[..., 0, :]


def _line(planes: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """A t0 where N(t0) = 0 (...), and whether there is one."""
    c, b, a = np.moveaxis(np.einsum("...ki,...i->...k", planes, _longest(planes)), -1, 0)
    larger = -0.5 * (b + np.copysign(np.sqrt(np.maximum(b * b - 4.0 * a * c, 0.0)), b))
    found, exists = np.zeros(a.shape), np.zeros(a.shape, bool)
    for numerator, denominator in ((c, larger), (larger, a)):
        usable = ~exists & (np.abs(denominator) > SAME * np.abs(numerator))
        t0 = np.where(usable, numerator, 0.0) / np.where(usable, denominator, 1.0)
        terms = np.einsum("...k,...k->...", np.linalg.norm(planes, axis=-1), np.abs(t0[..., None]) ** np.arange(3))
        vanishes = usable & (np.linalg.norm(_normal(planes, t0), axis=-1) <= SAME * terms)
        found, exists = np.where(vanishes, t0, found), exists | vanishes
    return found, exists


def _divided(planes: np.ndarray, t0: np.ndarray) -> np.ndarray:
    """N(t) / (t - t0), or N(t) / (1 - t / t0) for a t0 beyond 1: from the end at which the division is stable."""
    beyond = np.abs(t0) > 1.0
    t0 = t0[..., None]
    far = np.where(beyond[..., None], t0, 1.0)
    n0, n1, n2 = np.moveaxis(planes, -2, 0)
    constant = np.where(beyond[..., None], n0, n1 + t0 * n2)
    slope = np.where(beyond[..., None], n1 + n0 / far, n2)
    return np.stack([constant, slope, np.zeros_like(n2)], axis=-2)
