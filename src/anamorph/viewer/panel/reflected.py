"""The reflection points of the clicked point: a table in the panel, and their numbers over the image."""

from __future__ import annotations

import numpy as np
from imgui_bundle import imgui

from anamorph.reflections.reflection_points import ReflectionStatus
from anamorph.viewer.facts import Facts, Rectangle, Reflection
from anamorph.viewer.panel import theme
from anamorph.viewer.panel.sheet import caption, row, wrapped
from anamorph.viewer.panel.wording import MINUS, number_text, point_text
from anamorph.viewer.state import State, shown_camera

ORDERS = {1: "right way round", -1: "mirrored", 0: "focus"}

KNOWN = {
    ReflectionStatus.FOUND: "All are found.",
    ReflectionStatus.FOCUS: "A focus: one stands for all of its mirror.",
    ReflectionStatus.ON_MIRROR: "It is on a mirror, which is left out.",
    ReflectionStatus.MANY: "There may be more.",
}

BESIDE = (9.0, -16.0)
"""How far from a reflection point its number stands, logical pixels."""


def reflections_table(facts: Facts) -> None:
    """Where mirrors show the point, a reflection point after the other."""
    caption("Reflection points")
    reflections = facts.reflections
    if reflections is None:
        caption("Searching …" if facts.searching else "None.")
        return
    row("of the point, m", point_text(reflections.point))
    wrapped(KNOWN[reflections.status], theme.FAINT if reflections.status is ReflectionStatus.FOUND else theme.WARNING)
    for number, each in enumerate(reflections.found, start=1):
        row(f"{number}   {each.name}", number_text(each.length, 3, "m"))
        row(f"{_pixel_text(each)}", f"{ORDERS[each.order]}{', hidden' if each.hidden else ''}")


def draw_numbers(state: State, facts: Facts, area: Rectangle) -> None:
    """The number and the sign of the order of each reflection point, beside it in the image in `area`."""
    if facts.reflections is None or not facts.reflections.found:
        return
    left, top, right, bottom = area
    places = np.array([each.position for each in facts.reflections.found])
    image = shown_camera(state).image(places, (max(int(right - left), 1), max(int(bottom - top), 1)))
    lines, dark = imgui.get_background_draw_list(), imgui.get_color_u32(theme.SHADE)
    lines.push_clip_rect((left, top), (right, bottom), True)
    for number, (each, (x, y, w)) in enumerate(zip(facts.reflections.found, image, strict=True), start=1):
        if w <= 0.0:
            continue
        place = left + x / w + BESIDE[0], top + y / w + BESIDE[1]
        text = number_sign(number, each)
        size = imgui.calc_text_size(text)
        lines.add_rect_filled((place[0] - 3.0, place[1]), (place[0] + size.x + 3.0, place[1] + size.y), dark)
        lines.add_text(place, imgui.get_color_u32(theme.FAINT if each.hidden else theme.TEXT), text)
    lines.pop_clip_rect()


def number_sign(number: int, reflection: Reflection) -> str:
    """A number with the sign of the order, in brackets where the reflection point is hidden."""
    text = f"{number}{'+' if reflection.order > 0 else MINUS if reflection.order < 0 else '0'}"
    return f"({text})" if reflection.hidden else text


def _pixel_text(reflection: Reflection) -> str:
    if reflection.pixel is None:
        return "behind the eye"
    return ", ".join(number_text(value, 1) for value in reflection.pixel)
