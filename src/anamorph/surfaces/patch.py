"""Patches: surfaces by two parameters over a rectangle, with derivatives of any order that is asked for."""

from __future__ import annotations

from abc import abstractmethod

import numpy as np
from scipy.spatial import KDTree

from anamorph.base.errors import AnamorphError
from anamorph.surfaces.base import Surface

POLE = 1e-6
"""A parameter moves nothing where the surface moves by less than this share of its size over all of its range."""

SAMPLES = 33
"""Points along each side among which a search without a start takes the nearest."""


class Patch(Surface):
    """A surface with derivatives, whose edges may collapse to a pole, and which may close on itself.

    The normal points along sign * d/du x d/dv. Where that vanishes (a pole) it is the limit from inside.
    """

    sign: float = 1.0
    """-1 for one whose outside is the other side."""

    @property
    @abstractmethod
    def domain(self) -> tuple[np.ndarray, np.ndarray]:
        """The least and the greatest (u, v), (2,) float64 each."""

    @property
    @abstractmethod
    def extent(self) -> float:
        """Its size, metres: what is small against it is zero."""

    @abstractmethod
    def derivative(self, uv: np.ndarray, order_u: int, order_v: int) -> np.ndarray:
        """Partial derivative of the position, (N, 3) float64, at parameters (N, 2); orders sum to 2 at most."""

    def position(self, uv: np.ndarray) -> np.ndarray:
        return self.derivative(uv, 0, 0)

    def normal(self, uv: np.ndarray) -> np.ndarray:
        uv, (low, high) = np.asarray(uv, float).reshape(-1, 2), self.domain
        least = 1e-7 * self.extent**2
        normal = np.cross(self._slope(uv, 1, 0), self._slope(uv, 0, 1))
        collapsed = np.linalg.norm(normal, axis=1) <= least
        if collapsed.any():
            inward = np.where(uv[collapsed] < (low + high) / 2.0, 1.0, -1.0)
            normal[collapsed] = self._limit(uv[collapsed], inward, least)
        return self.sign * (normal / np.linalg.norm(normal, axis=1, keepdims=True))

    def _slope(self, uv: np.ndarray, order_u: int, order_v: int) -> np.ndarray:
        """Like `derivative`, by parameters that go from 0 to 1."""
        low, high = self.domain
        size = high - low
        return self.derivative(uv, order_u, order_v) * (size[0] ** order_u * size[1] ** order_v)

    def _limit(self, uv: np.ndarray, inward: np.ndarray, least: float) -> np.ndarray:
        """Directions of the normals at collapsed points, by the change of d/du x d/dv toward the inside."""
        to_u, to_v = inward[:, :1], inward[:, 1:]
        along_u, along_v, mixed = self._slope(uv, 1, 0), self._slope(uv, 0, 1), self._slope(uv, 1, 1)
        change = np.cross(to_u * self._slope(uv, 2, 0) + to_v * mixed, along_v)
        change += np.cross(along_u, to_u * mixed + to_v * self._slope(uv, 0, 2))
        still = np.linalg.norm(change, axis=1) <= least
        # A corner may collapse to second order: a short step inside leaves it.
        low, high = self.domain
        near = uv[still] + 1e-3 * inward[still] * (high - low)
        change[still] = np.cross(self._slope(near, 1, 0), self._slope(near, 0, 1))
        if not np.linalg.norm(change, axis=1).all():
            raise AnamorphError("surface: its control points collapse to a line; remove the patch")
        return change

    def curvatures(self, uv: np.ndarray) -> np.ndarray:
        """Principal curvatures, (N, 2) float64, 1/m, the greater first; positive where it bends away from its normal.

        Near a pole they are those of a point a thousandth of the domain further inside.
        """
        uv = self._off_poles(np.asarray(uv, float).reshape(-1, 2))
        along_u, along_v = self.derivative(uv, 1, 0), self.derivative(uv, 0, 1)
        normal = self.normal(uv)
        second = [self.derivative(uv, *orders) for orders in ((2, 0), (1, 1), (0, 2))]
        uu, mixed, vv = (-np.sum(value * normal, axis=1) for value in second)
        # In an orthonormal frame of the tangent plane the second form is symmetric, and its eigenvalues exact even
        # where they are equal: d/du = a x, d/dv = b x + c y.
        a = np.linalg.norm(along_u, axis=1)
        x = along_u / a[:, None]
        b, c = np.sum(along_v * x, axis=1), np.sum(along_v * np.cross(normal, x), axis=1)
        xx = uu / a**2
        xy = (mixed - b * uu / a) / (a * c)
        yy = (vv - 2.0 * b * mixed / a + b**2 * uu / a**2) / c**2
        middle, half = (xx + yy) / 2.0, np.hypot((xx - yy) / 2.0, xy)
        return np.stack([middle + half, middle - half], axis=-1)

    def _off_poles(self, uv: np.ndarray) -> np.ndarray:
        low, high = self.domain
        size = high - low
        sides = [np.linalg.norm(self.derivative(uv, *orders), axis=1) for orders in ((1, 0), (0, 1))]
        pole = np.minimum(sides[0] * size[0], sides[1] * size[1]) <= 1e-4 * self.extent
        inward = np.where(uv < (low + high) / 2.0, size, -size)
        return np.where(pole[:, None], uv + 1e-3 * inward, uv)

    def parameters(self, points: np.ndarray, near: np.ndarray | None = None) -> np.ndarray:
        """The (u, v), (N, 2) float64, of the surface points nearest to `points` (N, 3), by Gauss and Newton's method.

        It starts at `near` (N, 2), or else at the nearest of some points all over the patch.
        """
        points, (low, high) = np.asarray(points, float).reshape(-1, 3), self.domain
        if near is None:
            shares = np.stack(np.meshgrid(*[np.linspace(0.0, 1.0, SAMPLES)] * 2), axis=-1).reshape(-1, 2)
            starts = low + shares * (high - low)
            near = starts[KDTree(self.position(starts)).query(points)[1]]
        uv = np.array(near, float)
        for _ in range(20):
            away = points - self.position(uv)
            slopes = np.stack([self.derivative(uv, 1, 0), self.derivative(uv, 0, 1)], axis=-1)
            uv = np.clip(uv + np.einsum("nij,nj->ni", np.linalg.pinv(slopes), away), low, high)
        return uv

    def places(self, uv: np.ndarray) -> np.ndarray:
        """Parameters from 0 to 1 over the patch."""
        low, high = self.domain
        return super().places((uv - low) / (high - low))

    def placed(self, places: np.ndarray) -> np.ndarray:
        low, high = self.domain
        return low + super().placed(places) * (high - low)

    def between(self, parameters: np.ndarray, positions: np.ndarray) -> np.ndarray:
        """The mean, also across a seam; at a pole, where a parameter has no meaning, the others' value counts."""
        uv, (low, high) = np.asarray(parameters, float), self.domain
        size = high - low
        weight = np.ones(uv.shape)
        border = ((uv <= low) | (uv >= high)).any(axis=-1)
        for axis, orders in enumerate(((1, 0), (0, 1))):
            moves = np.linalg.norm(self.derivative(uv[border], *orders), axis=1) * size[axis]
            weight[border, axis] = moves > POLE * self.extent
        weight[:] = np.where(weight.any(axis=1, keepdims=True), weight, 1.0)

        first = np.take_along_axis(uv, weight.argmax(axis=1)[:, None], axis=1)
        uv = uv - np.where(self._closed(), size * np.round((uv - first) / size), 0.0)
        middle = np.sum(weight * uv, axis=1) / np.sum(weight, axis=1)
        return np.where(middle < low, middle + size, np.where(middle > high, middle - size, middle))

    def _closed(self) -> np.ndarray:
        """Whether the surface ends where it starts along u and along v, (2,) bool."""
        low, high = self.domain
        starts = low + np.linspace(0.0, 1.0, 7)[:, None] * (high - low)
        found = np.zeros(2, bool)
        for axis in range(2):
            ends = np.stack([starts, starts])
            ends[:, :, axis] = np.stack([low, high])[:, axis : axis + 1]
            found[axis] = np.abs(self.position(ends[0]) - self.position(ends[1])).max() <= POLE * self.extent
        return found
