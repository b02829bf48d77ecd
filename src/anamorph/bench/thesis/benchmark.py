"""All measurements of chapter 8 and appendix D in one run, and the files they are written to."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from itertools import count
from pathlib import Path
from typing import Any

from anamorph.base.compiled import cores
from anamorph.base.errors import AnamorphError, nearest
from anamorph.base.output import save_text
from anamorph.base.progress import Report
from anamorph.bench.crossover import Crossover, crossovers
from anamorph.bench.thesis.cases import CaseTime, cases, time_cases
from anamorph.bench.thesis.configurations import (
    EXACT,
    STRAIGHT,
    ConfigurationTime,
    TessellationError,
    measure_tessellation,
    time_configurations,
)
from anamorph.bench.thesis.curves import (
    Plot,
    clip_plots,
    configuration_plots,
    growth_plots,
    random_plots,
    tessellation_plots,
)
from anamorph.bench.thesis.plots import can_plot, save_plot
from anamorph.bench.thesis.printed import (
    CLIPPED,
    COMPETITOR,
    RAY_TRACING,
    RAY_TRACING_CONFIGURATIONS,
    TESSELLATION,
    TRILINEAR,
    TRILINEAR_CONFIGURATIONS,
    configurations,
)
from anamorph.bench.thesis.sweeps import Place, RandomTime, clip_lines, lines_through, time_random
from anamorph.bench.written import as_csv
from anamorph.gpu.device import adapter_name
from anamorph.methods import Specification

CLIPPED_STRAIGHT = STRAIGHT.with_options(clip="scene")
SMOOTHED = EXACT.with_options(antialias=4)
DEFAULT = (EXACT, STRAIGHT)
"""What is timed beside the tracer where nothing is chosen; in the cases, `EXACT` and `SMOOTHED`."""

SMOOTH = 0.15
"""The roughness of ray meshes that neighbouring rays of mirrors and lenses are like."""

PARTS = ("random", "clipping", "configurations", "tessellation", "growth", "cases")


@dataclass(frozen=True)
class Extent:
    """How much is measured; lengths of sides are in pixels, `quads` are along a side of the ray mesh."""

    frames: int
    sides: tuple[int, ...]
    counts: tuple[int, ...]
    quads: tuple[int, ...]
    configuration_sides: tuple[int, ...]
    configurations: int
    factors: tuple[int, ...]
    growth: tuple[Place, ...]
    case_scale: float
    cases: int


FULL = Extent(
    frames=3,
    sides=(1, 128, 256, 384, 512, 640),
    counts=(1, 128, 256, 384, 512, 640),
    quads=(1, 2, 3, 4, 5),
    configuration_sides=(128, 256, 384, 512, 640),
    configurations=7,
    factors=(1, 2, 3, 4, 6, 8, 10, 20, 40, 60),
    growth=(
        *(Place(512, count, quads, SMOOTH) for count in (100, 1000, 10_000) for quads in (1, 5, 10, 20)),
        *(Place(512, 100_000, quads, SMOOTH) for quads in (1, 5)),
        *(Place(512, count, quads) for count in (100, 1000) for quads in (1, 3, 5, 7)),
        Place(512, 10_000, 5),
    ),
    case_scale=1.0,
    cases=14,
)
QUICK = Extent(
    frames=1,
    sides=(1, 32, 128),
    counts=(1, 16, 128),
    quads=(1, 2),
    configuration_sides=(32, 128),
    configurations=2,
    factors=(1, 4, 10),
    growth=tuple(Place(64, count, quads, SMOOTH) for count in (100, 1000) for quads in (1, 5)),
    case_scale=0.1,
    cases=4,
)


@dataclass(frozen=True)
class Results:
    """What was measured; parts that were not asked for are empty."""

    adapter: str
    cores: int
    random: list[RandomTime] = field(default_factory=list)
    clipping: list[RandomTime] = field(default_factory=list)
    configurations: list[ConfigurationTime] = field(default_factory=list)
    tessellation: list[TessellationError] = field(default_factory=list)
    growth: list[RandomTime] = field(default_factory=list)
    cases: list[CaseTime] = field(default_factory=list)

    @property
    def crossovers(self) -> list[Crossover]:
        """Along pixels a ray triangle, then along scene triangles."""
        rays, scene = "pixels_a_ray_triangle", "scene_triangles"
        return [
            *crossovers(self.growth, rays, ("roughness", scene)),
            *crossovers(self.growth, scene, ("roughness", rays)),
        ]


def measure_thesis(
    methods: Sequence[Specification] = (),
    extent: Extent = FULL,
    parts: Sequence[str] = PARTS,
    report: Report = lambda done, total, what: None,
) -> Results:
    """Measure the tracer and `methods`.

    Without `methods`, they are `DEFAULT`. Clipping and tessellation are ways of drawing with straight edges, and
    measured with them whatever `methods` are.
    """
    for part in parts:
        if part not in PARTS:
            raise AnamorphError(f"part: there is no {part!r}; parts are {', '.join(PARTS)}{nearest(part, PARTS)}")
    timed = tuple(dict.fromkeys((Specification.parse(COMPETITOR), *(methods or DEFAULT))))
    drawn = tuple(methods or (EXACT, SMOOTHED))
    places = lines_through(extent.sides, extent.counts, extent.quads)
    clipped = clip_lines(extent.sides, extent.counts, extent.quads)
    names, chosen = tuple(configurations())[: extent.configurations], cases(extent.case_scale)[: extent.cases]
    sides, frames, done = extent.configuration_sides, extent.frames, count()

    def as_step(what: str) -> None:
        report(next(done), sum(runs[part][0] for part in parts), what)

    runs: dict[str, tuple[int, Callable[[], list]]] = {
        "random": (len(places), lambda: time_random(places, timed, frames, as_step)),
        "clipping": (len(clipped), lambda: time_random(clipped, (STRAIGHT, CLIPPED_STRAIGHT), frames, as_step)),
        "configurations": (len(names) * len(sides), lambda: time_configurations(names, sides, timed, frames, as_step)),
        "tessellation": (
            len(names),
            lambda: measure_tessellation(names, extent.sides[-1], extent.factors, frames, as_step),
        ),
        "growth": (len(extent.growth), lambda: time_random(extent.growth, timed, frames, as_step)),
        "cases": (len(chosen), lambda: time_cases(chosen, drawn, frames, as_step)),
    }
    return Results(adapter_name(), cores(), **{part: runs[part][1]() for part in PARTS if part in parts})


def write_results(results: Results, directory: Path) -> list[Path]:
    """Write a CSV for each of the thesis's tables that was measured, and plots where matplotlib is installed."""
    directory.mkdir(parents=True, exist_ok=True)
    written = []
    for name, rows in _tables(results).items():
        if rows:
            written.append(directory / f"{name}.csv")
            save_text(written[-1], as_csv(rows, results.adapter, results.cores))
    for plot in _plots(results) if can_plot() else ():
        written.append(directory / f"{plot.name}.png")
        save_plot(written[-1], plot.title, plot.panels)
    return written


