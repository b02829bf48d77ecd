"""Colours of OBJ, PLY and STL files, which have no rule for them.

They are what the programs that wrote them put on a screen unchanged, so they are taken as sRGB. Alpha is ignored:
everything is opaque. (What glTF files look like is told by `files/gltf`, and MTL files by `files/mtl`.)
"""

from __future__ import annotations

import numpy as np

from anamorph.base.srgb import decode_srgb
from anamorph.scene.model import WHITE, Diffuse


def linear_colors(encoded: np.ndarray) -> np.ndarray:
    """Linear colours (N, 3) float64 of unsigned integers, of fractions, or of floats that stand for bytes."""
    if encoded.dtype.kind in "iu":
        fractions = encoded / np.iinfo(encoded.dtype).max
    else:
        # Fractions may pass 1 by their rounding, and bytes are not all 0 and 1.
        fractions = encoded / (255.0 if encoded.max(initial=0.0) > 1.5 else 1.0)
    return decode_srgb(np.clip(np.nan_to_num(fractions, nan=0.0), 0.0, 1.0))


def plain(colored: bool) -> Diffuse:
    """The material of what has none: white where vertices have colours, which are multiplied by it."""
    return Diffuse(WHITE) if colored else Diffuse()
