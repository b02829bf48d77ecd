"""How the panel looks: its colours, its measures and its letters."""

from __future__ import annotations

from pathlib import Path

import imgui_bundle
from imgui_bundle import imgui

Color = tuple[float, float, float, float]

TEXT: Color = (0.90, 0.91, 0.92, 1.0)
FAINT: Color = (0.68, 0.71, 0.75, 1.0)
GROUND: Color = (0.085, 0.095, 0.11, 0.97)
BAR: Color = (0.085, 0.095, 0.11, 1.0)
FIELD: Color = (0.225, 0.24, 0.265, 1.0)
FIELD_UNDER: Color = (0.285, 0.305, 0.335, 1.0)
FILL: Color = (0.17, 0.36, 0.53, 1.0)
FILL_UNDER: Color = (0.20, 0.42, 0.61, 1.0)
ACCENT: Color = (0.36, 0.67, 0.93, 1.0)
WARNING: Color = (0.96, 0.72, 0.33, 1.0)
LINE: Color = (0.30, 0.32, 0.35, 1.0)
SHADE: Color = (0.05, 0.055, 0.065, 0.92)
CLEAR: Color = (0.0, 0.0, 0.0, 0.0)

LETTERS = 14.0
"""Height of the font, logical pixels."""

MARGIN = 8.0
"""Between what lies over the image and the edges of its half."""

GUTTER = 22.0
"""Kept free at the right of every field, for the sign that sets it back."""

_FONTS = Path(imgui_bundle.__file__).parent / "assets" / "fonts"
REGULAR = _FONTS / "Roboto" / "Roboto-Regular.ttf"


def set_theme() -> None:
    """Give the current imgui context this look; once, before its first frame.

    Roboto (Apache 2.0) has the letters and signs of the panel, Inconsolata (SIL Open Font Licence) the arrows. Both
    come with the bindings. Letters are drawn as sharp as the canvas is, whatever its pixel ratio.
    """
    fonts = imgui.get_io().fonts
    fonts.add_font_from_file_ttf(str(REGULAR), LETTERS)
    merged = imgui.ImFontConfig()
    merged.merge_mode = True
    fonts.add_font_from_file_ttf(str(_FONTS / "Inconsolata-Medium.ttf"), LETTERS, merged)
    fonts.add_font_from_file_ttf(str(_FONTS / "Roboto" / "Roboto-Bold.ttf"), LETTERS)
    style = imgui.get_style()
    imgui.style_colors_dark(style)
    style.font_size_base = LETTERS
    style.window_padding = imgui.ImVec2(10.0, 8.0)
    style.frame_padding = imgui.ImVec2(6.0, 3.0)
    style.item_spacing = imgui.ImVec2(6.0, 5.0)
    style.item_inner_spacing = imgui.ImVec2(6.0, 4.0)
    style.scrollbar_size = 9.0
    style.window_min_size = imgui.ImVec2(1.0, 1.0)
    style.window_border_size = style.frame_border_size = 0.0
    style.popup_border_size = 1.0
    # Round corners and smoothed areas cost triangles at every frame, and show nothing.
    style.window_rounding = style.frame_rounding = style.scrollbar_rounding = style.grab_rounding = 0.0
    style.anti_aliased_fill = False
    for color, value in _colors().items():
        style.set_color_(color, value)


def bold() -> imgui.ImFont:
    """The font of headings."""
    fonts = imgui.get_io().fonts.fonts
    return fonts[len(fonts) - 1]


def _colors() -> dict[imgui.Col_, Color]:
    kinds = imgui.Col_
    return {
        kinds.text: TEXT,
        kinds.text_disabled: FAINT,
        kinds.window_bg: GROUND,
        kinds.popup_bg: BAR,
        kinds.border: LINE,
        kinds.separator: LINE,
        kinds.frame_bg: FIELD,
        kinds.frame_bg_hovered: FIELD_UNDER,
        kinds.frame_bg_active: FIELD_UNDER,
        kinds.button: FIELD,
        kinds.button_hovered: FIELD_UNDER,
        kinds.button_active: FILL,
        kinds.header: CLEAR,
        kinds.header_hovered: FIELD,
        kinds.header_active: FIELD_UNDER,
        kinds.check_mark: ACCENT,
        kinds.scrollbar_bg: CLEAR,
        kinds.scrollbar_grab: LINE,
        kinds.plot_histogram: FILL_UNDER,
    }
