"""OpenEXR images: linear light, and further layers beside it, without loss.

Format: openexr.com, read and written by its own library.
"""

from __future__ import annotations

import io
import os
import sys
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, redirect_stdout, suppress
from threading import Lock
from typing import Any

import numpy as np

REC_709 = (0.64, 0.33, 0.30, 0.60, 0.15, 0.06, 0.3127, 0.3290)
"""Chromaticities of red, green, blue and white."""

_PRINTING = Lock()
"""Who is about to turn the process's output away."""

AXES = "XYZ"
"""What the numbers of a vector are called in a layer."""


def decode_exr(data: bytes, most_pixels: int) -> np.ndarray:
    """The colours of the first part of an .exr file, (H, W, 3) float32; one of a single channel Y or R is grey.

    Raises
    ------
    ValueError
        Damage, more than `most_pixels`, or something that is not read: deep or subsampled pixels, a data window of its
        own, other primaries than those of Rec. 709, no colours. It says which.
    """
    try:
        width, height = _size(_opened(data, header_only=True).header(), most_pixels)
    except (AttributeError, KeyError, TypeError, OverflowError):
        # What damage leaves of an attribute is of another type.
        raise ValueError("a damaged header") from None
    channels = _opened(data).channels()
    names = next((names for names in ("RGB", "YYY", "RRR") if set(names) <= channels.keys()), None)
    if names is None:
        raise ValueError(f"the channels {', '.join(sorted(channels))}, and neither R, G, B nor Y")
    colors = [channels[name].pixels for name in names]
    if any(color.shape != (height, width) for color in colors):
        raise ValueError("subsampled colours")
    return np.stack(colors, axis=-1).astype(np.float32)


def _size(header: dict[str, Any], most_pixels: int) -> tuple[int, int]:
    """Width and height of an image whose header names nothing that is not read."""
    low, high = header["dataWindow"]
    width, height = (int(extent) for extent in np.subtract(high, low, dtype=np.int64) + 1)
    if min(width, height) < 1 or width * height > most_pixels:
        raise ValueError(f"{width} x {height} pixels, and at most {most_pixels} are read")
    if not np.array_equal(header["dataWindow"], header["displayWindow"]):
        raise ValueError("a data window that is not its display window")
    if "deep" in str(header.get("type", "")):
        raise ValueError("deep pixels")
    primaries = header.get("chromaticities", REC_709)
    if np.abs(np.subtract(primaries, REC_709)).max() > 1e-3:
        raise ValueError("other primaries than those of Rec. 709")
    return width, height


def encode_exr(color: np.ndarray, layers: Mapping[str, np.ndarray]) -> bytes:
    """Linear Rec. 709 light (H, W, 3) as R, G and B, and `layers`, (H, W) or (H, W, 3), as the bytes of an .exr file.

    A layer NAME becomes the channel NAME, or NAME.X, NAME.Y and NAME.Z: whole numbers as uint32, others as float32.
    """
    import OpenEXR

    channels = dict(zip("RGB", np.moveaxis(color, -1, 0), strict=True))
    for name, values in layers.items():
        if values.ndim == 2:
            channels[name] = values
        else:
            channels |= {f"{name}.{axis}": values[..., i] for i, axis in enumerate(AXES)}
    forms = {name: np.uint32 if values.dtype.kind == "u" else np.float32 for name, values in channels.items()}
    packed = {name: np.ascontiguousarray(values, forms[name]) for name, values in channels.items()}
    header = {
        "compression": OpenEXR.ZIP_COMPRESSION,
        "type": OpenEXR.scanlineimage,
        "chromaticities": REC_709,
    }
    file = io.BytesIO()
    OpenEXR.File(header, packed).write(file)
    return file.getvalue()


def _opened(data: bytes, **options: bool) -> Any:
    # The library is loaded by who reads or writes such a file, and by nobody else.
    import OpenEXR

    try:
        with _unprinted():
            file = OpenEXR.File(io.BytesIO(data), separate_channels=True, **options)
            damaged = not file.parts
    # Damage of every kind surfaces in the library as an error of some kind.
    except Exception:
        damaged = True
    if damaged:
        raise ValueError("no whole .exr image")
    return file


@contextmanager
def _unprinted() -> Iterator[None]:
    """Keep off stdout and stderr what the library prints of damage: its callers say it in one line."""
    with _PRINTING, open(os.devnull, "wb") as nowhere:
        kept = []
        # A program without a terminal may have neither.
        if sys.stdout is not None:
            sys.stdout.flush()
        for number in (1, 2):
            with suppress(OSError):
                kept.append((number, os.dup(number)))
        try:
            for number, _ in kept:
                os.dup2(nowhere.fileno(), number)
            with redirect_stdout(io.StringIO()):
                yield
        finally:
            for number, copy in kept:
                os.dup2(copy, number)
                os.close(copy)
