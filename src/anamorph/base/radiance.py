"""Radiance .hdr images: linear light, three bytes of mantissas and one of a shared exponent a pixel.

Format: Ward, "Real pixels", Graphics Gems II (1991), and the Radiance reference manual on pictures. The exponent byte
e stands for a factor 2^(e - 136); the byte 0 for black. Of the headers' variants only rows from the top, each from the
left, are read, which is what programs write.
"""

from __future__ import annotations

import re

import numpy as np

RUN = 2
"""The two first bytes of a row that is packed in four runs, one for each byte of its pixels."""

PACKED_WIDTHS = range(8, 32768)
"""Rows of other widths are never packed so."""


def decode_radiance(data: bytes, most_pixels: int) -> np.ndarray:
    """The bytes of a .hdr file as linear light, (H, W, 3) float32.

    Raises
    ------
    ValueError
        Another format, more than `most_pixels`, or damage; it says which.
    """
    found = re.match(rb"#\?[^\n]*\n((?:[^\n]+\n)*)\n([^\n]{1,80})\n", data)
    if found is None:
        raise ValueError("no Radiance header")
    header, size = found.group(1), re.fullmatch(rb"-Y (\d{1,7}) \+X (\d{1,7})\s*", found.group(2))
    if b"FORMAT=32-bit_rle_rgbe" not in header:
        raise ValueError("no FORMAT=32-bit_rle_rgbe")
    if size is None:
        raise ValueError(f"rows in the order {found.group(2).decode('ascii', 'replace')}, not -Y +X")
    height, width = (int(extent) for extent in size.groups())
    if not 0 < height * width <= most_pixels:
        raise ValueError(f"{width} x {height} pixels, and at most {most_pixels} are read")
    exposure = 1.0
    for line in re.findall(rb"EXPOSURE=([^\n]*)", header):
        exposure *= float(line)
    if not (np.isfinite(exposure) and exposure > 0.0):
        raise ValueError("an EXPOSURE that is no positive number")
    rows, at = np.empty((height, width, 4), np.uint8), found.end()
    for row in rows:
        at = _read_row(data, at, row)
    factors = np.ldexp(1.0 / exposure, rows[..., 3].astype(np.int32) - 136) * (rows[..., 3] > 0)
    return (rows[..., :3] * factors[..., None]).astype(np.float32)


def encode_radiance(color: np.ndarray) -> bytes:
    """Linear light (H, W, 3) as the bytes of a .hdr file; each pixel keeps 8 bits of its brightest colour."""
    color = np.maximum(np.asarray(color, np.float64), 0.0)
    height, width = color.shape[:2]
    _, exponents = np.frexp(color.max(axis=-1))
    # Rounded up to 256, the brightest colour would not fit its byte.
    exponents = exponents + (np.rint(np.ldexp(color.max(axis=-1), 8 - exponents)) > 255.0)
    bright = (exponents > -128) & color.any(axis=-1)
    if (exponents > 127).any():
        raise ValueError("has light beyond 2^127, which .hdr cannot hold")
    pixels = np.zeros((height, width, 4), np.uint8)
    pixels[..., :3] = np.rint(np.ldexp(color, (8 - exponents)[..., None])) * bright[..., None]
    pixels[..., 3] = np.where(bright, exponents + 128, 0)
    return b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y %d +X %d\n" % (height, width) + pixels.tobytes()


def _read_row(data: bytes, at: int, row: np.ndarray) -> int:
    """Fill one row (W, 4); the place of the next one."""
    width = len(row)
    packed = data[at : at + 2] == bytes((RUN, RUN)) and width in PACKED_WIDTHS
    if not packed or int.from_bytes(data[at + 2 : at + 4], "big") != width:
        return _read_pixels(data, at, row)
    at += 4
    for channel in range(4):
        done = 0
        while done < width:
            count = _byte(data, at)
            if count > 128:
                count -= 128
                row[done : done + count, channel] = _byte(data, at + 1)
                at += 2
            else:
                values = np.frombuffer(data[at + 1 : at + 1 + count], np.uint8)
                if not count or done + count > width or len(values) < count:
                    raise ValueError("a damaged row")
                row[done : done + count, channel] = values
                at += 1 + count
            done += count
        if done > width:
            raise ValueError("a damaged row")
    return at


def _read_pixels(data: bytes, at: int, row: np.ndarray) -> int:
    """A row of whole pixels, in which 1, 1, 1, n repeats the last one n times; runs of runs count in 256s."""
    pixels = np.frombuffer(data[at : at + 4 * len(row)], np.uint8)
    if len(pixels) == 4 * len(row) and not (pixels.reshape(-1, 4)[:, :3] == 1).all(axis=1).any():
        row[:] = pixels.reshape(-1, 4)
        return at + 4 * len(row)
    done, shift = 0, 0
    while done < len(row):
        pixel = data[at : at + 4]
        if len(pixel) < 4:
            raise ValueError("too few pixels")
        at += 4
        if pixel[:3] == b"\x01\x01\x01":
            count = pixel[3] << shift
            if not done or done + count > len(row):
                raise ValueError("a damaged row")
            row[done : done + count] = row[done - 1]
            done, shift = done + count, min(shift + 8, 24)
        else:
            row[done] = np.frombuffer(pixel, np.uint8)
            done, shift = done + 1, 0
    return at


def _byte(data: bytes, at: int) -> int:
    if at >= len(data):
        raise ValueError("too few pixels")
    return data[at]
