"""Surfaces of CAD files: non-uniform rational B-splines, evaluated here so that nothing else is needed once loaded."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import comb

import numpy as np

from anamorph.base.compiled import compiled
from anamorph.base.errors import AnamorphError
from anamorph.base.vectors import Vector
from anamorph.surfaces.base import Expansion
from anamorph.surfaces.bsplines import basis
from anamorph.surfaces.nurbs_pieces import (
    EXTENT,
    LOW_U,
    LOW_V,
    SIZE_U,
    SIZE_V,
    expand_pieces,
    pieces,
    point_and_tangents,
)
from anamorph.surfaces.patch import Patch
from anamorph.surfaces.patch_search import meet_patch
from anamorph.surfaces.similarity import Similarity

AT_ONCE = 4096
"""Points evaluated together: what is between the two directions' sums is (points, poles along v, 4) large."""


@compiled
def _meet(
    numbers: np.ndarray, origin: Vector, direction: Vector, distance: float, u: float, v: float, facing: Vector
) -> tuple[bool, float, Vector]:
    u, v = (u - numbers[LOW_U]) / numbers[SIZE_U], (v - numbers[LOW_V]) / numbers[SIZE_V]
    return meet_patch(point_and_tangents, numbers, numbers[EXTENT], numbers[-1], origin, direction, u, v)


@compiled
def _expand(numbers: np.ndarray, place: Vector) -> Expansion:
    return expand_pieces(numbers, place[0], place[1])


@dataclass(frozen=True, eq=False)
class NurbsSurface(Patch):
    """position = sum N_i(u) N_j(v) w_ij P_ij / sum N_i(u) N_j(v) w_ij, with B-spline bases N.

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

    meet = staticmethod(_meet)
    expand = staticmethod(_expand)

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
    def numbers(self) -> np.ndarray:
        knots, degrees = (self.knots_u, self.knots_v), (self.degree_u, self.degree_v)
        return np.append(pieces(self._weighted, knots, degrees, self.extent), self.sign)

    @property
    def domain(self) -> tuple[np.ndarray, np.ndarray]:
        u, v = self.knots_u, self.knots_v
        return (
            np.array([u[self.degree_u], v[self.degree_v]]),
            np.array([u[-self.degree_u - 1], v[-self.degree_v - 1]]),
        )

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
        weighted, found = self._weighted, np.empty((len(uv), 4))
        for first in range(0, len(uv), AT_ONCE):
            u, v = uv[first : first + AT_ONCE].T
            basis_u = basis(self.knots_u, self.degree_u, u, order_u)
            basis_v = basis(self.knots_v, self.degree_v, v, order_v)
            along_v = np.tensordot(basis_u, weighted, axes=1)
            found[first : first + AT_ONCE] = np.einsum("nj,njk->nk", basis_v, along_v)
        return found

    def moved(self, by: Similarity) -> NurbsSurface:
        return replace(self, poles=by.points(self.poles))

    @property
    def _weighted(self) -> np.ndarray:
        """The poles' numerators and denominators, (P, Q, 4)."""
        return np.concatenate([self.poles * self.weights[..., None], self.weights[..., None]], axis=-1)


def _quotient(sums: dict[tuple[int, int], np.ndarray], order_u: int, order_v: int) -> np.ndarray:
    """The derivative of numerator over denominator, from theirs."""
    value = sums[order_u, order_v][:, :3]
    for i in range(order_u, -1, -1):
        for j in range(order_v, -1, -1):
            if (i, j) != (0, 0):
                ways = comb(order_u, i) * comb(order_v, j)
                value = value - ways * sums[i, j][:, 3:] * _quotient(sums, order_u - i, order_v - j)
    return value / sums[0, 0][:, 3:]
