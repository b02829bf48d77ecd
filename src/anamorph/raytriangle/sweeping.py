"""Whether a ray triangle may see a point more than once, by its parametric triangle, which sweeps along the rays.

As t grows, the triangle with the corners p_k + t d_k sweeps the volume that the rays fill, and a point that is seen
twice lies in it at two t. Let N(t) be its normal. Where all d_k . N(t) have one sign, all corners leave the plane to
one side, so that no other position of the triangle touches it: its points are seen once.

Source: Mei, Popescu and Sacks 2007, section 5.1. Deviation: the paper names intervals of t in which points may be seen
twice. Here each point is judged at its own t, because the intervals have no end where rays cross only once.
"""

from __future__ import annotations

import numpy as np

from anamorph.raytriangle.scaled import checked

NOISE = 1e-11
"""A product of less than this share of its factors' lengths has no sign."""


def seen_once(origins: np.ndarray, directions: np.ndarray, t: np.ndarray) -> np.ndarray:
    """Whether points that a ray triangle sees are seen by no other of its rays.

    Parameters
    ----------
    origins, directions : (..., 3, 3) array
        A row for each of the three rays. Leading axes are many ray triangles.
    t : (...) array
        Where along its ray each point lies, in lengths of the interpolated direction: a root from `project_points`.

    Returns
    -------
    (...) bool
        True only where no other ray meets the point. False says nothing: of a ray triangle that rounding cannot tell
        from a flat one, all are False.

    Raises
    ------
    AnamorphError
        If a number is not finite, or all directions of a ray triangle are 0.
    """
    origins, directions = checked(origins, directions)
    rises, noise = _rises(origins, directions, np.asarray(t, float))
    return np.all(rises > noise, axis=-1) | np.all(rises < -noise, axis=-1)


def sees_once(origins: np.ndarray, directions: np.ndarray, near: np.ndarray, far: np.ndarray) -> np.ndarray:
    """Whether ray triangles see no point from t = near to t = far more than once.

    Parameters
    ----------
    origins, directions : (..., 3, 3) array
    near, far : (...) array
        In lengths of the interpolated direction.

    Returns
    -------
    (...) bool
        True only where that is so; False says nothing.

    Raises
    ------
    AnamorphError
        If a number is not finite, or all directions of a ray triangle are 0.
    """
    origins, directions = checked(origins, directions)
    ends = np.stack([np.asarray(near, float), np.asarray(far, float)], axis=-1)
    _, b, a = _quadratics(origins, directions)
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        turns = -0.5 * b / a
    # Each product is least and greatest at the ends, or where it turns.
    turns = np.clip(np.where(np.isfinite(turns), turns, ends[..., :1]), ends[..., :1], ends[..., 1:])
    t = np.concatenate([ends, turns], axis=-1)
    rises, noise = _rises(origins[..., None, :, :], directions[..., None, :, :], t)
    return np.all(rises > noise, axis=(-2, -1)) | np.all(rises < -noise, axis=(-2, -1))


def _rises(origins: np.ndarray, directions: np.ndarray, t: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """d_k . N(t) of each ray, (..., 3), and below which size it has no sign."""
    t = t[..., None, None]
    corners = origins + t * directions
    one, other = corners[..., 1, :] - corners[..., 0, :], corners[..., 2, :] - corners[..., 0, :]
    rises = np.einsum("...ki,...i->...k", directions, np.cross(one, other))
    # What rounding takes from the corners counts as much as what it takes from the products.
    size = np.abs(origins).max(axis=(-2, -1)) + np.abs(t[..., 0, 0]) * np.abs(directions).max(axis=(-2, -1))
    lengths = np.linalg.norm(one, axis=-1) + np.linalg.norm(other, axis=-1)
    return rises, NOISE * np.linalg.norm(directions, axis=-1) * (lengths * (lengths + size))[..., None]


def _quadratics(origins: np.ndarray, directions: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """c, b and a (..., 3) of d_k . N(t) = c + b t + a t^2."""
    e, f = (each[..., 1:, :] - each[..., :1, :] for each in (origins, directions))
    at_0 = np.cross(e[..., 0, :], e[..., 1, :])
    more = np.cross(e[..., 0, :], f[..., 1, :]) + np.cross(f[..., 0, :], e[..., 1, :])
    most = np.cross(f[..., 0, :], f[..., 1, :])
    c, b, a = (np.einsum("...ki,...i->...k", directions, each) for each in (at_0, more, most))
    return c, b, a


def switches(origins: np.ndarray, directions: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Where the parametric triangle has one of its rays in its plane: there the ray changes sides.

    Parameters
    ----------
    origins, directions : (..., 3, 3) array

    Returns
    -------
    t : (..., 3, 2) float64
        Of each ray, in ascending order; 0 where there is none.
    real : (..., 3, 2) bool
        Where there is one.

    Raises
    ------
    AnamorphError
        If a number is not finite, or all directions of a ray triangle are 0.
    """
    c, b, a = _quadratics(*checked(origins, directions))
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        half = -0.5 * (b + np.copysign(np.sqrt(b * b - 4.0 * a * c), b))
        # One root by the sum that cancels nothing, the other by the product of both.
        t = np.stack([half / a, c / half], axis=-1)
    real = np.isfinite(t)
    t = np.sort(np.where(real, t, np.inf), axis=-1)
    real = np.isfinite(t)
    return np.where(real, t, 0.0), real
