"""The even asphere: a conic of revolution and even powers of the distance from its axis."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.polynomial.polynomial import polyder, polyval

from anamorph.base.compiled import compiled
from anamorph.base.errors import AnamorphError
from anamorph.base.vectors import Vector
from anamorph.surfaces.base import Expansion
from anamorph.surfaces.sag import SagSurface, check_sag, root
from anamorph.surfaces.sag_search import Sag, expand_sag, meet_sag
from anamorph.surfaces.similarity import Similarity

MOST_COEFFICIENTS = 16


@compiled
def _sag(shape: np.ndarray, x: float, y: float) -> Sag:
    """`shape`: curvature, conic constant, number of coefficients, coefficients."""
    distance = x * x + y * y
    square = 1.0 - (1.0 + shape[1]) * shape[0] * shape[0] * distance
    if square <= 0.0:
        return False, 0.0, 0.0, 0.0
    root = math.sqrt(square)
    value, slope = 0.0, 0.0
    for number in range(int(shape[2]) - 1, -1, -1):
        value = value * distance + shape[3 + number]
        slope = slope * distance + (number + 2) * shape[3 + number]
    sag = shape[0] * distance / (1.0 + root) + distance * distance * value
    steep = shape[0] / root + 2.0 * distance * slope
    return True, sag, steep * x, steep * y


@compiled
def _bends(shape: np.ndarray, x: float, y: float) -> Vector:
    """The second derivatives of the sag, where it has one: xx, xy, yy."""
    distance = x * x + y * y
    root = math.sqrt(1.0 - (1.0 + shape[1]) * shape[0] * shape[0] * distance)
    slope, bend = 0.0, 0.0
    for number in range(int(shape[2]) - 1, -1, -1):
        bend = bend * distance + slope
        slope = slope * distance + (number + 2) * shape[3 + number]
    steep = shape[0] / root + 2.0 * distance * slope
    # The slope along x is x times `steep`, whose own slope along x is 2 x times this.
    change = (1.0 + shape[1]) * shape[0] ** 3 / (2.0 * root**3) + 2.0 * (slope + distance * bend)
    return steep + 2.0 * change * x * x, 2.0 * change * x * y, steep + 2.0 * change * y * y


@compiled
def _meet(
    numbers: np.ndarray, origin: Vector, direction: Vector, distance: float, u: float, v: float, facing: Vector
) -> tuple[bool, float, Vector]:
    return meet_sag(_sag, numbers, origin, direction, distance, facing)


@compiled
def _expand(numbers: np.ndarray, place: Vector) -> Expansion:
    return expand_sag(_sag, _bends, numbers, place)


@dataclass(frozen=True, eq=False)
class EvenAsphere(SagSurface):
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

    meet = staticmethod(_meet)
    expand = staticmethod(_expand)

    def __post_init__(self) -> None:
        check_sag("asphere", self)
        if len(self.coefficients) > MOST_COEFFICIENTS:
            raise AnamorphError(f"asphere: has {len(self.coefficients)} coefficients; give at most {MOST_COEFFICIENTS}")

    @property
    def shape(self) -> tuple[float, ...]:
        return self.curvature, self.conic, len(self.coefficients), *self.coefficients

    @property
    def apex_curvatures(self) -> tuple[float, ...]:
        return (self.curvature,)

    def with_apex_curvatures(self, curvatures: tuple[float, ...]) -> EvenAsphere:
        return replace(self, curvature=curvatures[0])

    def sag(self, uv: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        uv = np.asarray(uv, float)
        square, conic_root, steepness = self._steepness(uv)
        sag = self.curvature * square / (1.0 + conic_root) + polyval(square, self._powers)
        return sag, steepness[:, None] * uv

    def curvatures(self, uv: np.ndarray) -> np.ndarray:
        """Those of a surface of revolution: along the meridian and, by Meusnier's theorem, around the axis."""
        square, conic_root, steepness = self._steepness(np.asarray(uv, float))
        # Where the slope is r f(r^2), the meridian's second derivative is f + 2 r^2 f'.
        change = (1.0 + self.conic) * self.curvature**3 / (2.0 * conic_root**3)
        second = steepness + 2.0 * square * (change + 2.0 * polyval(square, polyder(self._powers, 2)))
        length = np.sqrt(1.0 + steepness**2 * square)
        around, along = steepness / length, second / length**3
        return np.stack([np.maximum(around, along), np.minimum(around, along)], axis=-1)

    def moved(self, by: Similarity) -> EvenAsphere:
        scaled = tuple(value * by.scale ** (-3 - 2 * power) for power, value in enumerate(self.coefficients))
        turned = by.directions(self.axes)
        return EvenAsphere(by.points(self.apex), self.curvature / by.scale, self.conic, scaled, turned)

    @property
    def _powers(self) -> np.ndarray:
        """The polynomial's coefficients, by powers of r^2."""
        return np.array([0.0, 0.0, *self.coefficients])

    def _steepness(self, uv: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """The distance from the axis squared, the conic's root, and the slope over the distance, (N,) each."""
        square = np.sum(uv**2, axis=1)
        conic_root = root("asphere", 1.0 - (1.0 + self.conic) * self.curvature**2 * square)
        return square, conic_root, self.curvature / conic_root + 2.0 * polyval(square, polyder(self._powers))
