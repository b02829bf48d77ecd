"""What the measurements come to, on the terminal."""

from __future__ import annotations

import statistics

from rich.table import Table
from rich.text import Text

from anamorph.bench.thesis.benchmark import Results
from anamorph.bench.thesis.cases import CaseTime
from anamorph.bench.thesis.configurations import EXACT, STRAIGHT
from anamorph.bench.thesis.printed import COMPETITOR
from anamorph.bench.thesis.sweeps import RandomTime
from anamorph.measure.figures import number
from anamorph.measure.table import headed


def summary_tables(results: Results) -> list[Table]:
    """Table 8.1, the growth and the crossover: those that were measured."""
    machine = f"{results.adapter}, {results.cores} cores"
    tables = []
    if results.cases:
        tables.append(_case_table(results.cases, machine))
    if results.growth:
        tables.append(_growth_table(results.growth, machine))
        tables.append(_crossover_table(results))
    return tables


def _case_table(rows: list[CaseTime], machine: str) -> Table:
    table = headed(
        "Table 8.1: ms a frame",
        f"{machine}; printed: an 800 MHz Athlon with a GeForce 2 MX, without a tree. "
        "Equal quality: the FLIP of 4 samples a pixel by the tracer, against 16",
        "figure", "size", "method", COMPETITOR, "method's", "times as fast", "at equal quality", "printed", words=3,
    )  # fmt: skip
    tracers = {row.figure: row for row in rows if row.method == COMPETITOR}
    for row in rows:
        tracer = tracers[row.figure]
        if row is tracer:
            continue
        equal = row.equal_quality_ms and tracer.equal_quality_ms and tracer.equal_quality_ms / row.equal_quality_ms
        speeds = (tracer.ms / row.ms, equal, tracer.printed_ms / row.printed_ms)
        cells = (number(value) for value in (tracer.ms, row.ms, *speeds))
        table.add_row(row.figure, f"{row.width} x {row.height}", Text(row.method), *cells)
    return table


def _growth_table(rows: list[RandomTime], machine: str) -> Table:
    methods = list(dict.fromkeys(row.method for row in rows))
    table = headed(
        "Growth with the scene: ms a frame",
        f"{machine}; '-': could not be drawn, see growth.csv",
        "roughness", "size", "ray triangles", "scene triangles", *methods, words=0,
    )  # fmt: skip
    times: dict[tuple[float, int, int, int], dict[str, float | None]] = {}
    for row in rows:
        key = (row.roughness, row.resolution_px, row.trilinear_projections, row.scene_triangles)
        times.setdefault(key, {})[row.method] = row.ms
    for (roughness, pixels, rays, count), timed in sorted(times.items()):
        side = round(pixels**0.5)
        cells = (number(timed[method]) for method in methods)
        table.add_row(number(roughness), f"{side} x {side}", f"{rays:,}", f"{count:,}", *cells)
    return table


def _crossover_table(results: Results) -> Table:
    table = headed(
        "Crossover: where tracing is faster",
        "each line is measured from its least to its greatest value, with all else fixed",
        "method", "roughness", "fixed", "tracing is faster for", words=4,
    )  # fmt: skip
    units = {"pixels_a_ray_triangle": "pixels a ray triangle", "scene_triangles": "scene triangles"}
    for line in results.crossovers:
        (_, roughness), (name, value) = line.fixed
        told = f"{units[line.axis]}: {line.told()}"
        table.add_row(Text(line.method), number(roughness), f"{value:,.0f} {units[name]}", told)
    return table


def exact_over_straight(results: Results) -> str | None:
    """How much longer exact edges take than straight ones, in one line; None where both were not timed."""
    times: dict[tuple[int, int, int], dict[str, float]] = {}
    for row in results.random:
        if row.ms:
            place = (row.resolution_px, row.scene_triangles, row.trilinear_projections)
            times.setdefault(place, {})[row.method] = row.ms
    exact, straight = str(EXACT), str(STRAIGHT)
    ratios = [timed[exact] / timed[straight] for timed in times.values() if {exact, straight} <= timed.keys()]
    if not ratios:
        return None
    low, high = number(min(ratios)), number(max(ratios))
    return (
        f"exact edges take {number(statistics.median(ratios))} times as long as straight ones (median of {len(ratios)} "
        f"places, {low} to {high})"
    )
