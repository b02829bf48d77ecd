"""Dice with letters on them, which show when an image is reversed."""

from __future__ import annotations

from functools import cache

from PIL import Image, ImageDraw

from anamorph.gallery.solids import Solid, six_sided
from anamorph.gallery.textures import centered, texture
from anamorph.scene.model import Texture


def die(edge: float) -> Solid:
    """A cube that stands on the origin with a letter on each side."""
    return six_sided((-edge / 2, 0.0, -edge / 2), (edge / 2, edge, edge / 2))


@cache
def letters() -> Texture:
    """The sides of the die: six fields in the left three quarters, three across and two down."""
    image = Image.new("RGB", (512, 256), (240, 234, 218))
    draw = ImageDraw.Draw(image)
    inks = ((30, 60, 130), (150, 40, 30), (20, 100, 60), (120, 60, 120), (40, 40, 50), (160, 90, 20))
    for number, (letter, ink) in enumerate(zip("RPQFGJ", inks, strict=True)):
        row, column = divmod(number, 3)
        left, top = column * 128, row * 128
        draw.rectangle((left + 4, top + 4, left + 123, top + 123), outline=ink, width=8)
        centered(draw, (left + 64, top + 62), letter, 92, ink)
    return texture(image)
