"""The numbers that stand beside reflection points: where, and in an image that is saved."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from PIL import Image, ImageDraw, ImageFont

from anamorph.scene.camera import Camera
from anamorph.viewer.facts import Reflections
from anamorph.viewer.panel import theme

SIGNS = {1: "+", -1: "\N{MINUS SIGN}", 0: "*"}
"""Of the order of a reflection point."""

BESIDE = (9.0, -16.0)
"""How far right and down of its reflection point a number begins, logical pixels."""

PAD = 3.0
"""Of dark ground at both sides of a number."""


@dataclass(frozen=True)
class Number:
    """What stands beside a reflection point.

    Parameters
    ----------
    text : str
        Its number and the sign of its order, in brackets where it is hidden.
    place : (x, y)
        Where that begins: pixels right and down of the image's top left.
    color : Color
    """

    text: str
    place: tuple[float, float]
    color: theme.Color


def numbers_of(reflections: Reflections | None, camera: Camera, size: tuple[float, float]) -> tuple[Number, ...]:
    """The numbers in a camera's image of `size` (width, height), logical pixels; none of what lies behind it."""
    if reflections is None:
        return ()
    positions = np.array([each.path[0] for each in reflections.found]).reshape(-1, 3)
    width, height = (max(round(side), 1) for side in size)
    numbers = []
    for number, (each, (x, y, w)) in enumerate(
        zip(reflections.found, camera.image(positions, (width, height)), strict=True), start=1
    ):
        text = f"{number}{SIGNS[each.order]}"
        if w > 0.0:
            place = (float(x / w) + BESIDE[0], float(y / w) + BESIDE[1])
            text, color = (f"({text})", theme.FAINT) if each.hidden else (text, theme.TEXT)
            numbers.append(Number(text, place, color))
    return tuple(numbers)


def numbered(pixels: np.ndarray, numbers: tuple[Number, ...], ratio: float = 1.0) -> np.ndarray:
    """An image (H, W, 3) uint8 sRGB with numbers in it; `ratio` of its pixels are a logical one."""
    if not numbers:
        return pixels
    image = Image.fromarray(pixels)
    draw, font = ImageDraw.Draw(image), ImageFont.truetype(str(theme.REGULAR), theme.LETTERS * ratio)
    for number in numbers:
        x, y = (ratio * place for place in number.place)
        across = draw.textlength(number.text, font)
        pad, below = PAD * ratio, (theme.LETTERS + PAD) * ratio
        draw.rectangle((x - pad, y, x + across + pad, y + below), _bytes(theme.SHADE))
        draw.text((x, y + below / 2.0), number.text, _bytes(number.color), font, "lm")
    return np.asarray(image)


def _bytes(color: theme.Color) -> tuple[int, int, int]:
    red, green, blue, _ = (round(255.0 * value) for value in color)
    return red, green, blue
