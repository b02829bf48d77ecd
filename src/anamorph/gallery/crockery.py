"""What stands about in a kitchen: plates, cups, jars, bottles, fruit and bread, turned on lathes with many segments."""

from __future__ import annotations

import numpy as np
from PIL import Image, ImageDraw

from anamorph.gallery.solids import Solid, ball, box, join, lathe
from anamorph.gallery.textures import Rgb, centered, mottled, texture
from anamorph.scene.model import Color, Diffuse, Mesh, Texture

SEGMENTS = 32

WHITE_GLAZE: Color = (0.84, 0.83, 0.79)


def curve(points: list[tuple[float, float]], parts: int = 3) -> list[tuple[float, float]]:
    """A profile cut into `parts` between each two of its points, rounded by Catmull and Rom's spline."""
    given = np.array([points[0], *points, points[-1]], float)
    t = np.linspace(0.0, 1.0, parts, endpoint=False)[:, None]
    pieces = [
        0.5 * (2.0 * b + (c - a) * t + (2.0 * a - 5.0 * b + 4.0 * c - d) * t**2 + (3.0 * b - a - 3.0 * c + d) * t**3)
        for a, b, c, d in zip(given, given[1:], given[2:], given[3:], strict=False)
    ]
    smooth = np.concatenate([*pieces, given[-1:]])
    smooth[:, 0] = np.maximum(smooth[:, 0], 0.0)
    return [(float(radius), float(height)) for radius, height in smooth]


def plate(radius: float, color: Color = WHITE_GLAZE) -> Solid:
    r = radius
    profile = [
        (0.0, 0.0),
        (0.6 * r, 0.0),
        (0.68 * r, 0.004),
        (r, 0.02),
        (0.99 * r, 0.024),
        (0.66 * r, 0.009),
        (0.0, 0.008),
    ]
    return lathe(curve(profile), SEGMENTS, 50.0).painted(color)


def cup(color: Color) -> Solid:
    profile = [
        (0.0, 0.0), (0.024, 0.0), (0.030, 0.006), (0.038, 0.04), (0.040, 0.078), (0.038, 0.08),
        (0.035, 0.04), (0.024, 0.008), (0.0, 0.006),
    ]  # fmt: skip
    handle = ring(0.022, 0.005, 24, 12).turned(90.0, 0).moved(0.052, 0.042, 0.0)
    return join([lathe(curve(profile), SEGMENTS, 50.0), handle]).painted(color)


def ring(radius: float, thick: float, around: int, across: int) -> Solid:
    """A ring that lies flat around the origin."""
    angles = np.linspace(0.0, 2.0 * np.pi, across + 1)
    return lathe([(radius - thick * np.cos(a), -thick * np.sin(a)) for a in -angles], around, 60.0)


def jar(height: float, radius: float, color: Color, lid: Color) -> Solid:
    """A jar of spice or flour with a lid that has a knob."""
    profile = [
        (0.0, 0.0),
        (0.92 * radius, 0.0),
        (radius, 0.08 * height),
        (radius, 0.7 * height),
        (0.8 * radius, 0.8 * height),
        (0.0, 0.8 * height),
    ]
    body = lathe(curve(profile, 3), SEGMENTS, 50.0).painted(color)
    top = [
        (0.0, 0.8 * height),
        (0.86 * radius, 0.8 * height),
        (0.84 * radius, 0.9 * height),
        (0.2 * radius, 0.94 * height),
        (0.24 * radius, height),
        (0.0, height),
    ]
    return join([body, lathe(curve(top, 3), SEGMENTS, 50.0).painted(lid)])


def bottle(height: float, radius: float, color: Color) -> Solid:
    profile = [
        (0.0, 0.0), (0.9 * radius, 0.0), (radius, 0.03 * height), (radius, 0.58 * height),
        (0.45 * radius, 0.75 * height), (0.34 * radius, 0.8 * height), (0.34 * radius, 0.97 * height),
        (0.4 * radius, height), (0.0, height),
    ]  # fmt: skip
    return lathe(curve(profile), SEGMENTS, 50.0).painted(color)


def pear(size: float, color: Color) -> Solid:
    profile = [
        (0.0, 0.0),
        (0.3 * size, 0.02 * size),
        (0.5 * size, 0.35 * size),
        (0.36 * size, 0.75 * size),
        (0.2 * size, 1.05 * size),
        (0.0, 1.15 * size),
    ]
    return lathe(curve(profile, 6), SEGMENTS, 60.0).painted(color)


