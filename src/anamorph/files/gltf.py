"""The header of a glTF file: what trimesh leaves out of materials and names.

Format: glTF 2.0 specification, sections 3 (concepts), 4 (GLB container), and KHR_texture_transform.
"""

from __future__ import annotations

import json
import struct
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from anamorph.base.errors import AnamorphError
from anamorph.scene.model import Color

UNDERSTOOD = ("KHR_materials_", "KHR_texture_transform", "KHR_lights_punctual", "EXT_texture_webp")
"""Extensions that a file may require; of materials, only the base colour matters here."""


@dataclass(frozen=True, eq=False)
class GltfMaterial:
    """The base colour of a material: linear `color`, and (3, 3) `transform` of texture coordinates."""

    name: str
    color: Color
    textured: bool
    transform: np.ndarray


@dataclass(frozen=True, eq=False)
class Gltf:
    """A glTF file for trimesh, in which materials and nodes are called by their number.

    trimesh keeps of each only the name, and a name may be missing or stand twice; `materials` and `nodes` hold
    what the numbers stand for.
    """

    data: bytes
    materials: tuple[GltfMaterial, ...]
    nodes: tuple[str, ...]


def read_gltf(data: bytes, path: Path) -> Gltf:
    """Take the header of a glTF or GLB file apart; `path` tells the kind, and is for messages."""
    glb = path.suffix.lower() == ".glb"
    header, rest = _split(data, path, glb)
    try:
        _refuse_unknown_extensions(header, path)
        _give_default_material(header)
        materials = tuple(_material(entry) for entry in header.get("materials", []))
        nodes = tuple(_node_name(header, node) for node in header.get("nodes", []))
        _choose_texture_coordinates(header)
        for kind in ("materials", "nodes"):
            for number, entry in enumerate(header.get(kind, [])):
                entry["name"] = str(number)
    except AnamorphError:
        raise
    except (AttributeError, IndexError, KeyError, TypeError, ValueError) as error:
        raise AnamorphError(f"{path}: its glTF header is damaged ({error!r}); export it again") from None
    return Gltf(_joined(header, rest, glb), materials, nodes)


def _split(data: bytes, path: Path, glb: bool) -> tuple[dict[str, Any], bytes]:
    try:
        rest = b""
        if glb:
            magic, _, total, length, kind = struct.unpack("<4sIII4s", data[:20])
            if magic != b"glTF" or kind != b"JSON":
                raise ValueError("no GLB header")
            if total > len(data):
                raise ValueError(f"cut off after {len(data)} of {total} bytes")
            data, rest = data[20 : 20 + length], data[20 + length : total]
        header = json.loads(data.decode("utf-8-sig"))
        if not isinstance(header, dict) or not str(header["asset"]["version"]).startswith("2"):
            raise ValueError("another version than 2")
    except (ValueError, struct.error, KeyError, TypeError, RecursionError) as error:
        raise AnamorphError(f"{path}: is damaged or not glTF 2.0 ({error}); export it again") from None
    return header, rest


def _joined(header: dict[str, Any], rest: bytes, glb: bool) -> bytes:
    text = json.dumps(header).encode()
    if not glb:
        return text
    text += b" " * (-len(text) % 4)
    return struct.pack("<4sIII4s", b"glTF", 2, 20 + len(text) + len(rest), len(text), b"JSON") + text + rest


def _refuse_unknown_extensions(header: dict[str, Any], path: Path) -> None:
    for name in header.get("extensionsRequired", []):
        if not name.startswith(UNDERSTOOD):
            remedy = "without compression" if "compression" in name else "without it"
            raise AnamorphError(f"{path}: needs the glTF extension {name}; export it again {remedy}")


def _base_color(material: dict[str, Any]) -> tuple[list[float], dict[str, Any] | None]:
    glossy = material.get("extensions", {}).get("KHR_materials_pbrSpecularGlossiness")
    if glossy is not None:
        return glossy.get("diffuseFactor", [1.0, 1.0, 1.0]), glossy.get("diffuseTexture")
    metallic = material.get("pbrMetallicRoughness", {})
    return metallic.get("baseColorFactor", [1.0, 1.0, 1.0]), metallic.get("baseColorTexture")


def _material(material: dict[str, Any]) -> GltfMaterial:
    color, texture = _base_color(material)
    red, green, blue = (float(value) for value in color[:3])
    extension = (texture or {}).get("extensions", {}).get("KHR_texture_transform", {})
    return GltfMaterial(
        name=str(material.get("name", "")),
        color=(red, green, blue),
        textured=texture is not None,
        transform=_texture_transform(extension),
    )


def _texture_transform(extension: dict[str, Any]) -> np.ndarray:
    """Translation times rotation times scale, on (u, v, 1) from the top left."""
    (x, y), (scale_x, scale_y) = extension.get("offset", [0, 0]), extension.get("scale", [1, 1])
    cosine, sine = np.cos(extension.get("rotation", 0.0)), np.sin(extension.get("rotation", 0.0))
    return np.array([[cosine * scale_x, sine * scale_y, x], [-sine * scale_x, cosine * scale_y, y], [0, 0, 1]])


def _node_name(header: dict[str, Any], node: dict[str, Any]) -> str:
    if "mesh" in node:
        return str(node.get("name") or header["meshes"][node["mesh"]].get("name") or "part")
    return str(node.get("name") or "part")


def _give_default_material(header: dict[str, Any]) -> None:
    """Name the white default material outright: trimesh reads vertex colours rightly only beside a material."""
    header["materials"] = [*header.get("materials", []), {}]
    for mesh in header.get("meshes", []):
        for primitive in mesh["primitives"]:
            primitive.setdefault("material", len(header["materials"]) - 1)


def _choose_texture_coordinates(header: dict[str, Any]) -> None:
    """Make the set of coordinates that the base colour uses the first, the only one that trimesh reads."""
    for mesh in header.get("meshes", []):
        for primitive in mesh["primitives"]:
            _, texture = _base_color(header["materials"][primitive["material"]])
            transform = (texture or {}).get("extensions", {}).get("KHR_texture_transform", {})
            chosen = transform.get("texCoord", (texture or {}).get("texCoord", 0))
            if chosen:
                primitive["attributes"]["TEXCOORD_0"] = primitive["attributes"][f"TEXCOORD_{chosen}"]
