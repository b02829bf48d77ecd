"""A sculpture of a robed figure on a plinth, which holds a ball over its head."""

from __future__ import annotations

import numpy as np

from anamorph.gallery.sculpting import Lump, Sculpture, limb, mirrored
from anamorph.scene.model import Color

WAIST = 0.66
FOLDS, DEPTH = 13, 0.011
"""Of the robe: how many go around, and how deep they are, metres."""


def statue() -> Sculpture:
    """A statue, 1.5 m high, that looks along +z."""
    robe: Color = (0.50, 0.09, 0.05)
    sash: Color = (0.72, 0.50, 0.12)
    skin: Color = (0.66, 0.44, 0.30)
    hair: Color = (0.06, 0.045, 0.04)
    stone: Color = (0.30, 0.36, 0.34)
    lumps = (
        _drum(0.0, 0.05, 0.30, stone),
        _drum(0.05, 0.11, 0.25, stone),
        limb([(0, 0.27, 0, 0.17), (0, 0.42, 0, 0.155), (0, 0.56, -0.01, 0.135), (0, WAIST, -0.01, 0.115)], robe),
        limb([(0, 0.70, -0.01, 0.115), (0, 0.84, 0, 0.125), (0, 0.96, -0.01, 0.10)], robe, (0.0, 0.0, 0.25)),
        limb([(0, WAIST, -0.01, 0.128), (0, WAIST + 0.02, -0.01, 0.128)], sash, (0.0, 0.5, 0.0)),
        limb([(0, 0.98, 0, 0.045), (0, 1.06, 0.005, 0.045)], skin),
        limb([(0, 1.13, 0.0, 0.078), (0, 1.10, 0.022, 0.066)], skin),
        limb([(0, 1.155, -0.018, 0.080), (0, 1.17, -0.02, 0.076)], hair),
        limb([(0, 1.25, -0.03, 0.032), (0, 1.265, -0.03, 0.03)], hair),
        limb([(0, 1.13, 0.080, 0.008), (0, 1.10, 0.092, 0.014)], skin),
        limb([(-0.02, 1.07, 0.079, 0.007), (0.02, 1.07, 0.079, 0.007)], robe),
        mirrored(limb([(0.022, 1.132, 0.072, 0.010), (0.036, 1.132, 0.067, 0.009)], hair)),
        mirrored(limb([(0.078, 1.13, 0.0, 0.016), (0.078, 1.10, 0.005, 0.013)], skin)),
        mirrored(limb([(0.13, 0.92, 0, 0.055), (0.23, 1.02, 0.02, 0.062), (0.27, 1.15, 0.03, 0.080)], robe)),
        mirrored(limb([(0.27, 1.14, 0.03, 0.034), (0.22, 1.27, 0.03, 0.028), (0.14, 1.36, 0.02, 0.024)], skin)),
        mirrored(limb([(0.135, 1.365, 0.02, 0.030), (0.115, 1.395, 0.015, 0.028)], skin)),
        limb([(0, 1.42, 0.01, 0.105), (0, 1.421, 0.01, 0.105)], sash),
    )

    def draped(points: np.ndarray) -> np.ndarray:
        x, y, z = points.T
        angle = FOLDS * np.arctan2(x, z) + 2.2 * np.sin(7.0 * y)
        low = np.clip((WAIST - 0.02 - y) / 0.25, 0.0, 1.0) * np.clip((y - 0.115) / 0.02, 0.0, 1.0)
        away = np.clip(np.hypot(x, z) / 0.1, 0.0, 1.0)
        return DEPTH * low * away * np.sin(angle)

    return Sculpture(lumps, (-0.38, -0.02, -0.34), (0.38, 1.56, 0.34), 0.012, draped)


def _drum(low: float, high: float, radius: float, color: Color) -> Lump:
    """An upright cylinder with rounded rims."""
    rim = 0.2 * (high - low)

    def distance(points: np.ndarray) -> np.ndarray:
        x, y, z = points.T
        out = np.hypot(x, z) - radius + rim
        over = np.abs(y - 0.5 * (low + high)) - 0.5 * (high - low) + rim
        outside = np.hypot(np.maximum(out, 0.0), np.maximum(over, 0.0))
        return np.minimum(np.maximum(out, over), 0.0) + outside - rim

    return Lump(distance, color, np.array([(-radius, low, -radius), (radius, high, radius)]))
