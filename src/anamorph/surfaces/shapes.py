"""Exact shapes of specular surfaces: what a tessellation only approximates.

To add a shape: a frozen dataclass with the two methods of `Surface`, and a case in `surfaces/intersection.py`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np
from numpy.polynomial.polynomial import polyder, polyval

from anamorph.base.errors import AnamorphError


class Surface(Protocol):
    """A parametric surface."""

    def position(self, uv: np.ndarray) -> np.ndarray:
        """World points, (N, 3) float64, at parameters (N, 2)."""
        ...

    def normal(self, uv: np.ndarray) -> np.ndarray:
        """Unit normals pointing outside, (N, 3) float64, at parameters (N, 2)."""
        ...


@dataclass(frozen=True, eq=False)
class Plane:
    """position = origin + u * edge_u + v * edge_v; the normal is edge_u x edge_v, normalised."""

    origin: np.ndarray
    edge_u: np.ndarray
    edge_v: np.ndarray

    def position(self, uv: np.ndarray) -> np.ndarray:
        u, v = np.asarray(uv, float).T
        return np.asarray(self.origin) + u[:, None] * self.edge_u + v[:, None] * self.edge_v

    def normal(self, uv: np.ndarray) -> np.ndarray:
        normal = np.cross(self.edge_u, self.edge_v)
        return np.broadcast_to(normal / np.linalg.norm(normal), (len(uv), 3)).copy()

    def parameters(self, points: np.ndarray) -> np.ndarray:
        """The (u, v), (N, 2) float64, of the plane's points nearest to `points` (N, 3)."""
        edges = np.stack([self.edge_u, self.edge_v]).astype(float)
        return (np.asarray(points, float) - self.origin) @ np.linalg.pinv(edges)


@dataclass(frozen=True, eq=False)
class Sphere:
    """A sphere, by angles in a frame of its own: (u, v) = (0, 0) lies on the outward axis.

    u is the longitude about the up axis, positive to the right; v is the latitude, positive upward; both in radians.
    position = center + radius * (cos v sin u right + sin v up + cos v cos u outward).

    Parameters
    ----------
    center : (3,) array
        Metres.
    radius : float
        Metres.
    axes : (3, 3) array
        Rows: the unit vectors right, up and outward, right-handed and perpendicular.
    """

    center: np.ndarray
    radius: float
    axes: np.ndarray = field(default_factory=lambda: np.eye(3))

    def __post_init__(self) -> None:
        if not (np.isfinite(self.radius) and self.radius > 0):
            raise AnamorphError(f"sphere: radius is {self.radius}; give a positive length in metres")
        axes = np.asarray(self.axes, float)
        if not (np.allclose(axes @ axes.T, np.eye(3), atol=1e-9) and np.linalg.det(axes) > 0):
            raise AnamorphError("sphere: axes must be three perpendicular unit rows, right x up = outward")

    def position(self, uv: np.ndarray) -> np.ndarray:
        return np.asarray(self.center) + self.radius * self.normal(uv)

    def normal(self, uv: np.ndarray) -> np.ndarray:
        u, v = np.asarray(uv, float).T
        local = np.stack([np.cos(v) * np.sin(u), np.sin(v), np.cos(v) * np.cos(u)], axis=-1)
        return local @ np.asarray(self.axes, float)

    def parameters(self, points: np.ndarray) -> np.ndarray:
        """The (u, v), (N, 2) float64, of the surface points in the directions of `points` (N, 3) from the center."""
        right, up, outward = np.asarray(self.axes, float) @ (np.asarray(points, float) - self.center).T
        return np.stack([np.arctan2(right, outward), np.arctan2(up, np.hypot(right, outward))], axis=-1)


@dataclass(frozen=True, eq=False)
class BezierPatch:
    """A bicubic Bezier patch: position = sum over i, j of B_i(u) B_j(v) control[i, j], with u and v in 0 to 1.

    The normal points along d/du x d/dv. Where that vanishes (a collapsed edge, a pole) it is the limit from inside.

    Parameters
    ----------
    control : (4, 4, 3) array
        Control points, metres; the first index runs along u.
    """

    control: np.ndarray

    def __post_init__(self) -> None:
        if np.shape(self.control) != (4, 4, 3) or not np.isfinite(self.control).all():
            raise AnamorphError(f"Bezier patch: control is {np.shape(self.control)}; give (4, 4, 3) finite numbers")

    def position(self, uv: np.ndarray) -> np.ndarray:
        return self.derivative(uv, 0, 0)

    def derivative(self, uv: np.ndarray, order_u: int, order_v: int) -> np.ndarray:
        """Partial derivative of the position, (N, 3) float64, at parameters (N, 2)."""
        u, v = np.asarray(uv, float).T
        return np.einsum("ni,nj,ijk->nk", _bernstein(u, order_u), _bernstein(v, order_v), np.asarray(self.control))

    def normal(self, uv: np.ndarray) -> np.ndarray:
        extent = float(np.ptp(np.reshape(self.control, (-1, 3)), axis=0).max())
        return unit_normals(self.derivative, np.zeros(2), np.ones(2), extent, uv)


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


def _bernstein(t: np.ndarray, order: int) -> np.ndarray:
    """The four cubic Bernstein polynomials at `t` (N,), or their derivatives of `order`: (N, 4)."""
    powers = np.array([[1.0, 0.0, 0.0, 0.0], [-3.0, 3.0, 0.0, 0.0], [3.0, -6.0, 3.0, 0.0], [-1.0, 3.0, -3.0, 1.0]])
    return polyval(t, polyder(powers, order) if order else powers).T
