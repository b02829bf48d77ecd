"""The viewer in a window of its own."""

from __future__ import annotations

import asyncio
import os
import signal
import sys
import warnings
from contextlib import suppress

from anamorph.base.errors import AnamorphError
from anamorph.viewer.fluency import MOST_IMAGES
from anamorph.viewer.starting import Start

SIZE = (1280, 720)
"""Of the window, logical pixels, where the screen has room for it."""

TITLE_BAR = 48
"""Logical pixels of the screen's height that are kept for it."""


def has_display() -> bool:
    """Whether a window could open."""
    if sys.platform.startswith("linux") and not (os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")):
        return False
    try:
        import glfw
    except (ImportError, OSError):
        return False
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return bool(glfw.init())


def open_window(start: Start, size: tuple[int, int] | None = None) -> None:
    """Show the viewer in a window, until that is closed.

    Parameters
    ----------
    start : Start
    size : (width, height), optional
        Of the window, logical pixels.

    Raises
    ------
    AnamorphError
        When there is no display, or the window does not open on it.
    """
    if not has_display():
        raise AnamorphError("--backend desktop: there is no display to open a window on; give --backend browser")
    from rendercanvas.glfw import GlfwRenderCanvas, loop

    from anamorph.viewer.application import Viewer

    canvas = GlfwRenderCanvas(size=size or _fitting(), max_fps=MOST_IMAGES, vsync=True)
    viewer = Viewer(canvas, start, loop.call_later)

    async def mind_interrupts() -> None:
        # The library's own handler would close the window in the midst of an image. Windows has no other.
        with suppress(NotImplementedError):
            for each in (signal.SIGINT, signal.SIGTERM):
                asyncio.get_running_loop().add_signal_handler(each, canvas.close)

    loop.add_task(mind_interrupts)
    loop.run()
    viewer.close()


def _fitting() -> tuple[int, int]:
    """`SIZE`, or what fits the screen."""
    import glfw

    monitor = glfw.get_primary_monitor()
    if not monitor:
        return SIZE
    _, _, width, height = glfw.get_monitor_workarea(monitor)
    # A Mac counts its screen in logical pixels, others in their own.
    ratio = 1.0 if sys.platform == "darwin" else glfw.get_monitor_content_scale(monitor)[0]
    return min(SIZE[0], int(width / ratio)), min(SIZE[1], int(height / ratio) - TITLE_BAR)
