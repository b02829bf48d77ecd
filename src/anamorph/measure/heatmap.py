"""Error maps as pictures, and the colour scale they are read with."""

from __future__ import annotations

import numpy as np

from anamorph.measure.errors import ErrorMaps
from anamorph.srgb import encode_srgb

LOWEST, HIGHEST = 0.1, 1000.0
"""The ends of the scale in milliradians; between them it is logarithmic."""

TICKS = (0.1, 1.0, 10.0, 100.0, 1000.0)

VIRIDIS = ("#440154", "#472d7b", "#3b528b", "#2c728e", "#21918c", "#28ae80", "#5ec962", "#addc30", "#fde725")
"""Evenly spaced colours of the viridis map: equal steps look equal, also in grey and to the colour-blind."""

_STOPS = np.array([[int(color[i : i + 2], 16) for i in (1, 3, 5)] for color in VIRIDIS], float)


def scale_colors(milliradians: np.ndarray) -> np.ndarray:
    """Colours of angular errors (...): 8-bit sRGB, (..., 3) uint8."""
    clipped = np.clip(milliradians, LOWEST, HIGHEST)
    place = np.log(clipped / LOWEST) / np.log(HIGHEST / LOWEST) * (len(VIRIDIS) - 1)
    below = np.minimum(place.astype(int), len(VIRIDIS) - 2)
    part = (place - below)[..., None]
    return np.round((1.0 - part) * _STOPS[below] + part * _STOPS[below + 1]).astype(np.uint8)


def heat_map(maps: ErrorMaps, truth_color: np.ndarray) -> np.ndarray:
    """Angular errors over the truth in faint grey: 8-bit sRGB, (H, W, 3) uint8."""
    grey = encode_srgb(truth_color).mean(axis=-1, keepdims=True)
    around = np.broadcast_to(np.round(255.0 * (0.75 + 0.2 * grey)), (*grey.shape[:2], 3)).astype(np.uint8)
    return np.where(maps.specular[..., None], scale_colors(maps.angular), around)
