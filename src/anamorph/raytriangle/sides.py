"""Which points a ray triangle cannot see, by the side of the surfaces that its edges sweep.

Source: Vallance 2005, section 3.7. The rays along an edge sweep a ruled surface. With e and f the differences of the
edge's origins and directions and (p, n) its first ray, a point p + d lies on it where

    S(d) = K det(e, n, d) - det(d, n, f) det(e, d, f) = 0,    K = det(e, n, f).

Deviations: the printed implicit form does not follow from the one before it, and this one takes no rotation. And a
wrong side does not by itself mean that a point is not seen, since the volume of the rays folds over where they cross.
Put in a point at weight w of the third ray and weight a of the edge's second, and S is w times something linear in a
and w and quadratic in t. Where that keeps one sign over the whole volume, the side decides; where it does not, the edge
culls nothing.

In float32 the same sums serve with 1e-5 for `NOISE`, formed in the ray triangle's own units.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from anamorph.raytriangle.factors import SAME
from anamorph.raytriangle.scaled import SPREAD, ScaledRays, scaled_rays

NOISE = 1e-12
"""The share of its terms that rounding may take from S, and by which a nearly plane side may be bent."""


@dataclass(frozen=True, eq=False)
class SideSurfaces:
    """The three surfaces of each ray triangle, in its own units: S(d) = linear . d - (first . d) (second . d).

    Parameters
    ----------
    rays : ScaledRays
    edges : (..., 3, 3) float64
        Where d is counted from, for each edge: its first ray's origin.
    linear, first, second : (..., 3, 3) float64
        First and second are 0 where the side is a plane.
    inner : (..., 3) float64
        The sign of S inside; 0 where the side tells nothing.
    slack : (..., 3) float64
        How far beyond 0 S may be inside all the same, at a distance of 1: slivers sway by as much as rounding hides.
    """

    rays: ScaledRays
    edges: np.ndarray
    linear: np.ndarray
    first: np.ndarray
    second: np.ndarray
    inner: np.ndarray
    slack: np.ndarray

    def outside(self, points: np.ndarray) -> np.ndarray:
        """Whether points (..., N, 3) are beyond a side, (..., N) bool: true only for points that are not seen."""
        off = self.rays.local(np.asarray(points, float))[..., None, :, :] - self.edges[..., None, :]

        def along(form: np.ndarray) -> np.ndarray:
            return np.einsum("...ei,...eni->...en", form, off)

        far = 1.0 + np.linalg.norm(off, axis=-1)
        lengths = (np.linalg.norm(form, axis=-1)[..., None] for form in (self.linear, self.first, self.second))
        linear, first, second = lengths
        noise = NOISE * (linear * far + first * second * far**2) + self.slack[..., None] * far**2
        values = along(self.linear) - along(self.first) * along(self.second)
        return (self.inner[..., None] * values < -noise).any(axis=-2)


def side_surfaces(origins: np.ndarray, directions: np.ndarray, reach: float = np.inf) -> SideSurfaces:
    """The side surfaces of ray triangles.

    Parameters
    ----------
    origins, directions : (..., 3, 3) array
        A row for each of the three rays.
    reach : float
        Points with a greater t do not count as seen. The less it is, the more sides tell something: rays that cross
        do so beyond it.

    Raises
    ------
    AnamorphError
        If a number is not finite, or all directions of a ray triangle are 0.
    """
    rays = scaled_rays(origins, directions)
    n = rays.mean[..., None, :] + SPREAD.T @ rays.directions
    # Back from the waist to where the rays start.
    p = SPREAD.T @ rays.origins - rays.shift[..., None, None] * n
    e, f = np.roll(p, -1, axis=-2) - p, np.roll(n, -1, axis=-2) - n
    g, h = np.roll(p, -2, axis=-2) - p, np.roll(n, -2, axis=-2) - n
    first, second = np.cross(n, f), np.cross(f, e)
    across = np.cross(e, n)
    k = _dot(first, e)[..., None]
    # The rays of a plane side: whichever two vectors in it are furthest from parallel say where it is.
    candidates = np.stack([across, np.cross(e, n + f), first], axis=-2)
    longest = np.linalg.norm(candidates, axis=-1).argmax(axis=-1)
    normal = np.take_along_axis(candidates, longest[..., None, None], axis=-2)[..., 0, :]
    plane = np.abs(k) <= SAME * np.linalg.norm(normal, axis=-1, keepdims=True)
    linear = np.where(plane, normal, k * across)
    first, second = np.where(plane, 0.0, first), np.where(plane, 0.0, second)
    end = np.broadcast_to(reach / rays.pace, rays.pace.shape)
    inner, slack = _inner(linear, first, second, k, plane, g, h, end)
    return SideSurfaces(rays, p, linear, first, second, inner, slack)


def _dot(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    return np.sum(a * b, axis=-1)


def _inner(
    linear: np.ndarray,
    first: np.ndarray,
    second: np.ndarray,
    k: np.ndarray,
    plane: np.ndarray,
    g: np.ndarray,
    h: np.ndarray,
    end: np.ndarray,
) -> tuple[np.ndarray, np.ndarray]:
    """The sign of S / w over all weights and all t from 0 to `end`, 0 where it changes; the slack in it. (..., 3)."""
    k = np.where(plane, 0.0, k)[..., 0]
    zero = np.zeros_like(k)
    l0, l1 = _dot(linear, g), _dot(linear, h)
    a0, a1, b0, b1 = _dot(first, g), _dot(first, h), _dot(second, g), _dot(second, h)
    at_first = np.stack([l0, l1 - k * a0, -k * a1], axis=-1)
    at_second = at_first - np.stack([k * b0, k * b1, zero], axis=-1)
    at_third = at_first - np.stack([a0 * b0, a0 * b1 + a1 * b0, a1 * b1], axis=-1)
    corners = np.stack([at_first, at_second, at_third], axis=-2)
    magnitude = np.abs(corners).max(axis=(-1, -2))
    # Bernstein's coefficients hold a polynomial between them, up to the end or to infinity.
    c0, c1, c2 = np.moveaxis(corners, -1, 0)
    bounded = np.isfinite(end)[..., None, None]
    t = np.where(bounded, end[..., None, None], 1.0)
    middle, last = np.where(bounded, c0 + 0.5 * t * c1, c1), np.where(bounded, c0 + t * (c1 + t * c2), c2)
    bounds = np.stack([c0, middle, last], axis=-1)
    noise = NOISE * magnitude * np.maximum(1.0, t[..., 0]) ** 2
    lowest, highest = bounds.min(axis=(-1, -2)), bounds.max(axis=(-1, -2))
    positive, negative = lowest >= -noise, highest <= noise
    return np.where(positive & ~negative, 1.0, np.where(negative & ~positive, -1.0, 0.0)), noise
