"""The measurements of virtual objects, in small."""

from __future__ import annotations

import pytest

from anamorph.base.errors import AnamorphError
from anamorph.bench import virtual_objects
from anamorph.bench.virtual_objects import costs_of, virtual_tables
from anamorph.measure.frame_times import WARM_UP


def cells(table) -> list[list[str]]:
    return [[str(cell) for cell in row] for row in zip(*(column.cells for column in table.columns), strict=True)]


def test_each_part_is_a_table_with_a_row_for_each_method(monkeypatch):
    monkeypatch.setattr(virtual_objects, "REFLECTORS", ("flat-mirror",))
    monkeypatch.setattr(virtual_objects, "MOVING", (("spheres", "ball-0"),))
    monkeypatch.setattr(virtual_objects, "KITCHEN", ("raytrace", virtual_objects.PAPER))
    heard = []
    tables = virtual_tables(("virtual:bounces=1",), (64, 48), 1, report=lambda done, total, what: heard.append(what))
    kitchen, reflectors, moving = map(cells, tables)
    assert [row[0] for row in kitchen] == ["raytrace", virtual_objects.PAPER, "virtual:bounces=1"]
    assert kitchen[1][4] == "1.3" and int(kitchen[1][5]) > 50_000
    assert [row[0] for row in reflectors] == ["flat-mirror, virtual", "flat-mirror, virtual:bounces=1"]
    assert reflectors[0][5] == "0" and float(reflectors[0][7]) == 0.0
    assert [row[0] for row in moving] == [
        "spheres, raytrace; ball-0", "spheres, virtual; ball-0", "spheres, virtual:bounces=1; ball-0"
    ]  # fmt: skip
    assert {"kitchen", "flat-mirror", "spheres: the eye", "spheres: ball-0"} <= set(heard)


def test_what_takes_turns_is_called_in_turns():
    called = []
    draws = {name: lambda turn, name=name: called.append((name, turn)) for name in ("one", "other")}
    costs = costs_of(draws, 2, lambda done, total, what: None, "")
    assert set(costs) == {"one", "other"} and all(cost.clock >= 0.0 and cost.cores >= 0.0 for cost in costs.values())
    assert [name for name, _ in called] == ["one", "other"] * (len(called) // 2)
    assert [turn for name, turn in called if name == "one"] == list(range(-WARM_UP, 2))


def test_an_unknown_part_is_refused_in_one_line():
    with pytest.raises(AnamorphError, match=r"^part 'chairs' is none of kitchen, reflectors, moving; choose one"):
        virtual_tables(parts=("chairs",))
