"""The materials of a glTF file as this package's: diffuse ones, and mirrors and glass where they come near it.

Format: glTF 2.0 specification, section 3.9 (materials) and 3.8 (textures), KHR_texture_transform, and
KHR_materials_transmission, _ior, _volume, _dispersion and _pbrSpecularGlossiness.
"""

from __future__ import annotations

from collections import defaultdict
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from anamorph.base.notes import note
from anamorph.files.gltf.container import Container, extension
from anamorph.files.reading import decoded
from anamorph.scene.model import Color, Diffuse, Glass, Material, Mirror, Texture

POLISHED = 0.3
"""The roughness up to which a metal is drawn as a mirror."""

HALF = 0.5
"""The share from which a material counts as metal, or as letting light through."""

GLOSSY = "KHR_materials_pbrSpecularGlossiness"

WRAPS = {10497: "repeat", 33071: "clamp", 33648: "mirror"}
"""How samplers say what lies beyond an image's edges."""


@dataclass(frozen=True, eq=False)
class GltfMaterial:
    """A material of a file.

    Parameters
    ----------
    name : str
        "" for none.
    material : Diffuse, Mirror or Glass
    coordinates : str
        Which texture coordinates its image takes.
    transform : (3, 3) float64
        What these are multiplied by, as (u, v, 1).
    thin : bool
        Whether it is glass without a volume inside, which bends no light where its mesh is open.
    """

    name: str
    material: Material
    coordinates: str = "TEXCOORD_0"
    transform: np.ndarray = field(default_factory=lambda: np.eye(3))
    thin: bool = False


