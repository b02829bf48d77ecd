"""Files of every kind that is read, broken at random: what the tests and the bench of attacks open."""

from __future__ import annotations

import io
import json
import random
import re
import struct
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from PIL import Image

from anamorph.base.exr import encode_exr
from anamorph.base.radiance import encode_radiance
from anamorph.files.gltf.exporting import save_gltf
from anamorph.gallery import make

EXTREMES = (
    b"1e308",
    b"-1",
    b"nan",
    b"inf",
    b"0",
    b"99999999999999999999",
    b"4294967295",
    b"1e-320",
    b"",
    b"\xff",
    b"-0.0",
)

NUMBER = re.compile(rb"-?\d+(\.\d+)?([eE][-+]?\d+)?")


def image_bytes(kind: str) -> bytes:
    data = io.BytesIO()
    Image.fromarray(np.arange(192, dtype=np.uint8).reshape(8, 8, 3)).save(data, format=kind)
    return data.getvalue()


def whole_files(folder: Path) -> dict[str, bytes]:
    """One good file of each kind, by its name; `folder` is for those that are made by writing."""
    corners = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], "<f4")
    faces = np.array([[0, 1, 2], [0, 2, 3]], "<i4")
    light = np.linspace(0.0, 4.0, 8 * 16 * 3, dtype=np.float32).reshape(8, 16, 3)
    save_gltf(folder / "mirror.glb", make("flat-mirror"))
    ply = (
        "element vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
        "element face 2\nproperty list uchar int vertex_indices\nend_header\n"
    )
    rows = np.zeros(2, [("count", "u1"), ("corners", "<i4", 3)])
    rows["count"], rows["corners"] = 3, faces
    lists = "".join(f"3 {a} {b} {c}\n" for a, b, c in faces)
    points = "".join(f"{x} {y} {z}\n" for x, y, z in corners)
    triangles = np.zeros(2, [("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("more", "<u2")])
    triangles["corners"] = corners[faces]
    binary = corners.tobytes() + faces.astype("<u2").tobytes()
    gltf = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0, "translation": [0, 0, 1], "rotation": [0, 0, 0, 1]}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1, "material": 0, "mode": 4}]}],
        "materials": [{"pbrMetallicRoughness": {"baseColorFactor": [1, 0.5, 0, 1], "metallicFactor": 0}}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "type": "VEC3", "count": 4, "min": [0, 0, 0], "max": [1, 1, 0]},
            {"bufferView": 1, "componentType": 5123, "type": "SCALAR", "count": 6},
        ],
        "bufferViews": [{"buffer": 0, "byteLength": 48}, {"buffer": 0, "byteOffset": 48, "byteLength": 12}],
        "buffers": [{"byteLength": len(binary), "uri": "square.bin"}],
    }
    square = "".join(f"v {x} {y} {z}\nvt {x} {y}\n" for x, y, z in corners)
    square += "vn 0 0 1\nusemtl red\nf 1/1/1 2/2/1 3/3/1 4/4/1\n"
    facet = "facet normal 0 0 1\nouter loop\n{}endloop\nendfacet\n"
    loops = [facet.format("".join("vertex {} {} {}\n".format(*corners[k]) for k in face)) for face in faces]
    return {
        "square.obj": b"mtllib square.mtl\no square\n" + square.encode(),
        "square.mtl": b"newmtl red\nKd 1 0 0\nmap_Kd -s 1 1 1 image.png\n",
        "image.png": image_bytes("PNG"),
        "image.jpg": image_bytes("JPEG"),
        "text.ply": f"ply\nformat ascii 1.0\n{ply}{points}{lists}".encode(),
        "bytes.ply": f"ply\nformat binary_little_endian 1.0\n{ply}".encode() + corners.tobytes() + rows.tobytes(),
        "text.stl": f"solid square\n{''.join(loops)}endsolid square\n".encode(),
        "bytes.stl": bytes(80) + struct.pack("<I", 2) + triangles.tobytes(),
        "square.gltf": json.dumps(gltf).encode(),
        "square.bin": binary,
        "mirror.glb": (folder / "mirror.glb").read_bytes(),
        "light.hdr": encode_radiance(light),
        "light.exr": encode_exr(light, {}),
        "scene.toml": b'builtin = "flat-mirror"\nsize = [64, 48]\nmethod = "raytrace"\n[[model]]\nfile = "text.stl"\n'
        b'scale = 0.1\ntranslate = [0.0, 1.0, 0.5]\n[[light]]\nkind = "point"\n'
        b'position = [0.0, 2.0, 1.0]\n[sky]\nimage = "image.jpg"\n[eye]\nposition = [0.0, 1.0, 3.0]\n'
        b"target = [0.0, 1.0, 0.0]\nfield_of_view = 40.0\n",
    }


OPENED = {
    "square.mtl": "square.obj", "image.png": "square.obj", "image.jpg": "scene.toml", "square.bin": "square.gltf",
    "light.hdr": "hdr.toml", "light.exr": "exr.toml",
}  # fmt: skip
"""What is opened to have another file read."""


def broken_files(count: int, seed: int, folder: Path) -> Iterator[tuple[str, Path]]:
    """Break one file after the other in `folder`: what was broken and how, and the path to open; whole again after."""
    files, choose = whole_files(folder), random.Random(seed)
    for name, light in (("hdr.toml", "light.hdr"), ("exr.toml", "light.exr")):
        (folder / name).write_text(f'builtin = "flat-mirror"\n[sky]\nimage = "{light}"\n')
    for name, data in files.items():
        (folder / name).write_bytes(data)
    names = sorted(files)
    for number in range(count):
        name = names[number % len(names)]
        how, data = broken(files[name], choose)
        (folder / name).write_bytes(data)
        yield f"{number}: {name}, {how}", folder / OPENED.get(name, name)
        (folder / name).write_bytes(files[name])


def broken(data: bytes, choose: random.Random) -> tuple[str, bytes]:
    """One to three faults of some kind in a file, and their names."""
    names = []
    for _ in range(choose.choice((1, 1, 2, 3))):
        at, to = sorted(choose.randrange(len(data) + 1) for _ in range(2))
        found = list(NUMBER.finditer(data))
        kind = choose.choice(("flip", "cut", "repeat", "insert", "end", "number", "number", "number", "swap"))
        if kind == "number" and not found:
            kind = "flip"
        names.append(kind)
        if kind == "flip" and data:
            place = choose.randrange(len(data))
            data = data[:place] + bytes([data[place] ^ 1 << choose.randrange(8)]) + data[place + 1 :]
        elif kind == "cut":
            data = data[:at] + data[min(to, at + 40) :]
        elif kind == "repeat":
            data = data[:at] + data[at:to][:200] * choose.choice((2, 50)) + data[to:]
        elif kind == "insert":
            data = data[:at] + choose.randbytes(choose.choice((1, 4, 30))) + data[at:]
        elif kind == "end":
            data = data[:at]
        elif kind == "number":
            number = choose.choice(found)
            data = data[: number.start()] + choose.choice(EXTREMES) + data[number.end() :]
        elif kind == "swap":
            lines = data.split(b"\n")
            one, other = choose.randrange(len(lines)), choose.randrange(len(lines))
            lines[one], lines[other] = lines[other], lines[one]
            data = b"\n".join(lines)
    return "+".join(names), data
