"""Makes the images of threeray.md: `.venv/bin/python docs/make_threeray.py`, or those whose numbers are given."""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path

from figures import beside_teapot, three_rays
from figures.panels import Panel, save

IMAGES = Path(__file__).resolve().parent / "images" / "threeray"

FIGURES: dict[int, Callable[[], list[list[Panel]]]] = {
    1: beside_teapot.points,
    2: beside_teapot.environment,
    3: three_rays.glass,
    4: three_rays.sweeping,
    5: beside_teapot.over_environment,
    6: beside_teapot.six,
}
"""What makes each figure, by its number in the paper."""


def main() -> None:
    """Make all figures, or those whose numbers are given."""
    IMAGES.mkdir(parents=True, exist_ok=True)
    for number in [int(word) for word in sys.argv[1:]] or FIGURES:
        save(IMAGES / f"figure-{number}.webp", FIGURES[number]())


if __name__ == "__main__":
    main()
