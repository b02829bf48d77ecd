"""STL files, binary and text, with the colours that some programs hide in them.

The format is 3D Systems' of 1989. Colours are those of VisCAM and SolidView, which mark a triangle's own by a bit, and
of Materialise Magics, which names one for the whole in the header and marks the triangles that keep to it.
"""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from anamorph.base.errors import AnamorphError
from anamorph.base.notes import note
from anamorph.files.materials import linear_colors, plain
from anamorph.files.model_shape import ModelShape
from anamorph.files.reading import as_utf8
from anamorph.scene.model import Diffuse

TRIANGLE = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("color", "<u2")])
HEADER = 84
SOLID = re.compile(r"^[^\S\n]*solid\b[^\S\n]*([^\n]*)$", re.IGNORECASE | re.MULTILINE)
CORNER = re.compile(r"\bvertex\s+(\S+)\s+(\S+)\s+(\S+)", re.IGNORECASE)


def stl_shapes(data: bytes, path: Path) -> list[ModelShape]:
    """The solids of an STL file: one of a binary file, any number of a text file."""
    count = int.from_bytes(data[80:HEADER], "little") if len(data) >= HEADER else 0
    # Text has letters where the count stands, which make it greater than any file. What begins with "solid" may be
    # either, and only a text goes on with the words of one.
    whole = 0 < count <= (len(data) - HEADER) // TRIANGLE.itemsize
    text = "" if whole else as_utf8(data).decode()
    if SOLID.match(text.lstrip()) and (CORNER.search(text) or "endsolid" in text.lower()):
        return _text_shapes(text.lstrip(), path)
    if len(data) >= HEADER and not count:
        return []
    if not whole:
        fits = max(len(data) - HEADER, 0) // TRIANGLE.itemsize
        raise AnamorphError(
            f"{path}: is damaged or no STL file (it has room for {fits} of {count} triangles); export it again"
        )
    left = len(data) - HEADER - count * TRIANGLE.itemsize
    if left:
        note(f"{path}: has {left} bytes after its last triangle, which are left out")
    triangles = np.frombuffer(data, TRIANGLE, count, HEADER)
    colors = _colors(data[:80], triangles["color"])
    return [_shape(path.stem, triangles["corners"].reshape(-1, 3), colors)]


def _shape(name: str, corners: np.ndarray, colors: np.ndarray | None = None) -> ModelShape:
    return ModelShape(
        name=name,
        positions=corners.astype(float),
        faces=np.arange(len(corners)).reshape(-1, 3),
        normals=None,
        matrix=np.eye(4),
        material=plain(colors is not None),
        material_name="",
        texcoords=None,
        colors=None if colors is None else np.repeat(colors, 3, axis=0),
    )


def _colors(header: bytes, words: np.ndarray) -> np.ndarray | None:
    """The colour of each triangle, linear; None where the file has none."""
    fields = np.stack([words >> 10, words >> 5, words], axis=1) & 31
    marked = words >> 15 == 1
    _, named, rest = header.partition(b"COLOR=")
    if named and len(rest) >= 3:
        # Magics writes red into the low bits, and marks what keeps to the colour of the whole.
        own, whole, fields = ~marked, linear_colors(np.frombuffer(rest[:3], np.uint8)), fields[:, ::-1]
    elif marked.any():
        own, whole = marked, np.array(Diffuse().color)
    else:
        return None
    return np.where(own[:, None], linear_colors(fields / 31.0), whole)


def _text_shapes(text: str, path: Path) -> list[ModelShape]:
    starts = list(SOLID.finditer(text))
    ends = [start.start() for start in starts[1:]] + [len(text)]
    shapes = []
    for start, end in zip(starts, ends, strict=True):
        numbers = CORNER.findall(text, start.end(), end)
        try:
            corners = np.array(numbers, float).reshape(-1, 3)
        except ValueError as error:
            raise AnamorphError(f"{path}: is damaged or no STL file ({error}); export it again") from None
        if len(corners) % 3:
            raise AnamorphError(
                f"{path}: is damaged or no STL file (a triangle has not three corners); export it again"
            )
        if len(corners):
            shapes.append(_shape((len(starts) > 1 and start[1].strip()) or path.stem, corners))
    return shapes
