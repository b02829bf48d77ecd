"""What a PLY file consists of: its header, and the numbers of its elements.

The format is Greg Turk's of 1994, as text and as binary of either order of bytes.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from pathlib import Path
from typing import NoReturn

import numpy as np

from anamorph.base.compiled import compiled
from anamorph.base.errors import AnamorphError, nearest
from anamorph.files.reading import as_utf8

TYPES = {
    "char": "i1", "uchar": "u1", "short": "i2", "ushort": "u2", "int": "i4", "uint": "u4", "float": "f4",
    "double": "f8", "int8": "i1", "uint8": "u1", "int16": "i2", "uint16": "u2", "int32": "i4", "uint32": "u4",
    "float32": "f4", "float64": "f8", "int64": "i8", "uint64": "u8", "float16": "f2",
}  # fmt: skip
FORMATS = {"ascii": "", "binary_little_endian": "<", "binary_big_endian": ">"}


@dataclass(frozen=True, eq=False)
class PlyLists:
    """A list for each entry of an element: all `values` in one array, and how many each entry has."""

    values: np.ndarray
    counts: np.ndarray


@dataclass(frozen=True, eq=False)
class Property:
    """A property as the header declares it; `counted` is the type of a list's length, None for a single number."""

    name: str
    dtype: np.dtype
    counted: np.dtype | None


@dataclass(frozen=True, eq=False)
class Element:
    """An element of a PLY file: how often it stands there, and its numbers by the names of its properties."""

    name: str
    count: int
    properties: list[Property] = field(default_factory=list)
    numbers: dict[str, np.ndarray] = field(default_factory=dict)
    lists: dict[str, PlyLists] = field(default_factory=dict)


@dataclass(frozen=True, eq=False)
class Ply:
    """A PLY file: its elements by their names, and the images that comments name."""

    elements: dict[str, Element]
    images: list[str]


def read_ply(data: bytes, path: Path) -> Ply:
    """Take the bytes of a PLY file apart; `path` is for messages."""
    end = re.search(rb"(?:^|[\r\n])end_header[^\S\n]*\n?", data)
    if not data.startswith(b"ply") or end is None:
        _damaged(path, "it has no header from 'ply' to 'end_header'")
    order, elements, images = _header(as_utf8(data[: end.start()]).decode(), path)
    try:
        if order:
            _read_binary(data, end.end(), elements)
        else:
            _read_text(data[end.end() :].split(), elements)
    except (ValueError, IndexError, OverflowError) as error:
        _damaged(path, str(error))
    return Ply({element.name: element for element in elements}, images)


def _damaged(path: Path, why: str) -> NoReturn:
    raise AnamorphError(f"{path}: is damaged or no PLY file ({why}); export it again")


def _header(text: str, path: Path) -> tuple[str, list[Element], list[str]]:
    """The order of bytes ("" for text), the elements without their numbers, and the names of images."""
    order, elements, images = None, list[Element](), list[str]()
    for line in text.splitlines()[1:]:
        words = line.split()
        match words:
            case ["format", name, *_] if name in FORMATS:
                order = FORMATS[name]
            case ["comment", key, _, *_] if key.lower() == "texturefile":
                images.append(line.split(maxsplit=2)[2].strip())
            case ["element", name, count] if count.isascii() and count.isdigit() and len(count) < 16:
                elements.append(Element(name, int(count)))
            case ["property", "list", counted, kind, name] if elements and order is not None:
                types = (np.dtype(order + _type(word, path)) for word in (kind, counted))
                elements[-1].properties.append(Property(name, *types))
            case ["property", kind, name] if elements and order is not None:
                elements[-1].properties.append(Property(name, np.dtype(order + _type(kind, path)), None))
            # Comments, and lines of their own that programs add.
            case ["format" | "element" | "property", *_]:
                _damaged(path, f"its header says '{line.strip()[:60]}'")
    if order is None:
        _damaged(path, "its header names no format")
    return order, elements, images


def _type(word: str, path: Path) -> str:
    return TYPES.get(word) or _damaged(path, f"its header names the type '{word[:20]}'{nearest(word, TYPES)}")


def _short(element: Element) -> NoReturn:
    raise ValueError(f"it ends among its {element.count} entries of '{element.name}'")


