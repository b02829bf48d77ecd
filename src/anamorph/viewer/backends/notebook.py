"""The viewer as the output of a notebook's cell."""

from __future__ import annotations

import sys
from typing import Any

from anamorph.base.errors import AnamorphError
from anamorph.gpu.device import get_device
from anamorph.viewer.application import Later, Viewer
from anamorph.viewer.fluency import MOST_IMAGES
from anamorph.viewer.starting import Start


def in_notebook() -> bool:
    """Whether this Python is a notebook's kernel: Jupyter's, or marimo's."""
    shell, marimo = sys.modules.get("IPython"), sys.modules.get("marimo")
    if shell is not None and getattr(shell.get_ipython(), "kernel", None) is not None:
        return True
    return marimo is not None and marimo.running_in_notebook()


def make_widget(start: Start, size: tuple[int, int]) -> Any:
    """The viewer as a widget, which shows itself as the last value of a cell.

    Parameters
    ----------
    start : Start
    size : (width, height)
        Logical pixels.

    Raises
    ------
    AnamorphError
        When the library of the widget is not installed.
    """
    try:
        from rendercanvas.anywidget import loop

        from anamorph.viewer.backends.widget import Widget
    except ImportError as error:
        raise AnamorphError("the viewer in a notebook needs anywidget; pip install 'anamorph[notebook]'") from error
    # Where there is none, the cell says so.
    get_device()
    canvas = Widget(size=size, max_fps=MOST_IMAGES, vsync=False)
    canvas.follow_views(_WidgetViewer(canvas, start, loop.call_later).follow)
    return canvas


class _WidgetViewer:
    """The viewer of a widget while somebody sees it, and in between what it takes to go on.

    Python keeps every widget: also those whose cell was run again, and those that were never shown.
    """

    def __init__(self, canvas: Any, start: Start, later: Later) -> None:
        self._canvas, self._later = canvas, later
        self._start, self._state = start, start.state
        self._viewer: Viewer | None = None

    def follow(self, views: int) -> None:
        """Begin with the first view on the widget, and end with the last."""
        if self._canvas.get_closed():
            return
        if views > 0 and self._viewer is None:
            self._viewer = Viewer(self._canvas, self._start, self._later)
            self._viewer.state = self._state
        elif views == 0 and self._viewer is not None:
            self._start, self._state = self._viewer.start, self._viewer.state
            self._viewer.close()
            self._viewer = None
            # The canvas keeps what draws it, and textures to draw into.
            self._canvas.request_draw(lambda: None)
            self._canvas.get_wgpu_context().unconfigure()
