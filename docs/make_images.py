"""Makes the images of the README and these pages: `.venv/bin/python docs/make_images.py`."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw, ImageFont

import anamorph as an
from anamorph.base.output import to_pixels, whole_file
from anamorph.cli import demo
from anamorph.measure.errors import measure
from anamorph.measure.heatmap import MILLIRADIANS, heat_map, scale_colors

IMAGES = Path(__file__).resolve().parent / "images"

SHOWN = {
    **{f"car-mirror-{name}": ("car-mirror", *drawn) for name, drawn in demo.IMAGES.items()},
    "car-mirror-overlay": ("car-mirror", "pervertex:map=image,antialias=4,overlay=mesh", 1),
    "flat-mirror-pervertex": ("flat-mirror", "pervertex:antialias=4", 1),
    "room-pervertex": ("room", "pervertex:antialias=4", 1),
    "room-raytrace": ("room", "raytrace", 3),
}
"""Scene, method and samples of each image."""

STATUS_COLORS = {
    an.Status.DIRECT: (235, 235, 230),
    an.Status.PROVED: (33, 145, 140),
    an.Status.DOUBTFUL: (240, 175, 40),
    an.Status.SKY: (130, 175, 230),
    an.Status.OUTSIDE: (215, 60, 40),
}


def save(name: str, pixels: np.ndarray) -> None:
    """Write 8-bit pixels as a small JPEG in `IMAGES`."""
    with whole_file(IMAGES / f"{name}.jpg") as file:
        Image.fromarray(pixels).save(file, "JPEG", quality=86, optimize=True)
    print(IMAGES / f"{name}.jpg")


def error_map(method: str) -> np.ndarray:
    """Angular errors of `method` in car-mirror, as in the page that `anamorph compare --html` writes."""
    reference = an.render("car-mirror", method="raytrace", size=demo.SIZE, seen=True)
    frame = an.render("car-mirror", method=method, size=demo.SIZE, seen=True)
    return heat_map(measure(reference, frame).maps, reference.color)


def scale() -> np.ndarray:
    """The colours of the error maps, with their milliradians."""
    width, height, margin = 640, 24, 48
    image = Image.new("RGB", (width + 2 * margin, 64), "white")
    ticks = MILLIRADIANS.ticks
    errors = np.geomspace(ticks[0], ticks[-1], width)
    image.paste(Image.fromarray(np.tile(scale_colors(errors), (height, 1, 1))), (margin, 4))
    draw = ImageDraw.Draw(image)
    for index, tick in enumerate(ticks):
        place = margin + index * width / (len(ticks) - 1)
        unit = " mrad" if index == len(ticks) - 1 else ""
        draw.text((place, 34), f"{tick:g}{unit}", "black", ImageFont.load_default(18), "mt")
    return np.asarray(image)


def status_map() -> np.ndarray:
    """How each pixel of the room got its value."""
    status = an.render("room", method="pervertex", size=demo.SIZE, seen=True).status
    assert status is not None
    palette = np.zeros((256, 3), np.uint8)
    for value, color in STATUS_COLORS.items():
        palette[value] = color
    return palette[status]


def main() -> None:
    """Make them all."""
    IMAGES.mkdir(exist_ok=True)
    for name, (scene, method, samples) in SHOWN.items():
        save(name, to_pixels(an.render(scene, method=method, size=demo.SIZE, samples=samples).color))
    for method in ("pervertex", "environment"):
        save(f"car-mirror-{method}-error", error_map(method))
    save("error-scale", scale())
    save("room-pervertex-status", status_map())


if __name__ == "__main__":
    main()
