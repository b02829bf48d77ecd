"""Makes the images of pvrr.md: `.venv/bin/python docs/make_pvrr.py`, or those whose numbers are given."""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path

from figures import diagrams, mirrors, refraction
from figures.panels import Panel, save

IMAGES = Path(__file__).resolve().parent / "images" / "pvrr"

FIGURES: dict[int, Callable[[], list[list[Panel]]]] = {
    3: diagrams.viewpoint,
    4: diagrams.view_volume,
    5: mirrors.cad,
    6: mirrors.subdivision,
    7: mirrors.continuity_of_two,
    8: diagrams.regions,
    9: mirrors.curvature,
    10: mirrors.alignment,
    11: mirrors.two_bounces,
    12: refraction.spectacles,
    13: refraction.reversed_image,
    14: refraction.overlay,
    15: refraction.dispersion,
    16: mirrors.occlusion,
}
"""What makes each figure, by its number in the paper."""


def main() -> None:
    """Make all figures, or those whose numbers are given."""
    IMAGES.mkdir(parents=True, exist_ok=True)
    for number in [int(word) for word in sys.argv[1:]] or FIGURES:
        rows = FIGURES[number]()
        if rows:
            save(IMAGES / f"figure-{number:02}.webp", rows)


if __name__ == "__main__":
    main()
