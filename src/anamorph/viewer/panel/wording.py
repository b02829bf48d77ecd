"""How numbers read in the panel: with real minus signs, their units, and no more digits than tell something."""

from __future__ import annotations

import math

from anamorph.methods.specification import Specification
from anamorph.viewer.facts import Vector
from anamorph.viewer.state import REFERENCE

NOT_MEASURED = "\N{EN DASH}"

LEAST_FIGURE = 1e-4
"""What is told of a figure below it is that it is: methods that draw the same differ by rounding."""


def decimals(step: float) -> int:
    """How many digits after the point tell two values apart that are one step from each other."""
    return next((count for count in range(6) if abs(step - round(step, count)) < 1e-6 * step), 6)


def number_text(value: float, places: int, unit: str = "") -> str:
    """A value with its unit."""
    digits = f"{value:.{places}f}"
    # What rounds to nought has no sign.
    digits = digits.removeprefix("-") if float(digits) == 0.0 else digits
    return f"{digits}{unit if unit in ('', '°') else f' {unit}'}".replace("-", "\N{MINUS SIGN}")


def figure(value: float | None) -> str:
    """Three digits of a value that is not negative, or two behind zeros, without powers of ten."""
    if value is None:
        return NOT_MEASURED
    if value < LEAST_FIGURE:
        return f"< {LEAST_FIGURE:.4f}" if value else "0"
    if value < 0.1:
        return f"{value:.{max(3, 1 - math.floor(math.log10(value)))}f}"
    return f"{value:.{next(places for places, least in enumerate((100.0, 10.0, 1.0, 0.0)) if value >= least)}f}"


def size_text(size: tuple[int, int]) -> str:
    """Width and height, pixels."""
    return f"{size[0]} \N{MULTIPLICATION SIGN} {size[1]}"


def point_text(point: Vector) -> str:
    """A world point, metres."""
    return ", ".join(number_text(value, 3) for value in point)


def method_text(specification: Specification) -> str:
    """A method and its options in words."""
    name, _, options = str(specification).partition(":")
    words = ["truth" if specification == REFERENCE else name]
    return ", ".join([*words, *(each.replace("=", " ") for each in options.split(",") if each)])


def name_text(name: str) -> str:
    """The name of a status in words."""
    return name.replace("_", " ").replace("-", " ").lower()
