"""Images of all directions: longitude and latitude, and a cylinder."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from anamorph.cameras.grid import checked_number, checked_size
from anamorph.cameras.lens_model import statuses
from anamorph.raymesh import RayStatus


@dataclass(frozen=True)
class Equirectangular:
    """Longitude across and latitude upright, evenly; forward is the middle of the image.

    Parameters
    ----------
    size : (width, height)
        Pixels; 360 degrees across and 180 upright.
    """

    size: tuple[int, int]

    def __post_init__(self) -> None:
        checked_size(self.size)

    def rays(self, pixels: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """See `LensModel`. Directions are of unit length."""
        width, height = self.size
        x, y = np.asarray(pixels, float).T
        longitude, latitude = (x / width - 0.5) * 2.0 * np.pi, (y / height - 0.5) * np.pi
        level = np.cos(latitude)
        directions = np.column_stack([level * np.sin(longitude), np.sin(latitude), level * np.cos(longitude)])
        return directions, np.zeros(len(directions), np.uint8)

    def pixels(self, directions: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """See `LensModel`. At the poles, which a whole row sees, it is the middle of the row."""
        width, height = self.size
        x, y, z = np.asarray(directions, float).T
        longitude, latitude = np.arctan2(x, z), np.arctan2(y, np.hypot(x, z))
        pixels = np.column_stack([(longitude / (2.0 * np.pi) + 0.5) * width, (latitude / np.pi + 0.5) * height])
        return pixels, np.zeros(len(pixels), np.uint8)


@dataclass(frozen=True)
class Cylindrical:
    """Longitude across, evenly, and the height on an upright cylinder of radius 1; pixels are square in the middle.

    Parameters
    ----------
    size : (width, height)
        Pixels.
    angle : float
        What the image shows across, degrees, up to 360.
    """

    size: tuple[int, int]
    angle: float = 360.0

    def __post_init__(self) -> None:
        checked_size(self.size)
        checked_number("angle", self.angle, 0.0, 360.0 + 1e-9, "degrees")

    def rays(self, pixels: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """See `LensModel`. Directions reach the cylinder."""
        x, y = ((np.asarray(pixels, float) - np.divide(self.size, 2.0)) / self._focal).T
        return np.column_stack([np.sin(x), y, np.cos(x)]), np.zeros(len(x), np.uint8)

    def pixels(self, directions: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """See `LensModel`."""
        x, y, z = np.asarray(directions, float).T
        longitude, level = np.arctan2(x, z), np.hypot(x, z)
        seen = (level > 0.0) & (np.abs(longitude) <= np.radians(self.angle) / 2.0)
        plane = np.column_stack([longitude, y / np.where(level > 0.0, level, 1.0)])
        return plane * self._focal + np.divide(self.size, 2.0), statuses(seen, RayStatus.OUTSIDE)

    @property
    def _focal(self) -> float:
        return self.size[0] / float(np.radians(self.angle))
