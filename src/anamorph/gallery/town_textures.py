"""What the town wears: asphalt with its markings, facades, shop fronts with their names, signs and number plates."""

from __future__ import annotations

from functools import cache

import numpy as np
from PIL import Image, ImageDraw

from anamorph.gallery.textures import Rgb, centered, mottled, texture
from anamorph.scene.model import Texture

ROAD_WIDTH = 11.0
ROAD_TILE = 12.0
LANE_WIDTH = 3.4
CROSSING_LENGTH = 4.0
PAINT: Rgb = (226, 226, 220)
ASPHALT: Rgb = (98, 99, 102)

SHOPS = ("BAKERY", "BOOKS", "PHARMACY", "CAFE ROMA", "FLOWERS", "OPTICIAN", "GROCER", "CLOCKS")
SHOP_COLORS: tuple[Rgb, ...] = (
    (142, 46, 38), (30, 66, 110), (28, 104, 72), (92, 58, 34),
    (122, 44, 96), (24, 92, 108), (52, 104, 40), (52, 52, 60),
)  # fmt: skip
SIGNS = ("HOTEL", "BAR", "BANK", "TAXI", "POST", "ZOO 2", "CINEMA", "DENTIST")
PLATES = ("AN 2007", "KT 4936", "GC 1049", "TN 8800")


@cache
def road() -> Texture:
    """Asphalt across the whole road, 11 m by 12 m: edge lines, dashed centre line, parking bays."""
    width, height = 1024, 1024
    across, along = width / ROAD_WIDTH, height / ROAD_TILE
    image = mottled((width, height), ASPHALT, 11, (4, 16, 64, 256), 4.5)
    draw = ImageDraw.Draw(image)
    worn = (112, 112, 114)
    for lane in (-1, 1):
        for side in (-0.75, 0.75):
            x = (ROAD_WIDTH / 2 + lane * LANE_WIDTH / 2 + side) * across
            draw.rectangle((x - 0.16 * across, 0, x + 0.16 * across, height), fill=worn)
    image = Image.blend(image, mottled((width, height), ASPHALT, 11, (4, 16, 64, 256), 4.5), 0.6)
    draw = ImageDraw.Draw(image)

    def line(x: float, y: float, wide: float, long: float) -> None:
        left, top = (ROAD_WIDTH / 2 + x) * across, y * along
        draw.rectangle((left, top, left + wide * across - 1, top + long * along - 1), fill=PAINT)

    for start in (1.5, 7.5):
        line(-0.09, start, 0.18, 3.0)
    for side in (-1, 1):
        line(side * LANE_WIDTH - 0.07, 0.0, 0.14, ROAD_TILE)
        for start in (0.0, 6.0):
            line(side * (LANE_WIDTH + 1.05) - 1.05, start, 2.1, 0.12)
    return texture(image)


def crossing() -> Texture:
    """A zebra crossing over the whole road, 11 m by 4 m."""
    width, height = 1024, 256
    image = mottled((width, height), ASPHALT, 12, (4, 16, 64, 256), 4.5)
    draw = ImageDraw.Draw(image)
    stripe = width / 22
    for i in range(11):
        draw.rectangle(((2 * i + 0.5) * stripe, 24, (2 * i + 1.5) * stripe, height - 24), fill=PAINT)
    return texture(image)


@cache
def pavement() -> Texture:
    """Concrete slabs, 2 m by 2 m."""
    image = mottled((256, 256), (158, 154, 146), 13, (4, 16, 64), 4.0)
    return _courses(image, 64, (118, 114, 108), 2, (118, 114, 108))


def roof_tiles() -> Texture:
    """Clay tiles, 3 m by 3 m."""
    image = mottled((256, 256), (138, 74, 54), 14, (4, 16, 32), 9.0)
    return _courses(image, 32, (88, 46, 34), 4, (106, 56, 42))


