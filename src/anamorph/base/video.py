"""Moving images as files, written frame by frame: WebM, animated WebP, or a folder of PNG images.

A lossy WebP image is a key frame of VP8 (RFC 9649), which is what a WebM file may hold (webmproject.org, "VP8 Encode
Parameter Guide" and "WebM Container Guidelines"). So Pillow alone makes videos that every browser plays, without a
codec whose licence or patents would bind who ships this package.
"""

from __future__ import annotations

import io
import struct
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager
from pathlib import Path

import numpy as np
from PIL import Image

from anamorph.base.errors import AnamorphError
from anamorph.base.output import check_folder, check_output, pixel_bytes, whole_file, whole_folder

QUALITY = 90
VIDEOS = (".webm", ".webp")
LARGEST = 16383
"""Pixels along a side that VP8 can number."""

LONGEST = 2**32 - 2**24
"""Bytes of an animated WebP file, which counts them in 32 bits, with space for one more frame."""

MOST_FRAMES = 9999
"""As many as the names of a series number alike."""

RATES = (1.0, 120.0)
"""Frames a second."""

AddFrame = Callable[[np.ndarray], None]
"""Takes the next frame: 8-bit sRGB pixels (H, W, 3), all of one size."""


def check_video(path: Path, size: tuple[int, int]) -> None:
    """Refuse what `video` could not write, before any work is done for it."""
    if not path.suffix:
        check_folder(path)
        return
    if path.suffix.lower() not in VIDEOS:
        raise AnamorphError(
            f"{path}: cannot write '{path.suffix}' files; end the name in {', '.join(VIDEOS)}, "
            "or in nothing for a folder of PNG images"
        )
    check_output(path)
    if max(size) > LARGEST:
        raise AnamorphError(f"{path}: a video has at most {LARGEST} pixels a side; choose a smaller size, or a folder")


def video(path: str | Path, size: tuple[int, int], rate: float) -> AbstractContextManager[AddFrame]:
    """A video that takes its name only when the block ends well; gives the function that adds a frame.

    Parameters
    ----------
    path : str or Path
        Ends in .webm or .webp; without a suffix, a folder for numbered PNG images.
    size : (width, height)
    rate : float
        Frames a second.
    """
    path = Path(path)
    check_video(path, size)
    if not RATES[0] <= rate <= RATES[1]:
        raise AnamorphError(f"{path}: {rate:g} frames a second; give {RATES[0]:g} to {RATES[1]:g}")
    kinds = {".webm": _webm, ".webp": _animated_webp}
    return kinds[path.suffix.lower()](path, size, rate) if path.suffix else _series(path)


@contextmanager
def _series(path: Path) -> Iterator[AddFrame]:
    with whole_folder(path) as folder:
        count = 0

        def add(pixels: np.ndarray) -> None:
            nonlocal count
            count += 1
            (folder / f"frame-{count:04}.png").write_bytes(pixel_bytes(pixels))

        yield add


def _key_frame(pixels: np.ndarray) -> bytes:
    """The VP8 key frame in a lossy WebP image: what is left without the container's two headings."""
    file = io.BytesIO()
    Image.fromarray(pixels).save(file, "WEBP", quality=QUALITY)
    data = file.getvalue()
    if data[12:16] != b"VP8 ":
        raise AnamorphError("video: Pillow here writes WebP in another form; save PNG images into a folder")
    return data[20 : 20 + int.from_bytes(data[16:20], "little")]


def _time(frame: int, rate: float) -> int:
    """When a frame begins, milliseconds."""
    return round(1000.0 * frame / rate)


