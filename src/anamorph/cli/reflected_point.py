"""The command `anamorph reflections`: where the mirrors of a scene show a point."""

from __future__ import annotations

from pathlib import Path

from rich.table import Table

from anamorph.base.output import PIXELS, check_output, pixel_bytes, whole_file
from anamorph.base.progress import progress_bar
from anamorph.base.vectors import Vector
from anamorph.files.opening import open_source
from anamorph.files.source import Source
from anamorph.frame import View
from anamorph.measure.table import headed
from anamorph.methods import Specification
from anamorph.rendering import draw_frame
from anamorph.scene.model import Scene
from anamorph.viewer.facts import Reflections
from anamorph.viewer.marked_image import marked_image
from anamorph.viewer.panel.reflected import KNOWN, seen_text
from anamorph.viewer.point_search import reflections_of


def point_table(
    source: Source,
    point: Vector,
    output: Path | None = None,
    method: Specification | None = None,
    size: tuple[int, int] | None = None,
) -> Table:
    """A table of the reflection points of a point; they are also marked in an image, where there is an `output`.

    Other parameters as for `reflections_of`, `draw_frame` and `open_source`.
    """
    if output is not None:
        check_output(output, PIXELS)
    with progress_bar(f"opening {source.name}") as report:
        scene, settings = open_source(source)
        size = size or settings.size
        report(0, 2, "searching")
        reflections = reflections_of(scene, scene.camera, size, point)
        if output is not None:
            report(1, 2, "drawing")
            _save(output, scene, method or Specification.parse(settings.method), size, reflections)
    return _table(scene, size, reflections)


def _save(output: Path, scene: Scene, method: Specification, size: tuple[int, int], reflections: Reflections) -> None:
    color = draw_frame(View(scene, scene.camera, size), method).color
    pixels = marked_image(color, scene.camera, reflections)
    with whole_file(output) as file:
        file.write(pixel_bytes(pixels, output.suffix))


def _table(scene: Scene, size: tuple[int, int], reflections: Reflections) -> Table:
    width, height = size
    title = f"{scene.name}, {width} x {height}"
    table = headed(title, KNOWN[reflections.status], "", "mirror", "is seen", "x, px", "y, px", "path, m", words=3)
    for number, each in enumerate(reflections.found, start=1):
        x, y = ("behind", "the eye") if each.pixel is None else (f"{value:.2f}" for value in each.pixel)
        table.add_row(str(number), each.name, seen_text(each), x, y, f"{each.length:.4f}")
    return table