def apple(radius: float, color: Color) -> Solid:
    angle = np.linspace(-0.5 * np.pi, 0.5 * np.pi, 33)
    profile = [
        (radius * np.cos(a) * (1.0 + 0.12 * np.sin(a)), radius * (0.92 + 0.9 * np.sin(a) - 0.16 * np.sin(a) ** 8))
        for a in angle
    ]
    profile = [(max(r, 0.0), h) for r, h in profile]
    profile[0], profile[-1] = (0.0, profile[0][1]), (0.0, profile[-1][1])
    stem = lathe(
        [(0.0, 1.6 * radius), (0.05 * radius, 1.6 * radius), (0.04 * radius, 2.1 * radius), (0.0, 2.1 * radius)], 8
    )
    return join([lathe(profile, SEGMENTS, 60.0).painted(color), stem.painted((0.25, 0.15, 0.07))])


def citrus(radius: float, color: Color) -> Solid:
    return ball(4, radius, (0.0, radius, 0.0)).painted(color)


def fruit_bowl() -> list[Mesh]:
    """A glazed bowl with fruit in it, around the origin."""
    profile = [
        (0.0, 0.0),
        (0.055, 0.0),
        (0.06, 0.008),
        (0.11, 0.04),
        (0.145, 0.085),
        (0.141, 0.088),
        (0.10, 0.048),
        (0.05, 0.016),
        (0.0, 0.014),
    ]
    fruit = [
        apple(0.036, (0.62, 0.09, 0.06)).moved(-0.05, 0.035, 0.02),
        apple(0.034, (0.45, 0.55, 0.12)).moved(0.02, 0.035, -0.055),
        citrus(0.036, (0.85, 0.36, 0.04)).moved(0.05, 0.032, 0.03),
        citrus(0.03, (0.88, 0.72, 0.10)).moved(-0.015, 0.07, -0.005),
        pear(0.07, (0.62, 0.58, 0.16)).turned(18.0, 2).moved(-0.01, 0.04, 0.07),
    ]
    return [
        lathe(curve(profile), SEGMENTS, 50.0).mesh("fruit-bowl", Diffuse(color=(0.16, 0.30, 0.45))),
        join(fruit).mesh("fruit", Diffuse(color=(1.0, 1.0, 1.0))),
    ]


def place_setting(color: Color) -> Solid:
    """A plate with a cup on its saucer beside it, around the origin."""
    saucer = plate(0.07).moved(0.17, 0.0, -0.08)
    return join([plate(0.12), plate(0.085, color).moved(0.0, 0.009, 0.0), saucer, cup(color).moved(0.17, 0.009, -0.08)])


def labelled_box(words: str, color: Rgb, size: tuple[float, float, float]) -> Mesh:
    """A carton with words on all sides, standing on the origin."""
    image = mottled((128, 128), color, 71, (8, 32), 3.0)
    draw = ImageDraw.Draw(image)
    draw.rectangle((8, 30, 119, 92), fill=(240, 236, 220))
    centered(draw, (64, 52), words, 22, (60, 40, 36))
    for row in range(3):
        draw.line((20, 70 + 7 * row, 108, 70 + 7 * row), fill=(150, 140, 130), width=2)
    x, y, z = size
    return box((-x / 2, 0.0, -z / 2), (x / 2, y, z / 2), divisions=(6, 8)).mesh(
        f"carton-{words.lower()}", Diffuse(color=(1.0, 1.0, 1.0), texture=texture(image))
    )


def tea_towel() -> Texture:
    """Linen with coloured stripes."""
    image = mottled((128, 128), (226, 222, 208), 72, (32, 64), 4.0)
    draw = ImageDraw.Draw(image)
    for x, wide, color in (
        (10, 10, (168, 52, 46)),
        (26, 3, (168, 52, 46)),
        (96, 3, (50, 80, 130)),
        (104, 12, (50, 80, 130)),
    ):
        draw.rectangle((x, 0, x + wide, 127), fill=color)
    return texture(image)


def tiles() -> Texture:
    """Sixteen glazed tiles, some of them blue with a flower."""
    image = Image.new("RGB", (512, 512), (150, 148, 140))
    for row in range(4):
        for column in range(4):
            blue = (3 * row + 5 * column) % 7 == 0
            tile = mottled((122, 122), (86, 122, 168) if blue else (214, 216, 210), 80 + 4 * row + column, (2, 4), 3.0)
            draw = ImageDraw.Draw(tile)
            if blue:
                for angle in np.arange(6) * np.pi / 3.0:
                    x, y = 61 + 22 * np.cos(angle), 61 + 22 * np.sin(angle)
                    draw.ellipse((x - 13, y - 13, x + 13, y + 13), fill=(226, 228, 222))
                draw.ellipse((50, 50, 72, 72), fill=(222, 178, 70))
            image.paste(tile, (128 * column + 3, 128 * row + 3))
    return texture(image)
