"""A scene as a .glb file, for programs that know nothing of this one.

Format: glTF 2.0 specification, KHR_lights_punctual, and KHR_materials_transmission, _ior, _volume and _dispersion.
"""

from __future__ import annotations

import io
import json
import struct
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image

from anamorph.base.output import check_output, whole_file
from anamorph.base.versions import versions
from anamorph.files.gltf.gltf_materials import WRAPS
from anamorph.scene.camera import Camera
from anamorph.scene.model import AmbientLight, Color, Diffuse, DirectionalLight, Glass, Mesh, PointLight, Scene, Texture
from anamorph.scene.pose import WORLD_UP, upright_axes

SUFFIXES = (".glb",)

ARRAY_BUFFER, ELEMENT_ARRAY_BUFFER = 34962, 34963
"""What the bytes of vertices and of indices are bound as."""

FLOAT, UNSIGNED_INT = 5126, 5125
TYPES = {1: "SCALAR", 2: "VEC2", 3: "VEC3"}
CODES = {wrap: code for code, wrap in WRAPS.items()}


def save_gltf(path: str | Path, scene: Scene) -> None:
    """Write a scene's meshes, materials, lights that are not ambient, and camera as a .glb file.

    Mirrors become polished metals whose base colour is tint times reflectance, and glass becomes a transmitting volume
    of its index. glTF has no place for exact surfaces, the sky, ambient light, the backs of mirrors, and colours above
    1, which are cut off there.

    Raises
    ------
    AnamorphError
        Another suffix, or a path that cannot be written.
    """
    path = check_output(path, SUFFIXES)
    file = _File()
    for mesh in scene.meshes:
        file.add("nodes", {"name": mesh.name, **_placed_mesh(file, mesh)})
    for light in scene.lights:
        if not isinstance(light, AmbientLight):
            file.add("nodes", _light(file, light))
    file.add("nodes", _camera(file, scene.camera))
    with whole_file(path) as target:
        target.write(file.encoded(scene.name))


@dataclass(frozen=True, eq=False)
class _File:
    """The entries of a header by their kinds, the bytes after it, and the numbers of what is there already."""

    header: dict[str, list[dict[str, Any]]] = field(default_factory=dict)
    data: bytearray = field(default_factory=bytearray)
    lights: list[dict[str, Any]] = field(default_factory=list)
    extensions: set[str] = field(default_factory=set)
    _known: dict[tuple[str, int], int] = field(default_factory=dict)

    def add(self, kind: str, entry: dict[str, Any]) -> int:
        """The number of a new entry."""
        entries = self.header.setdefault(kind, [])
        entries.append(entry)
        return len(entries) - 1

    def once(self, kind: str, of: object, entry: Callable[[], dict[str, Any]]) -> int:
        """The number of the entry that stands for `of`, which is made when it is first asked for."""
        if (kind, id(of)) not in self._known:
            self._known[kind, id(of)] = self.add(kind, entry())
        return self._known[kind, id(of)]

    def view(self, data: bytes, target: int | None = None) -> int:
        """The number of a buffer view of these bytes."""
        entry = {"buffer": 0, "byteOffset": len(self.data), "byteLength": len(data)}
        self.data.extend(data + bytes(-len(data) % 4))
        return self.add("bufferViews", entry if target is None else {**entry, "target": target})

    def array(self, values: np.ndarray, target: int = ARRAY_BUFFER) -> int:
        """The number of an accessor of an array, (N,) or (N, width): float32, or uint32."""
        component = FLOAT if values.dtype == np.float32 else UNSIGNED_INT
        rows = np.ascontiguousarray(values).reshape(len(values), -1)
        limits = {"min": rows.min(axis=0).tolist(), "max": rows.max(axis=0).tolist()}
        view, kind = self.view(rows.astype(rows.dtype.newbyteorder("<")).tobytes(), target), TYPES[rows.shape[1]]
        entry = {"bufferView": view, "componentType": component, "count": len(rows), "type": kind, **limits}
        return self.add("accessors", entry)

    def extended(self, name: str, values: dict[str, Any]) -> dict[str, Any]:
        """The entry of an extension, which the file says that it uses."""
        self.extensions.add(name)
        return {name: values}

    def encoded(self, name: str) -> bytes:
        """The bytes of the file: a header of all that was added, in one scene, and the data."""
        header: dict[str, Any] = {
            "asset": {"version": "2.0", "generator": f"anamorph {versions()['anamorph']}"},
            "scene": 0,
            "scenes": [{"name": name, "nodes": list(range(len(self.header["nodes"])))}],
            **self.header,
            "buffers": [{"byteLength": len(self.data)}],
        }
        if self.lights:
            header["extensions"] = self.extended("KHR_lights_punctual", {"lights": self.lights})
        if self.extensions:
            header["extensionsUsed"] = sorted(self.extensions)
        text = json.dumps(header, separators=(",", ":")).encode()
        text += b" " * (-len(text) % 4)
        chunks = struct.pack("<I4s", len(text), b"JSON") + text
        chunks += struct.pack("<I4s", len(self.data), b"BIN\0") + bytes(self.data)
        return struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks


