"""What the viewer saves, each under a name that is free; every function says in a word what it has done."""

from __future__ import annotations

import re
from collections.abc import Generator, Sequence
from dataclasses import replace
from itertools import count
from pathlib import Path

import numpy as np

from anamorph.base import output
from anamorph.files.view_file import Opened, save_view
from anamorph.gpu.drawing import wait
from anamorph.measure.compare import comparison_steps
from anamorph.measure.page import comparison_page
from anamorph.methods import Specification
from anamorph.scene.checks import check_scene
from anamorph.scene.model import Scene
from anamorph.viewer.controls import edited, part_edits
from anamorph.viewer.facts import Progress
from anamorph.viewer.state import State
from anamorph.viewer.view_table import view_of

Saving = Generator[Progress, None, str]
"""Long work that tells how far it is, and in the end what it has saved. Closed before, it leaves nothing behind."""


def free_name(directory: str | Path, stem: str, suffix: str) -> Path:
    """The first of STEM-1, STEM-2, ... that nothing in the directory is called; `stem` may be any text."""
    plain = re.sub(r"[^\w.]+", "-", stem).strip("-.") or "view"
    names = (Path(directory) / f"{plain}-{number}{suffix}" for number in count(1))
    return next(path for path in names if not path.exists() and not path.is_symlink())


def save_image(path: str | Path, pixels: np.ndarray) -> str:
    """Save an image as it is shown, (H, W, 3) uint8 sRGB, as PNG."""
    path = output.check_output(path, (".png",))
    with output.whole_file(path) as file:
        file.write(output.pixel_bytes(np.ascontiguousarray(pixels)))
    return saved(path)


def save_scene(path: str | Path, opened: Opened, state: State, size: tuple[int, int]) -> str:
    """Save a scene file that opens the same view.

    Parameters
    ----------
    path : str or Path
        Ends in .toml.
    opened : Opened
        As the viewer began.
    state : State
    size : (width, height)
        Of the image, pixels.

    Raises
    ------
    AnamorphError
        Also where the file could be written but not opened, as with the eye behind its mirror.
    """
    check_scene(replace(edited(opened.scene, state.values), camera=state.camera))
    edits = part_edits(opened.scene, state.values)
    save_view(path, opened, state.camera, size, str(state.first.method), edits, view_of(state))
    return saved(path)


def save_comparison(
    path: str | Path, scene: Scene, methods: Sequence[Specification], size: tuple[int, int], command: str = ""
) -> Saving:
    """Save a page that compares methods with the reference, as the scene's own camera sees it."""
    path = output.check_output(path, (".html",))
    # The page is about one eye, and is refused at once where that one sees nothing.
    steps = comparison_steps(check_scene(scene), methods, size, command=command)
    while True:
        # What the viewer has drawn meanwhile must not count as a method's time.
        wait()
        try:
            done, total, what = next(steps)
        except StopIteration as end:
            comparison = end.value
            break
        yield Progress(what, done, total)
    yield Progress("writing the page", total, total)
    output.save_text(path, comparison_page(comparison))
    return saved(path)


def saved(path: str | Path) -> str:
    """What to tell of a file that is there now."""
    return f"saved {Path(path).name}"
