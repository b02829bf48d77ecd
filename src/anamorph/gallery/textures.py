"""Images painted by numpy and Pillow with fixed seeds: what the built-in scenes wear."""

from __future__ import annotations

import numpy as np
from PIL import Image, ImageDraw, ImageFilter, ImageFont

from anamorph.scene.model import Texture

Rgb = tuple[int, int, int]


def texture(image: Image.Image) -> Texture:
    return Texture(pixels=np.asarray(image.convert("RGBA")).copy())


def noise(size: tuple[int, int], seed: int, octaves: tuple[int, ...]) -> np.ndarray:
    """Smooth noise that tiles, (height, width) float64 of mean 0 and about unit spread.

    Each octave is a random lattice of that many cells across.
    """
    generator = np.random.default_rng(seed)
    width, height = size
    total = np.zeros((height, width))
    for cells in octaves:
        lattice = generator.normal(size=(max(1, cells * height // width), cells)).astype(np.float32)
        tiled = Image.fromarray(np.pad(lattice, 2, mode="wrap"))
        rows, columns = lattice.shape
        total += np.asarray(
            tiled.resize(size, Image.Resampling.BICUBIC, box=(2, 2, 2 + columns, 2 + rows)), dtype=np.float64
        )
    return total / max(total.std(), 1e-9)


def mottled(size: tuple[int, int], color: Rgb, seed: int, octaves: tuple[int, ...], strength: float) -> Image.Image:
    """A plain colour whose brightness wavers by `strength` 8-bit steps."""
    values = np.asarray(color, float) + strength * noise(size, seed, octaves)[..., None]
    return Image.fromarray(np.clip(values, 0, 255).astype(np.uint8))


def checkerboard(size: int, squares: int, one: Rgb, other: Rgb) -> Texture:
    """A board of squares x squares fields."""
    row, column = np.indices((size, size)) * squares // size
    return texture(Image.fromarray(np.where(((row + column) % 2)[..., None], other, one).astype(np.uint8)))


def centered(draw: ImageDraw.ImageDraw, middle: tuple[float, float], words: str, height: float, color: Rgb) -> None:
    """Write `words` with their middle at a point, in Pillow's own font at `height` pixels."""
    font = ImageFont.load_default(size=height)
    draw.text(middle, words, font=font, fill=color, anchor="mm", stroke_width=height / 40)


def planks(size: int, rows: int, color: Rgb, seed: int) -> Texture:
    """Wooden boards that run along u, with staggered ends."""
    generator = np.random.default_rng(seed)
    grain = noise((size, size), seed, (size // 128,)) + noise((size, size), seed + 1, (4,))
    fibre = np.asarray(Image.fromarray(generator.normal(size=(size, 8)).astype(np.float32)).resize((size, size)))
    image = Image.new("RGB", (size, size))
    values = np.asarray(color, float) + 4 * grain[..., None] + 7 * fibre[..., None]
    board = size // rows
    for row in range(rows):
        cut = int(generator.integers(size))
        part = np.roll(values[row * board : (row + 1) * board], cut, axis=1)
        part[:, : size // 2] += generator.normal() * 9
        part[:, size // 2 :] += generator.normal() * 9
        part[:, [0, 1, size // 2, size // 2 + 1]] *= 0.55
        part[:2] *= 0.55
        image.paste(Image.fromarray(np.clip(np.roll(part, cut, axis=1), 0, 255).astype(np.uint8)), (0, row * board))
    return texture(image)


def leaves() -> Texture:
    """Foliage: many small lit and shaded leaves."""
    size = 256
    generator = np.random.default_rng(5)
    image = Image.new("RGB", (size, size), (46, 82, 34))
    draw = ImageDraw.Draw(image)
    for x, y, spread, light in zip(
        generator.integers(0, size, 900),
        generator.integers(0, size, 900),
        generator.integers(4, 10, 900),
        generator.normal(size=900),
        strict=True,
    ):
        color = (int(74 + 22 * light), int(116 + 26 * light), int(48 + 14 * light))
        for left in (x - size, x, x + size):
            for top in (y - size, y, y + size):
                draw.ellipse((left, top, left + spread, top + spread // 2 + 2), fill=color)
    return texture(image.filter(ImageFilter.GaussianBlur(0.7)))
