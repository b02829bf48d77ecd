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

from anamorph.base.errors import AnamorphError

NARROW = 0.1
"""A waist this much smaller than the triangle of the origins is where the frame's t counts from."""

SAME = 1e-13
"""Below this, in its own frame, the parametric triangle has no extent: it is a point, or a line. Sixty times what
float64 loses in the products that say so."""


ROUNDING = 8.0 * np.finfo(float).eps


@dataclass(frozen=True, eq=False)
class RayTriangleFrame:
    """Ray triangles, moved and scaled; leading axes ... as in the arrays they were made from.

    The frame's t counts from the waist, where the parametric triangle is smallest, if it is much smaller there than at
    the origins: near a focus, cubics that count from elsewhere have no digits left. There the points r_i are at most 1
    from their middle; the directions are at most 1 long. Weights over the triangle are 1/3 each, plus `SPREAD` times a
    pair of coordinates.

    Parameters
    ----------
    center, remainder : (..., 3) float64
        Their sum is the frame's origin, metres. Apart, they hold more digits than one number.
    size : (...) float64
        Metres for one unit of length in the frame.
    pace : (...) float64
        How much t changes for one unit of the frame's t.
    shift : (...) float64
        How much less the frame's t is, in its units: t = pace (frame's t + shift).
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
        What rounding and the division by common factors leave open of a cubic, for a point 1 from the frame's origin.
    lines : (..., 2) float64
        The frame's t of the common factors, where the parametric triangle is a line or a point; infinite for none.
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
        """World points (..., N, 3) in the frame."""
        around = (points - self.center[..., None, :]) - self.remainder[..., None, :]
        return around / self.size[..., None, None]

    def cubics(self, local: np.ndarray) -> np.ndarray:
        """Coefficients (..., N, 4), from t^0 to t^3, of points (..., N, 3) in the frame."""
        at_point = np.einsum("...ni,...ki->...nk", local, self.planes)
        at_middle = np.einsum("...i,...ki->...k", self.mean, self.planes)[..., None, :]
        result = np.zeros((*at_point.shape[:-1], 4))
        result[..., :3] = at_point
        result[..., 1:] -= at_middle
        return result

    def sizes(self, local: np.ndarray) -> np.ndarray:
        """The greater distance of points (..., N, 3) in the frame, or of the origins, from the origins' middle."""
        off = local + (self.shift[..., None] * self.mean)[..., None, :]
        return np.maximum(np.linalg.norm(off, axis=-1), self.extent[..., None])

    def values(self, local: np.ndarray, t: float) -> np.ndarray:
        """How far points (N, 3) in the frame lie from the plane at the world's t, in lengths of N(t); (N,)."""
        at = t / self.pace - self.shift
        normal = self.planes[0] + at * (self.planes[1] + at * self.planes[2])
        return (local - at * self.mean) @ normal


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
    longest = np.linalg.norm(directions, axis=-1).max(axis=-1)[..., None, None]
    turned = directions / longest
    mean = turned.mean(axis=-2)
    spread = SPREAD @ turned
    center = origins.mean(axis=-2)
    around = origins - center[..., None, :]
    # The rounded mean is not quite the middle; what is left of it is small and exact.
    remainder = around.mean(axis=-2)
    around = around - remainder[..., None, :]
    widest = _widest(around)
    rounding = 4.0 * np.finfo(float).eps * np.abs(origins).max(axis=(-1, -2))
    squared = np.sum(spread * spread, axis=(-1, -2))
    waist = -np.sum((SPREAD @ around) * spread, axis=(-1, -2)) / np.where(squared > 0.0, squared, 1.0)
    there = around + waist[..., None, None] * (turned - mean[..., None, :])
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
    divided, remains, lines = _without_common_factors(planes)
    extent = np.where(widest > rounding, widest, 0.0) / size
    # The way to the waist, long against its size, costs digits as well.
    noise = ROUNDING * (1.0 + extent + np.abs(waist) / size) + 2.0 * remains
    return RayTriangleFrame(
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


def _without_common_factors(planes: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
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