@contextmanager
def _animated_webp(path: Path, size: tuple[int, int], rate: float) -> Iterator[AddFrame]:
    """An animation that runs for ever: RFC 9649, section 2.7."""
    extent = b"".join((side - 1).to_bytes(3, "little") for side in size)
    with whole_file(path) as file:
        # The length of all is filled in at the end.
        file.write(b"RIFF\0\0\0\0WEBP")
        file.write(_chunk(b"VP8X", b"\x02\0\0\0" + extent))
        file.write(_chunk(b"ANIM", bytes(6)))
        count = 0

        def add(pixels: np.ndarray) -> None:
            nonlocal count
            if file.tell() > LONGEST:
                raise AnamorphError(f"{path}: is too long for a WebP file at frame {count + 1}; give a .webm file")
            shown = _time(count + 1, rate) - _time(count, rate)
            count += 1
            heading = bytes(6) + extent + shown.to_bytes(3, "little") + b"\x02"
            file.write(_chunk(b"ANMF", heading + _chunk(b"VP8 ", _key_frame(pixels))))

        yield add
        length = file.tell() - 8
        file.seek(4)
        file.write(length.to_bytes(4, "little"))


def _chunk(name: bytes, payload: bytes) -> bytes:
    return name + len(payload).to_bytes(4, "little") + payload + bytes(len(payload) % 2)


@contextmanager
def _webm(path: Path, size: tuple[int, int], rate: float) -> Iterator[AddFrame]:
    """A WebM file of key frames (RFC 9559): one cluster for each, so that any of them is found at once."""
    with whole_file(path) as file:
        file.write(_element("1A45DFA3", _word("4282", "webm"), _whole("4287", 4), _whole("4285", 2)))
        segment = file.tell()
        file.write(_element("18538067"))
        start = file.tell()
        cues: list[bytes] = []

        def opening(cues_at: int, frames: int) -> bytes:
            """What stands before the frames, as long whatever the numbers are."""
            seek = _element("4DBB", _element("53AB", bytes.fromhex("1C53BB6B")), _whole("53AC", cues_at))
            duration = _element("4489", struct.pack(">d", _time(frames, rate)))
            maker = (_word("4D80", "anamorph"), _word("5741", "anamorph"))
            info = _element("1549A966", _whole("2AD7B1", 1_000_000), duration, *maker)
            return _element("114D9B74", seek) + info + _element("1654AE6B", _track(size, rate))

        file.write(opening(0, 0))

        def add(pixels: np.ndarray) -> None:
            when = _whole("E7", _time(len(cues), rate))
            block = _element("A3", b"\x81\0\0\x80", _key_frame(pixels))
            place = _element("B7", _whole("F7", 1), _whole("F1", file.tell() - start))
            cues.append(_element("BB", _whole("B3", _time(len(cues), rate)), place))
            file.write(_element("1F43B675", when, block))

        yield add
        cues_at = file.tell() - start
        file.write(_element("1C53BB6B", *cues))
        length = file.tell() - start
        file.seek(segment)
        file.write(bytes.fromhex("18538067") + _length(length) + opening(cues_at, len(cues)))


def _track(size: tuple[int, int], rate: float) -> bytes:
    """The one track of a WebM file; WebP's colours are those of BT.601 at limited range, of sRGB primaries."""
    colors = _element("55B0", _whole("55B1", 6), _whole("55B9", 1), _whole("55BA", 13), _whole("55BB", 1))
    shown = _element("E0", _whole("B0", size[0]), _whole("BA", size[1]), colors)
    names = (_whole("D7", 1), _whole("73C5", 1), _whole("83", 1), _word("86", "V_VP8"))
    return _element("AE", *names, _whole("23E383", round(1e9 / rate)), shown)


def _element(name: str, *payload: bytes) -> bytes:
    """An element of EBML: its number in hexadecimal, its length, and what is in it."""
    content = b"".join(payload)
    return bytes.fromhex(name) + _length(len(content)) + content


def _length(length: int) -> bytes:
    return (1 << 56 | length).to_bytes(8, "big")


def _whole(name: str, value: int) -> bytes:
    return _element(name, value.to_bytes(8, "big"))


def _word(name: str, text: str) -> bytes:
    return _element(name, text.encode())
