"""Surfaces of CAD files: non-uniform rational B-splines, evaluated here so that nothing else is needed once loaded."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import BSpline

from anamorph.base.errors import AnamorphError
from anamorph.surfaces.shapes import unit_normals

AT_ONCE = 4096
"""Points evaluated together: what is between the two directions' sums is (points, poles along v, 4) large."""


@dataclass(frozen=True, eq=False)
class NurbsSurface:
    """position = sum N_i(u) N_j(v) w_ij P_ij / sum N_i(u) N_j(v) w_ij, with B-spline bases N.

    The normal points along sign * d/du x d/dv. Where that vanishes (a pole) it is the limit from inside.

    Parameters
    ----------
    poles : (P, Q, 3) float64
        Metres; the first index runs along u.
    weights : (P, Q) float64
        Positive; all equal for a surface that is not rational.
    knots_u, knots_v : (P + degree_u + 1,), (Q + degree_v + 1,) float64
        Each knot as often as its multiplicity.
    degree_u, degree_v : int
    sign : float
        1, or -1 for a face whose outside is the other side.
    """

    poles: np.ndarray
    weights: np.ndarray
    knots_u: np.ndarray
    knots_v: np.ndarray
    degree_u: int
    degree_v: int
    sign: float = 1.0

    def __post_init__(self) -> None:
        shape = (len(self.knots_u) - self.degree_u - 1, len(self.knots_v) - self.degree_v - 1)
        if min(self.degree_u, self.degree_v) < 1 or shape[0] <= self.degree_u or shape[1] <= self.degree_v:
            raise AnamorphError(
                f"NURBS: degrees {self.degree_u}, {self.degree_v} do not fit the knots; export it again"
            )
        if np.shape(self.poles) != (*shape, 3) or np.shape(self.weights) != shape:
            raise AnamorphError(f"NURBS: poles are {np.shape(self.poles)}; the knots want {(*shape, 3)}")
        numbers = (self.poles, self.weights, self.knots_u, self.knots_v)
        if not all(np.isfinite(values).all() for values in numbers) or np.min(self.weights) <= 0:
            raise AnamorphError("NURBS: poles, weights and knots must be finite, weights positive; export it again")
        low, high = self.domain
        if (np.diff(self.knots_u) < 0).any() or (np.diff(self.knots_v) < 0).any() or not (low < high).all():
            raise AnamorphError("NURBS: knots must not fall, nor all be one; export it again")

    @property
    def domain(self) -> tuple[np.ndarray, np.ndarray]:
        """The least and the greatest (u, v), (2,) float64 each."""
        u, v = self.knots_u, self.knots_v
        return (
            np.array([u[self.degree_u], v[self.degree_v]]),
            np.array([u[-self.degree_u - 1], v[-self.degree_v - 1]]),
        )

    def position(self, uv: np.ndarray) -> np.ndarray:
        return self.derivative(uv, 0, 0)

    def normal(self, uv: np.ndarray) -> np.ndarray:
        return self.sign * unit_normals(self.derivative, *self.domain, self.extent, uv)

    @property
    def extent(self) -> float:
        """Length of the longest side of the box around the poles, metres."""
        return float(np.ptp(np.reshape(self.poles, (-1, 3)), axis=0).max())

    def derivative(self, uv: np.ndarray, order_u: int, order_v: int) -> np.ndarray:
        """Partial derivative of the position, (N, 3) float64, at parameters (N, 2); orders sum to 2 at most.

        The quotient rule of Piegl and Tiller, "The NURBS Book" (1997), equation 4.20.
        """
        sums = {(i, j): self.homogeneous(uv, i, j) for i in range(order_u + 1) for j in range(order_v + 1)}
        return _quotient(sums, order_u, order_v)

    def homogeneous(self, uv: np.ndarray, order_u: int, order_v: int) -> np.ndarray:
        """Partial derivative of numerator and denominator, (N, 4) float64: (w x, w y, w z, w)."""
        uv = np.asarray(uv, float).reshape(-1, 2)
        weighted = np.concatenate([self.poles * self.weights[..., None], self.weights[..., None]], axis=-1)
        found = np.empty((len(uv), 4))
        for first in range(0, len(uv), AT_ONCE):
            u, v = uv[first : first + AT_ONCE].T
            basis_u = basis(self.knots_u, self.degree_u, u, order_u)
            basis_v = basis(self.knots_v, self.degree_v, v, order_v)
            along_v = np.tensordot(basis_u, weighted, axes=1)
            found[first : first + AT_ONCE] = np.einsum("nj,njk->nk", basis_v, along_v)
        return found

    def curvatures(self, uv: np.ndarray) -> np.ndarray:
        """Principal curvatures, (N, 2) float64, 1/m, the greater first, at parameters (N, 2).

        Positive where the surface bends away from its normal: both are 1/R on a sphere seen from outside. Near a pole
        they are those of a point a thousandth of the domain further inside.
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


def basis(knots: np.ndarray, degree: int, at: np.ndarray, order: int = 0) -> np.ndarray:
    """All B-splines over `knots` at parameters (N,), or their derivatives of `order`: (N, poles)."""
    count = len(knots) - degree - 1
    if order > degree:
        return np.zeros((len(at), count))
    return BSpline(knots, np.eye(count), degree)(at, nu=order)


def _quotient(sums: dict[tuple[int, int], np.ndarray], i: int, j: int) -> np.ndarray:
    """The derivative of order (i, j) of numerator over denominator, from theirs."""
    weight = sums[0, 0][:, 3:]
    match i, j:
        case 0, 0:
            return sums[0, 0][:, :3] / weight
        case (1, 0) | (0, 1):
            return (sums[i, j][:, :3] - sums[i, j][:, 3:] * _quotient(sums, 0, 0)) / weight
        case (2, 0) | (0, 2):
            half = (i // 2, j // 2)
            value = sums[i, j][:, :3] - sums[i, j][:, 3:] * _quotient(sums, 0, 0)
            return (value - 2.0 * sums[half][:, 3:] * _quotient(sums, *half)) / weight
        case 1, 1:
            value = sums[1, 1][:, :3] - sums[1, 1][:, 3:] * _quotient(sums, 0, 0)
            value -= sums[1, 0][:, 3:] * _quotient(sums, 0, 1)
            return (value - sums[0, 1][:, 3:] * _quotient(sums, 1, 0)) / weight
    raise ValueError(f"derivative of order {i}, {j}")
