"""The image of a sky: linear light from .hdr and .exr files, or an image of 8 bits."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from anamorph.base.errors import AnamorphError
from anamorph.base.exr import decode_exr
from anamorph.base.limits import MOST_PIXELS
from anamorph.base.radiance import decode_radiance
from anamorph.files.reading import read, read_texture
from anamorph.scene.model import LinearImage, Texture

LINEAR = {".hdr": decode_radiance, ".exr": decode_exr}


def read_sky_image(path: str | Path) -> Texture | LinearImage:
    """The image of a sky from a file: .hdr (Radiance), .exr (OpenEXR), or what Pillow reads of 8-bit sRGB.

    Raises
    ------
    AnamorphError
        A file that is damaged, too large, or of colours that are not understood.
    """
    path = Path(path)
    decode = LINEAR.get(path.suffix.lower())
    if decode is None:
        return read_texture(path)
    try:
        pixels = decode(read(path, "image file"), MOST_PIXELS)
    except ValueError as error:
        if isinstance(error, AnamorphError):
            raise
        raise AnamorphError(f"{path}: cannot be read, it has {error}; save it again, as Rec. 709 colours") from None
    if np.isnan(pixels).any():
        raise AnamorphError(f"{path}: {np.isnan(pixels).any(axis=-1).sum()} pixels are NaN; mend the image")
    # A sun may be infinite, and filters leave a little less than no light beside it.
    return LinearImage(np.clip(pixels, 0.0, np.finfo(np.float32).max))
