"""Makes the images of surface-cameras.md: `.venv/bin/python docs/make_surface_cameras.py`, or those that are named.

With the word `tables` it measures, and prints the rows of the page's tables.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path

from figures import inward_looking, inward_measured, ray_surfaces
from figures.panels import Panel, save

IMAGES = Path(__file__).resolve().parent / "images" / "surface-cameras"

FIGURES: dict[str, Callable[[], list[list[Panel]]]] = {
    "f-03-04": ray_surfaces.strips,
    "f-05-06": ray_surfaces.columns,
    "f-09-11": ray_surfaces.cube_world,
    "f-12-14": ray_surfaces.amounts,
    "street": ray_surfaces.street,
    "g-01-02": inward_looking.volumes,
    "g-03-04": inward_looking.cubes,
    "g-05": inward_looking.mirror_rays,
    "g-06-08": inward_looking.environment_maps,
    "g-09": inward_looking.around_a_cube,
}
"""What makes each image, by the appendix and its figures."""


def main() -> None:
    """Make all images, or those that are named."""
    if sys.argv[1:] == ["tables"]:
        print(*inward_measured.rows(), sep="\n")
        return
    IMAGES.mkdir(parents=True, exist_ok=True)
    for name in sys.argv[1:] or FIGURES:
        save(IMAGES / f"{name}.webp", FIGURES[name]())


if __name__ == "__main__":
    main()
