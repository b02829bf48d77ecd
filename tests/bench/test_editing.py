"""Steps of a slider, timed in small scenes."""

from __future__ import annotations

from anamorph.bench.editing import editing_table
from anamorph.cli import commands as cli
from anamorph.methods import Specification


def test_a_step_is_timed_in_every_scene_by_every_method():
    done = []
    methods = [Specification.parse(text) for text in ("environment:face=32", "raytrace:bounces=1")]
    table = editing_table(methods, (40, 30), 1, lambda *progress: done.append(progress[:2]), counts=(300, 600))
    assert done == [(0, 4), (1, 4), (2, 4), (3, 4)]
    assert [str(cell) for cell in table.columns[1].cells] == 2 * [str(method) for method in methods]
    assert all(float(cell) > 0.0 for column in table.columns[2:] for cell in column.cells)


def test_a_wrong_method_is_one_line(capsys):
    assert cli.main(["bench", "editing", "-m", "envronment"]) == 2
    said = capsys.readouterr().err
    assert "environment" in said and said.count("\n") == 1