def _courses(image: Image.Image, side: int, bed: Rgb, thick: int, joint: Rgb) -> Texture:
    """Squares of `side` pixels in rows, each shifted by half of one against the next, with lines between them."""
    draw = ImageDraw.Draw(image)
    for top in range(0, 256, side):
        draw.line((0, top, 256, top), fill=bed, width=thick)
        for x in range(side // 2 * (top // side % 2), 257, side):
            draw.line((x, top, x, top + side), fill=joint, width=2)
    return texture(image)


def facade(wall: Rgb, trim: Rgb, seed: int, bricks: bool) -> Texture:
    """Two storeys of two windows each, 6 m by 6.4 m."""
    size = 512
    image = mottled((size, size), wall, seed, (4, 16, 64), 4.0)
    draw = ImageDraw.Draw(image)
    mortar = tuple(int(0.55 * channel + 78) for channel in wall)
    if bricks:
        for row in range(64):
            draw.line((0, row * 8, size, row * 8), fill=mortar)
            for x in range(10 * (row % 2), size, 20):
                draw.line((x, row * 8, x, row * 8 + 8), fill=mortar)
    generator = np.random.default_rng(seed)
    for storey in (0, 1):
        top = storey * 256
        draw.rectangle((0, top + 236, size, top + 247), fill=trim)
        draw.line((0, top + 248, size, top + 248), fill=(84, 80, 74), width=2)
        for bay in (0, 1):
            window(draw, bay * 256 + 68, top + 46, 120, 152, trim, generator)
    return texture(image)


def window(
    draw: ImageDraw.ImageDraw, left: int, top: int, wide: int, tall: int, trim: Rgb, generator: np.random.Generator
) -> None:
    """A sash window with frame, sill, lintel and curtains."""
    right, bottom = left + wide, top + tall
    draw.rectangle((left - 12, top - 16, right + 12, top - 4), fill=trim)
    draw.rectangle((left - 10, top - 4, right + 10, bottom + 8), fill=(226, 224, 216))
    for row in range(tall):
        sky = 1.0 - row / tall
        color = (int(36 + 70 * sky), int(48 + 84 * sky), int(62 + 98 * sky))
        draw.line((left, top + row, right, top + row), fill=color)
    if generator.random() < 0.7:
        cloth = (214, 206, 190) if generator.random() < 0.6 else (176, 126, 104)
        drawn = int(generator.integers(14, 38))
        draw.polygon([(left, top), (left + drawn + 12, top), (left + drawn, bottom), (left, bottom)], fill=cloth)
        draw.polygon([(right, top), (right - drawn - 12, top), (right - drawn, bottom), (right, bottom)], fill=cloth)
    draw.rectangle((left + wide // 2 - 3, top, left + wide // 2 + 3, bottom), fill=(232, 230, 224))
    draw.rectangle((left, top + tall // 3 - 3, right, top + tall // 3 + 3), fill=(232, 230, 224))
    draw.rectangle((left - 18, bottom + 8, right + 18, bottom + 20), fill=trim)
    draw.rectangle((left - 14, bottom + 20, right + 14, bottom + 24), fill=(74, 70, 66))


def shop_fronts() -> Texture:
    """Eight shop fronts of 6 m by 3.2 m, two across and four down, each under its name."""
    image = Image.new("RGB", (1024, 1024))
    for index, (name, color) in enumerate(zip(SHOPS, SHOP_COLORS, strict=True)):
        image.paste(shop_front(name, color, index), (index % 2 * 512, index // 2 * 256))
    return texture(image)


def shop_front(name: str, color: Rgb, seed: int) -> Image.Image:
    """One shop: name board, display window with goods on shelves, door with its handle."""
    image = Image.new("RGB", (512, 256), color)
    draw = ImageDraw.Draw(image)
    light = tuple(min(255, channel + 46) for channel in color)
    draw.rectangle((0, 0, 511, 6), fill=light)
    draw.rectangle((0, 62, 511, 66), fill=light)
    centered(draw, (256, 34), name, 50, (246, 238, 214))
    generator = np.random.default_rng(100 + seed)
    for left, right, top, bottom in ((20, 336, 80, 214), (376, 478, 80, 252)):
        draw.rectangle((left - 6, top - 6, right + 6, bottom + 6), fill=light)
        for row in range(top, bottom):
            shade = 1.0 - (row - top) / (bottom - top)
            color_here = (int(52 + 52 * shade), int(56 + 64 * shade), int(62 + 76 * shade))
            draw.line((left, row, right, row), fill=color_here)
    for shelf in (126, 170, 212):
        draw.rectangle((20, shelf, 336, shelf + 4), fill=(132, 108, 82))
        x = 28
        while x < 312:
            wide, tall = int(generator.integers(10, 24)), int(generator.integers(14, 34))
            goods = tuple(int(channel) for channel in generator.integers(70, 230, 3))
            draw.rectangle((x, shelf - tall, x + wide, shelf - 1), fill=goods)
            x += wide + int(generator.integers(4, 18))
    draw.rectangle((176, 80, 180, 214), fill=light)
    draw.rectangle((376, 206, 478, 252), fill=light)
    draw.rectangle((386, 150, 391, 182), fill=(222, 200, 130))
    draw.rectangle((404, 104, 450, 124), fill=(238, 238, 230))
    centered(draw, (427, 114), "OPEN", 15, (166, 36, 30))
    draw.rectangle((0, 226, 366, 255), fill=tuple(int(0.7 * channel) for channel in color))
    return image


def signs() -> Texture:
    """Eight boards of 2:1, two across and four down."""
    image = Image.new("RGB", (512, 512))
    draw = ImageDraw.Draw(image)
    for index, name in enumerate(SIGNS):
        left, top = index % 2 * 256, index // 2 * 128
        draw.rectangle((left, top, left + 255, top + 127), fill=SHOP_COLORS[-1 - index])
        draw.rectangle((left + 6, top + 6, left + 249, top + 121), outline=(246, 238, 214), width=4)
        centered(draw, (left + 128, top + 64), name, 62 if len(name) < 6 else 50, (246, 238, 214))
    return texture(image)


def plates() -> Texture:
    """Four number plates of 4:1, one below the other."""
    image = Image.new("RGB", (256, 256), (240, 240, 234))
    draw = ImageDraw.Draw(image)
    for index, number in enumerate(PLATES):
        draw.rectangle((1, index * 64 + 1, 254, index * 64 + 62), outline=(20, 20, 24), width=3)
        draw.rectangle((4, index * 64 + 4, 26, index * 64 + 59), fill=(24, 60, 150))
        centered(draw, (140, index * 64 + 32), number, 50, (20, 20, 24))
    return texture(image)


def meadow() -> Texture:
    """Grass, to be repeated every 8 m."""
    return texture(mottled((256, 256), (96, 116, 62), 15, (4, 16, 64, 128), 6.0))
