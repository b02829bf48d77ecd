"""Images side by side with words under them, as one figure of a page."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw, ImageFont

import anamorph as an
from anamorph.base.output import to_pixels, whole_file

GAP = 10
"""Between panels, pixels."""
LINE = 21
"""From one line of a caption to the next, pixels."""
INK = (30, 34, 40)
HALF = (475, 356)
"""Size of one of two panels beside each other, pixels."""
WARP = "pervertex:map=image,antialias=4"
"""The paper's own way."""


@dataclass(frozen=True, eq=False)
class Panel:
    """Pixels (H, W, 3) uint8, and the words under them, line by line."""

    pixels: np.ndarray
    caption: str = ""


@cache
def font(size: int) -> ImageFont.FreeTypeFont | ImageFont.ImageFont:
    """The typeface of all words in figures."""
    return ImageFont.load_default(size)


def compose(rows: Sequence[Sequence[Panel]]) -> np.ndarray:
    """Rows of panels, each row as high as its highest panel and caption, (H, W, 3) uint8."""
    heights = [
        max(len(panel.pixels) + (4 + LINE * (1 + panel.caption.count("\n")) if panel.caption else 0) for panel in row)
        for row in rows
    ]
    width = max(sum(panel.pixels.shape[1] for panel in row) + GAP * (len(row) - 1) for row in rows)
    page = Image.new("RGB", (width, sum(heights) + GAP * (len(rows) - 1)), "white")
    draw = ImageDraw.Draw(page)
    y = 0
    for row, height in zip(rows, heights, strict=True):
        x = 0
        for panel in row:
            page.paste(Image.fromarray(panel.pixels), (x, y))
            for number, words in enumerate(panel.caption.split("\n")):
                draw.text((x + 2, y + len(panel.pixels) + 4 + LINE * number), words, INK, font(17))
            x += panel.pixels.shape[1] + GAP
        y += height + GAP
    return np.asarray(page)


def save(path: Path, rows: Sequence[Sequence[Panel]]) -> None:
    """Write a figure as a WebP of moderate size."""
    with whole_file(path) as file:
        Image.fromarray(compose(rows)).save(file, "WEBP", quality=82, method=6)
    print(path, f"{path.stat().st_size / 1000:.0f} kB")


def labelled(pixels: np.ndarray, labels: Sequence[tuple[str, tuple[float, float], str]], size: int = 18) -> np.ndarray:
    """Pixels with words at places (x, y); the third entry is PIL's anchor, as "lm" for left and middle."""
    image = Image.fromarray(pixels)
    draw = ImageDraw.Draw(image)
    for words, place, anchor in labels:
        draw.text(place, words, INK, font(size), anchor, stroke_width=3, stroke_fill="white")
    return np.asarray(image)


def lined(
    pixels: np.ndarray, segments: np.ndarray, color: tuple[int, int, int], width: int = 1, scale: int = 4
) -> np.ndarray:
    """Pixels with smooth straight lines between image points, `segments` (N, 2, 2)."""
    height, across = pixels.shape[:2]
    mask = Image.new("L", (across * scale, height * scale))
    draw = ImageDraw.Draw(mask)
    for first, last in np.asarray(segments, float) * scale:
        draw.line([tuple(first), tuple(last)], 255, width * scale)
    share = np.asarray(mask.resize((across, height), Image.Resampling.BOX), float)[..., None] / 255.0
    return np.round((1.0 - share) * pixels + share * np.array(color, float)).astype(np.uint8)


def cropped(
    pixels: np.ndarray, box: tuple[int, int, int, int], size: tuple[int, int], smooth: bool = False
) -> np.ndarray:
    """The part (left, top, right, bottom) of pixels at `size` (width, height): as squares, or smooth."""
    how = Image.Resampling.LANCZOS if smooth else Image.Resampling.NEAREST
    return np.asarray(Image.fromarray(pixels).crop(box).resize(size, how))


def outlined(pixels: np.ndarray, box: tuple[int, int, int, int], width: int) -> np.ndarray:
    """Pixels with a dark frame, `width` pixels thick, around a box (left, top, right, bottom)."""
    image = Image.fromarray(pixels)
    ImageDraw.Draw(image).rectangle(box, outline=INK, width=width)
    return np.asarray(image)


def shrunk(pixels: np.ndarray, size: tuple[int, int]) -> np.ndarray:
    """Pixels at another `size` (width, height), smoothly."""
    return np.asarray(Image.fromarray(pixels).resize(size, Image.Resampling.LANCZOS))


def draw(scene: an.Scene | str, method: str = WARP, size: tuple[int, int] = HALF, samples: int = 3) -> np.ndarray:
    """A smooth image as pixels."""
    return to_pixels(an.render(scene, method=method, size=size, samples=samples).color)


def places(camera: an.Camera, size: tuple[int, int], **points: np.ndarray) -> dict[str, tuple[float, float]]:
    """Where points (3,) of the world are in the image."""
    rows = camera.image(np.array(list(points.values())), size)
    return {name: (float(x / w), float(y / w)) for name, (x, y, w) in zip(points, rows, strict=True)}
