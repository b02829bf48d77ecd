"""What a frame of the panel gathers while it is drawn, and the plain things it is drawn from.

Widgets are told apart by stable keys, such as "first/method": imgui knows them by these, and so do tests and scripts,
which look up their rectangles.
"""

from __future__ import annotations

import math
from bisect import bisect
from collections.abc import Sequence
from dataclasses import dataclass, field

from imgui_bundle import imgui

from anamorph.viewer.facts import Rectangle, Request
from anamorph.viewer.panel import theme

TIP_WIDTH = 260.0


@dataclass(frozen=True)
class Sheet:
    """What one frame's widgets leave behind: see `panel.Drawn`."""

    requests: list[Request] = field(default_factory=list)
    opens: list[str] = field(default_factory=list)
    rectangles: dict[str, Rectangle] = field(default_factory=dict)
    covered: list[Rectangle] = field(default_factory=list)
    dragged: list[str] = field(default_factory=list)

    def note(self, key: str) -> None:
        """Note the last item's rectangle."""
        low, high = imgui.get_item_rect_min(), imgui.get_item_rect_max()
        self.rectangles[key] = (low.x, low.y, high.x, high.y)

    def drag(self, key: str) -> None:
        """Note whether the last item, which is one to drag on, is held."""
        if imgui.is_item_active():
            self.dragged.append(key)

    def window(self, key: str) -> None:
        """Note the current window's rectangle."""
        place, size = imgui.get_window_pos(), imgui.get_window_size()
        self.rectangles[key] = (place.x, place.y, place.x + size.x, place.y + size.y)

    def cover_window(self, key: str) -> None:
        """Note that the current window owns what the pointer does over it."""
        self.window(key)
        self.covered.append(self.rectangles[key])

    def cover_canvas(self) -> None:
        """Note that all the canvas is imgui's: a press outside an open list only closes it."""
        size = imgui.get_io().display_size
        self.covered.append((0.0, 0.0, size.x, size.y))


def available() -> float:
    """The width that is left on this line."""
    return imgui.get_content_region_avail().x


def field_width() -> float:
    """The width of a field on a line of its own."""
    return available() - theme.GUTTER


def text_width(text: str) -> float:
    return imgui.calc_text_size(text).x


def shortened(text: str, width: float) -> str:
    """A text, with its end left out where it is wider."""
    if text_width(text) <= width:
        return text
    kept = bisect(range(len(text)), width, key=lambda count: text_width(f"{text[:count]}…")) - 1
    return f"{text[: max(kept, 0)]}…"


def broken(text: str, width: float) -> str:
    """A text in lines no wider than that, which end between words: imgui would also end them before the "stp" of .stp.

    A word that is wider is left to imgui.
    """
    if text_width(text) <= width:
        return text
    lines: list[str] = []
    for paragraph in text.split("\n"):
        line, *words = paragraph.split(" ")
        for word in words:
            longer = f"{line} {word}"
            if text_width(longer) > width:
                lines.append(line)
                line = word
            else:
                line = longer
        lines.append(line)
    return "\n".join(lines)


def tip(text: str) -> None:
    """Say more about the last item while the pointer rests on it."""
    if text and imgui.is_item_hovered(imgui.HoveredFlags_.for_tooltip | imgui.HoveredFlags_.allow_when_disabled):
        imgui.begin_tooltip()
        imgui.push_text_wrap_pos(TIP_WIDTH)
        imgui.text_unformatted(broken(text, TIP_WIDTH - 1.0))
        imgui.pop_text_wrap_pos()
        imgui.end_tooltip()


def wrapped(text: str, color: theme.Color = theme.TEXT, margin: float = 0.0) -> None:
    """A text over as many lines as it needs, leaving a `margin` on its right."""
    width = available() - margin
    imgui.push_style_color(imgui.Col_.text, color)
    imgui.push_text_wrap_pos(imgui.get_cursor_pos_x() + width)
    # A little narrower than where imgui breaks by itself.
    imgui.text_unformatted(broken(text, width - 1.0))
    imgui.pop_text_wrap_pos()
    imgui.pop_style_color()


def to_column(x: float) -> None:
    """Go on in this line at `x`, as `imgui.get_cursor_pos_x` counts."""
    imgui.same_line()
    imgui.set_cursor_pos_x(x)


def caption(text: str) -> None:
    """What the widget below sets."""
    wrapped(text, theme.FAINT)


def row(label: str, *values: str) -> None:
    """A label, and its values at the right in columns of equal width; what does not fit goes on lines of its own."""
    left, width = imgui.get_cursor_pos_x(), field_width()
    column = (width * 0.58) / len(values)
    if any(text_width(value) > column for value in values) or text_width(label) > width - column * len(values):
        if len(values) == 1 and text_width(label) + text_width(values[0]) + 8.0 < width:
            column = text_width(values[0])
        else:
            wrapped(label, theme.FAINT)
            for value in values:
                wrapped(value)
            return
    imgui.text_colored(theme.FAINT, label)
    for number, value in enumerate(values, start=1):
        to_column(left + width - column * (len(values) - number) - text_width(value))
        imgui.text_unformatted(value)


