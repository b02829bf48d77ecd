"""What a ray triangle contributes to the projection of any point: its own units, and the planes it sweeps.

Source: Vallance 2005, section 3.6 and appendix A.3, derived again, because the indices of the printed equation 3.31 are
in another order. At each t the points r_i(t) = p_i + t n_i span a plane with the normal N(t) = N0 + N1 t + N2 t^2,
through their middle, which the units make t m with m the mean direction. A point s lies in it where the cubic

    (s - t m) . N(t) = s.N0 + (s.N1 - m.N0) t + (s.N2 - m.N1) t^2 - m.N2 t^3

vanishes. Everything here is independent of the point.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from anamorph.base.errors import AnamorphError
from anamorph.raytriangle.factors import SAME, without_common_factors

NARROW = 0.1
"""A waist this much smaller than the triangle of the origins is where the scaled t counts from."""

ROUNDING = 8.0 * np.finfo(float).eps
"""What float64 may lose of a sum of products, as a share of its terms."""


@dataclass(frozen=True, eq=False)
class ScaledRays:
    """Ray triangles, moved and scaled; leading axes ... as in the arrays they were made from.

    The scaled t counts from the waist, where the parametric triangle is smallest, if it is much smaller there than at
    the origins: near a focus, cubics that count from elsewhere have no digits left. There the points r_i are at most 1
    from their middle; the directions are at most 1 long. Weights over the triangle are 1/3 each, plus `SPREAD` times a
    pair of coordinates.

    Parameters
    ----------
    center, remainder : (..., 3) float64
        Their sum is the point that becomes the origin, metres. Apart, they hold more digits than one number.
    size : (...) float64
        Metres for one scaled unit of length.
    pace : (...) float64
        How much t changes for one unit of the scaled t.
    shift : (...) float64
        How much less the scaled t is, in its units: t = pace (scaled t + shift).
    origins, directions : (..., 2, 3) float64
        The two differences of waist points and of directions that go with the pair of coordinates.
    mean : (..., 3) float64
        The mean direction.
    planes : (..., 3, 3) float64
        N0, N1, N2, with common factors divided out.
    flat : (...) bool
        The rays have no triangle between them at any t: no point is projected.
    extent : (...) float64
        The origins' greatest distance from their middle.
    blur : (...) float64
        The size that rounding may have given the waist, where that is taken for a point; 0 elsewhere.
    noise : (...) float64
        What rounding and the division by common factors leave open of a cubic, for a point 1 from the origin.
    lines : (..., 2) float64
        The scaled t of the common factors, where the parametric triangle is a line or a point; infinite for none.
    """

    center: np.ndarray
    remainder: np.ndarray
    size: np.ndarray
    pace: np.ndarray
    shift: np.ndarray
    origins: np.ndarray
    directions: np.ndarray
    mean: np.ndarray
    planes: np.ndarray
    flat: np.ndarray
    extent: np.ndarray
    blur: np.ndarray
    noise: np.ndarray
    lines: np.ndarray

    def local(self, points: np.ndarray) -> np.ndarray:
        """World points (..., N, 3) in scaled units."""
        around = (points - self.center[..., None, :]) - self.remainder[..., None, :]
        return around / self.size[..., None, None]


SPREAD = np.array([[-1.0, 1.0, 0.0], [-1.0, -1.0, 2.0]]) / np.sqrt([[2.0], [6.0]])
"""(2, 3): orthonormal directions in which weights change that go on summing to 1."""


def checked(origins: np.ndarray, directions: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The rays as float64 (..., 3, 3), if they can be used."""
    origins, directions = np.asarray(origins, float), np.asarray(directions, float)
    if origins.shape[-2:] != (3, 3) or directions.shape != origins.shape:
        raise AnamorphError("ray triangle: origins and directions must both be three rows of three numbers")
    if not (np.isfinite(origins).all() and np.isfinite(directions).all()):
        raise AnamorphError("ray triangle: origins and directions must be finite numbers")
    if not directions.any(axis=(-1, -2)).all():
        raise AnamorphError("ray triangle: all three directions are 0; give at least one a length")
    return origins, directions


def scaled_rays(origins: np.ndarray, directions: np.ndarray) -> ScaledRays:
    """Ray triangles in units of their own, and their planes.

    Parameters
    ----------
    origins, directions : (..., 3, 3) array
        A row for each of the three rays; directions of any length, but not all of them 0.

    Raises
    ------
    AnamorphError
        If a number is not finite, or all directions of a ray triangle are 0.
    """
    origins, directions = checked(origins, directions)
    longest = np.linalg.norm(directions, axis=-1).max(axis=-1)[..., None, None]
    along = directions / longest
    mean = along.mean(axis=-2)
    spread = SPREAD @ along
    center = origins.mean(axis=-2)
    around = origins - center[..., None, :]
    # The rounded mean is not quite the middle; what is left of it is small and exact.
    remainder = around.mean(axis=-2)
    around = around - remainder[..., None, :]
    widest = _widest(around)
    rounding = 4.0 * np.finfo(float).eps * np.abs(origins).max(axis=(-1, -2))
    squared = np.sum(spread * spread, axis=(-1, -2))
    waist = -np.sum((SPREAD @ around) * spread, axis=(-1, -2)) / np.where(squared > 0.0, squared, 1.0)
    there = around + waist[..., None, None] * (along - mean[..., None, :])
    narrow = (squared > 0.0) & (_widest(there) < NARROW * widest)
    around = np.where(narrow[..., None, None], there, around)
    waist = np.where(narrow, waist, 0.0)
    # What is left of a focus by rounding is a point.
    size = _widest(around)
    blur = np.maximum(rounding, 16.0 * ROUNDING * (widest + np.abs(waist)) * (waist != 0.0))
    is_point = size <= blur
    size = np.where(is_point, longest[..., 0, 0], size)
    around = np.where(is_point[..., None, None], 0.0, around) / size[..., None, None]
    planes = _planes(SPREAD @ around, spread)
    divided, remains, lines = without_common_factors(planes)
    extent = np.where(widest > rounding, widest, 0.0) / size
    # The way to the waist, long against its size, costs digits as well.
    noise = ROUNDING * (1.0 + extent + np.abs(waist) / size) + 2.0 * remains
    return ScaledRays(
        center=center,
        remainder=remainder + waist[..., None] * mean,
        size=size,
        pace=size / longest[..., 0, 0],
        shift=waist / size,
        origins=SPREAD @ around,
        directions=spread,
        mean=mean,
        planes=divided,
        flat=np.linalg.norm(planes, axis=-1).max(axis=-1) <= SAME,
        extent=extent,
        blur=np.where(is_point, blur, 0.0) / size,
        noise=noise,
        lines=lines,
    )


def _widest(around: np.ndarray) -> np.ndarray:
    return np.linalg.norm(around, axis=-1).max(axis=-1)


def _planes(origins: np.ndarray, directions: np.ndarray) -> np.ndarray:
    """N0, N1, N2 (..., 3, 3)."""
    (e, g), (f, h) = np.moveaxis(origins, -2, 0), np.moveaxis(directions, -2, 0)
    return np.stack([np.cross(e, g), np.cross(e, h) + np.cross(f, g), np.cross(f, h)], axis=-2)
