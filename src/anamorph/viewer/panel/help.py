"""The help over the image: every key and gesture."""

from __future__ import annotations

from dataclasses import replace
from itertools import groupby

from imgui_bundle import imgui

from anamorph.viewer.gestures import GESTURES
from anamorph.viewer.layout import STATUS_HEIGHT
from anamorph.viewer.panel import theme
from anamorph.viewer.panel.sheet import Sheet, available, caption, sign, text_width, to_column, wrapped
from anamorph.viewer.shortcuts import SHORTCUTS
from anamorph.viewer.state import State

WIDEST = 620.0
COLUMN = 270.0
"""A list narrower than this is not set beside another."""


def draw_help(sheet: Sheet, state: State, size: tuple[int, int]) -> State:
    """The help, in the middle of a canvas of `size`; the state without it when it is closed."""
    width, height = size
    imgui.set_next_window_pos((width / 2.0, height / 2.0), imgui.Cond_.always, (0.5, 0.5))
    wide = min(WIDEST, width - 2.0 * theme.MARGIN)
    highest = height - 2.0 * (STATUS_HEIGHT + theme.MARGIN)
    imgui.set_next_window_size_constraints((wide, 0.0), (wide, highest))
    flags = imgui.WindowFlags_.no_decoration & ~imgui.WindowFlags_.no_scrollbar | imgui.WindowFlags_.no_move
    flags |= imgui.WindowFlags_.always_auto_resize | imgui.WindowFlags_.no_saved_settings
    imgui.push_style_color(imgui.Col_.window_bg, theme.BAR)
    imgui.begin("##help", None, flags)
    end = imgui.get_cursor_pos_x() + available()
    imgui.align_text_to_frame_padding()
    imgui.text_unformatted("Keys and gestures")
    to_column(end - imgui.get_frame_height())
    if sign(sheet, "help/close", "close", "Close the help (Esc)"):
        state = replace(state, help=False)
    imgui.separator()
    columns = 2 if available() >= 2.0 * COLUMN else 1
    groups = groupby(SHORTCUTS, lambda each: each.group)
    lists = [(group, [(" or ".join(each.keys), each.summary) for each in members]) for group, members in groups]
    lists.append(("Mouse and fingers", list(GESTURES)))
    if imgui.begin_table("##lists", columns, imgui.TableFlags_.sizing_stretch_same):
        for number in range(columns):
            imgui.table_next_column()
            for group, rows in _shared(lists, columns)[number]:
                _list(group, rows)
        imgui.end_table()
    # Above the panel, whichever was pressed last.
    imgui.internal.bring_window_to_display_front(imgui.internal.get_current_window())
    sheet.cover_window("help")
    imgui.end()
    imgui.pop_style_color()
    return state


Rows = list[tuple[str, str]]


def _shared(lists: list[tuple[str, Rows]], columns: int) -> list[list[tuple[str, Rows]]]:
    """The lists dealt out, in order, to columns of about the same height."""
    lengths = [len(rows) + 1 for _, rows in lists]
    dealt: list[list[tuple[str, Rows]]] = [[] for _ in range(columns)]
    for number, each in enumerate(lists):
        before = sum(lengths[:number]) + lengths[number] / 2.0
        dealt[min(int(before / sum(lengths) * columns), columns - 1)].append(each)
    return dealt


def _list(group: str, rows: Rows) -> None:
    caption(group)
    left = imgui.get_cursor_pos_x()
    across = min(max(text_width(keys) for keys, _ in rows) + 14.0, 0.55 * available())
    for keys, summary in rows:
        imgui.text_colored(theme.ACCENT, keys)
        to_column(left + across)
        wrapped(summary)
    imgui.dummy((0.0, 4.0))
