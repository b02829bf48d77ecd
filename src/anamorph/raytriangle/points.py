"""Which rays of a ray triangle pass through a point.

Source: Vallance 2005, sections 3.1 to 3.6 and 3.8. The ray at weights (1 - u - v, u, v) is

    ray(u, v, t) = (1 - u - v) p1 + u p2 + v p3 + t ((1 - u - v) n1 + u n2 + v n3)

and the t at which one passes through a point are roots of a cubic; u and v follow in the plane of that t.

Deviations: the cubic is formed in the triangle's own scaled frame, and what its rays alone make vanish is divided out
(`coefficients`); its roots are kept between its extrema instead of taken from a formula (`cubic`), and polished on the
determinant as the product (s - t m) . N(t), which loses less than its expanded terms. The thesis leaves open below
which area a triangle counts as degenerate. Here the question does not arise: a root is valid where its ray passes
through the point, rounding included.

In float32 the same steps hold (`device`) if the frame is made in float64, and frame, point and all of the polishing are
sums of two floats. With floats alone, rays across 800 pixels are off by 4e-5 pixels at the median, by 2e-3 at the 99th
percentile, and by a third of a pixel at caustics. Neighbouring triangles have frames of their own, and do not get the
same bits at a shared edge: what must not crack decides inside or outside by the ray and not by these weights.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from anamorph.base.errors import AnamorphError
from anamorph.raytriangle.coefficients import ROUNDING, SAME, SPREAD, RayTriangleFrame, ray_triangle_frame
from anamorph.raytriangle.cubic import real_roots

REACH = 1e-9
"""How near a valid ray passes by its point, as a share of the greater distance of point and origins from the middle."""

INFINITE = 1e10
"""Times the distance of point or origins from the middle, in the frame: a t beyond is at infinity. No ray with such a t
is valid, since a rounding error of t carries it further from its point than `REACH`."""

OUTERMOST = 1e8
"""A greater weight is noise: its ray would be this many times further from the middle than the triangle is wide."""


@dataclass(frozen=True, eq=False)
class Projections:
    """The up to three places at which each point is seen in a ray triangle, in ascending order of t.

    Parameters
    ----------
    t, u, v : (..., N, 3) float64
        Along the ray, in lengths of its interpolated direction, and the weights of the second and third ray. 0 where
        `real`, or for u and v `valid`, is false.
    real : (..., N, 3) bool
        Where the point lies in the plane of the parametric triangle at t. Rays beyond the triangle count.
    valid : (..., N, 3) bool
        Where, moreover, ray(u, v, t) is the point to 1e-9 of the greater distance of point and origins from the
        origins' middle, or to rounding of the coordinates. Real but not valid is a ray so far outside (weights beyond
        about 1e4) that float64 cannot tell it, or none, where the parametric triangle is a line or a point and the
        point is not on it.
    """

    t: np.ndarray
    u: np.ndarray
    v: np.ndarray
    real: np.ndarray
    valid: np.ndarray

    @property
    def inside(self) -> np.ndarray:
        """Where the valid ray lies in the ray triangle: u, v and 1 - u - v are not negative. (..., N, 3) bool."""
        return self.valid & (self.u >= 0.0) & (self.v >= 0.0) & (self.u + self.v <= 1.0)

    @property
    def seen(self) -> np.ndarray:
        """Where `inside`, and the point lies on the ray and not behind its origin: t >= 0. (..., N, 3) bool."""
        return self.inside & (self.t >= 0.0)


def project_points(origins: np.ndarray, directions: np.ndarray, points: np.ndarray) -> Projections:
    """All the rays of a ray triangle that pass through each point.

    A point that many rays pass through at one t, because there the parametric triangle is a line or a point (the eye of
    a pinhole), is given the one of them nearest to the triangle's middle. A ray triangle whose rays have no triangle
    between them at any t projects nothing, nor is a point projected that lies in the triangle's plane at every t. A
    root that the cubic only touches, within rounding, is reported twice.

    Parameters
    ----------
    origins, directions : (..., 3, 3) array
        A row for each of the three rays. Leading axes are many ray triangles, each with its own projections.
    points : (N, 3) or (..., N, 3) array
        The same for all ray triangles, or some for each.

    Raises
    ------
    AnamorphError
        If a number is not finite, or all directions of a ray triangle are 0.
    """
    points = np.asarray(points, float)
    if not np.isfinite(points).all():
        raise AnamorphError("points: coordinates must be finite numbers")
    return project_into(ray_triangle_frame(origins, directions), points)


def project_into(frame: RayTriangleFrame, points: np.ndarray) -> Projections:
    """As `project_points`, with what does not depend on the points made beforehand by `ray_triangle_frame`."""
    local = frame.local(points)
    cubics = frame.cubics(local)
    far = np.linalg.norm(local, axis=-1)
    noise = frame.noise[..., None] * (1.0 + far)
    roots = real_roots(cubics.reshape(-1, 4), noise.ravel(), (INFINITE * (1.0 + far)).ravel())
    t, real = (array.reshape(*far.shape, 3) for array in roots)
    # Neither a flat ray triangle nor a point in all its planes has any t of its own.
    some = np.abs(cubics).max(axis=-1) > ROUNDING * (1.0 + far)
    real &= (some & ~frame.flat[..., None])[..., None]
    t = _polished(frame, local, t)
    weights, missed = _weights(frame, local, t)
    valid = real & (missed <= (REACH * frame.sizes(local) + frame.blur[..., None])[..., None])
    weights = np.where(valid[..., None], weights, 0.0)
    order = np.argsort(np.where(real, t, np.inf), axis=-1, kind="stable")
    t = np.where(real, (t + frame.shift[..., None, None]) * frame.pace[..., None, None], 0.0)
    return Projections(
        *(np.take_along_axis(array, order, axis=-1) for array in (t, weights[..., 1], weights[..., 2], real, valid))
    )


def rays_at(frame: RayTriangleFrame, points: np.ndarray, t: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """u, v and validity (N,) of the rays that pass, at a given t, through points (N, 3) in the plane of that t."""
    local = frame.local(points)
    weights, missed = _weights(frame, local, np.full((len(points), 1), t / frame.pace - frame.shift))
    valid = missed[:, 0] <= REACH * frame.sizes(local) + frame.blur
    u, v = np.where(valid, weights[:, 0, 1:].T, 0.0)
    return u, v, valid


def _planes_at(frame: RayTriangleFrame, t: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """N(t) and its slope, (..., N, 3 roots, 3)."""
    n0, n1, n2 = (frame.planes[..., None, None, i, :] for i in range(3))
    t = t[..., None]
    return n0 + t * (n1 + t * n2), n1 + 2.0 * t * n2


def _polished(frame: RayTriangleFrame, local: np.ndarray, t: np.ndarray) -> np.ndarray:
    """Roots after two of Newton's steps on the product (s - t m) . N(t), each taken where it comes nearer to zero."""
    mean = frame.mean[..., None, None, :]

    def value(t: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        off, (normal, change) = local[..., None, :] - t[..., None] * mean, _planes_at(frame, t)
        return np.sum(off * normal, axis=-1), np.sum(off * change, axis=-1) - np.sum(mean * normal, axis=-1)

    now, slope = value(t)
    for _ in range(2):
        step = t - np.where(slope != 0.0, now, 0.0) / np.where(slope != 0.0, slope, 1.0)
        then, slope_then = value(step)
        better = np.abs(then) < np.abs(now)
        t, now, slope = np.where(better, step, t), np.where(better, then, now), np.where(better, slope_then, slope)
    return t


def _length(vectors: np.ndarray) -> np.ndarray:
    return np.linalg.norm(vectors, axis=-1)


def _weights(frame: RayTriangleFrame, local: np.ndarray, t: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The weights of the three rays (..., N, 3 roots, 3), and by how much at most their ray passes by the point."""
    along = t[..., None]
    off = local[..., None, :] - along * frame.mean[..., None, None, :]
    starts = [frame.origins[..., None, None, k, :] for k in range(2)]
    changes = [along * frame.directions[..., None, None, k, :] for k in range(2)]
    e, g = (start + change for start, change in zip(starts, changes, strict=True))
    # What the two sums would be without cancelling is what their rounding errors are to be measured by.
    full_e, full_g = (_length(start) + _length(change) for start, change in zip(starts, changes, strict=True))
    normal = np.cross(e, g)
    area = np.sum(normal * normal, axis=-1)
    extent = np.sum(e * e, axis=-1) + np.sum(g * g, axis=-1)
    together = extent <= np.maximum(SAME * (full_e + full_g), frame.blur[..., None, None]) ** 2
    thin = together | (area <= (SAME * (full_e * _length(g) + _length(e) * full_g)) ** 2)

    def solved(off: np.ndarray) -> np.ndarray:
        within = np.stack([np.sum(normal * np.cross(off, g), axis=-1), np.sum(normal * np.cross(e, off), axis=-1)], -1)
        # On a line, the least change of the weights that leads to the point; at a point, no change.
        on_line = np.stack([np.sum(e * off, axis=-1), np.sum(g * off, axis=-1)], -1)
        return np.where(
            thin[..., None],
            np.where(together[..., None], 0.0, on_line) / np.where(together, 1.0, extent)[..., None],
            within / np.where(thin, 1.0, area)[..., None],
        )

    def left(pair: np.ndarray) -> np.ndarray:
        return off - pair[..., :1] * e - pair[..., 1:] * g

    pair = solved(off)
    pair = pair + np.where(thin[..., None], 0.0, solved(left(pair)))
    # What float64 loses in t and in the weights themselves.
    spans = full_e + full_g + (frame.extent + np.abs(frame.shift))[..., None, None] + np.abs(t)
    uncertain = np.abs(pair).sum(axis=-1) * frame.blur[..., None, None]
    lost = uncertain + ROUNDING * (
        (1.0 + np.abs(pair).sum(axis=-1)) * spans + np.linalg.norm(local, axis=-1)[..., None]
    )
    weights = 1.0 / 3.0 + pair @ SPREAD
    missed = np.where(np.abs(weights).max(axis=-1) <= OUTERMOST, _length(left(pair)) + lost, np.inf)
    return weights, missed
