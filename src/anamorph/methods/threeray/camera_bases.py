"""What the triangle of a three-ray camera says of what it sees: nothing lies behind it, and how wide a sample is."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from anamorph.methods.threeray.cameras_seen import Cameras

ROUNDING = 1e-12
"""What planes are moved back by, as a share of the coordinates."""


class Bases(NamedTuple):
    """The triangles of cameras, K of them, as compiled loops read them."""

    plane: np.ndarray
    """(K, 4) float64: vectors m and numbers h: all that is seen is where m . x >= h. Without a plane they are 0."""
    samples: np.ndarray
    """(K,) float64: how many samples the triangle covers in the image; 0 where that is not known."""
    spread: np.ndarray
    """(K,) float64: the solid angle between the three directions."""


def bases_of(cameras: Cameras, chosen: np.ndarray) -> Bases:
    """The triangles of the chosen cameras."""
    origins, directions, image = cameras.origins[chosen], cameras.directions[chosen], cameras.image[chosen]
    normal = np.cross(origins[:, 1] - origins[:, 0], origins[:, 2] - origins[:, 0])
    length = np.linalg.norm(normal, axis=1)
    normal = normal / np.where(length > 0.0, length, 1.0)[:, None]
    rises = np.einsum("kij,kj->ki", directions, normal)
    normal = normal * np.sign(rises.sum(axis=1))[:, None]
    least = np.abs(rises).min(axis=1)
    # All rays leave the triangle to one side; what they meet before `near` they do not see.
    leave = (np.abs(rises.sum(axis=1)) == np.abs(rises).sum(axis=1)) & (least > 0.0)
    height = np.einsum("kij,kj->ki", origins, normal).min(axis=1) + cameras.near[chosen] * least
    height -= ROUNDING * np.abs(origins).max(axis=(1, 2))
    plane = np.where(leave[:, None], np.column_stack([normal, height]), 0.0)
    return Bases(plane, _areas(image), _solid_angles(directions))


def _areas(image: np.ndarray) -> np.ndarray:
    """The areas of image triangles with these homogeneous corners (K, 3, 3), (K,) float64; 0 where one is behind."""
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        places = image[..., :2] / image[..., 2:]
        one, other = places[:, 1] - places[:, 0], places[:, 2] - places[:, 0]
        area = 0.5 * np.abs(one[:, 0] * other[:, 1] - one[:, 1] * other[:, 0])
    return np.where((image[..., 2] > 0.0).all(axis=1) & np.isfinite(area), area, 0.0)


def _solid_angles(directions: np.ndarray) -> np.ndarray:
    """Between directions (K, 3, 3) of any length: van Oosterom and Strackee 1983."""
    lengths = np.linalg.norm(directions, axis=2, keepdims=True)
    a, b, c = np.moveaxis(directions / np.where(lengths > 0.0, lengths, 1.0), 1, 0)
    volume = np.abs(np.einsum("ki,ki->k", a, np.cross(b, c)))
    sides = sum(np.einsum("ki,ki->k", one, other) for one, other in ((a, b), (b, c), (c, a)))
    return 2.0 * np.arctan2(volume, 1.0 + sides)
