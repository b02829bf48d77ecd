"""What a ray triangle contributes to the projection of any point: its own frame, and the planes it sweeps.

Source: Vallance 2005, section 3.6 and appendix A.3, derived again, because the indices of the printed equation 3.31 are
in another order. At each t the points r_i(t) = p_i + t n_i span a plane with the normal N(t) = N0 + N1 t + N2 t^2,
through their middle, which the frame makes t m with m the mean direction. A point s lies in it where the cubic

    (s - t m) . N(t) = s.N0 + (s.N1 - m.N0) t + (s.N2 - m.N1) t^2 - m.N2 t^3

vanishes. Everything here is independent of the point.

Where the points r_i(t0) fall on one line or together, N(t0) = 0 and every point would have the root t0, though no ray
leads to it. That factor is divided out beforehand: a pinhole leaves a linear equation, as it should.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from anamorph.errors import AnamorphError

SAME = 1e-13
"""Below this, in its own frame, the parametric triangle has no extent: it is a point, or a line. Sixty times what
float64 loses in the products that say so."""


@dataclass(frozen=True, eq=False)
class RayTriangleFrame:
    """Ray triangles, moved to their middle and scaled; leading axes ... as in the arrays they were made from.

    In the frame the origins are at most 1 from their middle and the directions at most 1 long. Weights over the
    triangle are 1/3 each, plus `SPREAD` times a pair of coordinates.

    Parameters
    ----------
    center : (..., 3) float64
        The middle of the origins, metres.
    size : (...) float64
        Metres for one unit of length in the frame.
    pace : (...) float64
        How much t changes for one unit of the frame's t.
    origins, directions : (..., 2, 3) float64
        The two differences of origins and of directions that go with the pair of coordinates.
    mean : (..., 3) float64
        The mean direction.
    planes : (..., 3, 3) float64
        N0, N1, N2, with common factors divided out.
    flat : (...) bool
        The rays have no triangle between them at any t: no point is projected.
    extent : (...) float64
        The origins' greatest distance from their middle: 1, or 0 where all of them coincide.
    """

    center: np.ndarray
    size: np.ndarray
    pace: np.ndarray
    origins: np.ndarray
    directions: np.ndarray
    mean: np.ndarray
    planes: np.ndarray
    flat: np.ndarray
    extent: np.ndarray

    def local(self, points: np.ndarray) -> np.ndarray:
        """World points (..., N, 3) in the frame."""
        return (points - self.center[..., None, :]) / self.size[..., None, None]

    def cubics(self, local: np.ndarray) -> np.ndarray:
        """Coefficients (..., N, 4), from t^0 to t^3, of points (..., N, 3) in the frame."""
        at_point = np.einsum("...ni,...ki->...nk", local, self.planes)
        at_middle = np.einsum("...i,...ki->...k", self.mean, self.planes)[..., None, :]
        result = np.zeros((*at_point.shape[:-1], 4))
        result[..., :3] = at_point
        result[..., 1:] -= at_middle
        return result

    def values(self, local: np.ndarray, t: float) -> np.ndarray:
        """How far points (N, 3) in the frame lie from the plane at the world's t, in lengths of N(t); (N,)."""
        t = t / self.pace
        normal = self.planes[0] + t * (self.planes[1] + t * self.planes[2])
        return (local - t * self.mean) @ normal


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


def ray_triangle_frame(origins: np.ndarray, directions: np.ndarray) -> RayTriangleFrame:
    """The frame and the planes of ray triangles.

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
    longest = np.linalg.norm(directions, axis=-1).max(axis=-1)
    center = origins.mean(axis=-2)
    around = origins - center[..., None, :]
    # The rounded mean is not quite the middle; what is left of it is exact enough to take away.
    left = around.mean(axis=-2)
    widest = np.linalg.norm(around, axis=-1).max(axis=-1)
    widest = np.where(widest > 4.0 * np.finfo(float).eps * np.abs(origins).max(axis=(-1, -2)), widest, 0.0)
    size = np.where(widest > 0.0, widest, longest)
    pace = size / longest
    around = np.where(widest > 0.0, 1.0, 0.0)[..., None, None] * (around - left[..., None, :]) / size[..., None, None]
    turned = directions / longest[..., None, None]
    spread_origins, spread_directions = SPREAD @ around, SPREAD @ turned
    planes = _planes(spread_origins, spread_directions)
    flat = np.linalg.norm(planes, axis=-1).max(axis=-1) <= SAME
    return RayTriangleFrame(
        center=center + np.where(widest > 0.0, 1.0, 0.0)[..., None] * left,
        size=size,
        pace=pace,
        origins=spread_origins,
        directions=spread_directions,
        mean=turned.mean(axis=-2),
        planes=_without_common_factors(planes, spread_origins, spread_directions),
        flat=flat,
        extent=np.where(widest > 0.0, 1.0, 0.0),
    )


def _planes(origins: np.ndarray, directions: np.ndarray) -> np.ndarray:
    """N0, N1, N2 (..., 3, 3)."""
    (e, g), (f, h) = np.moveaxis(origins, -2, 0), np.moveaxis(directions, -2, 0)
    return np.stack([np.cross(e, g), np.cross(e, h) + np.cross(f, g), np.cross(f, h)], axis=-2)


def _without_common_factors(planes: np.ndarray, origins: np.ndarray, directions: np.ndarray) -> np.ndarray:
    """The planes divided by (t - t0) for every t0 at which the parametric triangle is a line, twice where a point."""
    divided = planes
    for _ in range(2):
        t0, exists = _line(divided)
        divided = np.where(exists[..., None, None], _divided(divided, t0), divided)
    # Where the triangle is a point, the t0 of its least extent is sharp, which the double root of its area is not.
    squared = np.einsum("...ki,...ki->...", directions, directions)
    t0 = -np.einsum("...ki,...ki->...", origins, directions) / np.where(squared > 0.0, squared, 1.0)
    extent = np.linalg.norm(origins + t0[..., None, None] * directions, axis=(-1, -2))
    is_point = (squared > 0.0) & (extent <= SAME * (1.0 + np.abs(t0)))
    # All the planes are then parallel, and the longest normal has the most digits.
    parallel = np.zeros_like(planes)
    parallel[..., 0, :] = _longest(planes)
    return np.where(is_point[..., None, None], parallel, divided)


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
        normal = planes[..., 0, :] + t0[..., None] * (planes[..., 1, :] + t0[..., None] * planes[..., 2, :])
        vanishes = usable & (np.linalg.norm(normal, axis=-1) <= SAME * (1.0 + np.abs(t0)) ** 2)
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
