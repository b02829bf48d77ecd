"""Traced paths as the visibility buffer holds them. Compiled."""

from __future__ import annotations

import math

import numpy as np

from anamorph.base.compiled import compiled, over_all_cores

GRAIN = 16384

PLACES = 2**24 - 1
"""Places along a side of the octahedron."""

BLANK = 0xFFFFFFFF
"""The triangle of a record whose path ends in the sky."""


def packed(records: np.ndarray) -> np.ndarray:
    """Path ends as `gpu/visibility.wgsl` reads them.

    Parameters
    ----------
    records : (N, 16) float32
        From `PathTracer.tracing`.

    Returns
    -------
    texels : (2, N, 4) uint32
    """
    texels = np.empty((2, len(records), 4), np.uint32)
    words = records.view(np.uint32)
    over_all_cores(lambda first, stop: _pack(records, words, texels, first, stop), len(records), GRAIN)
    return texels


@compiled
def _pack(records: np.ndarray, words: np.ndarray, texels: np.ndarray, first: int, stop: int) -> None:
    for i in range(first, stop):
        x, y, z = np.float64(records[i, 4]), np.float64(records[i, 5]), np.float64(records[i, 6])
        size = max(abs(x) + abs(y) + abs(z), 1e-30)
        x, y = x / size, y / size
        if z < 0.0:
            x, y = (1.0 - abs(y)) * (1.0 if x >= 0.0 else -1.0), (1.0 - abs(x)) * (1.0 if y >= 0.0 else -1.0)
        for axis in range(3):
            texels[0, i, axis] = words[i, axis]
        red, green, blue = half(records[i, 8]), half(records[i, 9]), half(records[i, 10])
        texels[0, i, 3] = np.uint32(0) if words[i, 3] == BLANK else np.uint32(words[i, 3] + 1)
        texels[1, i, 0] = np.uint32(int(np.rint((0.5 + 0.5 * x) * PLACES)) | ((red & 0xFF) << 24))
        texels[1, i, 1] = np.uint32(int(np.rint((0.5 + 0.5 * y) * PLACES)) | ((red >> 8) << 24))
        texels[1, i, 2] = words[i, 7]
        texels[1, i, 3] = np.uint32(green | (blue << 16))


@compiled
def half(value: float) -> int:
    """The bits of a number from 0 to 65504 as a half float, rounded to the nearest, and of two to the even."""
    share = min(max(value, 0.0), 65504.0)
    if share < 2.0**-14:
        return int(np.rint(share * 2.0**24))
    mantissa, exponent = math.frexp(share)
    bits = int(np.rint(mantissa * 2048.0))
    return bits - 1024 + ((exponent + 14) << 10)
