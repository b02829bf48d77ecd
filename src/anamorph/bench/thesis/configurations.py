"""One scene triangle in one ray triangle, in the thesis's configurations: tables D.4 to D.7.

A configuration is called by the numbers of corners of the shapes that are seen: figures 4.1 to 4.7, table C. Appendix D
measures one called 9 whose triangles are not printed, and table C prints one called 2,7 that is not measured.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from anamorph.bench.moving import time_methods
from anamorph.bench.thesis.printed import (
    COMPETITOR,
    RAY_TRACING_CONFIGURATIONS,
    TESSELLATION,
    TRILINEAR_CONFIGURATIONS,
    configurations,
    printed,
)
from anamorph.bench.thesis.random_scene import loose_triangles
from anamorph.frame import View
from anamorph.measure.colors import color_errors
from anamorph.methods import Specification
from anamorph.raymesh import RayMesh
from anamorph.rendering import draw_frame
from anamorph.scene.model import Scene

EXACT = Specification.parse("trilinear")
STRAIGHT = EXACT.with_options(edges="straight", clip="screen")
"""As the thesis draws where it says nothing else."""
EXACT_EDGES = "exact"
"""Stands where a way to tessellate does; its factor is 0."""

COLORS = np.eye(3)[None]
"""Of the scene triangle's corners: "arbitrarily specified"."""


@dataclass(frozen=True)
class ConfigurationTime:
    """What a frame takes, milliseconds."""

    configuration: str
    resolution_px: int
    method: str
    ms: float
    least_ms: float
    printed_ms: float | None


@dataclass(frozen=True)
class TessellationError:
    """What a frame with straight edges takes, milliseconds, and its relative error against the tracer's.

    `way` is `tessellate`, `slices`, or `exact`, for which the factor is 0 and nothing is printed.
    """

    configuration: str
    resolution_px: int
    way: str
    tessellation_factor: int
    ms: float
    least_ms: float
    relative_error: float | None
    printed_ms: float | None = None
    printed_relative_error: float | None = None


def configuration_scene(name: str, side: int) -> tuple[Scene, RayMesh]:
    """The scene triangle, and the ray triangle in the upper left half of a square image of `side` pixels."""
    numbers = configurations()[name]
    image = np.array([[0.0, 0.0, 1.0], [side, 0.0, 1.0], [0.0, side, 1.0]])
    faces, status = np.arange(3, dtype=np.int32)[None], np.zeros(3, np.uint8)
    rays = RayMesh(image, numbers[:, 3:6], numbers[:, 6:9], faces, status)
    return loose_triangles(name, numbers[None, :, :3], COLORS), rays


def time_configurations(
    names: Sequence[str],
    sides: Sequence[int],
    methods: Sequence[Specification],
    frames: int,
    report: Callable[[str], None] = lambda what: None,
) -> list[ConfigurationTime]:
    """Time every configuration at every resolution."""
    rows = []
    for name in names:
        for side in sides:
            report(f"configuration {name}, {side} x {side}")
            scene, rays = configuration_scene(name, side)
            for method, timing in time_methods(scene, rays, (side, side), methods, frames).timings.items():
                table = RAY_TRACING_CONFIGURATIONS if str(method) == COMPETITOR else TRILINEAR_CONFIGURATIONS
                known = printed(table, configuration=name, resolution_px=side**2)
                rows.append(ConfigurationTime(name, side**2, str(method), timing.median, timing.min, known))
    return rows


def measure_tessellation(
    names: Sequence[str],
    side: int,
    factors: Sequence[int],
    frames: int,
    report: Callable[[str], None] = lambda what: None,
) -> list[TessellationError]:
    """Time and error of every configuration, by exact edges and by both ways to tessellate, for every factor."""
    rows = []
    for name in names:
        report(f"configuration {name}: tessellation")
        scene, rays = configuration_scene(name, side)
        view = View(scene, rays, (side, side))
        chosen = {(EXACT_EDGES, 0): EXACT}
        chosen |= {(way, factor): STRAIGHT.with_options(**{way: factor}) for way in TESSELLATION for factor in factors}
        reference = draw_frame(view, Specification.parse(COMPETITOR)).color
        counted = _within(side)
        for (way, factor), method in chosen.items():
            timing = time_methods(scene, rays, view.size, [method], frames).timings[method]
            error = color_errors(reference, draw_frame(view, method).color, counted).relative_error
            known = _printed(name, side, way, factor)
            rows.append(TessellationError(name, side**2, way, factor, timing.median, timing.min, error, *known))
    return rows


def _within(side: int) -> np.ndarray:
    """Pixels (side, side) that the ray triangle covers, or does not, whatever the rule for pixels on its border.

    Its long side runs through the middles of a diagonal of pixels: the tracer has rays there and rasterisers have none.
    """
    across = np.add.outer(np.arange(side), np.arange(side))
    return across != side - 1


def _printed(name: str, side: int, way: str, factor: int) -> tuple[float | None, float | None]:
    """Time and relative error as printed."""
    table, key = TESSELLATION.get(way), (name, side**2, factor)
    if table is None:
        return None, None
    named = dict(zip(("configuration", "resolution_px", "tessellation_factor"), key, strict=True))
    return printed(table, "ms", **named), printed(table, "relative_error", **named)
