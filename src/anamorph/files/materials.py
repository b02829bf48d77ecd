"""What the parts of a model file look like: material, texture coordinates and vertex colours.

The bytes of colours in PLY, STL and OBJ files, and Kd in an MTL file, are what the programs that wrote them put on a
screen unchanged, so they are taken as sRGB. Alpha is ignored: everything is opaque. (What glTF files look like is told
by `files/gltf`.)
"""

from __future__ import annotations

from typing import Any

import numpy as np

from anamorph.base.srgb import decode_srgb
from anamorph.files.reading import to_texture
from anamorph.scene.model import WHITE, Color, Diffuse, Texture


def appearance(
    where: str, geometry: Any, textures: dict[int, Texture]
) -> tuple[Diffuse, str, np.ndarray | None, np.ndarray | None]:
    """What a trimesh geometry looks like; `textures` remembers images that several parts share.

    Returns
    -------
    material : Diffuse
    name : str
        The material's name in the file, "" for none.
    texcoords : (V, 2) float64 or None
        From the top left.
    colors : (V, 3) float64 or None
        Linear; (3 F, 3), for the faces' corners in turn, where the file colours faces.
    """
    visual = geometry.visual
    if visual.kind in ("vertex", "face"):
        encoded = visual.vertex_colors if visual.kind == "vertex" else np.repeat(visual.face_colors, 3, axis=0)
        return Diffuse(WHITE), "", None, decode_srgb(np.asarray(encoded)[:, :3] / 255.0)
    if visual.kind != "texture":
        return Diffuse(), "", None, None

    texcoords: np.ndarray | None = None
    if visual.uv is not None:
        texcoords = np.asarray(visual.uv, float)[:, :2] * (1.0, -1.0) + (0.0, 1.0)
    image, color, name = _simple(visual.material)
    if image is None or texcoords is None or not np.isfinite(texcoords).all():
        return Diffuse(color), name, None, None
    if id(image) not in textures:
        textures[id(image)] = to_texture(image, f"{where}: material '{name}'")
    return Diffuse(color, textures[id(image)]), name, texcoords, None


def _simple(material: Any) -> tuple[Any, Color, str]:
    """Image, linear colour and name of a material of an OBJ or PLY file."""
    image = getattr(material, "image", None)
    # Where the file names no image, trimesh puts a grey one of its own, which has no file format.
    image = None if getattr(image, "format", None) is None else image
    # What trimesh calls a material that has no name.
    name = "" if material.name == "material_0" else str(material.name)
    shade = np.asarray(getattr(material, "kwargs", {}).get("kd", ()), float)
    if shade.shape != (3,) or not np.isfinite(shade).all():
        return image, WHITE if image else Diffuse().color, name
    red, green, blue = decode_srgb(np.clip(shade, 0.0, 1.0))
    return image, (float(red), float(green), float(blue)), name
