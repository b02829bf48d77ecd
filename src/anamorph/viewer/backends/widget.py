"""The canvas in a notebook: the library's widget, on one thread, with fingers, and with an end."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from functools import partial
from importlib.resources import files
from typing import Any

from anywidget import AnyWidget
from rendercanvas.anywidget import JS, AnywidgetRenderCanvas
from traitlets import Int


def _script(name: str) -> str:
    return "\n" + files(__package__).joinpath(name).read_text()


class Widget(AnywidgetRenderCanvas):
    """A widget that tells how many views there are on it, and draws where it was made.

    JupyterLab has a thread of its own for what a page says, whereas imgui may be called by one alone.
    """

    _esm = JS + _script("input.js") + _script("notebook.js")
    _views = Int(0).tag(sync=True)

    def __init__(self, **options: Any) -> None:
        self._loop = asyncio.get_running_loop()
        super().__init__(**options)

    def follow_views(self, act: Callable[[int], object]) -> None:
        """Have `act` called with the number of views, whenever it has changed."""
        self.observe(lambda change: self._loop.call_soon_threadsafe(act, change["new"]), "_views")

    def _rfb_handle_msg(self, widget: Any, content: dict[str, Any], buffers: list[bytes]) -> None:
        self._loop.call_soon_threadsafe(partial(super()._rfb_handle_msg, widget, content, buffers))

    def _rfb_schedule_maybe_draw(self, *changes: Any) -> None:
        self._loop.call_soon_threadsafe(self._rfb_maybe_draw)

    def _rc_close(self) -> None:
        # The library's closes again without end.
        if not self.get_closed():
            self._is_closed = True
            AnyWidget.close(self)

    def _rc_set_title(self, title: str) -> None:
        # The library's brings up a bar for it.
        pass
