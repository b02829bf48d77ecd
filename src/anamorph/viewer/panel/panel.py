"""All that the viewer draws with imgui: the panel, the status line, the help, and the legends over the image.

It shows a state and facts, and returns another state: nothing is kept here but what imgui keeps itself, which section
is folded and how far the panel is scrolled.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

from imgui_bundle import imgui

from anamorph.viewer.facts import Facts, Rectangle, Request
from anamorph.viewer.layout import PANEL_WIDTH, STATUS_HEIGHT, image_area
from anamorph.viewer.panel import theme
from anamorph.viewer.panel.help import draw_help
from anamorph.viewer.panel.legend import draw_divider, draw_legends
from anamorph.viewer.panel.methods import image_section, quality_section, space_section
from anamorph.viewer.panel.notice import draw_notice
from anamorph.viewer.panel.opening import opening_page, scene_button
from anamorph.viewer.panel.reflected import draw_numbers
from anamorph.viewer.panel.results import (
    figures_section,
    inspection_section,
    save_section,
    timing_section,
)
from anamorph.viewer.panel.scene import eye_section, scene_section
from anamorph.viewer.panel.sheet import Sheet, available, button, sign, text_width, to_column
from anamorph.viewer.panel.touch import scroll_by_finger
from anamorph.viewer.panel.views import views_section
from anamorph.viewer.panel.wording import size_text
from anamorph.viewer.state import EyeSide, State

FIXED = (
    imgui.WindowFlags_.no_title_bar
    | imgui.WindowFlags_.no_resize
    | imgui.WindowFlags_.no_move
    | imgui.WindowFlags_.no_saved_settings
    | imgui.WindowFlags_.no_bring_to_front_on_focus
)


SEPARATOR = "   ·   "
HELP = "F1 for help"


@dataclass(frozen=True)
class Drawn:
    """What came of drawing one frame.

    Parameters
    ----------
    state : State
        With what the user has just changed.
    requests : tuple of Request
        What the user has just asked for.
    rectangles : mapping of str to Rectangle
        Where each widget is, by its key; those scrolled out of the panel lie outside of the rectangle "panel/body".
    opens : str or None
        The scene that the user has just asked for: the name of a built-in one, or a path.
    covered : tuple of Rectangle
        Where the pointer belongs to imgui, and not to the image.
    typing : bool
        Whether keys belong to imgui, because a value is being typed.
    """

    state: State
    requests: tuple[Request, ...]
    rectangles: Mapping[str, Rectangle]
    opens: str | None
    covered: tuple[Rectangle, ...]
    typing: bool


def draw_panel(state: State, facts: Facts) -> Drawn:
    """Draw everything, within imgui's frame, and see what the user does with it.

    Parameters
    ----------
    state : State
    facts : Facts

    Returns
    -------
    Drawn
    """
    sheet = Sheet()
    shown = state
    area = image_area(facts.size, state.panel)
    draw_divider(sheet, state, area)
    state = _panel(sheet, state, facts) if state.panel else _panel_button(sheet, state)
    # The closed panel's button stands where a caption would begin.
    edge = area[0] if shown.panel else sheet.rectangles["panel/show"][2]
    lowest = draw_legends(sheet, shown, (edge, *area[1:]), area)
    _status_line(sheet, state, facts)
    draw_numbers(state, facts, area)
    # The help may need all the space there is; messages wait.
    if state.help:
        state = draw_help(sheet, state, facts.size)
    else:
        draw_notice(sheet, facts, (area[0], lowest, *area[2:]))
    typing = imgui.get_io().want_text_input
    opens = sheet.opens[-1] if sheet.opens else None
    return Drawn(state, tuple(sheet.requests), sheet.rectangles, opens, tuple(sheet.covered), typing)


def _panel(sheet: Sheet, state: State, facts: Facts) -> State:
    imgui.set_next_window_pos((0.0, 0.0))
    imgui.set_next_window_size((PANEL_WIDTH, facts.size[1] - STATUS_HEIGHT))
    imgui.begin("##panel", None, FIXED | imgui.WindowFlags_.no_scrollbar | imgui.WindowFlags_.no_scroll_with_mouse)
    sheet.cover_window("panel")
    side = imgui.get_frame_height()
    end = imgui.get_cursor_pos_x() + available()
    state = scene_button(sheet, state, facts, available() - 2.0 * side - 8.0)
    to_column(end - 2.0 * side - 2.0)
    if button(sheet, "help/show", "?", "Keys and gestures (F1)", side):
        state = replace(state, help=not state.help)
    to_column(end - side)
    if sign(sheet, "panel/hide", "hide", "Hide the panel (Tab)"):
        state = replace(state, panel=False)
    # The bar of the scroll lies in the window's own margin; it keeps its place when there is nothing to scroll.
    padding = imgui.get_style().window_padding.x
    body = "##body" if state.opening is None else "##opening"
    imgui.begin_child(body, (available() + padding, 0.0), 0, imgui.WindowFlags_.always_vertical_scrollbar)
    sheet.window("panel/body")
    state = _sections(sheet, state, facts) if state.opening is None else opening_page(sheet, state, facts)
    scroll_by_finger(sheet)
    imgui.end_child()
    imgui.end()
    return state


def _sections(sheet: Sheet, state: State, facts: Facts) -> State:
    state = image_section(sheet, state, facts)
    state = scene_section(sheet, state, facts)
    state = eye_section(sheet, state, facts)
    state = views_section(sheet, state)
    state = inspection_section(sheet, state, facts)
    figures_section(sheet, state, facts)
    state = space_section(sheet, state)
    state = quality_section(sheet, state)
    save_section(sheet, state, facts)
    timing_section(sheet, facts)
    return state


def _panel_button(sheet: Sheet, state: State) -> State:
    """What opens the panel again."""
    imgui.set_next_window_pos((0.0, 0.0))
    imgui.push_style_var(imgui.StyleVar_.window_padding, (4.0, 4.0))
    imgui.begin("##closed", None, FIXED | imgui.WindowFlags_.always_auto_resize)
    sheet.cover_window("panel")
    if sign(sheet, "panel/show", "show", "Show the panel (Tab)"):
        state = replace(state, panel=True)
    imgui.end()
    imgui.pop_style_var()
    return state


def _status_line(sheet: Sheet, state: State, facts: Facts) -> None:
    """One line at the bottom; what does not fit is left out, from the end."""
    width, height = facts.size
    imgui.set_next_window_pos((0.0, height - STATUS_HEIGHT))
    imgui.set_next_window_size((width, STATUS_HEIGHT))
    imgui.push_style_color(imgui.Col_.window_bg, theme.BAR)
    imgui.push_style_var(imgui.StyleVar_.window_padding, (10.0, 4.0))
    imgui.begin("##status", None, FIXED | imgui.WindowFlags_.no_scrollbar)
    sheet.cover_window("status")
    words = [size_text(facts.image)] if all(facts.image) else []
    if all(facts.image) and facts.samples_total > 1:
        words.append(f"{facts.samples_done} of {facts.samples_total} samples")
    if facts.frame_ms:
        words.append(f"{facts.frame_ms:.0f} ms, {1000.0 / facts.frame_ms:.0f} images a second")
    words += ["searching reflection points"] if facts.searching else []
    words += ["from outside"] if state.observer is not None else []
    words += [f"{state.eye} eye"] if state.eye is not EyeSide.MIDDLE else []
    words += [f"{len(state.views)} view{'s' * (len(state.views) > 1)} remembered"] if state.views else []
    while len(words) > 1 and text_width(SEPARATOR.join(words)) > available() - text_width(HELP) - 20.0:
        words.pop()
    imgui.text_colored(theme.FAINT, SEPARATOR.join(words))
    to_column(width - 10.0 - text_width(HELP))
    imgui.text_colored(theme.FAINT, HELP)
    imgui.end()
    imgui.pop_style_var()
    imgui.pop_style_color()
