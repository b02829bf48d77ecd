"""Sculptures of animals: a bunny, a dragon and a dinosaur, each a few limbs that run into each other."""

from __future__ import annotations

import numpy as np

from anamorph.gallery.sculpting import Lump, Sculpture, limb, mirrored
from anamorph.scene.model import Color

DARK: Color = (0.03, 0.02, 0.02)
IVORY: Color = (0.82, 0.72, 0.52)


def bunny() -> Sculpture:
    """A sitting bunny, 1 m high, that looks along +z."""
    fur: Color = (0.52, 0.33, 0.20)
    pale: Color = (0.80, 0.68, 0.56)
    ear = ((0.06, 0.74, 0.22, 0.045), (0.09, 0.84, 0.14, 0.075), (0.12, 0.93, 0.05, 0.065), (0.13, 0.98, 0.0, 0.02))
    arm = ((0.11, 0.36, 0.20, 0.09), (0.11, 0.20, 0.26, 0.06), (0.11, 0.06, 0.28, 0.05), (0.11, 0.05, 0.34, 0.045))
    lumps = (
        limb([(0, 0.30, -0.20, 0.24), (0, 0.33, -0.05, 0.27), (0, 0.36, 0.10, 0.21), (0, 0.46, 0.20, 0.15)], fur),
        limb([(0, 0.50, 0.22, 0.12), (0, 0.62, 0.27, 0.155), (0, 0.60, 0.37, 0.11), (0, 0.57, 0.44, 0.07)], fur),
        mirrored(limb([(0.05, 0.56, 0.43, 0.055), (0.06, 0.555, 0.45, 0.05)], pale)),
        limb([(0, 0.585, 0.49, 0.018), (0, 0.577, 0.50, 0.015)], (0.45, 0.12, 0.12)),
        mirrored(limb([(0.125, 0.655, 0.345, 0.026), (0.127, 0.655, 0.350, 0.025)], DARK)),
        mirrored(limb(ear, fur, (0.5, 1.0, 1.2))),
        mirrored(limb([(0.19, 0.26, -0.13, 0.20), (0.20, 0.18, -0.02, 0.15)], fur)),
        mirrored(limb([(0.20, 0.055, -0.10, 0.06), (0.21, 0.05, 0.06, 0.06), (0.21, 0.045, 0.17, 0.045)], pale)),
        mirrored(limb(arm, fur)),
        limb([(0, 0.22, -0.46, 0.085), (0, 0.24, -0.49, 0.085)], pale),
    )

    def shaggy(points: np.ndarray) -> np.ndarray:
        x, y, z = 46.0 * points.T
        return 0.0016 * (np.sin(x + 0.6 * y) * np.sin(y + 0.7 * z) + np.sin(1.7 * z + x) * np.sin(1.9 * y - x))

    return Sculpture(lumps, (-0.45, -0.02, -0.62), (0.45, 1.04, 0.56), 0.022, shaggy)


# From the tip of the tail to the neck: x, y, z and radius.
SERPENT = np.array(
    [
        (0.40, 0.12, -0.98, 0.010), (0.34, 0.07, -0.76, 0.034), (-0.04, 0.09, -0.66, 0.058),
        (-0.30, 0.19, -0.42, 0.090), (-0.14, 0.33, -0.18, 0.125), (0.12, 0.36, 0.02, 0.145),
        (0.20, 0.34, 0.24, 0.135), (0.08, 0.42, 0.42, 0.115), (-0.03, 0.57, 0.47, 0.095), (0.0, 0.76, 0.52, 0.085),
    ]
)  # fmt: skip
LEGS = (
    ((0.28, 0.32, 0.24, 0.080), (0.43, 0.22, 0.17, 0.055), (0.44, 0.09, 0.26, 0.036), (0.44, 0.035, 0.34, 0.034)),
    ((-0.01, 0.30, 0.36, 0.080), (-0.17, 0.21, 0.32, 0.055), (-0.18, 0.09, 0.41, 0.036), (-0.18, 0.035, 0.49, 0.034)),
    ((0.00, 0.27, -0.20, 0.090), (0.15, 0.22, -0.24, 0.065), (0.16, 0.09, -0.34, 0.040), (0.16, 0.035, -0.24, 0.036)),
    (
        (-0.28, 0.25, -0.20, 0.090),
        (-0.42, 0.22, -0.16, 0.065),
        (-0.45, 0.09, -0.25, 0.040),
        (-0.45, 0.035, -0.15, 0.036),
    ),
)
"""From the body to the foot, as rows of a limb."""


