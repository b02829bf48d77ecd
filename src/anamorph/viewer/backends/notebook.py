"""The viewer as the output of a notebook's cell."""

from __future__ import annotations

import sys
from typing import Any

from anamorph.errors import AnamorphError
from anamorph.viewer.fluency import MOST_PICTURES
from anamorph.viewer.starting import Start


def in_notebook() -> bool:
    """Whether this Python is a notebook's kernel."""
    shell = sys.modules.get("IPython")
    return shell is not None and getattr(shell.get_ipython(), "kernel", None) is not None


def make_widget(beginning: Start, size: tuple[int, int]) -> Any:
    """The viewer as a widget, which shows itself as the last value of a cell.

    Parameters
    ----------
    beginning : Start
    size : (width, height)
        Logical pixels.

    Raises
    ------
    AnamorphError
        When the library of the widget is not installed.
    """
    try:
        from anywidget import AnyWidget
        from rendercanvas.anywidget import AnywidgetRenderCanvas, loop
    except ImportError as error:
        raise AnamorphError("the viewer in a notebook needs anywidget; pip install 'anamorph[notebook]'") from error
    from anamorph.viewer.application import Viewer

    class Widget(AnywidgetRenderCanvas):
        """The library's, whose closing closes it again without end, and which sets a title in a bar of its own."""

        def _rc_close(self) -> None:
            if not self.get_closed():
                self._is_closed = True
                AnyWidget.close(self)

        def _rc_set_title(self, title: str) -> None:
            pass

    canvas = Widget(size=size, max_fps=MOST_PICTURES, vsync=False)
    # The canvas keeps it: it draws and handles the events.
    Viewer(canvas, beginning, loop.call_later)
    return canvas
