"""Motions that keep shapes alike: turned, moved, and larger or smaller."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True, eq=False)
class Similarity:
    """point -> scale * rotation @ point + translation, which keeps shapes alike.

    Parameters
    ----------
    scale : float
        Positive.
    rotation : (3, 3) float64
    translation : (3,) float64
        Metres.
    """

    scale: float
    rotation: np.ndarray
    translation: np.ndarray

    @classmethod
    def shift(cls, by: np.ndarray) -> Similarity:
        """A motion along a vector (3,)."""
        return cls(1.0, np.eye(3), by)

    @classmethod
    def turn_about(cls, point: np.ndarray, turn: np.ndarray) -> Similarity:
        """A turn by a matrix (3, 3), in which a point (3,) stays."""
        return cls(1.0, turn, point - turn @ point)

    def points(self, points: np.ndarray) -> np.ndarray:
        """Points, (..., 3), moved."""
        return self.scale * np.asarray(points, float) @ self.rotation.T + self.translation

    def vectors(self, vectors: np.ndarray) -> np.ndarray:
        """Differences of points, (..., 3), moved."""
        return self.scale * np.asarray(vectors, float) @ self.rotation.T

    def directions(self, directions: np.ndarray) -> np.ndarray:
        """Directions, (..., 3), turned; they keep their lengths."""
        return np.asarray(directions, float) @ self.rotation.T


def rotation(degrees: tuple[float, float, float]) -> np.ndarray:
    """Turn about the fixed x axis, then y, then z, each anticlockwise seen from its tip: (3, 3) float64."""
    matrix = np.eye(3)
    for axis, angle in enumerate(np.radians(degrees)):
        turn = np.eye(3)
        one, other = (axis + 1) % 3, (axis + 2) % 3
        turn[one, one] = turn[other, other] = np.cos(angle)
        turn[other, one] = np.sin(angle)
        turn[one, other] = -np.sin(angle)
        matrix = turn @ matrix
    return matrix
