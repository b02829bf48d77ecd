"""What lies over the image itself: the divider, what each half shows, and the scales to read it by.

All of it is drawn without windows. A half whose free part is too narrow for its caption or its scale goes without.
"""

from __future__ import annotations

from collections.abc import Mapping
from itertools import pairwise

from imgui_bundle import imgui

from anamorph.measure.heatmap import STOPS
from anamorph.viewer.counting import COUNT_COLORS
from anamorph.viewer.facts import Rectangle
from anamorph.viewer.measured import ERROR_COLORS, STATUS_COLORS, Color, scale_ticks
from anamorph.viewer.panel import theme
from anamorph.viewer.panel.sheet import Sheet
from anamorph.viewer.panel.wording import method_text, name_text
from anamorph.viewer.state import Aspect, Half, State

HANDLE = (7.0, 22.0)
"""Half the width and half the height of the divider's handle."""

PAD = 5.0
GAP = 6.0
BAR_WIDTH = 12.0
BAR_HEIGHT = 132.0
LINE_HEIGHT = 17.0


def draw_divider(sheet: Sheet, state: State, area: Rectangle) -> None:
    """The line between the halves of the image in `area`, and its handle."""
    if not state.split:
        return
    lines, (left, _, right, height) = imgui.get_background_draw_list(), area
    x, y = round(left + state.divider * (right - left)), round(height / 2.0)
    dark, light = imgui.get_color_u32((0.0, 0.0, 0.0, 0.6)), imgui.get_color_u32(theme.TEXT)
    lines.add_rect_filled((x - 1.5, 0.0), (x + 1.5, height), dark)
    lines.add_rect_filled((x - 0.5, 0.0), (x + 0.5, height), light)
    across, along = HANDLE
    lines.add_rect_filled((x - across - 1.0, y - along - 1.0), (x + across + 1.0, y + along + 1.0), dark)
    lines.add_rect_filled((x - across, y - along), (x + across, y + along), light)
    for turn in (-1.0, 1.0):
        tip = x + turn * (across - 1.5)
        lines.add_triangle_filled((tip, y), (tip - turn * 4.0, y - 4.0), (tip - turn * 4.0, y + 4.0), dark)
    sheet.rectangles["divider"] = (x - across, y - along, x + across, y + along)


def draw_legends(sheet: Sheet, state: State, free: Rectangle, area: Rectangle) -> float:
    """Caption and scale of each half of the image in `area`, within what of it is `free`; where the captions end."""
    left, top, right, bottom = free
    x = area[0] + state.divider * (area[2] - area[0])
    halves = (("first", state.first, left, min(x, right)), ("second", state.second, max(x, left), right))
    lowest = top
    for key, half, start, end in halves if state.split else (("first", state.first, left, right),):
        free = (start + theme.MARGIN, top + theme.MARGIN, end - theme.MARGIN, bottom - theme.MARGIN)
        ends = _caption(sheet, f"{key}/caption", half_caption(half, state), free)
        lowest = max(lowest, ends)
        free = (free[0], max(ends, top) + theme.MARGIN, free[2], free[3])
        if half.aspect is Aspect.ERROR:
            _scale(sheet, f"{key}/scale", state.unit, free)
        elif half.aspect is Aspect.STATUS:
            _named(
                sheet, f"{key}/statuses", {name_text(each.name): color for each, color in STATUS_COLORS.items()}, free
            )
        elif half.aspect is Aspect.COUNTS:
            _named(sheet, f"{key}/counts", COUNT_COLORS, free)
    return lowest


def half_caption(half: Half, state: State) -> str:
    """What a half shows, in words."""
    said = method_text(half.method)
    return said if half.aspect is Aspect.IMAGE else f"{said}, {half.aspect}"


def _caption(sheet: Sheet, key: str, text: str, free: Rectangle) -> float:
    """A text at the top left of `free`, over as many lines as it needs; where it ends."""
    left, top, right, _ = free
    across = right - left - 2.0 * PAD
    if across < max(imgui.calc_text_size(word).x for word in text.split()):
        return top - theme.MARGIN
    size = imgui.calc_text_size(text, False, across)
    _ground(sheet, key, (left, top, left + size.x + 2.0 * PAD, top + size.y + PAD))
    font = imgui.get_font()
    color = imgui.get_color_u32(theme.TEXT)
    place = (left + PAD, top + PAD / 2.0)
    imgui.get_background_draw_list().add_text(font, imgui.get_font_size(), place, color, text, across)
    return top + size.y + PAD


