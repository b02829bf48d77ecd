"""What is said above all else: a message, and how far something long has come."""

from __future__ import annotations

from imgui_bundle import imgui

from anamorph.viewer.facts import Facts, Rectangle, Request
from anamorph.viewer.panel import theme
from anamorph.viewer.panel.sheet import Sheet, available, button, sign, to_column, wrapped

WIDEST = 460.0
LEGEND = 240.0
"""What is left for the scales below."""


def draw_notice(sheet: Sheet, facts: Facts, free: Rectangle) -> None:
    """Message and progress at the top of what is free of the panel, if there is any."""
    if not facts.message and facts.progress is None:
        return
    left, top, right, bottom = free
    width = min(WIDEST, right - left - 2.0 * theme.MARGIN)
    imgui.set_next_window_pos(((left + right) / 2.0, top + theme.MARGIN), imgui.Cond_.always, (0.5, 0.0))
    highest = max(min(0.5 * (bottom - top), bottom - top - LEGEND), 60.0)
    imgui.set_next_window_size_constraints((width, 0.0), (width, highest))
    flags = imgui.WindowFlags_.no_title_bar | imgui.WindowFlags_.no_resize | imgui.WindowFlags_.no_move
    flags |= imgui.WindowFlags_.always_auto_resize | imgui.WindowFlags_.no_saved_settings
    flags |= imgui.WindowFlags_.no_focus_on_appearing
    imgui.push_style_color(imgui.Col_.window_bg, theme.BAR)
    imgui.begin("##notice", None, flags)
    if facts.message:
        side, end = imgui.get_frame_height(), imgui.get_cursor_pos_x() + available()
        imgui.begin_group()
        imgui.align_text_to_frame_padding()
        wrapped(facts.message, theme.TEXT, margin=side + 6.0)
        imgui.end_group()
        to_column(end - side)
        if sign(sheet, "message/close", "close", "Dismiss"):
            sheet.requests.append(Request.DISMISS)
    if facts.progress is not None:
        progress = facts.progress
        wrapped(progress.what)
        share = progress.done / progress.total if progress.total else 0.0
        across = available() - imgui.calc_text_size("Cancel").x - 2.0 * 6.0 - 6.0
        imgui.progress_bar(share, (across, 0.0), f"{progress.done} of {progress.total}")
        sheet.note("progress")
        imgui.same_line(0.0, 6.0)
        if button(sheet, "cancel", "Cancel"):
            sheet.requests.append(Request.CANCEL)
    sheet.cover_window("notice")
    imgui.end()
    imgui.pop_style_color()
