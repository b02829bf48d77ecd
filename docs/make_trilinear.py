"""Makes images and table of trilinear.md: `.venv/bin/python docs/make_trilinear.py`, or those of some figures."""

from __future__ import annotations

import sys
from collections.abc import Callable
from functools import partial
from pathlib import Path

from figures import curves, nonlinear, ray_triangle
from figures.comparing import Drawn
from figures.configurations import FIGURES as CONFIGURATIONS
from figures.panels import save

from anamorph.base.output import whole_file

PAGE = Path(__file__).resolve().parent / "trilinear.md"
IMAGES = PAGE.parent / "images" / "trilinear"

FIGURES: dict[str, Callable[[], Drawn]] = {
    "3.2": ray_triangle.parametric,
    **{figure: partial(curves.configuration, figure) for figure in CONFIGURATIONS},
    "4.8": curves.straight_error,
    "4.9": partial(curves.finer, "4.9"),
    "4.10": partial(curves.finer, "4.10"),
    "5.1": curves.discontinuity,
    "6.4": nonlinear.perspective,
    "6.7": nonlinear.two_views,
    "6.9": nonlinear.mapping,
    "7.4": nonlinear.on_a_sphere,
    "7.5": nonlinear.wavy,
    "7.6": nonlinear.refracted,
}
"""What makes each figure, by its number in the thesis; Figure 6.3 is in the image of 6.4."""


def image(figure: str) -> Path:
    """Where a figure is kept."""
    chapter, place = figure.split(".")
    return IMAGES / f"figure-{chapter}-{int(place):02}.webp"


def renewed(page: str, rows: list[str]) -> str:
    """The page with those rows of its table whose first cells are those of `rows` replaced."""
    new = {row.split("|")[1]: row for row in rows}
    lines = [new.pop(line.split("|")[1], line) if line.startswith("| ") else line for line in page.split("\n")]
    if new:
        raise SystemExit(f"{PAGE.name} has no row for {', '.join(key.strip() for key in new)}; write one")
    return "\n".join(lines)


def main() -> None:
    """Make all figures, or those whose numbers are given."""
    IMAGES.mkdir(parents=True, exist_ok=True)
    table: list[str] = []
    for figure in sys.argv[1:] or FIGURES:
        panels, rows = FIGURES[figure]()
        save(image(figure), panels)
        table += rows
    page = renewed(PAGE.read_text(), table)
    with whole_file(PAGE) as file:
        file.write(page.encode())


if __name__ == "__main__":
    main()
