"""Normals of patches, also where an edge or a corner has collapsed to a point."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from anamorph.base.errors import AnamorphError

Derivative = Callable[[np.ndarray, int, int], np.ndarray]


def unit_normals(
    derivative: Derivative, low: np.ndarray, high: np.ndarray, extent: float, uv: np.ndarray
) -> np.ndarray:
    """Directions of d/du x d/dv, (N, 3) float64; where it vanishes, their limit from inside.

    Parameters
    ----------
    derivative : callable
        Partial derivative (N, 3) of the position, at parameters (N, 2), of two orders.
    low, high : (2,) array
        Bounds of (u, v).
    extent : float
        Size of the surface, metres: what is small against it is zero.
    uv : (N, 2) array
    """
    uv = np.asarray(uv, float).reshape(-1, 2)
    size = high - low

    def along(at: np.ndarray, order_u: int, order_v: int) -> np.ndarray:
        return derivative(at, order_u, order_v) * (size[0] ** order_u * size[1] ** order_v)

    normal = np.cross(along(uv, 1, 0), along(uv, 0, 1))
    collapsed = np.linalg.norm(normal, axis=1) <= 1e-7 * extent**2
    if collapsed.any():
        inward = np.where(uv[collapsed] < (low + high) / 2.0, 1.0, -1.0)
        normal[collapsed] = _limit(along, uv[collapsed], inward, size, 1e-7 * extent**2)
    return normal / np.linalg.norm(normal, axis=1, keepdims=True)


def _limit(along: Derivative, uv: np.ndarray, inward: np.ndarray, size: np.ndarray, least: float) -> np.ndarray:
    """Directions of the normals near collapsed points, by the change of d/du x d/dv toward the inside."""
    to_u, to_v = inward[:, :1], inward[:, 1:]
    along_u, along_v, mixed = along(uv, 1, 0), along(uv, 0, 1), along(uv, 1, 1)
    change = np.cross(to_u * along(uv, 2, 0) + to_v * mixed, along_v)
    change += np.cross(along_u, to_u * mixed + to_v * along(uv, 0, 2))
    still = np.linalg.norm(change, axis=1) <= least
    # A corner may collapse to second order: a short step inside leaves it.
    near = uv[still] + 1e-3 * inward[still] * size
    change[still] = np.cross(along(near, 1, 0), along(near, 0, 1))
    if not np.linalg.norm(change, axis=1).all():
        raise AnamorphError("surface: its control points collapse to a line; remove the patch")
    return change