def _placed_mesh(file: _File, mesh: Mesh) -> dict[str, Any]:
    """The mesh and the place of a node; a mesh that float32 would blur is written about its middle."""
    positions, middle = np.asarray(mesh.positions), np.zeros(3)
    if (positions != positions.astype(np.float32)).any():
        middle = (positions.min(axis=0) + positions.max(axis=0)) / 2.0
    attributes = {"POSITION": file.array((positions - middle).astype(np.float32))}
    for name, values in (("NORMAL", mesh.normals), ("TEXCOORD_0", mesh.texcoords), ("COLOR_0", mesh.colors)):
        if values is not None:
            attributes[name] = file.array(values.astype(np.float32))
    indices = file.array(mesh.faces.astype(np.uint32).ravel(), ELEMENT_ARRAY_BUFFER)
    material = file.once("materials", mesh.material, lambda: _material(file, mesh))
    primitive = {"attributes": attributes, "indices": indices, "material": material}
    number = file.add("meshes", {"name": mesh.name, "primitives": [primitive]})
    return {"mesh": number, **({"translation": middle.tolist()} if middle.any() else {})}


def _material(file: _File, mesh: Mesh) -> dict[str, Any]:
    match mesh.material:
        case Diffuse(color=color, texture=texture):
            shine = _shine(color, metal=0.0, roughness=1.0)
            if texture is not None:
                image = texture
                shine["baseColorTexture"] = {"index": file.once("textures", image, lambda: _texture(file, image))}
            return {"pbrMetallicRoughness": shine, "doubleSided": True}
        case Glass(tint=tint, index=index, abbe=abbe):
            thickness = float(np.ptp(np.asarray(mesh.positions, float), axis=0).min())
            extensions = {
                **file.extended("KHR_materials_transmission", {"transmissionFactor": 1.0}),
                **file.extended("KHR_materials_ior", {"ior": max(index, 1.0)}),
                **file.extended("KHR_materials_volume", {"thicknessFactor": max(thickness, 1e-6)}),
            }
            if abbe is not None:
                extensions |= file.extended("KHR_materials_dispersion", {"dispersion": 20.0 / abbe})
            return {"pbrMetallicRoughness": _shine(tint, metal=0.0, roughness=0.0), "extensions": extensions}
        case mirror:
            red, green, blue = (mirror.reflectance * channel for channel in mirror.tint)
            return {"pbrMetallicRoughness": _shine((red, green, blue), metal=1.0, roughness=0.0)}


def _shine(color: Color, metal: float, roughness: float) -> dict[str, Any]:
    factor = [min(float(channel), 1.0) for channel in color]
    return {"baseColorFactor": [*factor, 1.0], "metallicFactor": metal, "roughnessFactor": roughness}


def _texture(file: _File, texture: Texture) -> dict[str, Any]:
    encoded = io.BytesIO()
    Image.fromarray(np.ascontiguousarray(texture.pixels[..., :3])).save(encoded, "PNG")
    image = file.add("images", {"bufferView": file.view(encoded.getvalue()), "mimeType": "image/png"})
    across, down = (CODES[wrap] for wrap in texture.wraps)
    return {"source": image, "sampler": file.add("samplers", {"wrapS": across, "wrapT": down})}


def _light(file: _File, light: DirectionalLight | PointLight) -> dict[str, Any]:
    """A light's node. Its colour is irradiance over pi here, and irradiance, or intensity, in glTF."""
    most = max(light.color)
    color = [float(channel) / most for channel in light.color] if most else [0.0, 0.0, 0.0]
    point = isinstance(light, PointLight)
    kind = "point" if point else "directional"
    file.lights.append({"type": kind, "color": color, "intensity": float(np.pi * most)})
    node = {"name": kind, "extensions": {"KHR_lights_punctual": {"light": len(file.lights) - 1}}}
    if isinstance(light, PointLight):
        return {**node, "translation": [float(value) for value in light.position]}
    # It shines along -z of its node.
    toward = np.asarray(light.toward, float)
    return {**node, "matrix": _columns(upright_axes(toward / np.linalg.norm(toward), WORLD_UP), np.zeros(3))}


def _camera(file: _File, camera: Camera) -> dict[str, Any]:
    """A camera's node; cameras look along -z."""
    right, up, forward = camera.axes()
    lens = {"yfov": float(np.radians(camera.field_of_view)), "znear": 1e-3}
    number = file.add("cameras", {"type": "perspective", "perspective": lens})
    position = np.asarray(camera.position, float)
    return {"name": "eye", "camera": number, "matrix": _columns(np.stack([right, up, -forward]), position)}


def _columns(axes: np.ndarray, place: np.ndarray) -> list[float]:
    """A matrix whose columns are `axes` (3, 3), one a row, and a place, column by column."""
    return np.block([[axes, np.zeros((3, 1))], [place, 1.0]]).ravel().tolist()
