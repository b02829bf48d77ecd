"""Which lines the plots have: the thesis's figures, ours on the left and the printed ones on the right."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
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


def _lines(rows: Iterable[Any], x: Key, y: Key, group: Key, kind: Key) -> tuple[Line, ...]:
    """Rows that have a figure as lines, one for each group and kind, ascending in x."""
    found: dict[tuple[Any, str], dict[float, float]] = {}
    for row in rows:
        if y(row) is not None:
            found.setdefault((group(row), kind(row)), {})[x(row)] = y(row)
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


def _speeds(rows: Sequence[Any], place: Key) -> list[tuple[Any, float, float | None]]:
    """(row, speed here, printed speed) of what is not the tracer, where the tracer was timed as well."""
    traced = {place(row): row for row in rows if row.method == COMPETITOR}
    found = []
    for row in rows:
        tracer = traced.get(place(row))
        if row.method != COMPETITOR and tracer and tracer.ms and row.ms:
            known = tracer.printed_ms / row.printed_ms if tracer.printed_ms and row.printed_ms else None
            found.append((row, tracer.ms / row.ms, known))
    return found


def _both(rows: Sequence[Any], x: Key, group: Key, label: str) -> tuple[Panel, Panel]:
    """Times here and printed."""
    ours = _lines(rows, x, lambda row: row.ms, group, lambda row: row.method)
    theirs = _lines(rows, x, lambda row: row.printed_ms, group, _as_printed)
    return Panel(HERE, label, TIME, ours), Panel(THESIS, label, TIME, theirs)


def _both_speeds(rows: Sequence[Any], place: Key, x: Key, group: Key, label: str) -> tuple[Panel, Panel]:
    """Speeds here and printed."""
    speeds = _speeds(rows, place)
    ours = _lines(speeds, lambda s: x(s[0]), lambda s: s[1], lambda s: group(s[0]), lambda s: s[0].method)
    theirs = _lines(speeds, lambda s: x(s[0]), lambda s: s[2], lambda s: group(s[0]), lambda s: _as_printed(s[0]))
    return Panel(HERE, label, SPEED, ours, even=1.0), Panel(THESIS, label, SPEED, theirs, even=1.0)


def _pixels(row: Any) -> int:
    return row.resolution_px


def _count(row: RandomTime) -> int:
    return row.scene_triangles


def _rays(row: RandomTime) -> int:
    return row.trilinear_projections


def _by_count(row: RandomTime) -> tuple[str, int]:
    return TRIANGLES, row.scene_triangles


def _by_pixels(row: RandomTime) -> tuple[str, int]:
    return "pixels", row.resolution_px


def _place(row: RandomTime) -> tuple[int, int, int, float]:
    return row.resolution_px, row.scene_triangles, row.trilinear_projections, row.roughness


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
        slow = [(row, ms(row) / ms(fast)) for row, fast in pairs if ms(row) and ms(fast)]
        lines = _lines(slow, lambda s: _rays(s[0]), lambda s: s[1], lambda s: _by_count(s[0]), lambda s: s[0].method)
        return Panel(title, PROJECTIONS, "time with clipping in the scene, relative", lines, logarithmic=False)

    panels = (panel(HERE, lambda row: row.ms), panel(THESIS, lambda row: row.printed_ms))
    return [Plot("clipping", "Figure 8.16: clipping in the scene over clipping on the screen", panels)]


def configuration_plots(rows: Sequence[ConfigurationTime]) -> list[Plot]:
    """Figures 8.1, 8.4 and 8.7."""

    def group(row: ConfigurationTime) -> str:
        return f"({row.configuration})"

    def place(row: ConfigurationTime) -> tuple[str, int]:
        return row.configuration, row.resolution_px

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
        speeds = _speeds(those, _place)
        times = _lines(those, _count, lambda row: row.ms, lambda row: (PROJECTIONS, _rays(row)), lambda row: row.method)
        share = _lines(
            speeds,
            lambda s: s[0].pixels_a_ray_triangle,
            lambda s: s[1],
            lambda s: _by_count(s[0]),
            lambda s: s[0].method,
        )
        panels = (
            Panel("time", TRIANGLES, TIME, times),
            Panel("speed", "pixels a ray triangle", SPEED, share, even=1.0),
        )
        plots.append(Plot(f"growth-roughness-{roughness:g}", f"Growth and crossover, roughness {roughness:g}", panels))
    return plots