def _read_text(words: list[bytes], elements: list[Element]) -> None:
    at = 0
    for element in elements:
        found: list[list[bytes]] = [[] for _ in element.properties]
        counts: list[list[int]] = [[] for _ in element.properties]
        if all(one.counted is None for one in element.properties):
            width, end = len(element.properties), at + element.count * len(element.properties)
            found = [words[at + number : end : width] for number in range(width)]
            at = end
        else:
            for _ in range(element.count):
                for number, one in enumerate(element.properties):
                    length = 1
                    if one.counted is not None:
                        length = _length(int(words[at]), element)
                        counts[number].append(length)
                        at += 1
                    found[number] += words[at : at + length]
                    at += length
        if at > len(words):
            _short(element)
        for one, values, lengths in zip(element.properties, found, counts, strict=True):
            # Numbers in a text keep the digits that its own type of float would not.
            numbers = np.array(list(map(float, values)))
            if one.dtype.kind != "f":
                numbers = _whole(numbers, one, element)
            _keep(element, one, numbers, np.array(lengths, int))


def _whole(numbers: np.ndarray, one: Property, element: Element) -> np.ndarray:
    """Numbers as the integers that a header says they are."""
    limits = np.iinfo(one.dtype)
    wrong = ~((numbers >= limits.min) & (numbers <= limits.max))
    if wrong.any():
        raise ValueError(f"'{one.name}' of '{element.name}' has the number {numbers[wrong][0]:g}, which does not fit")
    return numbers.astype(one.dtype)


def _read_binary(data: bytes, at: int, elements: list[Element]) -> None:
    content = np.frombuffer(data, np.uint8)
    for element in elements:
        properties = element.properties
        sizes = np.array([one.dtype.itemsize for one in properties], np.int64)
        counted = np.array([one.counted.itemsize if one.counted is not None else 0 for one in properties], np.int64)
        # Every entry has a byte at least, so that a count in the header makes no arrays that the file cannot fill.
        if element.count * int(np.where(counted > 0, counted, sizes).sum()) > len(data) - at:
            _short(element)
        starts, lengths = np.zeros((2, element.count, len(properties)), np.int64)
        big = any(one.dtype.byteorder == ">" for one in properties)
        at = find_entries(content, at, sizes, counted, big, starts, lengths)
        if at < 0:
            _short(element)
        for number, one in enumerate(properties):
            own = np.ascontiguousarray(lengths[:, number])
            values = np.zeros(int(own.sum()) * int(sizes[number]), np.uint8)
            copy_entries(content, np.ascontiguousarray(starts[:, number]), own * sizes[number], values)
            _keep(element, one, values.view(one.dtype), own)


def _keep(element: Element, one: Property, values: np.ndarray, counts: np.ndarray) -> None:
    """Note what has been read of a property."""
    if one.counted is None:
        element.numbers[one.name] = values
    else:
        element.lists[one.name] = PlyLists(values, counts)


def _length(length: int, element: Element) -> int:
    if length < 0:
        raise ValueError(f"a list of '{element.name}' has {length} entries")
    return length


@compiled
def find_entries(
    data: np.ndarray,
    at: int,
    sizes: np.ndarray,
    counted: np.ndarray,
    big: bool,
    starts: np.ndarray,
    lengths: np.ndarray,
) -> int:
    """Note where each entry (row) has each property (column), and of how many numbers; -1 where the data end before.

    `sizes` are those of a property's numbers in bytes, and `counted` those of its length, 0 for what is no list.
    """
    for row in range(starts.shape[0]):
        for column in range(starts.shape[1]):
            length, width = np.int64(1), counted[column]
            if width > 0:
                if at + width > data.size:
                    return -1
                length = np.int64(0)
                for byte in range(width):
                    place = at + byte if big else at + width - 1 - byte
                    length = 256 * length + np.int64(data[place])
                at += width
            if length < 0 or length > (data.size - at) // sizes[column]:
                return -1
            starts[row, column], lengths[row, column] = at, length
            at += length * sizes[column]
    return at


@compiled
def copy_entries(data: np.ndarray, starts: np.ndarray, sizes: np.ndarray, copied: np.ndarray) -> None:
    """Put runs of bytes behind one another."""
    at = 0
    for row in range(starts.size):
        for byte in range(sizes[row]):
            copied[at] = data[starts[row] + byte]
            at += 1
