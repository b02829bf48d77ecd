"""The bicubic Bezier patch."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.polynomial.polynomial import polyder, polyval

from anamorph.base.compiled import compiled
from anamorph.base.errors import AnamorphError
from anamorph.base.vectors import Vector, along
from anamorph.surfaces.base import Expansion
from anamorph.surfaces.patch import Patch
from anamorph.surfaces.patch_search import meet_patch
from anamorph.surfaces.similarity import Similarity

COORDINATES = 48


@compiled
def _cubic(t: float) -> tuple[tuple[float, float, float, float], tuple[float, float, float, float]]:
    """The four Bernstein polynomials at t, and their derivatives."""
    s = 1.0 - t
    values = (s * s * s, 3.0 * s * s * t, 3.0 * s * t * t, t * t * t)
    slopes = (-3.0 * s * s, 3.0 * s * (s - 2.0 * t), 3.0 * t * (2.0 * s - t), 3.0 * t * t)
    return values, slopes


@compiled
def _point_and_tangents(control: np.ndarray, u: float, v: float) -> tuple[Vector, Vector, Vector]:
    (a, da), (b, db) = _cubic(u), _cubic(v)
    position, along_u, along_v = (0.0, 0.0, 0.0), (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)
    for i in range(4):
        for j in range(4):
            first = 3 * (4 * i + j)
            point = (control[first], control[first + 1], control[first + 2])
            position = along(position, a[i] * b[j], point)
            along_u = along(along_u, da[i] * b[j], point)
            along_v = along(along_v, a[i] * db[j], point)
    return position, along_u, along_v


@compiled
def _expand(numbers: np.ndarray, place: Vector) -> Expansion:
    zero = (0.0, 0.0, 0.0)
    position, along_u, along_v = _point_and_tangents(numbers, place[0], place[1])
    (a, da), (b, db) = _cubic(place[0]), _cubic(place[1])
    s, t = 1.0 - place[0], 1.0 - place[1]
    bend_a = (6.0 * s, 6.0 * (1.0 - 3.0 * s), 6.0 * (1.0 - 3.0 * place[0]), 6.0 * place[0])
    bend_b = (6.0 * t, 6.0 * (1.0 - 3.0 * t), 6.0 * (1.0 - 3.0 * place[1]), 6.0 * place[1])
    uu, uv, vv = zero, zero, zero
    for i in range(4):
        for j in range(4):
            first = 3 * (4 * i + j)
            point = (numbers[first], numbers[first + 1], numbers[first + 2])
            uu = along(uu, bend_a[i] * b[j], point)
            uv = along(uv, da[i] * db[j], point)
            vv = along(vv, a[i] * bend_b[j], point)
    return True, position, along_u, along_v, uu, uv, vv


@compiled
def _meet(
    numbers: np.ndarray, origin: Vector, direction: Vector, distance: float, u: float, v: float, facing: Vector
) -> tuple[bool, float, Vector]:
    extent = 0.0
    for number in range(3, COORDINATES):
        extent = max(extent, abs(numbers[number] - numbers[number % 3]))
    return meet_patch(_point_and_tangents, numbers, extent, 1.0, origin, direction, u, v)


@dataclass(frozen=True, eq=False)
class BezierPatch(Patch):
    """position = sum over i, j of B_i(u) B_j(v) control[i, j], with cubic Bernstein polynomials B and u, v in 0 to 1.

    Parameters
    ----------
    control : (4, 4, 3) array
        Control points, metres; the first index runs along u.
    """

    control: np.ndarray

    meet = staticmethod(_meet)
    expand = staticmethod(_expand)

    def __post_init__(self) -> None:
        if np.shape(self.control) != (4, 4, 3) or not np.isfinite(self.control).all():
            raise AnamorphError(f"Bezier patch: control is {np.shape(self.control)}; give (4, 4, 3) finite numbers")

    @property
    def numbers(self) -> np.ndarray:
        return np.ravel(np.asarray(self.control, float))

    @property
    def domain(self) -> tuple[np.ndarray, np.ndarray]:
        return np.zeros(2), np.ones(2)

    @property
    def extent(self) -> float:
        """Length of the longest side of the box around the control points, metres."""
        return float(np.ptp(np.reshape(self.control, (-1, 3)), axis=0).max())

    def derivative(self, uv: np.ndarray, order_u: int, order_v: int) -> np.ndarray:
        u, v = np.asarray(uv, float).T
        return np.einsum("ni,nj,ijk->nk", _bernstein(u, order_u), _bernstein(v, order_v), np.asarray(self.control))

    def moved(self, by: Similarity) -> BezierPatch:
        return BezierPatch(by.points(self.control))


def _bernstein(t: np.ndarray, order: int) -> np.ndarray:
    """The four cubic Bernstein polynomials at `t` (N,), or their derivatives of `order`: (N, 4)."""
    powers = np.array([[1.0, 0.0, 0.0, 0.0], [-3.0, 3.0, 0.0, 0.0], [3.0, -6.0, 3.0, 0.0], [-1.0, 3.0, -3.0, 1.0]])
    return polyval(t, polyder(powers, order) if order else powers).T
