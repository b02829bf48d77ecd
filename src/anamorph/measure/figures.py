"""The rows of every table of results: one measure each, the methods side by side."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from anamorph.measure.compare import COMPETITOR, Comparison, MethodResult
from anamorph.measure.status import STATUS_NAMES, status_shares

NOTHING = "-"
"""Stands where there is nothing to measure."""

SMALLEST = 1e-5
"""The least figure that is written out."""


@dataclass(frozen=True)
class Row:
    """A measure: what it is called, its unit, and the figure of one method as text."""

    label: str
    unit: str
    cell: Callable[[Comparison, MethodResult], str]


def number(value: float | None) -> str:
    """Three significant digits of a figure that is not negative, with no exponent and at most five decimals."""
    if value is None:
        return NOTHING
    if value == 0.0:
        return "0"
    if value < SMALLEST:
        return f"< {SMALLEST:.5f}"
    decimals = max(0, 2 - int(np.floor(np.log10(abs(value)))))
    return f"{value:,.{min(decimals, 5)}f}"


def count_or_number(value: float | None) -> str:
    """A whole number in full, and any other figure as `number` has it."""
    return f"{value:,.0f}" if value is not None and float(value).is_integer() else number(value)


def speed(comparison: Comparison, result: MethodResult) -> str:
    """How many times as fast as the competitor in the same run."""
    competitor = comparison.competitor
    return NOTHING if competitor is None else number(competitor.timing.median / result.timing.median)


def times_without_mirrors(comparison: Comparison, result: MethodResult) -> str:
    """How many times as long as the same frame without its specular meshes, in the same run."""
    plain = comparison.without_mirrors
    return NOTHING if plain is None else number(result.timing.median / plain.median)


ROWS = (
    Row("frame time: median", "ms", lambda _, result: number(result.timing.median)),
    Row(
        "frame time: min to max",
        "ms",
        lambda _, result: f"{number(result.timing.min)} to {number(result.timing.max)}",
    ),
    Row(f"as fast as {COMPETITOR}", "times", speed),
    Row("the frame without mirrors", "times", times_without_mirrors),
    Row("angular error: median", "mrad", lambda _, result: number(result.errors.angular_mrad.median)),
    Row("angular error: 95th percentile", "mrad", lambda _, result: number(result.errors.angular_mrad.p95)),
    Row("angular error: maximum", "mrad", lambda _, result: number(result.errors.angular_mrad.max)),
    Row("error in the image: median", "px", lambda _, result: number(result.errors.pixels.median)),
    Row("error in the image: 95th percentile", "px", lambda _, result: number(result.errors.pixels.p95)),
    Row("error in the image: maximum", "px", lambda _, result: number(result.errors.pixels.max)),
    Row("sees another object", "%", lambda _, result: number(result.errors.other_object_percent)),
    Row("at a silhouette", "%", lambda _, result: number(result.errors.silhouette_percent)),
    Row("colour RMSE", "0 to 1", lambda _, result: number(result.errors.rmse)),
    Row("FLIP", "0 to 1", lambda _, result: number(result.errors.flip)),
    Row("relative colour error", "ratio", lambda _, result: number(result.errors.relative_error)),
)


def rows_of(comparison: Comparison) -> tuple[Row, ...]:
    """All rows of one comparison: `ROWS`, how the pixels got their value, and what the methods report of themselves."""
    shares = {result.name: status_shares(result.frame, result.errors.maps.specular) for result in comparison.methods}
    given = {status for share in shares.values() for status in share}
    statuses = [status for status in STATUS_NAMES if status in given]
    figures = dict.fromkeys(name for result in comparison.methods for name in result.frame.figures)

    def status_row(status: str) -> Row:
        return Row(f"pixels: {status}", "%", lambda _, result: number(shares[result.name].get(status, 0.0)))

    def figure_row(name: str) -> Row:
        label, unit = name.removesuffix("_percent"), "%" if name.endswith("_percent") else ""
        return Row(label.replace("_", " "), unit, lambda _, result: count_or_number(result.frame.figures.get(name)))

    return (*ROWS, *map(status_row, statuses), *map(figure_row, figures))
