"""Files that a scene is made of: opening them, and saying in one line what is wrong with one."""

from __future__ import annotations

import io
import os
import stat
from pathlib import Path
from urllib.parse import unquote

import numpy as np
from PIL import Image

from anamorph.base.errors import AnamorphError
from anamorph.base.limits import MOST_BYTES, MOST_PIXELS
from anamorph.scene.model import Texture

FORMATS = ("PNG", "JPEG", "BMP", "GIF", "TGA", "TIFF", "WEBP")
"""What image files may hold, whatever they are called: of other formats some have Pillow start a program."""


def read(path: Path, what: str, most: int = MOST_BYTES) -> bytes:
    """The bytes of a file, or one line that says why not: also where it has more than `most`."""
    try:
        check_file(path, what, most)
        return path.read_bytes()
    except FileNotFoundError:
        raise AnamorphError(f"{path}: there is no such {what}; check the name and the folder") from None
    except IsADirectoryError:
        raise AnamorphError(f"{path}: is a folder; give a {what}") from None
    except OSError as error:
        raise AnamorphError(f"{path}: this {what} cannot be read ({error.strerror}); check its permissions") from None


def check_file(path: Path, what: str, most: int = MOST_BYTES) -> None:
    """Refuse a pipe or a device, which need not end, and a file of more than `most` bytes, before it is read.

    Raises
    ------
    OSError
        There is no such file, or it cannot be looked at.
    AnamorphError
    """
    found = os.stat(path)
    if stat.S_ISDIR(found.st_mode):
        raise IsADirectoryError(path)
    if not stat.S_ISREG(found.st_mode):
        raise AnamorphError(f"{path}: is a pipe or a device; give a {what}")
    if found.st_size > most:
        raise AnamorphError(
            f"{path}: this {what} has {found.st_size / 2**20:.0f} MiB, more than {most / 2**20:.0f}; make it smaller"
        )


def as_utf8(data: bytes) -> bytes:
    """Text in UTF-8, from text in UTF-8, UTF-16 with its byte order mark, or else Latin-1."""
    if data[:2] in (b"\xff\xfe", b"\xfe\xff"):
        return data.decode("utf-16", errors="replace").encode()
    try:
        return data.decode("utf-8-sig").encode()
    except UnicodeDecodeError:
        return data.decode("latin-1").encode()


def to_texture(image: Image.Image, name: str) -> Texture:
    """A texture from an image of any kind; `name` is for messages. Sixteen bits are rounded to eight."""
    try:
        if image.mode.startswith("I") or image.mode == "F":
            levels = np.asarray(image, float)
            grey = np.clip(levels / (257.0 if levels.max(initial=0.0) > 255.0 else 1.0), 0.0, 255.0)
            image = Image.fromarray(np.round(grey).astype(np.uint8))
        return Texture(np.asarray(image.convert("RGBA"), np.uint8))
    except (OSError, ValueError, SyntaxError, Image.DecompressionBombError) as error:
        raise AnamorphError(f"{name}: this image is damaged ({error}); save it again") from None


def read_texture(path: Path) -> Texture:
    """An image file as a texture."""
    if path.suffix.lower() in (".hdr", ".exr"):
        raise AnamorphError(f"{path}: holds linear light, which only the sky takes; save it as PNG or JPEG")
    return decoded(read(path, "image file"), str(path))


def decoded(data: bytes, name: str) -> Texture:
    """The bytes of an image file as a texture; `name` is for messages."""
    return to_texture(_opened(data, name), name)


def _opened(data: bytes, name: str) -> Image.Image:
    try:
        image = Image.open(io.BytesIO(data), formats=FORMATS)
    except Image.DecompressionBombError:
        raise AnamorphError(f"{name}: this image has too many pixels; make it at most 8192 x 8192") from None
    except (OSError, ValueError, SyntaxError):
        raise AnamorphError(f"{name}: is not an image that can be read; save it as PNG or JPEG") from None
    if image.width * image.height > MOST_PIXELS:
        raise AnamorphError(
            f"{name}: this image has {image.width} x {image.height} pixels; make it at most 8192 x 8192, or as many"
        )
    return image


def beside(model: Path, name: str) -> Path:
    """The file that a model names, relative to the model's folder."""
    name = name.strip().strip('"').replace("\\", "/")
    for candidate in (name, unquote(name), Path(name).name):
        path = model.parent / candidate
        if is_file(path):
            return path
    raise AnamorphError(
        f"{model}: names the file '{name:.80}', which is not there; put it beside the model, or remove the name"
    )


def is_file(path: Path) -> bool:
    """Whether there is such a file; of a name that the system does not take, such as a very long one, there is none."""
    try:
        return path.is_file()
    except OSError:
        return False


def texture_beside(model: Path, name: str) -> Texture:
    """The image file that a model names, as a texture."""
    return read_texture(beside(model, name))
