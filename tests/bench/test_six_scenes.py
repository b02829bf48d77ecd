"""The measurements of the paper on three-ray cameras, made again: printed figures, scenes, files and the command."""

from __future__ import annotations

import csv

import numpy as np
import pytest

from anamorph.base.errors import AnamorphError
from anamorph.bench.hybrid import six_scenes
from anamorph.bench.hybrid.hybrid_tables import six_scene_tables, write_six_scenes
from anamorph.bench.hybrid.six_scenes import PAPERS, Amount, SixScenes, depths, measure_six_scenes, printed
from anamorph.cli import commands as cli
from anamorph.gallery.beside_teapot import OBJECTS
from anamorph.methods import Specification

SMALL = Amount(("Dinosaur",), 0.05, (48, 36), ("Dinosaur",), ((24, 18), (48, 36)), 1)


def test_the_printed_figures_are_whole_and_the_objects_have_their_numbers():
    trees, frames = printed("table-1"), printed("table-2")
    assert list(trees) == list(frames) == list(OBJECTS)
    assert {name: row["points"] for name, row in trees.items()} == {
        name: each.triangles for name, each in OBJECTS.items()
    }
    for row in frames.values():
        assert row["culling_ms"] + row["projection_ms"] == row["ms"]


def test_a_trees_depths_are_the_nodes_above_each():
    # a root over a leaf and over a node that has two leaves
    assert depths(np.array([5, 1, 3, 1, 1])).tolist() == [0, 1, 1, 2, 2]
    assert depths(np.array([1])).tolist() == [0]


@pytest.fixture(scope="module")
def results():
    told = []
    made = measure_six_scenes(
        [Specification.parse("environment")], SMALL, report=lambda done, total, what: told.append((done, total))
    )
    assert told == [(done, 4) for done in range(4)]
    return made


def test_the_tables_have_the_papers_rows_beside_ours(results, tmp_path):
    written = write_six_scenes(results, tmp_path / "new")
    tables = {path.stem: list(csv.DictReader(path.read_text().splitlines())) for path in written}
    assert set(tables) == {"table-1", "table-2", "growth"}
    (tree,) = tables["table-1"]
    assert float(tree["printed_ms"]) == 6.0 and float(tree["ms"]) > 0.0
    assert int(tree["points"]) > 500 and 1.0 <= float(tree["points_a_leaf"]) <= 8.0
    assert float(tree["depth"]) == pytest.approx(np.log2(int(tree["points"]) / float(tree["points_a_leaf"])), abs=1.0)
    by_method = {row["method"]: row for row in tables["table-2"]}
    assert list(by_method) == ["raytrace", "threeray", str(PAPERS), "environment"]
    assert [row["printed_ms"] for row in by_method.values()] == ["", "", "48", ""]
    phases = by_method[str(PAPERS)]
    assert float(phases["culling_ms"]) > 0.0 and 0.0 < float(phases["valid_percent"]) <= 100.0
    assert float(phases["culling_ms"]) + float(phases["projection_ms"]) == pytest.approx(float(phases["ms"]), rel=1e-4)
    assert all(float(row["ms"]) > 0.0 and int(row["cores"]) == results.cores for row in tables["growth"])
    assert [row["printed_ms"] for row in tables["growth"] if row["width"] == "24"] == ["", "", "", ""]
    pixels = {row["width"]: int(row["pixels"]) for row in tables["growth"]}
    assert pixels["48"] == pytest.approx(4 * pixels["24"], rel=0.2)


def test_the_summary_says_what_was_measured_and_where_tracing_wins(results):
    titles = [str(table.title) for table in six_scene_tables(results)]
    assert [title.split(":")[0] for title in titles] == ["Table 1", "Table 2", "Growth with the image", "Crossover"]
    lines = results.crossovers
    assert [line.method for line in lines] == ["threeray", str(PAPERS), "environment"]
    assert {line.axis for line in lines} == {"pixels_a_camera"}
    assert six_scene_tables(SixScenes("", 1)) == []


def test_the_command_measures_a_part_and_an_unknown_one_is_refused(monkeypatch, tmp_path, capsys):
    monkeypatch.setattr(six_scenes, "QUICK", SMALL)
    assert cli.main(["bench", "threeray", "--quick", "--part", "trees", "--output", str(tmp_path)]) == 0
    assert [path.name for path in tmp_path.iterdir()] == ["table-1.csv"]
    assert "Table 1" in capsys.readouterr().out
    with pytest.raises(AnamorphError, match=r"^part: there is no 'tree'; parts are trees, frames, growth.*$"):
        measure_six_scenes(parts=("tree",))
