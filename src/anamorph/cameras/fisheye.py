"""Fisheyes: the distance from the middle of the image is a function of the angle to the axis, and of nothing else.

Sources: Kannala and Brandt, "A generic camera model and calibration method" (2006), as OpenCV's `fisheye` has
it; Miyamoto, "Fish eye lens" (1964) for the equidistant, equisolid and stereographic laws.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from anamorph.base.errors import AnamorphError
from anamorph.cameras.distorted_pinhole import first_root
from anamorph.cameras.lens_model import Intrinsics, checked_numbers
from anamorph.raymesh import RayStatus

LAWS = ("polynomial", "equisolid", "stereographic")
HALVINGS = 60
"""After them an interval of pi is below what float64 tells apart."""


@dataclass(frozen=True)
class Fisheye:
    """Rays through one point, whose image is round about the principal point.

    Parameters
    ----------
    intrinsics : Intrinsics
    law : str
        Of the angle a to the axis: "polynomial", "equisolid", 2 sin(a / 2), or "stereographic", 2 tan(a / 2).
    coefficients : tuple of float
        Of a, a^2, a^3 ... in the polynomial; (1,) is the equidistant law.
    field_of_view : float
        Full angle of what is seen, degrees; beyond it pixels see nothing.
    """

    intrinsics: Intrinsics
    law: str = "polynomial"
    coefficients: tuple[float, ...] = (1.0,)
    field_of_view: float = 360.0

    def __post_init__(self) -> None:
        if self.law not in LAWS:
            raise AnamorphError(f"camera: law is {self.law!r}; give {', '.join(LAWS)}")
        numbers = checked_numbers("coefficients", self.coefficients)
        if not len(numbers) or numbers[0] <= 0.0:
            raise AnamorphError("camera: the image does not grow from its middle; give a first coefficient above 0")
        if not 0.0 < self.field_of_view <= 360.0:
            raise AnamorphError(f"camera: field_of_view is {self.field_of_view}; give degrees above 0, up to 360")

    def rays(self, pixels: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """See `LensModel`. Directions are of unit length."""
        plane = self.intrinsics.plane(pixels)
        radius = np.hypot(*plane.T)
        angle, status = self._angle(radius)
        around = plane / np.where(radius > 0.0, radius, 1.0)[:, None]
        return np.column_stack([np.sin(angle)[:, None] * around, np.cos(angle)]), status

    def pixels(self, directions: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """See `LensModel`."""
        directions = np.asarray(directions, float)
        across = np.hypot(directions[:, 0], directions[:, 1])
        angle = np.arctan2(across, directions[:, 2])
        around = directions[:, :2] / np.where(across > 0.0, across, 1.0)[:, None]
        return self.intrinsics.image(self._radius(angle)[:, None] * around), self._status(angle)

    def _radius(self, angle: np.ndarray) -> np.ndarray:
        if self.law == "equisolid":
            return 2.0 * np.sin(angle / 2.0)
        if self.law == "stereographic":
            return 2.0 * np.tan(np.minimum(angle, np.pi - 1e-9) / 2.0)
        return self._polynomial(angle)

    def _angle(self, radius: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Angles to the axis, and whether they are seen, for distances from the middle of the image."""
        if self.law == "equisolid":
            angle, there = 2.0 * np.arcsin(np.minimum(radius / 2.0, 1.0)), radius <= 2.0
        elif self.law == "stereographic":
            angle, there = 2.0 * np.arctan(radius / 2.0), np.ones(len(radius), bool)
        else:
            low, high = np.zeros_like(radius), np.full_like(radius, self._last)
            there = radius <= self._polynomial(self._last)
            for _ in range(HALVINGS):
                middle = (low + high) / 2.0
                under = self._polynomial(middle) < radius
                low, high = np.where(under, middle, low), np.where(under, high, middle)
            angle = (low + high) / 2.0
        status = self._status(angle)
        beyond = RayStatus.FOLDED if self._last < np.pi else RayStatus.OUTSIDE
        status[~there & (status == RayStatus.OK)] = beyond
        return angle, status

    def _status(self, angle: np.ndarray) -> np.ndarray:
        status = np.where(angle > self._last, RayStatus.FOLDED, RayStatus.OK)
        # A point that is on the border to rounding is seen.
        outside = angle > np.radians(self.field_of_view) / 2.0 * (1.0 + 1e-12)
        return np.where(outside, RayStatus.OUTSIDE, status).astype(np.uint8)

    @cached_property
    def _polynomial(self) -> np.polynomial.Polynomial:
        return np.polynomial.Polynomial([0.0, *self.coefficients])

    @cached_property
    def _last(self) -> float:
        """The angle up to which the image grows."""
        return min(np.pi, first_root(self._polynomial.deriv())) if self.law == "polynomial" else np.pi


def kannala_brandt(
    intrinsics: Intrinsics, coefficients: Sequence[float] = (0.0, 0.0, 0.0, 0.0), field_of_view: float = 360.0
) -> Fisheye:
    """OpenCV's fisheye: a + k1 a^3 + k2 a^5 + k3 a^7 + k4 a^9 of the angle a to the axis."""
    if len(coefficients) != 4:
        raise AnamorphError(f"camera: {len(coefficients)} coefficients of a fisheye; give k1, k2, k3 and k4")
    k1, k2, k3, k4 = checked_numbers("coefficients", coefficients).tolist()
    return Fisheye(intrinsics, "polynomial", (1.0, 0.0, k1, 0.0, k2, 0.0, k3, 0.0, k4), field_of_view)


def f_theta(middle: tuple[float, float], coefficients: Sequence[float], field_of_view: float = 360.0) -> Fisheye:
    """The distance from `middle` in pixels as a polynomial of the angle in radians: coefficients of a, a^2, ..."""
    return Fisheye(Intrinsics(1.0, 1.0, *middle), "polynomial", tuple(coefficients), field_of_view)


def dome_master(size: tuple[int, int], field_of_view: float = 180.0) -> Fisheye:
    """The image for a dome: an equidistant disc as large as the image allows; its middle is the dome's top."""
    radius = min(size) / 2.0 / (np.radians(field_of_view) / 2.0)
    return Fisheye(Intrinsics(radius, radius, size[0] / 2.0, size[1] / 2.0), field_of_view=field_of_view)
