"""What was measured of the six scenes, beside what the paper prints: files, and tables on the terminal."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from rich.table import Table
from rich.text import Text

from anamorph.base.output import save_text
from anamorph.bench.hybrid.six_scenes import FRAMES, TREES, SceneTime, SixScenes, TreeTime
from anamorph.bench.written import as_csv
from anamorph.measure.compare import COMPETITOR
from anamorph.measure.figures import number
from anamorph.measure.table import headed

PRINTED = "in brackets: as printed, of a 3.4 GHz Pentium 4 with a Quadro FX 3400"
UNITS = {"triangles": "triangles", "pixels_a_camera": "pixels a camera"}


def write_six_scenes(results: SixScenes, directory: Path) -> list[Path]:
    """Write a CSV for each table that was measured."""
    directory.mkdir(parents=True, exist_ok=True)
    written = []
    tables: dict[str, Sequence[TreeTime | SceneTime]] = {
        TREES: results.trees,
        FRAMES: results.frames,
        "growth": results.growth,
    }
    for name, rows in tables.items():
        if rows:
            written.append(directory / f"{name}.csv")
            save_text(written[-1], as_csv(rows, results.adapter, results.cores))
    return written


def six_scene_tables(results: SixScenes) -> list[Table]:
    """Tables 1 and 2, the growth with the image and the crossover: those that were measured."""
    machine = f"{results.adapter}, {results.cores} cores"
    tables = [_tree_table(results.trees, machine)] if results.trees else []
    if results.frames:
        tables.append(_frame_table("Table 2: ms a frame", results.frames, machine))
    if results.growth:
        tables.append(_frame_table("Growth with the image: ms a frame", results.growth, machine))
    return [*tables, *([_crossover_table(results)] if results.crossovers else [])]


def _beside(ours: float | None, theirs: float | None) -> str:
    return number(ours) if theirs is None else f"{number(ours)} ({number(theirs)})"


def _over(theirs: float | None, ours: float | None) -> str:
    return number(theirs / ours if theirs and ours else None)


def _tree_table(rows: list[TreeTime], machine: str) -> Table:
    table = headed(
        "Table 1: making the tree",
        f"{machine}, one of them; depths are of halves, and of an eight-way tree in the paper; {PRINTED}",
        "scene", "points", "ms", "depth", "points a leaf",
    )  # fmt: skip
    for row in rows:
        table.add_row(
            row.scene,
            f"{row.points:,} ({row.printed_points:,.0f})",
            _beside(row.ms, row.printed_ms),
            _beside(row.depth, row.printed_depth),
            _beside(row.points_a_leaf, row.printed_points_a_leaf),
        )
    return table


def _frame_table(title: str, rows: list[SceneTime], machine: str) -> Table:
    table = headed(
        title,
        f"{machine}; '-': has no such phase, or could not be drawn; CPU time is that of all threads; {PRINTED}",
        "scene", "size", "method", "triangles", "pixels a camera", "whole frame", f"{COMPETITOR}'s",
        "times as fast", "by CPU time", "culling", "projection", "valid, %", words=3,
    )  # fmt: skip
    tracers = {(row.scene, row.width): row for row in rows if row.method == COMPETITOR}
    for row in rows:
        tracer = tracers[row.scene, row.width]
        if row.method == COMPETITOR:
            continue
        phases = (
            _beside(row.culling_ms, row.printed_culling_ms),
            _beside(row.projection_ms, row.printed_projection_ms),
            _beside(row.valid_percent, row.printed_valid_percent),
        )
        table.add_row(
            row.scene, f"{row.width} x {row.height}", Text(row.method), f"{row.triangles:,}",
            number(row.pixels_a_camera), _beside(row.ms, row.printed_ms), number(tracer.ms),
            _over(tracer.ms, row.ms), _over(tracer.cpu_ms, row.cpu_ms), *phases,
        )  # fmt: skip
    return table


def _crossover_table(results: SixScenes) -> Table:
    table = headed(
        "Crossover: where tracing is faster",
        "each line is measured from its least to its greatest value, with all else fixed",
        "method", "fixed", "tracing is faster for", words=3,
    )  # fmt: skip
    for line in results.crossovers:
        fixed = " x ".join(str(value) for _, value in line.fixed)
        table.add_row(Text(line.method), fixed, f"{UNITS[line.axis]}: {line.told()}")
    return table