def _tables(results: Results) -> dict[str, list]:
    """Under the names of the printed ones, where there are such."""
    timed = [*results.random, *results.clipping]
    traced = [row for row in results.configurations if row.method == COMPETITOR]
    return {
        RAY_TRACING: [row for row in timed if row.method == COMPETITOR],
        TRILINEAR: [row for row in timed if row.method not in (COMPETITOR, str(CLIPPED_STRAIGHT))],
        CLIPPED: [row for row in timed if row.method == str(CLIPPED_STRAIGHT)],
        RAY_TRACING_CONFIGURATIONS: traced,
        TRILINEAR_CONFIGURATIONS: [row for row in results.configurations if row.method != COMPETITOR],
        **{
            table: [row for row in results.tessellation if row.way != other]
            for (_, table), other in zip(TESSELLATION.items(), reversed(TESSELLATION), strict=True)
        },
        "growth": results.growth,
        "table-8-1": results.cases,
    }


def _plots(results: Results) -> list[Plot]:
    makers: tuple[tuple[Sequence, Callable[[Any], list[Plot]]], ...] = (
        (results.random, random_plots),
        (results.clipping, lambda rows: clip_plots(rows, str(STRAIGHT), str(CLIPPED_STRAIGHT))),
        (results.configurations, configuration_plots),
        (results.tessellation, tessellation_plots),
        (results.growth, growth_plots),
    )
    return [plot for rows, make in makers if rows for plot in make(rows)]