@dataclass(frozen=True, eq=False)
class GltfMaterials:
    """The materials of a file; images that several of them share are read once."""

    container: Container
    _read: dict[int, GltfMaterial] = field(default_factory=dict)
    _textures: dict[tuple[int, tuple[str, str]], Texture] = field(default_factory=dict)
    _left_out: dict[str, list[str]] = field(default_factory=lambda: defaultdict(list))

    def __getitem__(self, number: object) -> GltfMaterial:
        """A material by its number; None stands for the file's default, which is white."""
        if number is None:
            return GltfMaterial("", Diffuse((1.0, 1.0, 1.0)))
        entry = self.container.entry("materials", number)
        assert isinstance(number, int)
        if number not in self._read:
            self._read[number] = self._material(entry, str(entry.get("name", "")), number)
        return self._read[number]

    def tell(self) -> None:
        """Issue a note for each kind of thing that was left out."""
        for what, names in self._left_out.items():
            shown = ", ".join(names[:6]) + (", ..." if len(names) > 6 else "")
            note(f"{self.container.path}: {what} ({shown})")

    def _material(self, entry: dict[str, Any], name: str, number: int) -> GltfMaterial:
        where = f"material '{name}'" if name else f"material {number}"
        color, reference = self._base_color(entry, where)
        # What stands beside the older kind of material is for programs that do not know it.
        shine = {} if GLOSSY in entry.get("extensions", {}) else entry.get("pbrMetallicRoughness", {})
        metal, roughness = (self._share(shine, key, where, 1.0) for key in ("metallicFactor", "roughnessFactor"))
        through = extension(entry, "KHR_materials_transmission")
        if self._share(through, "transmissionFactor", where, 0.0) >= HALF:
            self._tell_if(reference is not None or "transmissionTexture" in through, where, "images of glass")
            self._tell_if(roughness > 0.0 and "roughnessFactor" in shine, where, "the roughness of glass")
            volume = extension(entry, "KHR_materials_volume")
            thin = self._share(volume, "thicknessFactor", where, 0.0, None) == 0.0
            return GltfMaterial(name, self._glass(entry, color, where), thin=thin)
        if metal >= HALF and roughness <= POLISHED and "metallicRoughnessTexture" not in shine:
            self._tell_if(reference is not None, where, "images of mirrors")
            self._tell_if(roughness > 0.0, where, "the roughness of mirrors")
            return GltfMaterial(name, _mirror(color))
        if metal >= HALF and shine.keys() & {"metallicFactor", "metallicRoughnessTexture"}:
            self._left_out["metals that are rough, or told by an image, are drawn as diffuse"].append(where)
        if reference is None:
            return GltfMaterial(name, Diffuse(color))
        moved = extension(reference, "KHR_texture_transform")
        chosen = moved.get("texCoord", reference.get("texCoord", 0))
        image = Diffuse(color, self._texture(reference.get("index"), where))
        return GltfMaterial(name, image, f"TEXCOORD_{chosen}", _texture_transform(moved))

    def _base_color(self, entry: dict[str, Any], where: str) -> tuple[Color, dict[str, Any] | None]:
        glossy = entry.get("extensions", {}).get(GLOSSY)
        source, color, image = (
            (entry.get("pbrMetallicRoughness", {}), "baseColorFactor", "baseColorTexture")
            if glossy is None
            else (glossy, "diffuseFactor", "diffuseTexture")
        )
        values = source.get(color, [1.0, 1.0, 1.0])
        if len(values) < 3 or not all(type(value) in (int, float) and value >= 0 for value in values[:3]):
            self.container.wrong(f"{where}: {color} is {values!r:.60}, and must be numbers from 0")
        red, green, blue = (float(value) for value in values[:3])
        return (red, green, blue), source.get(image)

    def _glass(self, entry: dict[str, Any], color: Color, where: str) -> Glass:
        index = self._share(extension(entry, "KHR_materials_ior"), "ior", where, 1.5, None)
        if index < 1.0:
            self.container.wrong(f"{where}: ior is {index:g}, and must be at least 1")
        spread = self._share(extension(entry, "KHR_materials_dispersion"), "dispersion", where, 0.0, None)
        return Glass(index, color, 20.0 / spread if spread > 0.0 else None)

    def _texture(self, number: object, where: str) -> Texture:
        entry = self.container.entry("textures", number)
        source = extension(entry, "EXT_texture_webp").get("source", entry.get("source"))
        if source is None:
            kinds = ", ".join(entry.get("extensions", {})) or "no image"
            self.container.wrong(f"{where}: its texture holds {kinds}, which cannot be read; give it PNG or JPEG")
        sampler = self.container.entry("samplers", entry["sampler"]) if "sampler" in entry else {}
        across, down = (self._wrap(sampler, key, where) for key in ("wrapS", "wrapT"))
        key = source, (across, down)
        if key not in self._textures:
            plain = decoded(self._image_bytes(source, where), f"{self.container.path}: image of {where}")
            self._textures[key] = Texture(plain.pixels, (across, down))
        return self._textures[key]

    def _wrap(self, sampler: dict[str, Any], key: str, where: str) -> Any:
        value = sampler.get(key, 10497)
        if value not in WRAPS:
            self.container.wrong(
                f"{where}: {key} of its sampler is {value!r:.60} (known: {', '.join(map(str, WRAPS))})"
            )
        return WRAPS[value]

    def _image_bytes(self, source: object, where: str) -> bytes:
        entry = self.container.entry("images", source)
        if "bufferView" in entry:
            return bytes(self.container.view(entry["bufferView"]))
        return self.container.named(entry.get("uri"), f"image of {where}")

    def _share(self, entry: dict[str, Any], key: str, where: str, default: float, most: float | None = 1.0) -> float:
        value = entry.get(key, default)
        if type(value) not in (int, float) or not 0.0 <= value <= (np.finfo(float).max if most is None else most):
            limits = "0 to 1" if most else "0"
            self.container.wrong(f"{where}: {key} is {value!r:.60}, and must be a number from {limits}")
        return float(value)

    def _tell_if(self, so: bool, where: str, what: str) -> None:
        if so:
            self._left_out[f"left out: {what}"].append(where)


def _mirror(color: Color) -> Mirror:
    """A polished metal whose reflectance at normal incidence is `color`."""
    most = min(max(color), 1.0)
    red, green, blue = (min(value / most, 1.0) if most else 1.0 for value in color)
    return Mirror((red, green, blue), most)


def _texture_transform(extension: dict[str, Any]) -> np.ndarray:
    """Translation times rotation times scale, on (u, v, 1) from the top left."""
    (x, y), (scale_x, scale_y) = extension.get("offset", [0, 0]), extension.get("scale", [1, 1])
    cosine, sine = np.cos(extension.get("rotation", 0.0)), np.sin(extension.get("rotation", 0.0))
    return np.array([[cosine * scale_x, sine * scale_y, x], [-sine * scale_x, cosine * scale_y, y], [0, 0, 1]])
