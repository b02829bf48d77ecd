"""Makes the images of virtual.md: `.venv/bin/python docs/make_virtual.py`, or those whose numbers are given."""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path

from figures import kitchen_views, vector_field
from figures.panels import Panel, save

IMAGES = Path(__file__).resolve().parent / "images" / "virtual"

FIGURES: dict[int, Callable[[], list[list[Panel]]]] = {
    4: vector_field.field,
    6: kitchen_views.ways,
    7: kitchen_views.shares,
    8: kitchen_views.steps,
    9: kitchen_views.reflectors,
    10: kitchen_views.parts,
}
"""What makes each figure, by its number in the paper; 9 and 10 are ours."""


def main() -> None:
    """Make all figures, or those whose numbers are given."""
    IMAGES.mkdir(parents=True, exist_ok=True)
    for number in [int(word) for word in sys.argv[1:]] or FIGURES:
        save(IMAGES / f"figure-{number}.webp", FIGURES[number]())


if __name__ == "__main__":
    main()