def button(sheet: Sheet, key: str, text: str, summary: str = "", width: float = 0.0) -> bool:
    """A push button, of its text's width unless one is given."""
    pressed = imgui.button(f"{text}##{key}", (width, 0.0))
    sheet.note(key)
    tip(summary)
    return pressed


def sign(sheet: Sheet, key: str, drawn: str, summary: str) -> bool:
    """A small square button with a drawn sign: "reset", "close", "hide" or "show"."""
    side = imgui.get_frame_height()
    pressed = imgui.invisible_button(f"##{key}", (side, side))
    sheet.note(key)
    color = imgui.get_color_u32(theme.TEXT if imgui.is_item_hovered() else theme.FAINT)
    low, lines = imgui.get_item_rect_min(), imgui.get_window_draw_list()
    x, y, r = low.x + side / 2.0, low.y + side / 2.0, 4.5
    if drawn == "reset":
        start, bend = -2.4, (math.cos(-2.4), math.sin(-2.4))
        lines.path_arc_to((x, y), r, start, 2.2, 16)
        lines.path_stroke(color, 1.5)
        # The head lies along the arc's tangent, against its run.
        left, top = x + r * bend[0], y + r * bend[1]
        head = (left + 5.0 * bend[1], top - 5.0 * bend[0])
        inner, outer = ((left + part * bend[0], top + part * bend[1]) for part in (-3.0, 3.0))
        lines.add_triangle_filled(head, inner, outer, color)
    elif drawn == "close":
        lines.add_line((x - r, y - r), (x + r, y + r), color, 1.5)
        lines.add_line((x - r, y + r), (x + r, y - r), color, 1.5)
    else:
        turn = 1.0 if drawn == "hide" else -1.0
        for shift in (-2.5, 2.5):
            tipped = x + shift - turn * 2.0
            lines.add_line((tipped + turn * r, y - r), (tipped, y), color, 1.5)
            lines.add_line((tipped, y), (tipped + turn * r, y + r), color, 1.5)
    tip(summary)
    return pressed


def checkbox(sheet: Sheet, key: str, text: str, value: bool, summary: str = "") -> bool:
    """A box to tick; its new value."""
    _, value = imgui.checkbox(f"##{key}", value)
    tip(summary)
    low = imgui.get_item_rect_min()
    imgui.same_line(0.0, 6.0)
    imgui.begin_group()
    imgui.align_text_to_frame_padding()
    wrapped(text)
    imgui.end_group()
    start, high = imgui.get_item_rect_min(), imgui.get_item_rect_max()
    # The words belong to the box: pressing them ticks it.
    imgui.set_cursor_screen_pos(start)
    if imgui.invisible_button(f"##{key}/words", (high.x - start.x, high.y - start.y)):
        value = not value
    tip(summary)
    sheet.rectangles[key] = (low.x, low.y, high.x, high.y)
    return value


def choice(sheet: Sheet, key: str, chosen: str, words: Sequence[tuple[str, str]], summary: str = "") -> str:
    """Buttons side by side, of which one is down: (value, text) each; the new value."""
    gap = 1.0
    width = (field_width() - gap * (len(words) - 1)) / len(words)
    new = chosen
    for number, (value, text) in enumerate(words):
        if number:
            imgui.same_line(0.0, gap)
        imgui.push_style_color(imgui.Col_.button, theme.FILL if value == chosen else theme.FIELD)
        imgui.push_style_color(imgui.Col_.text, theme.TEXT if value == chosen else theme.FAINT)
        if button(sheet, f"{key}/{value}", text, summary, width):
            new = value
        imgui.pop_style_color(2)
    return new


def fold(sheet: Sheet, key: str, title: str, opened: bool) -> bool:
    """A smaller heading that folds what follows; whether that is to be drawn."""
    flags = imgui.TreeNodeFlags_.no_tree_push_on_open | imgui.TreeNodeFlags_.span_avail_width
    flags |= imgui.TreeNodeFlags_.frame_padding
    flags |= imgui.TreeNodeFlags_.default_open if opened else imgui.TreeNodeFlags_.none
    shown = imgui.tree_node_ex(f"{title}##{key}", flags)
    sheet.note(key)
    return shown


def section(sheet: Sheet, key: str, title: str, opened: bool = True) -> bool:
    """A heading that folds what follows; whether it is to be drawn."""
    imgui.dummy((0.0, 1.0))
    imgui.separator()
    flags = imgui.TreeNodeFlags_.default_open if opened else imgui.TreeNodeFlags_.none
    imgui.push_font(theme.bold(), 0.0)
    shown = imgui.collapsing_header(f"{title}##{key}", flags)
    imgui.pop_font()
    sheet.note(key)
    return shown
