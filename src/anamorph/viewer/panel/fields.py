"""Fields that hold a value: numbers on a slider, and words out of a list."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from imgui_bundle import imgui

from anamorph.viewer.panel import theme
from anamorph.viewer.panel.sheet import Sheet, field_width, sign, text_width, tip, wrapped
from anamorph.viewer.panel.touch import typing_by_double_tap
from anamorph.viewer.panel.wording import decimals, number_text

GRAB, TICK = 2.0, 3.0
"""Width of the grab at a slider's value, and its height at either edge."""


@dataclass(frozen=True)
class Choice:
    """One of a list's words; `reason` says why it cannot be taken, and is empty where it can."""

    value: str
    text: str
    summary: str = ""
    reason: str = ""


def number(
    sheet: Sheet,
    key: str,
    label: str,
    value: float,
    limits: tuple[float, float],
    *,
    default: float,
    step: float = 0.01,
    unit: str = "",
    summary: str = "",
    logarithmic: bool = False,
    shown: Callable[[float], str] | None = None,
) -> float:
    """A number between limits, dragged or typed; its new value, a whole number of steps.

    Of a number that is typed beyond the limits the nearer one is taken, and said below the field.

    Parameters
    ----------
    sheet : Sheet
    key : str
    label : str
    value : float
    limits : (low, high)
    default : float
        Where the value differs from this, a button sets it back.
    step : float
        What values are rounded to.
    unit, summary : str
    logarithmic : bool
    shown : callable, optional
        The text for a value, in place of the number with its unit.
    """
    low, high = limits
    ends = _drawn_ends(low, high, default)
    # One digit more, where the value was typed or found, and is no whole number of steps.
    places = decimals(step)
    places += abs(value - round(value / step) * step) > 1e-6 * step
    said = shown(value) if shown else number_text(value, places, unit)
    width = field_width()
    widest = max(text_width(number_text(end, decimals(step) + 1, unit)) for end in ends)
    # Not by the value itself: the label would jump about while it is dragged.
    if shown or text_width(label) + widest + 20.0 > width:
        wrapped(label, theme.FAINT)
        label = ""
    typed = _typed_into(key)
    flags = imgui.SliderFlags_.no_round_to_format
    flags |= imgui.SliderFlags_.logarithmic if logarithmic else imgui.SliderFlags_.none
    imgui.set_next_item_width(width)
    imgui.push_style_color(imgui.Col_.slider_grab, theme.CLEAR)
    imgui.push_style_color(imgui.Col_.slider_grab_active, theme.CLEAR)
    imgui.push_style_color(imgui.Col_.text, theme.TEXT if typed else theme.CLEAR)
    with typing_by_double_tap():
        changed, new = imgui.slider_float(f"##{key}", value, *ends, f"%.{places}f", flags)
    imgui.pop_style_color(3)
    sheet.note(key)
    sheet.drag(key)
    if imgui.is_item_activated():
        _note_cut(key, False)
    if not _typed_into(key):
        nought = min(max(0.0, ends[0]), ends[1])
        _fill(_share(nought, *ends, logarithmic), _share(value, *ends, logarithmic))
        _words(label, said)
    if not imgui.is_item_active():
        tip("\n".join(filter(None, (summary, _between(low, high, places, unit), "Ctrl-click or double tap to type."))))
    if changed and math.isfinite(new):
        # imgui counts in float32; what is typed is not rounded to steps.
        wanted = round(new if typed else round(new / step) * step, 6)
        value = min(max(wanted, low), high)
        _note_cut(key, typed and not math.isclose(wanted, value, rel_tol=1e-6, abs_tol=1e-6))
    if abs(value - default) > 1e-6 * step:
        imgui.same_line(0.0, 2.0)
        if sign(sheet, f"{key}/reset", "reset", f"Back to {number_text(default, places, unit)}"):
            value = default
            _note_cut(key, False)
    if _was_cut(key):
        side, end = ("most", high) if value > low else ("least", low)
        wrapped(f"at {side} {number_text(end, places, unit)}", theme.WARNING)
        sheet.note(f"{key}/limit")
    return value


def text(sheet: Sheet, key: str, label: str, value: str, summary: str = "") -> str:
    """A text to type, taken when Enter is pressed; its new value."""
    wrapped(label, theme.FAINT)
    imgui.set_next_item_width(field_width())
    _, value = imgui.input_text(f"##{key}", value, imgui.InputTextFlags_.enter_returns_true)
    sheet.note(key)
    sheet.drag(key)
    tip(summary)
    return value


