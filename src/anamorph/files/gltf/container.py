"""What a glTF or GLB file consists of: its header, and the bytes that its header names.

Format: glTF 2.0 specification, sections 3.6 (buffers and views) and 4 (the GLB container).
"""

from __future__ import annotations

import base64
import binascii
import json
import struct
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NoReturn
from urllib.parse import unquote_to_bytes

from anamorph.base.errors import AnamorphError
from anamorph.files.reading import beside, read

UNDERSTOOD = (
    "KHR_materials_",
    "KHR_texture_transform",
    "KHR_lights_punctual",
    "KHR_mesh_quantization",
    "KHR_node_visibility",
    "EXT_texture_webp",
)
"""Extensions that a file may require."""


@dataclass(frozen=True, eq=False)
class Container:
    """A glTF file: its `header`, and of a GLB file the `chunk` of bytes after it."""

    path: Path
    header: dict[str, Any]
    chunk: bytes | None
    _buffers: dict[int, bytes] = field(default_factory=dict)

    def wrong(self, what: str) -> NoReturn:
        """Raise an error that names the file."""
        raise AnamorphError(f"{self.path}: {what}; export it again")

    def entry(self, kind: str, number: object) -> dict[str, Any]:
        """One of the header's `kind`, as "accessors", by its number."""
        entries = self.header.get(kind, [])
        if not isinstance(entries, list) or type(number) is not int or not 0 <= number < len(entries):
            self.wrong(f"its glTF header is damaged (it names {number} of {kind}, which is not there)")
        if not isinstance(entries[number], dict):
            self.wrong(f"its glTF header is damaged ({number} of {kind} is no object)")
        return entries[number]

    def whole(self, entry: dict[str, Any], key: str, where: str, default: int | None = None) -> int:
        """A whole number that is not negative."""
        value = entry.get(key, default)
        if type(value) is not int or value < 0:
            self.wrong(f"{where}: {key} is {value!r:.60}, and must be a whole number from 0")
        return value

    def view(self, number: object) -> memoryview:
        """The bytes of a buffer view."""
        entry, where = self.entry("bufferViews", number), f"buffer view {number}"
        start, length = self.whole(entry, "byteOffset", where, 0), self.whole(entry, "byteLength", where)
        data = self._buffer(entry.get("buffer"))
        if start + length > len(data):
            self.wrong(f"{where}: ends at byte {start + length} of a buffer that has {len(data)}")
        return memoryview(data)[start : start + length]

    def named(self, uri: object, where: str) -> bytes:
        """The bytes that a URI names: those in it, or those of a file beside this one."""
        if not isinstance(uri, str):
            self.wrong(f"{where}: its uri is no text")
        if uri.startswith("data:"):
            head, _, data = uri.partition(",")
            try:
                return base64.b64decode(data, validate=True) if head.endswith(";base64") else unquote_to_bytes(data)
            except (binascii.Error, ValueError):
                self.wrong(f"{where}: its base64 data is damaged")
        return read(beside(self.path, uri), "file")

    def _buffer(self, number: object) -> bytes:
        entry = self.entry("buffers", number)
        assert isinstance(number, int)
        if number not in self._buffers:
            where = f"buffer {number}"
            if "uri" not in entry and (self.chunk is None or number):
                self.wrong(f"{where}: has neither a uri nor bytes in this file")
            data = self.named(entry["uri"], where) if "uri" in entry else self.chunk or b""
            length = self.whole(entry, "byteLength", where)
            if len(data) < length:
                self.wrong(f"{where}: has {len(data)} bytes, and its header says {length}")
            self._buffers[number] = data
        return self._buffers[number]


def extension(entry: dict[str, Any], name: str) -> dict[str, Any]:
    """What an extension adds to an entry of the header; empty where it adds nothing."""
    return entry.get("extensions", {}).get(name, {})


def opened(data: bytes, path: Path) -> Container:
    """Take the bytes of a glTF or GLB file apart; `path` tells the kind, and where the files lie that it names."""
    chunk = None
    try:
        if path.suffix.lower() == ".glb":
            magic, _, total, length, kind = struct.unpack("<4sIII4s", data[:20])
            if magic != b"glTF" or kind != b"JSON":
                raise ValueError("no GLB header")
            if total > len(data):
                raise ValueError(f"cut off after {len(data)} of {total} bytes")
            data, rest = data[20 : 20 + length], data[20 + length : total]
            chunk = _chunk(rest)
        header = json.loads(data.decode("utf-8-sig"))
        if not isinstance(header, dict) or not str(header["asset"]["version"]).startswith("2"):
            raise ValueError("another version than 2")
    except (ValueError, struct.error, KeyError, TypeError, RecursionError) as error:
        raise AnamorphError(f"{path}: is damaged or not glTF 2.0 ({error}); export it again") from None
    container = Container(path, header, chunk)
    for name in header.get("extensionsRequired", []):
        if not str(name).startswith(UNDERSTOOD):
            remedy = "without compression" if "compression" in str(name) else "without it"
            raise AnamorphError(f"{path}: needs the glTF extension {name}; export it again {remedy}")
    return container


def _chunk(rest: bytes) -> bytes | None:
    """The chunk of bytes that may follow the header of a GLB file."""
    if not rest:
        return None
    length, kind = struct.unpack("<I4s", rest[:8])
    if kind != b"BIN\0" or length > len(rest) - 8:
        raise ValueError("its binary chunk is cut off")
    return rest[8 : 8 + length]
