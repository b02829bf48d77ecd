"""Writing results: every file appears whole or not at all."""

from __future__ import annotations

import io
import os
import shutil
import threading
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
from PIL import Image

from anamorph.base.errors import AnamorphError
from anamorph.base.exr import encode_exr
from anamorph.base.interrupt import on_interrupt
from anamorph.base.radiance import encode_radiance
from anamorph.base.srgb import encode_srgb

PIXELS = (".png", ".jpg", ".jpeg", ".webp")
"""Suffixes of image files of 8-bit sRGB."""

IMAGES = (*PIXELS, ".exr", ".hdr", ".npy")
"""Suffixes of all image files: `.exr` and `.npy` keep the linear floats, and `.hdr` 8 bits of each and an exponent."""


def check_output(path: str | Path, suffixes: tuple[str, ...] = ()) -> Path:
    """Refuse a path that could not be written, before any work is done for it.

    Raises
    ------
    AnamorphError
        An unknown suffix, a directory that is missing or read-only, or something in the way that is no plain file.
    """
    path = Path(path)
    if suffixes and path.suffix.lower() not in suffixes:
        raise AnamorphError(f"{path}: cannot write '{path.suffix}' files; end the name in {', '.join(suffixes)}")
    directory = path.resolve().parent
    if not directory.is_dir():
        raise AnamorphError(f"{path}: there is no directory {directory}; make it first")
    if not os.access(directory, os.W_OK):
        raise AnamorphError(f"{path}: the directory {directory} cannot be written; choose another")
    if path.exists() and not path.is_file():
        raise AnamorphError(f"{path}: is there already and is not a plain file; choose another name")
    return path


def check_directory(path: Path) -> None:
    """Refuse a directory that could neither be made nor written to, before any work is done for it."""
    if path.is_dir():
        if not os.access(path, os.W_OK):
            raise AnamorphError(f"{path}: the directory cannot be written; choose another")
    elif path.exists():
        raise AnamorphError(f"{path}: is there already and is no directory; choose another name")
    else:
        check_output(path)


@contextmanager
def whole_file(path: str | Path) -> Iterator[BinaryIO]:
    """A binary file that takes its name only when the block ends well, and leaves nothing behind when it does not."""
    path = check_output(path).resolve()
    with _unfinished(path, lambda part: part.unlink(missing_ok=True)) as part, open(part, "wb") as file:
        yield file


@contextmanager
def whole_folder(path: str | Path) -> Iterator[Path]:
    """An empty folder that takes its name only when the block ends well, and is gone with all in it when it does not.

    A folder of that name must be empty, or not there.
    """
    path = check_folder(Path(path)).resolve()
    with _unfinished(path, lambda part: shutil.rmtree(part, ignore_errors=True)) as part:
        part.mkdir()
        yield part


@contextmanager
def _unfinished(path: Path, remove: Callable[[Path], object]) -> Iterator[Path]:
    """Where to write what shall be called `path` at the end of the block."""
    part = path.with_name(f".{path.name}.{os.getpid()}.{threading.get_ident()}.part")
    try:
        with on_interrupt(lambda: remove(part)):
            yield part
            if path.is_dir():
                path.rmdir()
            os.replace(part, path)
    except OSError as error:
        reason = error.strerror or error
        raise AnamorphError(f"{path}: cannot be written ({reason}); free space or choose another") from error
    finally:
        remove(part)


def check_folder(path: Path) -> Path:
    """Refuse a name that no new folder could take, before any work is done for it."""
    if path.is_dir() and any(path.iterdir()):
        raise AnamorphError(f"{path}: is there already and holds files; give a new folder")
    check_directory(path)
    return path


def save_text(path: str | Path, text: str) -> None:
    """Write `text` as UTF-8."""
    with whole_file(path) as file:
        file.write(text.encode())


def save_array(path: str | Path, array: np.ndarray) -> None:
    """Write `array` as a `.npy` file."""
    check_output(path, (".npy",))
    with whole_file(path) as file:
        np.save(file, array, allow_pickle=False)


def save_image(path: str | Path, color: np.ndarray, layers: Mapping[str, np.ndarray] | None = None) -> None:
    """Write linear colour (H, W, 3) in the format that the suffix names, one of `IMAGES`.

    `layers` are further buffers of the same size, by their names; only `.exr` has place for them.
    """
    path = check_output(path, IMAGES)
    suffix = path.suffix.lower()
    if layers and suffix != ".exr":
        raise AnamorphError(f"{path}: has no place for {', '.join(layers)}; end the name in .exr")
    if suffix == ".npy":
        save_array(path, color)
        return
    if suffix == ".exr":
        encoded = encode_exr(_finite(color), layers or {})
    elif suffix == ".hdr":
        encoded = encode_radiance(_finite(color))
    else:
        encoded = pixel_bytes(to_pixels(color), suffix)
    with whole_file(path) as file:
        file.write(encoded)


def _finite(color: np.ndarray) -> np.ndarray:
    if not np.isfinite(color).all():
        raise AnamorphError("the image holds values that are not finite; please report the scene that made them")
    return color


def to_pixels(color: np.ndarray) -> np.ndarray:
    """Linear colour (H, W, 3) as 8-bit sRGB pixels (H, W, 3)."""
    return np.round(255.0 * encode_srgb(_finite(color))).astype(np.uint8)


def pixel_bytes(pixels: np.ndarray, suffix: str = ".png") -> bytes:
    """8-bit sRGB pixels (H, W, 3) as the bytes of an image file."""
    jpeg: dict[str, Any] = {"format": "JPEG", "quality": 95, "subsampling": 0}
    webp: dict[str, Any] = {"format": "WEBP", "quality": 95}
    settings = {".png": {"format": "PNG"}, ".jpg": jpeg, ".jpeg": jpeg, ".webp": webp}[suffix.lower()]
    file = io.BytesIO()
    Image.fromarray(pixels).save(file, **settings)
    return file.getvalue()
