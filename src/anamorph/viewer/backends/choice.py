"""Where the viewer is shown: in a window, a page or a notebook; one application in all of them."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import Any

from anamorph.files.opening import open_scene
from anamorph.scene.camera import Camera
from anamorph.scene.model import Scene
from anamorph.viewer.backends.desktop import SIZE, has_display, open_window
from anamorph.viewer.backends.notebook import in_notebook, make_widget
from anamorph.viewer.starting import Start, start_of


def show(start: Start, backend: str = "auto", port: int = 0, size: tuple[int, int] | None = None) -> None:
    """Show a scene, until the window is closed or the process interrupted.

    Parameters
    ----------
    start : Start
    backend : str
        "desktop", "browser", or "auto": a window where one can open, else a page.
    port : int
        Of the page; 0 for any that is free.
    size : (width, height), optional
        Of the window, logical pixels.
    """
    if backend == "desktop" or (backend == "auto" and has_display()):
        open_window(start, size)
    else:
        from anamorph.viewer.backends.browser import serve

        serve(start, port, size or SIZE, _print_link)


def view(
    scene: str | Path | Scene,
    method: str | None = None,
    size: tuple[int, int] = (800, 600),
    camera: Camera | None = None,
) -> Any:
    """Look at a scene: turn it, and see how true the image is.

    Parameters
    ----------
    scene : str, Path or Scene
        The name of a built-in scene, a scene file, a model, or a scene made in Python.
    method : str, optional
        A method's name with its options, such as "pervertex:antialias=4".
    size : (width, height)
        Of the widget or the window, logical pixels.
    camera : Camera, optional
        The eye; by default the scene's own.

    Returns
    -------
    widget or None
        In a notebook, what shows itself as the output of a cell. Elsewhere the viewer opens in a window, or as a page
        where there is no display, and this returns when it has been closed.
    """
    if camera is not None:
        scene = dataclasses.replace(scene if isinstance(scene, Scene) else open_scene(scene)[0], camera=camera)
    start = start_of(scene, method)
    if in_notebook():
        return make_widget(start, size)
    return show(start, size=size)


def _print_link(link: str) -> None:
    print(f"The viewer is at {link} (this link is good for one browser; Ctrl-C ends the viewer)", flush=True)