def word(sheet: Sheet, key: str, label: str, value: str, choices: Sequence[Choice], summary: str = "") -> str:
    """A word out of a list that opens; its new value."""
    said = next((each.text for each in choices if each.value == value), value)
    width = field_width()
    arrow = imgui.get_frame_height()
    if text_width(label) + text_width(said) + arrow + 20.0 > width:
        wrapped(label, theme.FAINT)
        label = ""
    imgui.set_next_item_width(width)
    opened = imgui.begin_combo(f"##{key}", "", imgui.ComboFlags_.height_largest)
    # Inside an opened list the last item is the list's, and so are its rectangle and its words.
    if not opened:
        sheet.note(key)
        _words(label, said, arrow)
        tip(summary)
        return value
    value = _listed(sheet, key, value, choices)
    imgui.end_combo()
    sheet.note(key)
    _words(label, said, arrow)
    sheet.cover_canvas()
    return value


def _listed(sheet: Sheet, key: str, value: str, choices: Sequence[Choice]) -> str:
    chosen = value
    imgui.push_style_color(imgui.Col_.header, theme.FILL)
    for each in choices:
        imgui.begin_disabled(bool(each.reason))
        if imgui.selectable(f"{each.text}##{key}/{each.value}", each.value == value)[0]:
            chosen = each.value
        imgui.end_disabled()
        sheet.note(f"{key}/{each.value}")
        tip(each.reason or each.summary)
    imgui.pop_style_color()
    return chosen


def _drawn_ends(low: float, high: float, default: float) -> tuple[float, float]:
    """Where a slider ends: at the limits, or where there is none far enough from the default."""
    reach = max(10.0, 4.0 * abs(default))
    return low if math.isfinite(low) else -reach, high if math.isfinite(high) else reach


def _between(low: float, high: float, places: int, unit: str) -> str:
    if not math.isfinite(low):
        return ""
    if not math.isfinite(high):
        return f"{number_text(low, places, unit)} or more"
    return f"{number_text(low, places)} to {number_text(high, places, unit)}"


def _note_cut(key: str, cut: bool) -> None:
    """Remember, in imgui's own store, whether the number that was typed last lay beyond the limits."""
    imgui.get_state_storage().set_bool(imgui.get_id(f"{key}/limit"), cut)


def _was_cut(key: str) -> bool:
    return imgui.get_state_storage().get_bool(imgui.get_id(f"{key}/limit"))


def _typed_into(key: str) -> bool:
    return imgui.internal.temp_input_is_active(imgui.get_id(f"##{key}"))


def _share(value: float, low: float, high: float, logarithmic: bool) -> float:
    """How far along the slider a value is, as imgui has it."""
    if high <= low:
        return 0.0
    if logarithmic and low > 0.0:
        return math.log(max(value, low) / low) / math.log(high / low)
    return (min(max(value, low), high) - low) / (high - low)


def _fill(start: float, share: float) -> None:
    """Colour the last item from nought up to the value, and draw the grab at the value above and below the words."""
    low, high = imgui.get_item_rect_min(), imgui.get_item_rect_max()
    color = theme.FILL_UNDER if imgui.is_item_hovered() or imgui.is_item_active() else theme.FILL
    across, lines = high.x - low.x, imgui.get_window_draw_list()
    left, right = (low.x + end * across for end in sorted((start, share)))
    lines.add_rect_filled((left, low.y), (right, high.y), imgui.get_color_u32(color))
    x = low.x + share * (across - GRAB)
    for top, bottom in ((low.y, low.y + TICK), (high.y - TICK, high.y)):
        lines.add_rect_filled((x, top), (x + GRAB, bottom), imgui.get_color_u32(theme.ACCENT))


def _words(label: str, said: str, margin: float = 0.0) -> None:
    """Write a label at the left and a value at the right of the last item."""
    low, high = imgui.get_item_rect_min(), imgui.get_item_rect_max()
    lines, y = imgui.get_window_draw_list(), low.y + 3.0
    lines.add_text((low.x + 6.0, y), imgui.get_color_u32(theme.FAINT), label)
    lines.add_text((high.x - margin - 6.0 - text_width(said), y), imgui.get_color_u32(theme.TEXT), said)