def dragon() -> Sculpture:
    """A winding dragon, 1.9 m long and 1 m high, whose head looks along +z."""
    hide: Color = (0.06, 0.30, 0.16)
    crest: Color = (0.62, 0.12, 0.05)
    belly: Color = (0.62, 0.50, 0.22)
    lumps = [
        limb(SERPENT, hide),
        limb(SERPENT * (1.0, 1.0, 1.0, 0.82) - np.outer(SERPENT[:, 3], (0.0, 0.30, 0.0, 0.0)), belly),
        limb([(0, 0.80, 0.52, 0.090), (0, 0.83, 0.62, 0.080), (0, 0.80, 0.76, 0.055), (0, 0.79, 0.86, 0.048)], hide),
        limb([(0, 0.76, 0.56, 0.055), (0, 0.715, 0.68, 0.038), (0, 0.69, 0.80, 0.026)], belly),
        mirrored(limb([(0.035, 0.88, 0.60, 0.030), (0.065, 0.96, 0.50, 0.022), (0.085, 1.0, 0.38, 0.006)], IVORY)),
        mirrored(limb([(0.058, 0.868, 0.665, 0.026), (0.060, 0.868, 0.670, 0.026)], (0.85, 0.55, 0.03))),
        mirrored(limb([(0.066, 0.872, 0.687, 0.011), (0.067, 0.872, 0.690, 0.011)], DARK)),
        mirrored(limb([(0.022, 0.828, 0.88, 0.020), (0.024, 0.826, 0.89, 0.018)], hide)),
        mirrored(limb([(0.05, 0.78, 0.86, 0.013), (0.15, 0.73, 0.90, 0.010), (0.22, 0.80, 0.84, 0.005)], crest)),
        mirrored(limb([(0.028, 0.765, 0.83, 0.013), (0.028, 0.725, 0.835, 0.005)], IVORY)),
    ]
    for leg in LEGS:
        lumps.append(limb(leg, hide))
        x, y, z, radius = leg[-1]
        for side in (-0.9, 0.0, 0.9):
            start = (x + side * radius, y - 0.006, z + 0.4 * radius, 0.014)
            lumps.append(limb([start, (x + 1.8 * side * radius, y - 0.024, z + 2.2 * radius, 0.004)], IVORY))

    def scaly(points: np.ndarray) -> np.ndarray:
        x, y, z = 75.0 * points.T
        return 0.0022 * np.abs(np.sin(0.5 * (x + y)) * np.sin(0.5 * (y + z)) * np.sin(0.5 * (z - x)))

    return Sculpture((*lumps, *_spines(crest)), (-0.52, -0.02, -1.02), (0.52, 1.06, 0.96), 0.012, scaly)


def _spines(color: Color) -> list[Lump]:
    """Along the back of the dragon, which is carried along its curve."""
    along = np.linspace(0.6, len(SERPENT) - 1.0, 30)
    rows = np.stack([np.interp(along, np.arange(len(SERPENT)), column) for column in SERPENT.T], axis=1)
    back, found = np.array([0.0, 1.0, 0.0]), []
    for (*place, radius), way in zip(rows, np.gradient(rows[:, :3], axis=0), strict=True):
        way = way / np.linalg.norm(way)
        back = back - (back @ way) * way
        back /= np.linalg.norm(back)
        foot, tip = place + 0.85 * radius * back, place + (1.35 * radius + 0.03) * back - 0.25 * radius * way
        found.append(limb([(*foot, 0.25 * radius + 0.004), (*tip, 0.004)], color))
    return found


def dinosaur() -> Sculpture:
    """A long-necked dinosaur, 2 m long and 1 m high, that looks along +z."""
    hide: Color = (0.28, 0.36, 0.42)
    belly: Color = (0.62, 0.58, 0.48)
    spine = np.array(
        [
            (0.16, 0.16, -1.08, 0.010), (0.10, 0.26, -0.80, 0.035), (0.0, 0.38, -0.50, 0.085),
            (0.0, 0.46, -0.22, 0.185), (0.0, 0.48, 0.06, 0.200), (0.0, 0.56, 0.30, 0.125),
            (0.0, 0.72, 0.48, 0.075), (0.0, 0.88, 0.60, 0.058), (0.0, 0.96, 0.68, 0.055),
        ]
    )  # fmt: skip
    lumps = [
        limb(spine, hide),
        limb(spine[2:7] * (1.0, 1.0, 1.0, 0.85) - np.outer(spine[2:7, 3], (0.0, 0.30, 0.0, 0.0)), belly),
        limb([(0, 0.97, 0.70, 0.060), (0, 0.96, 0.78, 0.052), (0, 0.935, 0.86, 0.036)], hide),
        mirrored(limb([(0.046, 0.99, 0.76, 0.018), (0.047, 0.99, 0.762, 0.018)], DARK)),
        mirrored(limb([(0.11, 0.42, 0.18, 0.10), (0.15, 0.24, 0.20, 0.07), (0.15, 0.05, 0.20, 0.065)], hide)),
        mirrored(limb([(0.11, 0.40, -0.22, 0.12), (0.16, 0.24, -0.26, 0.08), (0.16, 0.05, -0.24, 0.07)], hide)),
    ]
    return Sculpture(tuple(lumps), (-0.26, -0.04, -1.12), (0.26, 1.06, 0.92), 0.02)
