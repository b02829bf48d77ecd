"""The pinhole camera: an eye and where it looks; and the eye alone, which for a map may be at infinity."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from anamorph.base.vectors import Vector, tuple_of


@dataclass(frozen=True, eq=False)
class Eye:
    """Where lines of sight come from, and the image that they make: a camera's, or a map's.

    Parameters
    ----------
    point : (4,) float64
        Homogeneous (x, y, z, w). With w > 0 lines of sight leave the point; with w < 0 they run towards it; with w = 0
        they all run along -(x, y, z).
    matrix : (3, 4) float64
        From homogeneous world points to homogeneous image points (x w, y w, w), in pixels from the top left corner.
    size : (width, height)
        Of the image, in pixels.
    """

    point: np.ndarray
    matrix: np.ndarray
    size: tuple[int, int]

    def offsets(self, points: np.ndarray) -> np.ndarray:
        """Along the lines of sight to `points`, (N, 3): as long as the distance from the eye, times |w|."""
        return self.point[3] * np.asarray(points, float) - self.point[:3]

    def image(self, points: np.ndarray) -> np.ndarray:
        """Homogeneous image points of world `points`, (N, 3) each."""
        return np.asarray(points, float) @ self.matrix[:, :3].T + self.matrix[:, 3]


@dataclass(frozen=True)
class Camera:
    """A pinhole at `position`, looking at `target`.

    Parameters
    ----------
    position, target : three floats
        World points, metres.
    up : three floats
        The direction that points up in the image; need not be perpendicular to the view.
    field_of_view : float
        Full vertical angle of the image, degrees.
    """

    position: Vector
    target: Vector
    up: Vector = (0.0, 1.0, 0.0)
    field_of_view: float = 40.0

    def moved(self, by: np.ndarray) -> Camera:
        """The same camera elsewhere, moved along a vector (3,)."""
        position, target = (tuple_of(np.add(place, by)) for place in (self.position, self.target))
        return replace(self, position=position, target=target)

    def axes(self) -> np.ndarray:
        """Rows: unit vectors to the right, up, and forward in world space, (3, 3) float64."""
        forward = np.subtract(self.target, self.position)
        forward = forward / np.linalg.norm(forward)
        right = np.cross(forward, self.up)
        right = right / np.linalg.norm(right)
        return np.stack([right, np.cross(right, forward), forward])

    def directions(self, pixels: np.ndarray, size: tuple[int, int]) -> np.ndarray:
        """Unit ray directions through image points.

        Parameters
        ----------
        pixels : (..., 2) array
            Image points, in pixels from the top left corner: the first pixel's centre is (0.5, 0.5).
        size : (width, height)

        Returns
        -------
        (..., 3) float64
        """
        right, up, forward = self.axes()
        x, y = self._slopes(np.asarray(pixels)[..., 0], np.asarray(pixels)[..., 1], size)
        directions = x[..., None] * right + y[..., None] * up + forward
        return directions / np.linalg.norm(directions, axis=-1, keepdims=True)

    def pixel_directions(self, size: tuple[int, int], shift: tuple[float, float] = (0.0, 0.0)) -> np.ndarray:
        """Unit ray directions through the centres of all pixels, moved right and down by `shift`, (H, W, 3) float64.

        They are those that `directions` gives, and take a fraction of the time.
        """
        width, height = size
        right, up, forward = self.axes()
        x, y = self._slopes(np.arange(width) + 0.5 + shift[0], np.arange(height) + 0.5 + shift[1], size)
        directions = x[:, None] * right + (y[:, None] * up + forward)[:, None]
        # The axes are perpendicular, so that lengths need no sums over coordinates.
        directions *= (1.0 / np.sqrt(1.0 + x**2 + (y**2)[:, None]))[..., None]
        return directions

    def _slopes(self, x: np.ndarray, y: np.ndarray, size: tuple[int, int]) -> tuple[np.ndarray, np.ndarray]:
        """How far right and up of the forward axis image points are, one unit ahead."""
        width, height = size
        scale = 2.0 * np.tan(np.radians(self.field_of_view) / 2.0) / height
        return (x - width / 2.0) * scale, (height / 2.0 - y) * scale

    def eye(self, size: tuple[int, int]) -> Eye:
        """This camera as an eye that sees an image of `size` (width, height); w is the depth in metres."""
        width, height = size
        across, up, depth = self.axes()
        focal = height / (2.0 * np.tan(np.radians(self.field_of_view) / 2.0))
        rows = np.stack([focal * across + width / 2.0 * depth, height / 2.0 * depth - focal * up, depth])
        position = np.asarray(self.position, float)
        return Eye(np.append(position, 1.0), np.column_stack([rows, -rows @ position]), size)

    def image(self, points: np.ndarray, size: tuple[int, int]) -> np.ndarray:
        """Where points (N, 3) appear in an image of `size` (width, height).

        Returns
        -------
        (N, 3) float64
            Homogeneous: (x w, y w, w), with x, y in pixels from the top left corner and w the depth in metres.
        """
        return self.eye(size).image(points)
