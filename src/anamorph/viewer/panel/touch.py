"""What fingers do on the panel beside what pointers do: scroll it, and open a slider for typing."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from imgui_bundle import imgui

from anamorph.viewer.panel.sheet import Sheet

LEFT = 0
"""The button that a finger is."""


def by_finger() -> bool:
    """Whether a finger was what last touched the canvas."""
    return imgui.get_io().mouse_source == imgui.MouseSource.touch_screen


def scroll_by_finger(sheet: Sheet) -> None:
    """Scroll the current window as a finger goes that came down on it, but on nothing that is dragged itself."""
    if not (by_finger() and imgui.is_mouse_dragging(LEFT) and imgui.is_window_focused()) or sheet.dragged:
        return
    now, gone = imgui.get_mouse_pos(), imgui.get_mouse_drag_delta(LEFT, 0.0)
    place, size = imgui.get_window_pos(), imgui.get_window_size()
    right, down = now.x - gone.x - place.x, now.y - gone.y - place.y
    if 0.0 <= right < size.x - imgui.get_style().scrollbar_size and 0.0 <= down < size.y:
        # Or what lies where the finger came down would be pressed when it is lifted.
        imgui.internal.clear_active_id()
        imgui.set_scroll_y(imgui.get_scroll_y() - imgui.get_io().mouse_delta.y)


@contextmanager
def typing_by_double_tap() -> Iterator[None]:
    """Have imgui take a double tap on what is drawn meanwhile for a click with Ctrl, which opens it for typing."""
    io = imgui.get_io()
    held = io.key_ctrl
    io.key_ctrl = held or (by_finger() and imgui.is_mouse_double_clicked(LEFT))
    try:
        yield
    finally:
        io.key_ctrl = held
