"""Lenses and mirrors whose rays meet in one point, by projections of a sphere.

Sources: Mei and Rives, "Single view point omnidirectional camera calibration from planar grids" (2007); Usenko, Demmel
and Cremers, "The double sphere camera model" (2018), equations 40 to 52.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from anamorph.base.errors import AnamorphError
from anamorph.cameras.distorted_pinhole import DistortedPinhole
from anamorph.cameras.lens_model import Intrinsics, checked_numbers, statuses
from anamorph.raymesh import RayStatus

FORWARD = (0.0, 0.0, 1.0)


@dataclass(frozen=True)
class UnifiedOmnidirectional:
    """A unit sphere seen from a point `xi` behind its middle, and distorted as a pinhole's image is.

    Parameters
    ----------
    intrinsics : Intrinsics
    xi : float
        0 is a pinhole, 1 a parabolic mirror; 0 or more.
    coefficients : tuple of float
        As of `DistortedPinhole`.
    """

    intrinsics: Intrinsics
    xi: float
    coefficients: tuple[float, ...] = ()

    def __post_init__(self) -> None:
        if checked_numbers("xi", [self.xi])[0] < 0.0:
            raise AnamorphError(f"camera: xi is {self.xi}; give 0 or more")
        DistortedPinhole(self.intrinsics, self.coefficients)

    def rays(self, pixels: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """See `LensModel`. Directions are of unit length."""
        flat, status = DistortedPinhole(self.intrinsics, self.coefficients).rays(pixels)
        square = np.sum(flat[:, :2] ** 2, axis=1)
        inner = 1.0 + (1.0 - self.xi**2) * square
        factor = (self.xi + np.sqrt(np.maximum(inner, 0.0))) / (1.0 + square)
        directions = factor[:, None] * flat - np.array([0.0, 0.0, self.xi])
        status[(inner < 0.0) & (status == RayStatus.OK)] = RayStatus.OUTSIDE
        directions[status != RayStatus.OK] = FORWARD
        return directions, status

    def pixels(self, directions: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """See `LensModel`."""
        units = directions / np.linalg.norm(directions, axis=1, keepdims=True)
        seen = units[:, 2] > (-self.xi if self.xi <= 1.0 else -1.0 / self.xi)
        shifted = np.where(seen[:, None], units + np.array([0.0, 0.0, self.xi]), FORWARD)
        pixels, status = DistortedPinhole(self.intrinsics, self.coefficients).pixels(shifted)
        status[~seen] = RayStatus.OUTSIDE
        return pixels, status


@dataclass(frozen=True)
class DoubleSphere:
    """Two unit spheres, one after the other, and a pinhole.

    Parameters
    ----------
    intrinsics : Intrinsics
    xi : float
        How far the spheres' middles are apart, above -1.
    alpha : float
        0 to 1: how far the pinhole stands behind the second middle, as alpha / (1 - alpha).
    """

    intrinsics: Intrinsics
    xi: float
    alpha: float

    def __post_init__(self) -> None:
        xi, alpha = checked_numbers("xi and alpha", [self.xi, self.alpha])
        if not (-1.0 < xi <= 1.0 and 0.0 <= alpha <= 1.0):
            raise AnamorphError(f"camera: xi, alpha are {xi}, {alpha}; give xi above -1 up to 1, and alpha from 0 to 1")

    def rays(self, pixels: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """See `LensModel`. Directions are of unit length."""
        plane, alpha, xi = self.intrinsics.plane(pixels), self.alpha, self.xi
        square = np.sum(plane**2, axis=1)
        inner = 1.0 - (2.0 * alpha - 1.0) * square
        depth = (1.0 - alpha**2 * square) / (alpha * np.sqrt(np.maximum(inner, 0.0)) + 1.0 - alpha + (inner <= 0.0))
        root = depth**2 + (1.0 - xi**2) * square
        ok = (inner > 0.0) & (root >= 0.0)
        factor = (depth * xi + np.sqrt(np.maximum(root, 0.0))) / (depth**2 + square)
        directions = factor[:, None] * np.column_stack([plane, depth]) - np.array([0.0, 0.0, xi])
        directions[~ok] = FORWARD
        return directions, statuses(ok, RayStatus.OUTSIDE)

    def pixels(self, directions: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """See `LensModel`."""
        units = directions / np.linalg.norm(directions, axis=1, keepdims=True)
        alpha, xi, z = self.alpha, self.xi, units[:, 2]
        share = alpha / (1.0 - alpha) if alpha <= 0.5 else (1.0 - alpha) / alpha
        ok = z > -(share + xi) / np.sqrt(2.0 * share * xi + xi**2 + 1.0)
        second = np.sqrt(1.0 + 2.0 * xi * z + xi**2)
        depth = alpha * second + (1.0 - alpha) * (xi + z)
        plane = units[:, :2] / np.where(ok, depth, 1.0)[:, None]
        return self.intrinsics.image(plane), statuses(ok, RayStatus.OUTSIDE)
