"""Exact surfaces of lenses that are given by their sag: how deep they lie below the plane that touches their apex.

Both take (u, v) = (x, y), metres in that plane: position = apex + u right + v up - sag(u, v) outward. A positive
curvature bulges outward.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.polynomial.polynomial import polyval

from anamorph.base.errors import AnamorphError

MOST_COEFFICIENTS = 16


@dataclass(frozen=True, eq=False)
class Toroid:
    """A piece of a torus, as on a lens for astigmatism: an arc along `up`, turned about an axis along `up`.

    Parameters
    ----------
    apex : (3,) array
        Metres.
    base_curvature : float
        One over the radius of the section along `right`, the circle of turning; 0 makes a cylinder. In 1/m.
    cross_curvature : float
        One over the radius of the section along `up`, the turned arc. In 1/m.
    axes : (3, 3) array
        Rows: the unit vectors right, up and outward at the apex, right-handed and perpendicular.
    """

    apex: np.ndarray
    base_curvature: float
    cross_curvature: float
    axes: np.ndarray = field(default_factory=lambda: np.eye(3))

    def __post_init__(self) -> None:
        _check("toroid", self.apex, self.axes, (self.base_curvature, self.cross_curvature))

    def sag(self, uv: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The sag, (N,), and its slopes along u and v, (N, 2)."""
        x, y = np.asarray(uv, float).T
        base, cross = self.base_curvature, self.cross_curvature
        arc_root = _root("toroid", 1.0 - (cross * y) ** 2)
        arc = cross * y**2 / (1.0 + arc_root)
        lever = 1.0 - base * arc
        root = _root("toroid", np.where(lever > 0.0, lever**2 - (base * x) ** 2, -1.0))
        sag = (2.0 * arc - base * arc**2 + base * x**2) / (1.0 + root)
        return sag, np.stack([base * x / root, lever * cross * y / (arc_root * root)], axis=-1)

    def position(self, uv: np.ndarray) -> np.ndarray:
        return _lifted(self.apex, self.axes, uv, self.sag(uv)[0])

    def normal(self, uv: np.ndarray) -> np.ndarray:
        return _tilted(self.axes, self.sag(uv)[1])

    def parameters(self, points: np.ndarray) -> np.ndarray:
        """The (u, v), (N, 2) float64, of the surface points above or below `points` (N, 3)."""
        return (np.asarray(points, float) - self.apex) @ np.asarray(self.axes, float)[:2].T


@dataclass(frozen=True, eq=False)
class EvenAsphere:
    """A conic of revolution and even powers of the distance r from its axis (ISO 10110-12).

    sag = c r^2 / (1 + sqrt(1 - (1 + k) c^2 r^2)) + sum over i of coefficients[i] r^(4 + 2 i).

    Parameters
    ----------
    apex : (3,) array
        Metres.
    curvature : float
        c, one over the radius at the apex, in 1/m.
    conic : float
        k: 0 a sphere, -1 a paraboloid, below a hyperboloid.
    coefficients : tuple of float
        Of r^4, r^6 and so on, in 1/m^3, 1/m^5 and so on; at most 16.
    axes : (3, 3) array
        Rows: the unit vectors right, up and outward at the apex, right-handed and perpendicular.
    """

    apex: np.ndarray
    curvature: float
    conic: float = 0.0
    coefficients: tuple[float, ...] = ()
    axes: np.ndarray = field(default_factory=lambda: np.eye(3))

    def __post_init__(self) -> None:
        _check("asphere", self.apex, self.axes, (self.curvature, self.conic, *self.coefficients))
        if len(self.coefficients) > MOST_COEFFICIENTS:
            raise AnamorphError(f"asphere: has {len(self.coefficients)} coefficients; give at most {MOST_COEFFICIENTS}")

    def sag(self, uv: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The sag, (N,), and its slopes along u and v, (N, 2)."""
        uv = np.asarray(uv, float)
        square = np.sum(uv**2, axis=1)
        root = _root("asphere", 1.0 - (1.0 + self.conic) * self.curvature**2 * square)
        powers = np.array([0.0, 0.0, *self.coefficients])
        sag = self.curvature * square / (1.0 + root) + polyval(square, powers)
        slope = self.curvature / root + 2.0 * polyval(square, powers[1:] * np.arange(1, len(powers)))
        return sag, slope[:, None] * uv

    def position(self, uv: np.ndarray) -> np.ndarray:
        return _lifted(self.apex, self.axes, uv, self.sag(uv)[0])

    def normal(self, uv: np.ndarray) -> np.ndarray:
        return _tilted(self.axes, self.sag(uv)[1])

    def parameters(self, points: np.ndarray) -> np.ndarray:
        """The (u, v), (N, 2) float64, of the surface points above or below `points` (N, 3)."""
        return (np.asarray(points, float) - self.apex) @ np.asarray(self.axes, float)[:2].T


def _check(name: str, apex: np.ndarray, axes: np.ndarray, numbers: tuple[float, ...]) -> None:
    if np.shape(apex) != (3,) or not np.isfinite(apex).all():
        raise AnamorphError(f"{name}: apex is {apex}; give three finite numbers in metres")
    if not np.isfinite(numbers).all():
        raise AnamorphError(f"{name}: its shape has the numbers {numbers}; give finite ones")
    axes = np.asarray(axes, float)
    if not (axes.shape == (3, 3) and np.allclose(axes @ axes.T, np.eye(3), atol=1e-9) and np.linalg.det(axes) > 0):
        raise AnamorphError(f"{name}: axes must be three perpendicular unit rows, right x up = outward")


def _root(name: str, square: np.ndarray) -> np.ndarray:
    if (square <= 0.0).any():
        raise AnamorphError(f"{name}: has no points so far from its apex; keep closer to it, or make it flatter")
    return np.sqrt(square)


def _lifted(apex: np.ndarray, axes: np.ndarray, uv: np.ndarray, sag: np.ndarray) -> np.ndarray:
    return np.asarray(apex, float) + np.column_stack([uv, -sag]) @ np.asarray(axes, float)


def _tilted(axes: np.ndarray, slopes: np.ndarray) -> np.ndarray:
    normal = np.column_stack([slopes, np.ones(len(slopes))]) @ np.asarray(axes, float)
    return normal / np.linalg.norm(normal, axis=1, keepdims=True)
