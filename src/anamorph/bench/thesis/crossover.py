"""Where tracing becomes the faster way: from what number of pixels a ray triangle, and of scene triangles."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from anamorph.bench.thesis.printed import COMPETITOR
from anamorph.bench.thesis.sweeps import RandomTime


@dataclass(frozen=True)
class Crossover:
    """Along one axis, with all others fixed: how much faster a method is than the tracer, and where that is 1.

    Parameters
    ----------
    method : str
    fixed : tuple of (str, float)
        What is the same along the line.
    axis : str
        `pixels_a_ray_triangle` or `scene_triangles`.
    values, speeds : tuple of float
        Along the axis, ascending: how many frames the method draws while the tracer draws one.
    """

    method: str
    fixed: tuple[tuple[str, float], ...]
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


def crossovers(rows: Sequence[RandomTime], axis: str) -> list[Crossover]:
    """All lines along an axis, in every method but the tracer."""
    other = "scene_triangles" if axis == "pixels_a_ray_triangle" else "pixels_a_ray_triangle"
    places: dict[tuple[float, float, float], dict[str, float]] = {}
    for row in rows:
        key = (row.roughness, getattr(row, other), getattr(row, axis))
        if row.ms:
            places.setdefault(key, {})[row.method] = row.ms
    lines: dict[tuple[str, float, float], list[tuple[float, float]]] = {}
    for (roughness, fixed, value), times in sorted(places.items()):
        for method, ms in times.items():
            if method != COMPETITOR and COMPETITOR in times:
                lines.setdefault((method, roughness, fixed), []).append((value, times[COMPETITOR] / ms))
    return [
        Crossover(method, (("roughness", roughness), (other, fixed)), axis, *zip(*line, strict=True))
        for (method, roughness, fixed), line in lines.items()
        if len(line) > 1
    ]
