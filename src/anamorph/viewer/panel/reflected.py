"""The reflection points of the clicked point: a table in the panel, and their numbers over the image."""

from __future__ import annotations

from imgui_bundle import imgui

from anamorph.reflections.reflection_points import ReflectionStatus
from anamorph.viewer.facts import Facts, Rectangle, Reflection
from anamorph.viewer.numbers import PAD, numbers_of
from anamorph.viewer.panel import theme
from anamorph.viewer.panel.sheet import caption, row, wrapped
from anamorph.viewer.panel.wording import number_text, point_text
from anamorph.viewer.state import State, shown_camera

ORDERS = {1: "right way round", -1: "mirrored", 0: "focus"}

KNOWN = {
    ReflectionStatus.FOUND: "All are found.",
    ReflectionStatus.FOCUS: "A focus: one stands for all of its mirror or lens.",
    ReflectionStatus.ON_SURFACE: "It is on a mirror or a lens, which is left out.",
    ReflectionStatus.MANY: "There may be more.",
}


def reflections_table(facts: Facts) -> None:
    """Where mirrors and lenses show the point, one place after the other."""
    caption("Reflection points")
    reflections = facts.reflections
    if reflections is None:
        caption("Searching …" if facts.searching else "None.")
        return
    row("of the point, m", point_text(reflections.point))
    wrapped(KNOWN[reflections.status], theme.FAINT if reflections.status is ReflectionStatus.FOUND else theme.WARNING)
    for number, each in enumerate(reflections.found, start=1):
        row(f"{number}  {each.name}", number_text(each.length, 3, "m"))
        row(_pixel_text(each), seen_text(each))


def seen_text(reflection: Reflection) -> str:
    """How the point is seen there."""
    return f"{ORDERS[reflection.order]}{', hidden' if reflection.hidden else ''}"


def draw_numbers(state: State, facts: Facts, area: Rectangle) -> None:
    """The numbers of the reflection points in the image in `area`."""
    left, top, right, bottom = area
    numbers = numbers_of(facts.reflections, shown_camera(state), (right - left, bottom - top))
    lines, dark = imgui.get_background_draw_list(), imgui.get_color_u32(theme.SHADE)
    lines.push_clip_rect((left, top), (right, bottom), True)
    for number in numbers:
        x, y = left + number.place[0], top + number.place[1]
        across = imgui.calc_text_size(number.text).x
        lines.add_rect_filled((x - PAD, y), (x + across + PAD, y + theme.LETTERS + PAD), dark)
        lines.add_text((x, y), imgui.get_color_u32(number.color), number.text)
    lines.pop_clip_rect()


def _pixel_text(reflection: Reflection) -> str:
    if reflection.pixel is None:
        return "    behind the eye"
    return f"    at {', '.join(number_text(value, 1) for value in reflection.pixel)}"
