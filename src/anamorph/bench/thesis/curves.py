"""Which lines the plots have: the thesis's figures, ours on the left and the printed ones on the right."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from operator import attrgetter
from typing import Any

from anamorph.bench.thesis.configurations import EXACT_EDGES, ConfigurationTime, TessellationError
from anamorph.bench.thesis.plots import Line, Panel
from anamorph.bench.thesis.printed import COMPETITOR
from anamorph.bench.thesis.sweeps import RandomTime

HERE = "here"
THESIS = "printed: 800 MHz Athlon, GeForce 2 MX"
PIXELS = "resolution, square pixels"
TRIANGLES = "scene triangles"
PROJECTIONS = "ray triangles"
TIME = "time a frame, ms"
SPEED = "times as fast as ray tracing"


@dataclass(frozen=True)
class Plot:
    """A file name without suffix, a title, and panels."""

    name: str
    title: str
    panels: tuple[Panel, ...]


Key = Callable[[Any], Any]

_method, _pixels, _count = attrgetter("method"), attrgetter("resolution_px"), attrgetter("scene_triangles")
_rays, _ms, _printed_ms = attrgetter("trilinear_projections"), attrgetter("ms"), attrgetter("printed_ms")
_place = attrgetter("resolution_px", "scene_triangles", "trilinear_projections", "roughness")


def _lines(figures: Iterable[tuple[Any, float | None]], x: Key, group: Key, kind: Key = _method) -> tuple[Line, ...]:
    """Rows with their figures, where they have one, as lines: one for each group and kind, ascending in x."""
    found: dict[tuple[Any, str], dict[float, float]] = {}
    for row, y in figures:
        if y is not None:
            found.setdefault((group(row), kind(row)), {})[x(row)] = y
    named = sorted(found.items(), key=lambda item: item[0])
    return tuple(
        Line(_named(label), method, *zip(*sorted(points.items()), strict=True)) for (label, method), points in named
    )


def _named(group: tuple[str, Any] | str) -> str:
    if isinstance(group, str):
        return group
    unit, value = group
    return f"{value:,} {unit}"


def _as_printed(row: Any) -> str:
    """What a printed line is called: the thesis has one way to draw, with straight edges."""
    return row.method if row.method == COMPETITOR else "trilinear as printed"


def _speeds(rows: Sequence[Any], place: Key, ms: Key) -> list[tuple[Any, float]]:
    """Rows of what is not the tracer, with their speeds by `ms`, where that is known of both."""
    traced = {place(row): ms(row) for row in rows if row.method == COMPETITOR}
    others = [row for row in rows if row.method != COMPETITOR]
    return [(row, traced[place(row)] / ms(row)) for row in others if traced.get(place(row)) and ms(row)]


def _both(rows: Sequence[Any], x: Key, group: Key, label: str) -> tuple[Panel, Panel]:
    """Times here and printed."""
    ours = _lines(((row, row.ms) for row in rows), x, group)
    theirs = _lines(((row, row.printed_ms) for row in rows), x, group, _as_printed)
    return Panel(HERE, label, TIME, ours), Panel(THESIS, label, TIME, theirs)


def _both_speeds(rows: Sequence[Any], place: Key, x: Key, group: Key, label: str) -> tuple[Panel, Panel]:
    """Speeds here and printed."""
    ours = _lines(_speeds(rows, place, _ms), x, group)
    theirs = _lines(_speeds(rows, place, _printed_ms), x, group, _as_printed)
    return Panel(HERE, label, SPEED, ours, even=1.0), Panel(THESIS, label, SPEED, theirs, even=1.0)


def _by_count(row: RandomTime) -> tuple[str, int]:
    return TRIANGLES, row.scene_triangles


def _by_pixels(row: RandomTime) -> tuple[str, int]:
    return "pixels", row.resolution_px


def random_plots(rows: Sequence[RandomTime]) -> list[Plot]:
    """Figures 8.2 to 8.8 and 8.13 to 8.15."""
    least, most = min(map(_rays, rows)), max(map(_count, rows))
    single = [row for row in rows if row.trilinear_projections == least]
    largest = [row for row in rows if row.scene_triangles == most]
    few = _lasting(single, _count, _pixels)
    some = _lasting(single, _pixels, _count)
    wide = _lasting(largest, _pixels, _rays)
    return [
        Plot("resolution", "Figures 8.2, 8.5: time", _both(few, _pixels, _by_count, PIXELS)),
        Plot("scene-triangles", "Figures 8.3, 8.6: time", _both(some, _count, _by_pixels, TRIANGLES)),
        Plot("speed-resolution", "Figure 8.8: speed", _both_speeds(few, _place, _pixels, _by_count, PIXELS)),
        Plot("ray-triangles", "Figures 8.13, 8.14: time", _both(wide, _rays, _by_pixels, PROJECTIONS)),
        Plot("speed-ray-triangles", "Figure 8.15: speed", _both_speeds(wide, _place, _rays, _by_pixels, PROJECTIONS)),
    ]  # fmt: skip


def _lasting(rows: Sequence[Any], group: Key, x: Key) -> list[Any]:
    """Those of the rows whose groups have most places on the axis: whole lines, and no points of others."""
    places: dict[Any, set] = {}
    for row in rows:
        places.setdefault(group(row), set()).add(x(row))
    longest = max(map(len, places.values()))
    return [row for row in rows if len(places[group(row)]) == longest]


def clip_plots(rows: Sequence[RandomTime], straight: str, clipped: str) -> list[Plot]:
    """Figure 8.16: how much longer clipping in the scene takes than clipping on the screen."""
    plain = {_place(row): row for row in rows if row.method == straight}
    pairs = [(row, plain[_place(row)]) for row in rows if row.method == clipped]

    def panel(title: str, ms: Key) -> Panel:
        slower = ((row, ms(row) / ms(fast)) for row, fast in pairs if ms(row) and ms(fast))
        lines = _lines(slower, _rays, _by_count)
        return Panel(title, PROJECTIONS, "time with clipping in the scene, relative", lines, logarithmic=False)

    panels = (panel(HERE, _ms), panel(THESIS, _printed_ms))
    return [Plot("clipping", "Figure 8.16: clipping in the scene over clipping on the screen", panels)]


def configuration_plots(rows: Sequence[ConfigurationTime]) -> list[Plot]:
    """Figures 8.1, 8.4 and 8.7."""

    def group(row: ConfigurationTime) -> str:
        return f"({row.configuration})"

    place = attrgetter("configuration", "resolution_px")
    return [
        Plot("configurations", "Figures 8.1, 8.4: time", _both(rows, _pixels, group, PIXELS)),
        Plot("speed-configurations", "Figure 8.7: speed", _both_speeds(rows, place, _pixels, group, PIXELS)),
    ]  # fmt: skip


def tessellation_plots(rows: Sequence[TessellationError]) -> list[Plot]:
    """Figures 8.9 to 8.12."""
    cut = [row for row in rows if row.way != EXACT_EDGES]
    error = "relative error"
    return [
        _tessellation("error", "Figures 8.9, 8.10: error", cut, error, "relative_error", False),
        _tessellation("error-mean", "Figure 8.11: error, mean of configurations", rows, error, "relative_error", True),
        _tessellation("tessellation-time", "Figure 8.12: time, mean of configurations", rows, TIME, "ms", True),
    ]


def _tessellation(name: str, title: str, rows: Sequence[TessellationError], label: str, value: str, mean: bool) -> Plot:
    def panel(heading: str, field: str) -> Panel:
        found: dict[tuple[str, str], dict[int, list[float]]] = {}
        exact: dict[str, list[float]] = {}
        for row in rows:
            figure, group = getattr(row, field), "mean" if mean else f"({row.configuration})"
            if figure is not None and row.way == EXACT_EDGES:
                exact.setdefault(group, []).append(figure)
            elif figure is not None:
                found.setdefault((group, row.way), {}).setdefault(row.tessellation_factor, []).append(figure)
        lines = [
            Line(group, way, *zip(*((f, sum(v) / len(v)) for f, v in sorted(points.items())), strict=True))
            for (group, way), points in found.items()
        ]
        ends = sorted({factor for points in found.values() for factor in points})
        for group, figures in exact.items():
            level = sum(figures) / len(figures)
            lines.append(Line(group, EXACT_EDGES, (ends[0], ends[-1]), (level, level)))
        return Panel(heading, "tessellation factor", label, tuple(lines))

    return Plot(name, title, (panel(HERE, value), panel(THESIS, f"printed_{value}")))


def growth_plots(rows: Sequence[RandomTime]) -> list[Plot]:
    """Time against scene triangles, and speed against pixels a ray triangle: what the crossover is read from."""
    plots = []
    for roughness in sorted({row.roughness for row in rows}):
        those = [row for row in rows if row.roughness == roughness]
        times = _lines(((row, row.ms) for row in those), _count, lambda row: (PROJECTIONS, _rays(row)))
        speeds = _lines(_speeds(those, _place, _ms), attrgetter("pixels_a_ray_triangle"), _by_count)
        panels = (
            Panel("time", TRIANGLES, TIME, times),
            Panel("speed", "pixels a ray triangle", SPEED, speeds, even=1.0),
        )
        plots.append(Plot(f"growth-roughness-{roughness:g}", f"Growth and crossover, roughness {roughness:g}", panels))
    return plots
