"""MTL files: the materials of OBJ files, of which the diffuse colour and image are shown.

Format: Wavefront's "Advanced Visualizer" manual, appendix B1, MTL material format.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from anamorph.base.errors import AnamorphError
from anamorph.base.notes import note
from anamorph.base.srgb import decode_srgb
from anamorph.files.reading import as_utf8, beside, read, read_texture
from anamorph.scene.model import WHITE, Color, Diffuse, Texture

OPTION = re.compile(r"(-[a-z]+)\s+", re.IGNORECASE)
NUMBERS = re.compile(r"(?:[-+]?(?:\d+\.?\d*|\.\d+)(?:e[-+]?\d+)?\s+){1,3}", re.IGNORECASE)
NUMBERED = {"-s": (1.0, 1.0), "-o": (0.0, 0.0), "-t": (0.0, 0.0), "-mm": (0.0, 1.0)}
"""Options of an image that take numbers, and what counts for those that are not there."""

WORDED = ("-blendu", "-blendv", "-bm", "-boost", "-cc", "-clamp", "-imfchan", "-texres", "-type")
"""Options that take a word. All but -clamp are for bumps, filters and other programs, and change nothing here."""


@dataclass(frozen=True)
class MtlImage:
    """An image on a material, and what its options say.

    Parameters
    ----------
    name : str
        Of the file.
    scale, offset : (float, float)
        Texture coordinates from the bottom left are multiplied by one, and then moved by the other.
    base, gain : float
        A texel t counts as base + gain t.
    clamp : bool
        Whether its edges go on outside it; else it repeats.
    """

    name: str
    scale: tuple[float, float] = (1.0, 1.0)
    offset: tuple[float, float] = (0.0, 0.0)
    base: float = 0.0
    gain: float = 1.0
    clamp: bool = False


@dataclass(frozen=True)
class MtlMaterial:
    """A material of the file `path`: its linear colour, None where the file has none, and its image."""

    path: Path
    color: Color | None = None
    image: MtlImage | None = None


class MtlMaterials:
    """The materials of an OBJ file, by their names; images that several use are read once."""

    def __init__(self, model: Path) -> None:
        self._model = model
        self._known: dict[str, MtlMaterial] = {}
        self._textures: dict[tuple[Path, float, float, bool], Texture] = {}

    def add(self, names: str) -> None:
        """Read the libraries that a line of an OBJ file names; of one name, the first material counts."""
        for path in self._libraries(names):
            for name, material in read_mtl(path).items():
                self._known.setdefault(name, material)

    def _libraries(self, names: str) -> list[Path]:
        """The files of a line: one name with spaces, or several names."""
        for choice in ([names], names.split()):
            try:
                return [beside(self._model, name) for name in choice]
            except AnamorphError:
                continue
        several = re.findall(r"\S.*?\.mtl(?=\s|$)", names, re.IGNORECASE)
        return [beside(self._model, name) for name in several or [names]]

    def image(self, name: str) -> MtlImage | None:
        """The image of a material."""
        return self._known[name].image if name in self._known else None

    def look(self, name: str, placed: bool, where: str) -> Diffuse:
        """A material as it is shown; `placed` says whether there are texture coordinates."""
        known = self._known.get(name)
        if known is None:
            if name and self._known:
                note(f"{where}: its material '{name}' is in no library of the file; it is grey")
            return Diffuse()
        if known.image is None:
            return Diffuse() if known.color is None else Diffuse(known.color)
        if not placed:
            note(f"{where}: has no texture coordinates; the image '{known.image.name}' is left out")
            return Diffuse(known.color or WHITE)
        return Diffuse(known.color or WHITE, self._texture(known.path, known.image))

    def _texture(self, library: Path, image: MtlImage) -> Texture:
        path = beside(library, image.name)
        key = (path, image.base, image.gain, image.clamp)
        if key not in self._textures:
            texture = read_texture(path)
            if (image.base, image.gain) != (0.0, 1.0):
                levels = np.clip(255.0 * image.base + image.gain * texture.pixels[..., :3], 0.0, 255.0)
                pixels = np.concatenate([np.round(levels).astype(np.uint8), texture.pixels[..., 3:]], axis=-1)
                texture = replace(texture, pixels=pixels)
            self._textures[key] = replace(texture, wraps=("clamp", "clamp")) if image.clamp else texture
        return self._textures[key]


def read_mtl(path: Path) -> dict[str, MtlMaterial]:
    """The materials of an MTL file, by their names."""
    found: dict[str, MtlMaterial] = {}
    name = ""
    for number, line in enumerate(as_utf8(read(path, "material library")).decode().splitlines(), start=1):
        word, *rest = line.strip().split(maxsplit=1)[:2] or [""]
        text, where = "".join(rest), f"{path}, line {number}"
        if word.lower() == "newmtl":
            name = text
            found[name] = MtlMaterial(path)
        elif word.lower() == "kd" and name in found:
            found[name] = replace(found[name], color=_color(text, where))
        elif word.lower() == "map_kd" and name in found:
            found[name] = replace(found[name], image=_image(text, where))
    return found


def _color(text: str, where: str) -> Color | None:
    try:
        shades = np.clip([float(word) for word in text.split()[:3]], 0.0, 1.0)
    except ValueError:
        shades = np.array([np.nan])
    if not len(shades) or not np.isfinite(shades).all():
        note(f"{where}: Kd is '{text:.40}', and not red, green and blue; it is left out")
        return None
    # One number is a grey.
    red, green, blue = decode_srgb(shades if len(shades) == 3 else np.repeat(shades[:1], 3))
    return (float(red), float(green), float(blue))


def _image(text: str, where: str) -> MtlImage:
    """An image with its options, which stand before its name; the name may have spaces."""
    image = MtlImage("")
    while match := OPTION.match(text):
        option, rest = match[1].lower(), text[match.end() :]
        if option in NUMBERED:
            numbers = NUMBERS.match(rest)
            if numbers is None:
                raise AnamorphError(f"{where}: map_Kd has {option} without a number; give it one, or leave it out")
            values = [float(word) for word in numbers[0].split()]
            first, second = (values + list(NUMBERED[option])[len(values) :])[:2]
            image, rest = _with(image, option, (first, second), where), rest[numbers.end() :]
        elif option in WORDED:
            word, _, rest = rest.partition(" ")
            image = replace(image, clamp=word.lower() == "on") if option == "-clamp" else image
        else:
            break
        text = rest.lstrip()
    return replace(image, name=text)


def _with(image: MtlImage, option: str, values: tuple[float, float], where: str) -> MtlImage:
    match option:
        case "-s":
            return replace(image, scale=values)
        case "-o":
            return replace(image, offset=values)
        case "-mm":
            return replace(image, base=values[0], gain=values[1])
    if any(values):
        note(f"{where}: the turbulence of map_Kd (-t) is left out")
    return image
