"""Where tracing becomes the faster way, along one axis of what was measured with all else fixed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from anamorph.measure.compare import COMPETITOR


class Timed(Protocol):
    """What a frame takes by a method, milliseconds; None where it could not be drawn."""

    @property
    def method(self) -> str: ...
    @property
    def ms(self) -> float | None: ...


@dataclass(frozen=True)
class Crossover:
    """Along one axis, with all others fixed: how much faster a method is than the tracer, and where that is 1.

    Parameters
    ----------
    method : str
    fixed : tuple of (str, value)
        What is the same along the line.
    axis : str
    values, speeds : tuple of float
        Along the axis, ascending: how many frames the method draws while the tracer draws one.
    """

    method: str
    fixed: tuple[tuple[str, Any], ...]
    axis: str
    values: tuple[float, ...]
    speeds: tuple[float, ...]

    @property
    def place(self) -> float | None:
        """Where both are as fast; of several places the first from where the method wins. None where there is none."""
        crossed = crossings(self.values, self.speeds)
        return (crossed[-1] if self.speeds[-1] > 1.0 else crossed[0]) if crossed else None

    def told(self) -> str:
        """For what values tracing wins, in words."""
        place, first, last = self.place, f"{self.values[0]:,.0f}", f"{self.values[-1]:,.0f}"
        if place is None:
            return f"{'never' if self.speeds[0] > 1.0 else 'always'}, from {first} to {last}"
        return f"{'below' if self.speeds[-1] > 1.0 else 'above'} {place:,.0f}"


def crossings(values: Sequence[float], speeds: Sequence[float]) -> list[float]:
    """Where the speed passes 1, ascending; between measured places log speed is linear in log value."""
    along, height = np.log(values), np.log(speeds)
    found = []
    for left in range(len(values) - 1):
        low, high = height[left], height[left + 1]
        if (low > 0.0) != (high > 0.0):
            found.append(float(np.exp(along[left] - low * (along[left + 1] - along[left]) / (high - low))))
    return found


def crossovers(rows: Sequence[Timed], axis: str, fixed: Sequence[str]) -> list[Crossover]:
    """All lines of `rows` along an axis, in every method but the tracer.

    Parameters
    ----------
    rows : sequence
        With the attributes `axis` and `fixed`.
    axis : str
        What changes along a line.
    fixed : sequence of str
        What does not.
    """
    places: dict[tuple[Any, ...], dict[str, float]] = {}
    for row in rows:
        if row.ms:
            places.setdefault(tuple(getattr(row, name) for name in (*fixed, axis)), {})[row.method] = row.ms
    lines: dict[tuple[Any, ...], list[tuple[float, float]]] = {}
    for (*same, value), times in sorted(places.items()):
        for method, ms in times.items():
            if method != COMPETITOR and COMPETITOR in times:
                lines.setdefault((method, *same), []).append((value, times[COMPETITOR] / ms))
    return [
        Crossover(method, tuple(zip(fixed, same, strict=True)), axis, *zip(*line, strict=True))
        for (method, *same), line in lines.items()
        if len(line) > 1
    ]
