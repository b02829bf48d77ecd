"""The sRGB curve (IEC 61966-2-1): the one way between 8-bit images and the linear light that everything else uses."""

from __future__ import annotations

import numpy as np


def encode_srgb(linear: np.ndarray) -> np.ndarray:
    """Display values in 0 to 1 of linear light, clipped to 0 to 1; any shape, float32."""
    clipped = np.clip(np.asarray(linear, np.float32), 0.0, 1.0)
    curve = 1.055 * np.power(clipped, np.float32(1.0 / 2.4)) - 0.055
    return np.where(clipped <= 0.0031308, 12.92 * clipped, curve).astype(np.float32)


def decode_srgb(encoded: np.ndarray) -> np.ndarray:
    """Linear light of display values in 0 to 1; any shape, of the input's precision."""
    encoded = np.asarray(encoded)
    return np.where(encoded <= 0.04045, encoded / 12.92, ((encoded + 0.055) / 1.055) ** 2.4)
