"""A bright hall as an image of all directions: floor boards, papered walls, windows and a coffered ceiling."""

from __future__ import annotations

from functools import cache

import numpy as np
from PIL import Image

from anamorph.gallery.room import landscape, wallpaper
from anamorph.gallery.textures import planks, texture
from anamorph.scene.model import Sky, Texture

SIZE = (2048, 1024)
HALF, FLOOR, CEILING = 7.0, -1.7, 4.0
"""Of the hall around the eye, metres: half its sides, and how high floor and ceiling are."""
WINDOWS, SILL, LINTEL = 5, -0.35, 2.9
"""In each wall, and between which heights, metres."""
FRAME = (232, 230, 222)


@cache
def hall() -> Sky:
    """The sky that shows the hall."""
    across, down = np.meshgrid((np.arange(SIZE[0]) + 0.5) / SIZE[0], (np.arange(SIZE[1]) + 0.5) / SIZE[1])
    longitude, latitude = 2.0 * np.pi * (across - 0.5), np.pi * (0.5 - down)
    level = np.cos(latitude)
    way = np.stack([level * np.sin(longitude), np.sin(latitude), -level * np.cos(longitude)], axis=-1)
    side = HALF / np.maximum(np.abs(way[..., 0]), np.abs(way[..., 2]))
    with np.errstate(divide="ignore"):
        far = np.minimum(side, np.where(way[..., 1] < 0.0, FLOOR, CEILING) / way[..., 1])
    x, y, z = np.moveaxis(far[..., None] * way, -1, 0)
    along = np.where(np.abs(way[..., 0]) > np.abs(way[..., 2]), z, x)
    pixels = np.where((far < side)[..., None], _level(x, y, z), _wall(along, y))
    return Sky(image=texture(Image.fromarray(pixels.astype(np.uint8))))


def _level(x: np.ndarray, y: np.ndarray, z: np.ndarray) -> np.ndarray:
    """Floor and ceiling."""
    beam = np.minimum(np.abs((x / 1.0) % 1.0 - 0.5), np.abs((z / 1.0) % 1.0 - 0.5)) < 0.08
    ceiling = np.where(beam[..., None], (150, 118, 84), (226, 220, 206))
    return np.where((y < 0.0)[..., None], _looked_up(planks(1024, 10, (158, 112, 70), 71), x / 3.0, z / 3.0), ceiling)


def _wall(along: np.ndarray, y: np.ndarray) -> np.ndarray:
    """A wall with windows."""
    share = (along + HALF) * WINDOWS / (2.0 * HALF) % 1.0
    u, v = (share - 0.2) / 0.6, (LINTEL - y) / (LINTEL - SILL)
    bars = np.minimum(np.abs(u - 0.5), 1.6 * np.abs(v - 0.33)) < 0.02
    open_to = (np.abs(u - 0.5) < 0.46) & (np.abs(v - 0.5) < 0.47)
    view = np.where(bars[..., None], FRAME, np.minimum(1.12 * _looked_up(landscape(), u, v), 255.0))
    paper = _looked_up(wallpaper(), along / 1.2, y / 1.2)
    wainscot = np.where((y < SILL - 0.3)[..., None], (196, 190, 176), paper)
    framed = np.where(((np.abs(u - 0.5) < 0.5) & (np.abs(v - 0.5) < 0.5))[..., None], FRAME, wainscot)
    return np.where(open_to[..., None], view, framed)


def _looked_up(image: Texture, u: np.ndarray, v: np.ndarray) -> np.ndarray:
    """The colours, 0 to 255, of a repeating texture."""
    height, width = image.pixels.shape[:2]
    column, row = (np.floor(each % 1.0 * count).astype(int) for each, count in ((u, width), (v, height)))
    return image.pixels[np.minimum(row, height - 1), np.minimum(column, width - 1), :3].astype(float)
