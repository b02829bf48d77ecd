"""A swell that everything rides on, and flags that flutter in the wind: where each vertex is at a time, and its normal.

The swell is Gerstner's trochoidal waves (1802), as Fournier and Reeves, "A simple model of ocean waves" (1986), use
them; it moves a vertex by the place at which it rests. Normals are exact: they go with the inverse transpose of the
motion's derivative.
"""

from __future__ import annotations

import math

import numpy as np

from anamorph.base.compiled import compiled, over_all_cores
from anamorph.base.vectors import Vector

GRAIN = 16384

GRAVITY = 9.81
STEEPNESS = 0.8
CALM = 45.0
"""Metres from the middle at which the swell has half its height."""

WAVES = np.array([(9.0, 0.24, 35.0, 0.3), (5.2, 0.11, -20.0, 1.9), (3.3, 0.05, 80.0, 4.0)])
"""Length and height over the mean (metres), heading from +x towards +z (degrees), phase (radians)."""

FLUTTER, FLAG_WAVE, FLAG_PERIOD, FLAG_SLANT = 0.14, 1.5, 0.9, 1.2
"""Of a flag: how far it swings a metre from its pole, length of its waves (m), period (s), slant (radians a metre)."""


def deform(
    positions: np.ndarray,
    normals: np.ndarray,
    reach: np.ndarray,
    wind: np.ndarray,
    time: float,
    moved: np.ndarray,
    turned: np.ndarray,
) -> None:
    """Find where vertices are at `time` (seconds), and their normals.

    Parameters
    ----------
    positions, normals : (V, 3) float32
        At rest, on a calm sea without wind.
    reach : (V,) float32
        Metres from the flagpole along a flag; negative for what is no flag.
    wind : (2,) float64
        The unit direction, (x, z), in which flags stream.
    time : float
    moved, turned : (V, 3) float32
        To be filled with the positions and the normals.
    """
    number = 2.0 * np.pi / WAVES[:, 0]
    heading = np.radians(WAVES[:, 2])
    waves = np.stack(
        [
            number * np.cos(heading), number * np.sin(heading), WAVES[:, 1],
            STEEPNESS * np.cos(heading), STEEPNESS * np.sin(heading), WAVES[:, 3] - np.sqrt(GRAVITY * number) * time,
        ],
        axis=1,
    )  # fmt: skip

    def work(start: int, stop: int) -> None:
        piece = slice(start, stop)
        _deform(positions[piece], normals[piece], reach[piece], wind, waves, time, moved[piece], turned[piece])

    over_all_cores(work, len(positions), GRAIN)


@compiled
def _flutter(place: Vector, normal: Vector, reach: float, wind: np.ndarray, time: float) -> tuple[Vector, Vector]:
    """The motion across the wind by f(reach, height), which grows from nothing at the pole."""
    number = 2.0 * math.pi / FLAG_WAVE
    phase = number * reach + FLAG_SLANT * place[1] - 2.0 * math.pi / FLAG_PERIOD * time
    across_x, across_z = -wind[1], wind[0]
    sine, cosine = math.sin(phase), math.cos(phase)
    swing = FLUTTER * reach * sine
    along_wind, along_height = FLUTTER * (sine + reach * number * cosine), FLUTTER * reach * FLAG_SLANT * cosine
    # The inverse transpose of I + a b', a across the wind and b at right angles to it, is I - b a'.
    part = normal[0] * across_x + normal[2] * across_z
    return (
        (place[0] + swing * across_x, place[1], place[2] + swing * across_z),
        (
            normal[0] - part * along_wind * wind[0],
            normal[1] - part * along_height,
            normal[2] - part * along_wind * wind[1],
        ),
    )


@compiled
def _swell(place: Vector, normal: Vector, waves: np.ndarray) -> tuple[Vector, Vector]:
    """The sum of the waves, lower the further from the middle, and the normal, of any length."""
    x, z = place[0], place[2]
    weight = 1.0 / (1.0 + (x * x + z * z) / (CALM * CALM))
    slope = -2.0 * weight * weight / (CALM * CALM)
    # The motion, and its derivatives by x and by z, of the waves at their full height.
    a = b = c = a_x = b_x = c_x = a_z = b_z = c_z = 0.0
    for wave in range(len(waves)):
        k_x, k_z, height, forth_x, forth_z, phase = waves[wave]
        # Rounded, because the sine of a float32 takes half the time; that of 1,000 radians is still good to 6e-5.
        angle = np.float32(k_x * x + k_z * z + phase)
        sine, cosine = height * math.sin(angle), height * math.cos(angle)
        a, b, c = a - forth_x * sine, b + cosine, c - forth_z * sine
        a_x, b_x, c_x = a_x - forth_x * cosine * k_x, b_x - sine * k_x, c_x - forth_z * cosine * k_x
        a_z, b_z, c_z = a_z - forth_x * cosine * k_z, b_z - sine * k_z, c_z - forth_z * cosine * k_z
    # Where the unit vectors along x and z are carried.
    ex, ey, ez = 1.0 + weight * a_x + slope * x * a, weight * b_x + slope * x * b, weight * c_x + slope * x * c
    fx, fy, fz = weight * a_z + slope * z * a, weight * b_z + slope * z * b, 1.0 + weight * c_z + slope * z * c
    n_x, n_y, n_z = normal
    # The cofactors of the derivative, whose columns are e, (0, 1, 0) and f, times the normal.
    return (
        (x + weight * a, place[1] + weight * b, z + weight * c),
        (
            n_x * fz - n_z * ez + n_y * (fy * ez - fz * ey),
            n_y * (fz * ex - fx * ez),
            n_z * ex - n_x * fx + n_y * (fx * ey - fy * ex),
        ),
    )


@compiled
def _deform(
    positions: np.ndarray,
    normals: np.ndarray,
    reach: np.ndarray,
    wind: np.ndarray,
    waves: np.ndarray,
    time: float,
    moved: np.ndarray,
    turned: np.ndarray,
) -> None:
    for i in range(len(positions)):
        place = (np.float64(positions[i, 0]), np.float64(positions[i, 1]), np.float64(positions[i, 2]))
        normal = (np.float64(normals[i, 0]), np.float64(normals[i, 1]), np.float64(normals[i, 2]))
        if reach[i] >= 0.0:
            place, normal = _flutter(place, normal, np.float64(reach[i]), wind, time)
        place, normal = _swell(place, normal, waves)
        length = math.sqrt(normal[0] * normal[0] + normal[1] * normal[1] + normal[2] * normal[2])
        for axis in range(3):
            moved[i, axis], turned[i, axis] = place[axis], normal[axis] / length