def _scale(sheet: Sheet, key: str, unit: str, free: Rectangle) -> None:
    """The colours of errors, from the lowest at the bottom to the highest, and below them those that stand apart."""
    title = f"error, {unit}"
    narrowest = imgui.calc_text_size(title).x + 2.0 * PAD
    widest = max(narrowest, *(_swatch_width(name) for name in ERROR_COLORS))
    # Where there is too little space for both, the scale says more than the colours that stand apart.
    apart, across = (ERROR_COLORS, widest) if widest <= free[2] - free[0] else ({}, narrowest)
    below = PAD + BAR_HEIGHT + LINE_HEIGHT * (2.0 + len(apart))
    if (place := _fitted(free, across, below)) is None:
        return
    left, top = place
    _ground(sheet, key, (left, top, left + across, top + below))
    color = imgui.get_color_u32(theme.TEXT)
    imgui.get_background_draw_list().add_text((left + PAD, top + PAD / 2.0), color, title)
    low = top + PAD + 1.5 * LINE_HEIGHT + BAR_HEIGHT
    _color_bar(unit, left + PAD, low)
    _swatches(apart, left + PAD, low + 0.5 * LINE_HEIGHT)


def _color_bar(unit: str, x: float, low: float) -> None:
    lines, color = imgui.get_background_draw_list(), imgui.get_color_u32(theme.TEXT)
    step = BAR_HEIGHT / (len(STOPS) - 1)
    colors = [imgui.get_color_u32((red, green, blue, 1.0)) for red, green, blue in STOPS / 255.0]
    for number, (under, over) in enumerate(pairwise(colors)):
        y = low - number * step
        lines.add_rect_filled_multi_color((x, y - step), (x + BAR_WIDTH, y), over, over, under, under)
    for share, tick in scale_ticks(unit):
        y = low - share * BAR_HEIGHT
        lines.add_rect_filled((x + BAR_WIDTH, y - 0.5), (x + BAR_WIDTH + 4.0, y + 0.5), color)
        lines.add_text((x + BAR_WIDTH + GAP, y - LINE_HEIGHT / 2.0), color, tick)


def _named(sheet: Sheet, key: str, names: Mapping[str, Color], free: Rectangle) -> None:
    """What colours stand for: how a pixel got its value, or how often a vertex is seen."""
    across = max(_swatch_width(name) for name in names)
    below = PAD + LINE_HEIGHT * len(names)
    if (place := _fitted(free, across, below)) is None:
        return
    left, top = place
    _ground(sheet, key, (left, top, left + across, top + below))
    _swatches(names, left + PAD, top + PAD / 2.0)


def _swatch_width(name: str) -> float:
    return 2.0 * PAD + BAR_WIDTH + GAP + imgui.calc_text_size(name).x


def _swatches(colors: Mapping[str, Color], x: float, y: float) -> None:
    """Names beside their colours, one a line."""
    lines, words = imgui.get_background_draw_list(), imgui.get_color_u32(theme.TEXT)
    for number, (name, (red, green, blue)) in enumerate(colors.items()):
        low = y + number * LINE_HEIGHT
        # An edge, because some of the colours are as dark as what is behind them.
        lines.add_rect_filled((x, low + 2.0), (x + BAR_WIDTH, low + 15.0), words)
        filled = imgui.get_color_u32((red / 255.0, green / 255.0, blue / 255.0, 1.0))
        lines.add_rect_filled((x + 1.0, low + 3.0), (x + BAR_WIDTH - 1.0, low + 14.0), filled)
        lines.add_text((x + BAR_WIDTH + GAP, low), words, name)


def _fitted(free: Rectangle, across: float, below: float) -> tuple[float, float] | None:
    """The left top of something so large at the bottom left of `free`; None where it does not fit."""
    left, top, right, bottom = free
    return (left, bottom - below) if right - left >= across and bottom - top >= below else None


def _ground(sheet: Sheet, key: str, rectangle: Rectangle) -> None:
    left, top, right, bottom = rectangle
    imgui.get_background_draw_list().add_rect_filled((left, top), (right, bottom), imgui.get_color_u32(theme.SHADE))
    sheet.rectangles[key] = rectangle
