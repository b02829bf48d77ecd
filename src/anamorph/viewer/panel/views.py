"""The panel's section on remembered views."""

from __future__ import annotations

from dataclasses import replace

from imgui_bundle import imgui

from anamorph.viewer.panel import theme
from anamorph.viewer.panel.sheet import Sheet, button, caption, field_width, section, shortened, sign
from anamorph.viewer.panel.wording import point_text
from anamorph.viewer.remembered import forget, go_to, remember
from anamorph.viewer.state import State, shown_camera

NONE_YET = "None yet. They are kept to come back to, and for a video that goes through them."


def views_section(sheet: Sheet, state: State) -> State:
    """The remembered views: what is shown becomes one, and each can be shown again or forgotten."""
    if not section(sheet, "section/views", "Views", opened=False):
        return state
    views, shown, width = state.views, shown_camera(state), field_width()
    caption(f"Remembered: {len(views)}. Press one to go there." if views else NONE_YET)
    for number, view in enumerate(views):
        imgui.push_style_color(imgui.Col_.button, theme.FILL if view == shown else theme.FIELD)
        text = shortened(f"{number + 1}:  {point_text(view.position)} m", width - 12.0)
        if button(sheet, f"views/{number}", text, "Show it again; it was taken from this place", width):
            state = go_to(state, number)
        imgui.pop_style_color()
        imgui.same_line(0.0, 2.0)
        if sign(sheet, f"views/{number}/forget", "close", "Forget this view"):
            state = forget(state, number)
    half = (width - 6.0) / 2.0
    if button(sheet, "views/remember", "Remember", "What is shown now becomes the last of the views (K)", half):
        state = remember(state)
    imgui.same_line(0.0, 6.0)
    imgui.begin_disabled(not views)
    if button(sheet, "views/clear", "Forget all", "Forget all of these views", half):
        state = replace(state, views=())
    imgui.end_disabled()
    return state
