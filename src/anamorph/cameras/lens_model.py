"""What every model of a real camera's lens answers: which ray a pixel sees, and which pixel sees a ray.

Rays are in the camera's own frame, as calibrations have it: x to the right, y down, z forward.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike

from anamorph.base.errors import AnamorphError
from anamorph.raymesh import RayStatus


class LensModel(Protocol):
    """The closed form of a lens. What has a status other than OK has a finite value that means nothing."""

    def rays(self, pixels: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The directions (N, 3), of any length but 0, that image points (N, 2) see, and a `RayStatus` each, (N,)."""
        ...

    def pixels(self, directions: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The image points (N, 2) that see directions (N, 3) of any length, and a `RayStatus` each, (N,)."""
        ...


@dataclass(frozen=True)
class Intrinsics:
    """The scale and the middle of an image: a point (x, y) of the plane z = 1 is at (fx x + cx, fy y + cy).

    Parameters
    ----------
    fx, fy : float
        Focal lengths in pixels, not 0.
    cx, cy : float
        The principal point in pixels from the top left corner of the image. Calibrations that count from the centre
        of the first pixel, as OpenCV's do, have half a pixel less.
    """

    fx: float
    fy: float
    cx: float
    cy: float

    def __post_init__(self) -> None:
        values = checked_numbers("intrinsics", (self.fx, self.fy, self.cx, self.cy))
        if values[0] <= 0.0 or values[1] <= 0.0:
            raise AnamorphError(f"camera: focal lengths are {self.fx}, {self.fy}; give both above 0, in pixels")

    def plane(self, pixels: np.ndarray) -> np.ndarray:
        """Where image points (N, 2) are in the plane z = 1, (N, 2)."""
        return (np.asarray(pixels, float) - (self.cx, self.cy)) / (self.fx, self.fy)

    def image(self, plane: np.ndarray) -> np.ndarray:
        """Where points (N, 2) of the plane z = 1 are in the image, (N, 2) pixels."""
        return np.asarray(plane, float) * (self.fx, self.fy) + (self.cx, self.cy)

    def check_size(self, size: tuple[int, int]) -> None:
        """Refuse an image whose principal point is outside of it: the calibration is that of another size."""
        if not (0.0 < self.cx < size[0] and 0.0 < self.cy < size[1]):
            raise AnamorphError(
                f"camera: the principal point ({self.cx:g}, {self.cy:g}) is outside an image of {size[0]} x {size[1]}; "
                "give the size for which the camera is calibrated"
            )


def checked_numbers(name: str, values: ArrayLike) -> np.ndarray:
    """Finite numbers, (N,), or the error that says what is wrong with them."""
    try:
        numbers = np.asarray(values, float)
    except (TypeError, ValueError):
        numbers = np.array(np.nan)
    if numbers.ndim != 1 or not np.isfinite(numbers).all():
        raise AnamorphError(f"camera: {name} are {values!r}; give finite numbers")
    return numbers


def statuses(ok: np.ndarray, otherwise: RayStatus) -> np.ndarray:
    """OK where `ok`, (N,), and elsewhere another status."""
    return np.where(ok, RayStatus.OK, otherwise).astype(np.uint8)
