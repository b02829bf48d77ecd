"""What opens another scene: this one's name at the panel's top; under it, a path to type and the built-in scenes."""

from __future__ import annotations

from dataclasses import replace

from imgui_bundle import imgui

from anamorph.gallery import SCENES
from anamorph.viewer.facts import Facts
from anamorph.viewer.panel import theme
from anamorph.viewer.panel.sheet import Sheet, button, caption, field_width, shortened, tip
from anamorph.viewer.state import State

LONGEST_NAME = 300
"""Letters of a scene's name that are told at all."""

OPTIONS = "A CAD file takes the options of the command line: mirror.step --scene car-mirror --faces 1,3 --flip"

ARROW = 22.0
"""Width of the sign at the right of the name."""


def scene_button(sheet: Sheet, state: State, facts: Facts, width: float) -> State:
    """The scene's name; a press shows what else there is, or hides it again."""
    if imgui.button("##opening/show", (width, 0.0)):
        state = replace(state, opening=None if state.opening is not None else "")
    sheet.note("opening/show")
    name = facts.scene.name[:LONGEST_NAME]
    low, high = imgui.get_item_rect_min(), imgui.get_item_rect_max()
    lines, color = imgui.get_window_draw_list(), imgui.get_color_u32(theme.TEXT)
    shown = shortened(name, high.x - low.x - 6.0 - ARROW)
    lines.add_text((low.x + 6.0, low.y + 3.0), color, shown)
    x, y = high.x - 0.5 * ARROW, (low.y + high.y) / 2.0
    down = 3.0 if state.opening is None else -3.0
    corners = ((x - 4.5, y - 0.5 * down), (x + 4.5, y - 0.5 * down), (x, y + down))
    lines.add_triangle_filled(*corners, color)
    said = "Open another scene (Ctrl+O)" if state.opening is None else "Back (Esc)"
    tip(said if shown == name else f"{name}\n{said}")
    return state


def opening_page(sheet: Sheet, state: State, facts: Facts) -> State:
    """A path to type, taken when Enter is pressed, and the built-in scenes."""
    imgui.dummy((0.0, 1.0))
    imgui.separator()
    imgui.dummy((0.0, 1.0))
    caption("Path of a scene, model or CAD file")
    # What was typed stays for the next attempt, and so do the keys.
    if imgui.is_window_appearing():
        imgui.set_keyboard_focus_here()
    imgui.set_next_item_width(field_width())
    flags = imgui.InputTextFlags_.enter_returns_true
    entered, typed = imgui.input_text_with_hint("##opening/path", "then Enter", state.opening or "", flags)
    sheet.note("opening/path")
    left = imgui.is_item_deactivated() and imgui.is_key_pressed(imgui.Key.escape)
    tip(OPTIONS)
    if entered:
        imgui.set_keyboard_focus_here(-1)
        sheet.opens.extend(filter(None, [typed.strip()]))
    imgui.dummy((0.0, 1.0))
    caption("Built-in scenes")
    imgui.push_style_var(imgui.StyleVar_.button_text_align, (0.0, 0.5))
    imgui.push_style_var(imgui.StyleVar_.item_spacing, (0.0, 0.0))
    for scene in SCENES.values():
        imgui.push_style_color(imgui.Col_.button, theme.FILL if scene.name == facts.scene.name else theme.CLEAR)
        if button(sheet, f"opening/{scene.name}", scene.name, scene.summary, field_width()):
            sheet.opens.append(scene.name)
        imgui.pop_style_color()
    imgui.pop_style_var(2)
    return replace(state, opening=None if left else typed)
