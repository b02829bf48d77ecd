"""Where the image stands on the canvas: beside the panel and above the status line, so that neither hides it."""

from __future__ import annotations

from anamorph.viewer.facts import Rectangle

PANEL_WIDTH = 276.0
STATUS_HEIGHT = 24.0
"""Logical pixels, like all here."""


def image_area(size: tuple[float, float], panel: bool) -> Rectangle:
    """The image's rectangle on a canvas of `size` (width, height), whether or not the panel is open."""
    width, height = size
    left = min(PANEL_WIDTH, width) if panel else 0.0
    return (left, 0.0, width, max(height - STATUS_HEIGHT, 0.0))


def in_pixels(area: Rectangle, ratio: float) -> tuple[int, int, int, int]:
    """Left, top, width and height of an area in physical pixels, `ratio` of them for each logical one."""
    left, top, right, bottom = (round(edge * ratio) for edge in area)
    return left, top, right - left, bottom - top


def inside(x: float, y: float, area: Rectangle) -> bool:
    """Whether a point lies in an area."""
    left, top, right, bottom = area
    return left <= x < right and top <= y < bottom
