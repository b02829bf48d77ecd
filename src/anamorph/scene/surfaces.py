"""Exact shapes of specular surfaces: what a tessellation only approximates.

To add a shape: a frozen dataclass with the two methods of `Surface`, and a case in `optics/exact.py`.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Protocol

import numpy as np
from numpy.polynomial.polynomial import polyder, polyval

from anamorph.errors import AnamorphError


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
        uv = np.asarray(uv, float)
        normal = np.cross(self.derivative(uv, 1, 0), self.derivative(uv, 0, 1))
        extent = np.ptp(np.reshape(self.control, (-1, 3)), axis=0).max()
        collapsed = np.linalg.norm(normal, axis=1) <= 1e-7 * extent**2
        if collapsed.any():
            normal[collapsed] = self._limit(uv[collapsed], 1e-7 * extent**2)
        return normal / np.linalg.norm(normal, axis=1, keepdims=True)

    def _limit(self, uv: np.ndarray, least: float) -> np.ndarray:
        """Directions of the normals near collapsed points, by the change of d/du x d/dv toward the inside."""
        inward = np.where(uv < 0.5, 1.0, -1.0)
        to_u, to_v = inward[:, :1], inward[:, 1:]
        along_u, along_v, mixed = self.derivative(uv, 1, 0), self.derivative(uv, 0, 1), self.derivative(uv, 1, 1)
        change = np.cross(to_u * self.derivative(uv, 2, 0) + to_v * mixed, along_v)
        change += np.cross(along_u, to_u * mixed + to_v * self.derivative(uv, 0, 2))
        still = np.linalg.norm(change, axis=1) <= least
        # A corner may collapse to second order: a short step inside leaves it.
        near = uv[still] + 1e-3 * inward[still]
        change[still] = np.cross(self.derivative(near, 1, 0), self.derivative(near, 0, 1))
        if not np.linalg.norm(change, axis=1).all():
            raise AnamorphError("Bezier patch: control points collapse to a line; remove the patch")
        return change


def _bernstein(t: np.ndarray, order: int) -> np.ndarray:
    """The four cubic Bernstein polynomials at `t` (N,), or their derivatives of `order`: (N, 4)."""
    powers = np.array([[1.0, 0.0, 0.0, 0.0], [-3.0, 3.0, 0.0, 0.0], [3.0, -6.0, 3.0, 0.0], [-1.0, 3.0, -3.0, 1.0]])
    return polyval(t, polyder(powers, order) if order else powers).T
