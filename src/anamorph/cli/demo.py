"""The demonstration: one scene by three methods, as images, a table and a page."""

from __future__ import annotations

from pathlib import Path

from anamorph.base.output import save_text
from anamorph.base.progress import Report
from anamorph.files.opening import open_scene
from anamorph.files.scene_file import DEFAULT_SIZE
from anamorph.frame import View
from anamorph.measure.compare import Comparison, compare
from anamorph.measure.page import comparison_page
from anamorph.methods import Specification
from anamorph.rendering import draw_frame

SCENE = "car-mirror"
SIZE = DEFAULT_SIZE
IMAGES = {
    "pervertex": ("pervertex:antialias=4", 1),
    "environment": ("environment:antialias=4", 2),
    "raytrace": ("raytrace", 3),
}
"""The methods that are measured, at one sample a pixel, and how each is best drawn: its options, and samples a side."""


def make_demo(directory: Path, command: str, report: Report) -> Comparison:
    """Compare the methods and write `index.html` and a PNG of each into `directory`, which is made if need be."""
    directory.mkdir(parents=True, exist_ok=True)
    report(0, 1, f"making the scene {SCENE}")
    scene, _ = open_scene(SCENE)
    comparison = compare(scene, tuple(IMAGES), SIZE, command=command, report=report)
    for step, (name, (specification, samples)) in enumerate(IMAGES.items()):
        report(step, len(IMAGES), f"smooth image by {name}")
        view = View(scene, scene.camera, SIZE, samples)
        draw_frame(view, Specification.parse(specification)).save(directory / f"{SCENE}-{name}.png")
    save_text(directory / "comparison.json", comparison.to_json())
    save_text(directory / "index.html", comparison_page(comparison))
    return comparison
