"""The rows of every table of results: one measure each, the methods side by side."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from anamorph.frame import Frame, Status
from anamorph.measure.compare import COMPETITOR, Comparison, MethodResult

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
    Row("error in the picture: median", "px", lambda _, result: number(result.errors.pixels.median)),
    Row("error in the picture: 95th percentile", "px", lambda _, result: number(result.errors.pixels.p95)),
    Row("error in the picture: maximum", "px", lambda _, result: number(result.errors.pixels.max)),
    Row("sees another object", "%", lambda _, result: number(result.errors.other_object_percent)),
    Row("at a silhouette", "%", lambda _, result: number(result.errors.silhouette_percent)),
    Row("colour RMSE", "0 to 1", lambda _, result: number(result.errors.rmse)),
    Row("FLIP", "0 to 1", lambda _, result: number(result.errors.flip)),
    Row("relative colour error", "ratio", lambda _, result: number(result.errors.relative_error)),
)


def status_shares(frame: Frame, counted: np.ndarray) -> dict[str, float]:
    """How the counted pixels (H, W) of a frame got their value: percent by status, the largest first."""
    if frame.status is None or not counted.any():
        return {}
    counts = np.bincount(frame.status[counted], minlength=len(Status))
    shares = {status.name.lower().replace("_", " "): 100.0 * counts[status] / counted.sum() for status in Status}
    return {name: float(share) for name, share in sorted(shares.items(), key=lambda item: -item[1]) if share > 0.0}
