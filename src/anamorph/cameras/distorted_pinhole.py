"""A pinhole whose image is distorted: OpenCV's model of 4 to 12 coefficients.

Source: the model of OpenCV's `calib3d`: radial (Brown, "Close-range camera calibration", 1971), rational (Claus and
Fitzgibbon, 2005) and thin-prism terms. Deviation: an image point beyond a fold of the distortion has the status FOLDED
and no ray, where OpenCV returns a wrong one.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from anamorph.base.errors import AnamorphError
from anamorph.cameras.lens_model import Intrinsics, checked_numbers, statuses
from anamorph.raymesh import RayStatus

COUNTS = (0, 4, 5, 8, 12)
STAGES = 8
POLISHING = 10
RESIDUAL = 1e-12
"""Of the plane z = 1: what is left when an image point is found again."""


@dataclass(frozen=True)
class DistortedPinhole:
    """Rays through one point, and an image that radial, tangential and thin-prism terms distort.

    Parameters
    ----------
    intrinsics : Intrinsics
    coefficients : tuple of float
        k1, k2, p1, p2, k3, k4, k5, k6, s1, s2, s3, s4 in this order: the first 4, 5, 8 or 12, or none.
    """

    intrinsics: Intrinsics
    coefficients: tuple[float, ...] = ()

    def __post_init__(self) -> None:
        if len(checked_numbers("coefficients", self.coefficients)) not in COUNTS:
            raise AnamorphError(
                f"camera: {len(self.coefficients)} coefficients of distortion; give 4, 5, 8 or 12 (tilt is not known)"
            )

    def distort(self, plane: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Where points (N, 2) of the plane z = 1 go, (N, 2), and the derivatives of that, (N, 2, 2)."""
        k1, k2, p1, p2, k3, k4, k5, k6, s1, s2, s3, s4 = self._all
        x, y = np.asarray(plane, float).T
        s = x * x + y * y
        over, under = 1.0 + s * (k1 + s * (k2 + s * k3)), 1.0 + s * (k4 + s * (k5 + s * k6))
        scale = over / under
        slope = (k1 + s * (2.0 * k2 + 3.0 * s * k3) - scale * (k4 + s * (2.0 * k5 + 3.0 * s * k6))) / under
        moved = np.stack(
            [
                x * scale + 2.0 * p1 * x * y + p2 * (s + 2.0 * x * x) + s * (s1 + s * s2),
                y * scale + p1 * (s + 2.0 * y * y) + 2.0 * p2 * x * y + s * (s3 + s * s4),
            ],
            axis=1,
        )
        across, prism_x, prism_y = 2.0 * (x * y * slope + p1 * x + p2 * y), s1 + 2.0 * s * s2, s3 + 2.0 * s * s4
        first = scale + 2.0 * x * x * slope + 2.0 * p1 * y + 6.0 * p2 * x + 2.0 * x * prism_x
        last = scale + 2.0 * y * y * slope + 6.0 * p1 * y + 2.0 * p2 * x + 2.0 * y * prism_y
        rows = [np.stack([first, across + 2.0 * y * prism_x], -1), np.stack([across + 2.0 * x * prism_y, last], -1)]
        return moved, np.stack(rows, axis=1)

    def rays(self, pixels: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """See `LensModel`. Directions reach the plane z = 1, so that without distortion they are linear."""
        plane, ok = self.undistort(self.intrinsics.plane(pixels))
        return np.column_stack([plane, np.ones(len(plane))]), statuses(ok, RayStatus.FOLDED)

    def pixels(self, directions: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """See `LensModel`."""
        directions = np.asarray(directions, float)
        before = directions[:, 2] > 0.0
        plane = directions[:, :2] / np.where(before, directions[:, 2], 1.0)[:, None]
        plane[~before] = 0.0
        moved, ok = self.distort_checked(plane)
        status = statuses(ok, RayStatus.FOLDED)
        status[~before] = RayStatus.OUTSIDE
        return self.intrinsics.image(moved), status

    def distort_checked(self, plane: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Where points (N, 2) of the plane z = 1 go, and which of them lie before every fold, (N,) bool."""
        inside = np.linalg.norm(plane, axis=1) < self._radius
        moved, derivatives = self.distort(np.where(inside[:, None], plane, 0.0))
        return moved, inside & (np.linalg.det(derivatives) > 0.0)

    def undistort(self, moved: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The points (N, 2) that go to `moved`, (N, 2), before every fold; which there are, (N,) bool.

        They are followed from the middle of the image outward, by Newton's steps: that leads to no other branch.
        """
        plane, ok = np.zeros_like(moved), np.ones(len(moved), bool)
        if not any(self.coefficients):
            return moved.copy(), ok
        for stage in range(1, STAGES + 1):
            for _ in range(POLISHING if stage == STAGES else 2):
                plane, ok = self._step(plane, ok, moved * stage / STAGES)
        found, before = self.distort_checked(plane)
        bound = RESIDUAL * (1.0 + np.linalg.norm(moved, axis=1))
        ok &= before & (np.linalg.norm(found - moved, axis=1) <= bound)
        return np.where(ok[:, None], plane, 0.0), ok

    def _step(self, plane: np.ndarray, ok: np.ndarray, wanted: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        found, derivatives = self.distort(plane)
        (a, b), (c, d) = np.moveaxis(derivatives, 0, -1)
        determinant = a * d - b * c
        ok = ok & (determinant > 0.0)
        x, y = (wanted - found).T
        change = np.stack([d * x - b * y, a * y - c * x], axis=1) / np.where(ok, determinant, 1.0)[:, None]
        moved = plane + np.where(ok[:, None], change, 0.0)
        ok = ok & (np.linalg.norm(moved, axis=1) < self._radius)
        return np.where(ok[:, None], moved, 0.0), ok

    @property
    def _all(self) -> tuple[float, ...]:
        return (*self.coefficients, *[0.0] * (COUNTS[-1] - len(self.coefficients)))

    @cached_property
    def _radius(self) -> float:
        """Up to where the radial terms grow: the root of their derivative, or of what they are divided by."""
        k1, k2, _, _, k3, k4, k5, k6 = self._all[:8]
        over, under = np.polynomial.Polynomial([1.0, k1, k2, k3]), np.polynomial.Polynomial([1.0, k4, k5, k6])
        s = np.polynomial.Polynomial([0.0, 1.0])
        slope = over * under + 2.0 * s * (over.deriv() * under - over * under.deriv())
        return float(np.sqrt(min(first_root(slope), first_root(under))))


def first_root(polynomial: np.polynomial.Polynomial) -> float:
    """The least real root above 0 of a polynomial; infinite where there is none."""
    roots = polynomial.trim().roots()
    real = roots.real[(np.abs(roots.imag) <= 1e-9 * np.abs(roots)) & (roots.real > 0.0)]
    return float(real.min(initial=np.inf))
