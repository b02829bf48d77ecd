"""The demonstration: one scene by three methods, as pictures, a table and a page."""

from __future__ import annotations

from pathlib import Path

from anamorph.measure.compare import Comparison, compare
from anamorph.measure.report import report_page
from anamorph.output import save_picture, save_text
from anamorph.progress import Tell
from anamorph.scene.opening import open_scene

SCENE = "car-mirror"
SPECS = ("pervertex", "environment", "raytrace")
SIZE = (1024, 768)


def make_demo(directory: Path, command: str, progress: Tell) -> Comparison:
    """Compare the methods and write `index.html` and a PNG of each into `directory`, which is made if need be."""
    directory.mkdir(parents=True, exist_ok=True)
    progress(0, 1, f"making the scene {SCENE}")
    scene, _ = open_scene(SCENE)
    comparison = compare(scene, SPECS, SIZE, command=command, progress=progress)
    for result in comparison.methods:
        save_picture(directory / f"{SCENE}-{result.name}.png", result.frame.color)
    save_text(directory / "comparison.json", comparison.to_json())
    save_text(directory / "index.html", report_page(comparison))
    return comparison
