"""Error maps as images, and the colour scales they are read with."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np

from anamorph.base.srgb import encode_srgb
from anamorph.measure.errors import ErrorMaps

VIRIDIS = ("#440154", "#472d7b", "#3b528b", "#2c728e", "#21918c", "#28ae80", "#5ec962", "#addc30", "#fde725")
"""Evenly spaced colours of the viridis map: equal steps look equal, also in grey and to the colour-blind."""

STOPS = np.array([[int(color[i : i + 2], 16) for i in (1, 3, 5)] for color in VIRIDIS], float)
"""The same as numbers from 0 to 255."""


@dataclass(frozen=True)
class Scale:
    """A logarithmic scale of colours between two errors, whole powers of ten.

    Parameters
    ----------
    unit : str
    lowest, highest : float
        What is less, or more, has the colour of the end.
    """

    unit: str
    lowest: float
    highest: float

    @property
    def ticks(self) -> tuple[float, ...]:
        """The powers of ten, evenly spaced along the scale."""
        first, last = (round(float(np.log10(end))) for end in (self.lowest, self.highest))
        return tuple(float(f"1e{power}") for power in range(first, last + 1))


MILLIRADIANS = Scale("mrad", 0.1, 1000.0)
PIXELS = Scale("px", 0.01, 100.0)


def scale_colors(errors: np.ndarray, scale: Scale = MILLIRADIANS) -> np.ndarray:
    """Colours of errors (...): 8-bit sRGB, (..., 3) uint8."""
    clipped = np.clip(errors, scale.lowest, scale.highest)
    place = np.log(clipped / scale.lowest) / np.log(scale.highest / scale.lowest) * (len(VIRIDIS) - 1)
    below = np.minimum(place.astype(int), len(VIRIDIS) - 2)
    part = (place - below)[..., None]
    return np.round((1.0 - part) * STOPS[below] + part * STOPS[below + 1]).astype(np.uint8)


def heat_map(maps: ErrorMaps, reference_color: np.ndarray) -> np.ndarray:
    """Angular errors over the reference in faint grey: 8-bit sRGB, (H, W, 3) uint8."""
    return heat_colors(maps, reference_color)[..., :3]


def heat_colors(maps: ErrorMaps, reference_color: np.ndarray, scale: Scale = MILLIRADIANS) -> np.ndarray:
    """Errors on either scale over the reference in faint grey: opaque 8-bit sRGB, (H, W, 4) uint8."""
    colors = faint(reference_color)
    errors = maps.pixels if scale == PIXELS else maps.angular
    np.copyto(packed(colors), _heat(scale)[_upper_half(errors)], where=maps.specular)
    return colors


def faint(color: np.ndarray) -> np.ndarray:
    """A linear image (H, W, 3) in grey so faint that colours stand out on it: opaque 8-bit sRGB, (H, W, 4) uint8."""
    encoded = _encoded()[_upper_half(color)]
    grey = _faint()[encoded[..., 0] + encoded[..., 1] + encoded[..., 2]]
    return grey.view(np.uint8).reshape(*grey.shape, 4)


def packed(colors: np.ndarray) -> np.ndarray:
    """The same memory with one number a colour: (..., 4) uint8 to (...) uint32, which moves four times as fast."""
    return colors.view(np.uint32)[..., 0]


def opaque(colors: np.ndarray) -> np.ndarray:
    """Colours (..., 3) uint8 with full alpha, packed: (...) uint32."""
    whole = np.full((*colors.shape[:-1], 4), 255, np.uint8)
    whole[..., :3] = colors
    return packed(whole)


def _upper_half(values: np.ndarray) -> np.ndarray:
    """Sign, exponent and seven more bits of each value: what the tables are in the order of."""
    return np.ascontiguousarray(values, np.float32).view(np.uint32) >> 16


@cache
def _middles() -> np.ndarray:
    """The values (65536,) that stand for all with the same upper half; half a percent away at most.

    Logarithms and powers of every pixel would take longer than the errors themselves.
    """
    middles = ((np.arange(1 << 16, dtype=np.uint32) << 16) | 0x8000).view(np.float32)
    return np.nan_to_num(middles, nan=np.inf, posinf=np.inf)


@cache
def _heat(scale: Scale) -> np.ndarray:
    """Packed colours of errors by their upper half; what is not a number has that of the highest."""
    return opaque(scale_colors(_middles().astype(float), scale))


@cache
def _encoded() -> np.ndarray:
    """Linear values by their upper half, as sRGB from 0 to 255, uint16 so that three can be added."""
    return np.round(255.0 * encode_srgb(_middles())).astype(np.uint16)


@cache
def _faint() -> np.ndarray:
    """Packed greys by the sum of three sRGB values."""
    grey = np.arange(3 * 255 + 1) / (3 * 255)
    return opaque(np.round(255.0 * (0.75 + 0.2 * grey))[:, None].repeat(3, axis=1).astype(np.uint8))
