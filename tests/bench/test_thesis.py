"""The measurements of the thesis on trilinear projection, made again: data, figures, files and the command."""

from __future__ import annotations

import csv
import sys
from dataclasses import fields, replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from PIL import Image

from anamorph.base.errors import AnamorphError
from anamorph.bench.crossover import crossings, crossovers
from anamorph.bench.moving import camera_path, open_sessions, time_methods
from anamorph.bench.thesis import benchmark, plots, printed
from anamorph.bench.thesis.benchmark import CLIPPED_STRAIGHT, PARTS, QUICK, Results, measure_thesis, write_results
from anamorph.bench.thesis.cases import cases, frames_for
from anamorph.bench.thesis.configurations import (
    EXACT,
    STRAIGHT,
    TessellationError,
    configuration_scene,
    measure_tessellation,
)
from anamorph.bench.thesis.curves import clip_plots, random_plots, tessellation_plots
from anamorph.bench.thesis.printed import TESSELLATION, configurations, random_table, rows
from anamorph.bench.thesis.random_scene import RADIUS, random_ray_mesh, random_triangles
from anamorph.bench.thesis.summary import exact_over_straight, summary_tables
from anamorph.bench.thesis.sweeps import Place, RandomTime, clip_lines, lines_through, time_random
from anamorph.cli import commands as cli
from anamorph.frame import View
from anamorph.methods import Specification
from anamorph.methods.trilinear.straight import project_triangle

SIZE = (48, 48)
FIXED = ("roughness", "pixels_a_ray_triangle")
TRACER = Specification.parse("raytrace")
STAND_IN = TRACER.with_options(bounces=1)
"""A second method that draws the same, at the same cost."""
SMALL = replace(QUICK, sides=(1, 24), counts=(1, 40), quads=(1, 2), configuration_sides=(24,), factors=(1, 4))


def time(method="trilinear", ms=1.0, pixels=100, count=10, rays=2, roughness=1.0, known=None):
    return RandomTime(pixels, count, rays, roughness, method, ms, ms, known)


def drawn(scene, rays, method="raytrace", size=SIZE):
    session = Specification.parse(method).open(View(scene, rays, size))
    session.draw(rays)
    return session.frame(seen=True)


@settings(max_examples=30)
@given(
    quads=st.integers(1, 6),
    seed=st.integers(0, 2**31),
    roughness=st.sampled_from([0.0, 0.15, 0.5, 1.0]),
    count=st.sampled_from([1, 2, 128, 640, 2560]),
)
def test_random_data_are_regular_on_the_screen_and_hold_to_their_seed(quads, seed, roughness, count):
    rays = random_ray_mesh(quads, SIZE, seed, roughness)
    assert len(rays.faces) == 2 * quads**2
    assert (np.unique(rays.places().round(6)) == np.linspace(0, SIZE[0], quads + 1).round(6)).all()
    assert np.linalg.norm(rays.directions, axis=1) == pytest.approx(1.0)
    again = random_ray_mesh(quads, SIZE, seed, roughness)
    assert (again.origins == rays.origins).all() and (again.directions == rays.directions).all()
    mesh = random_triangles(count, rays, seed).meshes[0]
    assert mesh.faces.shape == (count, 3) and len(np.unique(mesh.faces)) == 3 * count
    corners = mesh.positions[mesh.faces].astype(float)
    largest = np.linalg.norm(corners - corners.mean(axis=1, keepdims=True), axis=2).max(axis=1)
    assert largest == pytest.approx(RADIUS * min(1.0, 640 / count) ** 0.5, rel=1e-3)
    assert (random_triangles(count, rays, seed).meshes[0].positions == mesh.positions).all()


def test_seeds_give_other_data():
    one, other = (random_ray_mesh(2, SIZE, seed) for seed in (1, 2))
    assert (one.origins != other.origins).any()
    assert (random_triangles(5, one, 1).meshes[0].positions != random_triangles(5, one, 2).meshes[0].positions).any()


def test_without_roughness_rays_are_parallel():
    assert np.ptp(random_ray_mesh(3, SIZE, roughness=0.0).directions, axis=0) == pytest.approx(0.0)


@pytest.mark.parametrize("roughness", [0.15, 1.0])
@pytest.mark.parametrize("seed", range(4))
def test_one_random_triangle_is_seen(roughness, seed):
    size = (200, 200)
    rays = random_ray_mesh(2, size, seed, roughness)
    frame = drawn(random_triangles(1, rays, seed), rays, size=size)
    assert 0.0 < (frame.object_id > 0).mean() < 1.0


def test_colours_are_those_of_the_corners_without_lighting():
    scene, rays = configuration_scene("3,3,3", SIZE[0])
    frame = drawn(scene, rays)
    seen = frame.object_id > 0
    assert seen.any()
    # red, green and blue at the corners: the shares of the three add up to 1, and the sky is black
    assert frame.color[seen].sum(axis=-1) == pytest.approx(1.0, abs=2e-3)
    assert frame.color[~seen].max(initial=0.0) == 0.0


def test_a_moving_camera_is_never_the_same_and_stays_near():
    rays = random_ray_mesh(2, SIZE)
    path = camera_path(View(random_triangles(3, rays), rays, SIZE), 5)
    moved = np.array([camera.origins - rays.origins for camera in path])
    assert np.ptp(moved, axis=1) == pytest.approx(0.0, abs=1e-12)
    far = np.linalg.norm(moved[:, 0], axis=1)
    assert far == pytest.approx(far[0]) and 0.0 < far[0] < 0.05
    assert len({tuple(offset) for offset in moved[:, 0].round(9)}) == 5
    pinhole = replace(rays, origins=np.ones_like(rays.origins))
    assert (camera_path(View(random_triangles(3, rays), pinhole, SIZE), 2)[0].origins != 1.0).any()


def test_what_a_method_cannot_draw_is_told_and_not_timed(monkeypatch):
    rays = random_ray_mesh(1, SIZE)

    def refuse(self, camera, shift=(0.0, 0.0)):
        raise AnamorphError("scene: too large")

    def opened(view, methods):
        sessions = open_sessions(view, methods)
        monkeypatch.setattr(sessions[STAND_IN], "draw", refuse.__get__(sessions[STAND_IN]), raising=False)
        return sessions

    monkeypatch.setattr("anamorph.bench.moving.open_sessions", opened)
    row = time_random([Place(48, 3, 1)], (TRACER, STAND_IN), 1)[1]
    assert row.ms is None and row.refusal == "scene: too large"
    times = time_methods(random_triangles(2, rays), rays, SIZE, (TRACER, STAND_IN), 1)
    assert tuple(times.timings) == (TRACER,) and tuple(times.refusals) == (STAND_IN,)
    assert crossovers([time("raytrace", 2.0), time(ms=1.0), row], "scene_triangles", FIXED) == []


def test_the_printed_figures_are_whole():
    assert [len(rows(table)) for table in ("d1-ray-tracing", "d2-trilinear", "d3-trilinear-clipped")] == [180] * 3
    assert [len(rows(table)) for table in TESSELLATION.values()] == [133] * 2
    place = {"resolution_px": 409600, "scene_triangles": 128, "trilinear_projections": 2}
    assert printed.printed("d2-trilinear", **place) == 11.36
    assert printed.printed("d2-trilinear", **(place | {"scene_triangles": 129})) is None
    # table 8.1 prints the speed that follows from its times
    speeds = (1379, 1858, None, 7292, 2538, 1185, 773, 493, 619)
    for row, speed in zip(rows("table-8-1"), speeds, strict=False):
        assert speed is None or float(row["ray_ms"]) / float(row["trilinear_ms"]) == pytest.approx(speed, abs=1.0)


@pytest.mark.parametrize("label", ["2,2,2,3", "3,3,3", "4,2,3", "2,7", "2,3"])
def test_configurations_have_the_shapes_that_they_are_called_by(label):
    numbers = configurations()[label]
    shapes = project_triangle(numbers[:, 3:6], numbers[:, 6:9], numbers[:, :3])
    assert sorted(map(len, shapes)) == sorted(int(count) for count in label.split(","))


def test_times_stand_beside_those_of_their_own_table():
    assert random_table(STAND_IN) == "d1-ray-tracing"
    assert random_table(EXACT) == random_table(STRAIGHT) == "d2-trilinear"
    assert random_table(CLIPPED_STRAIGHT) == "d3-trilinear-clipped"
    row = time_random([Place(128, 128, 1)], (TRACER,), 1)[0]
    assert row.printed_ms == 390.67 and row.ms >= row.least_ms > 0.0 and row.pixels_a_ray_triangle == 8192
    assert time_random([Place(128, 128, 1, 0.5)], (TRACER,), 1)[0].printed_ms is None


def test_lines_remake_the_figures_without_the_whole_cross():
    sides, counts, quads = (1, 128, 256, 384, 512, 640), (1, 128, 256, 384, 512, 640), (1, 2, 3, 4, 5)
    places = lines_through(sides, counts, quads)
    assert len(places) == len(set(places)) < len(sides) * len(counts) * len(quads) / 4
    for count in (1, 128, 640):
        assert {place.side for place in places if (place.scene_triangles, place.quads) == (count, 1)} == set(sides)
    for side in (128, 384, 640):
        line = {place.scene_triangles for place in places if (place.side, place.quads) == (side, 1)}
        assert line == set(counts)
        assert {place.quads for place in places if (place.side, place.scene_triangles) == (side, 640)} == set(quads)
    assert {place.scene_triangles for place in clip_lines(sides, counts, quads)} == {1, 128, 640}


speeds = st.lists(st.floats(0.01, 100.0), min_size=2, max_size=8)


@given(speeds=speeds)
def test_the_crossover_lies_where_the_winner_changes(speeds):
    values = [10.0 ** (i + 1) for i in range(len(speeds))]
    found = crossings(values, speeds)
    changes = [i for i in range(len(speeds) - 1) if (speeds[i] > 1.0) != (speeds[i + 1] > 1.0)]
    assert len(found) == len(changes)
    for i, place in zip(changes, found, strict=True):
        assert values[i] * (1 - 1e-9) <= place <= values[i + 1] * (1 + 1e-9)


def test_a_power_law_crosses_where_it_must_and_words_say_on_which_side():
    def line(law):
        made = [time("raytrace", law(count), count=count) for count in (10, 100, 1000)]
        return crossovers([*made, *(time(ms=1.0, count=count) for count in (10, 100, 1000))], "scene_triangles", FIXED)[
            0
        ]

    falling, rising = line(lambda n: 250.0 / n), line(lambda n: n / 30.0)
    assert falling.place == pytest.approx(250.0) and falling.told() == "above 250"
    assert rising.place == pytest.approx(30.0) and rising.told() == "below 30"
    assert line(lambda n: 2.0).told() == "never, from 10 to 1,000"
    assert line(lambda n: 0.5).told() == "always, from 10 to 1,000"
    # the tracer wins between, as well as where scenes are small: what counts is from where on the method wins
    assert line(lambda n: {10: 2.0, 100: 0.5, 1000: 2.0}[n]).place > 100


def test_equal_quality_is_read_between_the_numbers_of_frames():
    assert frames_for(0.25, [1.0, 0.25]) == pytest.approx(4.0)
    assert frames_for(0.5, [1.0, 0.25]) == pytest.approx(2.0)
    assert frames_for(2.0, [1.0]) == 1.0
    assert frames_for(0.1, [1.0, 0.5, 0.4, 0.3]) is None
    assert frames_for(0.0, [0.0]) == 1.0


def test_the_cases_have_the_sizes_and_triangles_of_the_table():
    for case in cases():
        faces = {mesh.specular: 0 for mesh in case.scene.meshes}
        for mesh in case.scene.meshes:
            faces[mesh.specular] += len(mesh.faces)
        assert faces[False] == case.scene_triangles
        assert (faces[True] if case.rays is None else len(case.rays.faces)) == case.projections
        if case.rays is not None:
            assert case.rays.least_size() == case.size


@pytest.fixture(scope="module")
def results():
    extent = replace(SMALL, growth=SMALL.growth[:2], cases=2, case_scale=0.05)
    told = []
    made = measure_thesis([EXACT], extent, PARTS, lambda done, total, what: told.append((done, total)))
    assert [done for done, _ in told] == list(range(told[0][1]))
    return made


def test_every_table_has_the_printed_columns_ours_and_the_machine(results, tmp_path):
    written = write_results(results, tmp_path / "new")
    tables = {
        path.stem: list(csv.DictReader(path.read_text().splitlines())) for path in written if path.suffix == ".csv"
    }
    expected = {
        "d1-ray-tracing", "d2-trilinear", "d3-trilinear-clipped", "d4-ray-tracing-configurations",
        "d5-trilinear-configurations", *TESSELLATION.values(), "growth", "table-8-1",
    }  # fmt: skip
    assert tables.keys() == expected
    for name, lines in tables.items():
        assert all(row["adapter"] == results.adapter and int(row["cores"]) == results.cores for row in lines)
        assert all(float(row["ms"]) > 0.0 for row in lines)
        if name.startswith("d"):
            assert set(rows(name)[0]) < set(lines[0]) and "printed_ms" in lines[0]
    assert {row["method"] for row in tables["d1-ray-tracing"]} == {"raytrace"}
    assert {row["method"] for row in tables["d2-trilinear"]} == {"trilinear", str(STRAIGHT)}
    assert {row["method"] for row in tables["d3-trilinear-clipped"]} == {str(CLIPPED_STRAIGHT)}
    assert [row["printed_ms"] for row in tables["d1-ray-tracing"] if row["resolution_px"] == "576"] == [""] * 3


def test_plots_are_images_where_matplotlib_is_installed(results, tmp_path):
    pytest.importorskip("matplotlib")
    images = [path for path in write_results(results, tmp_path) if path.suffix == ".png"]
    assert len(images) == 12
    for path in images:
        with Image.open(path) as image:
            assert min(image.size) > 300 and len(image.convert("RGB").getcolors(1 << 20)) > 10


def test_without_matplotlib_there_are_tables_and_one_line_says_what_to_install(monkeypatch, tmp_path, capsys):
    monkeypatch.setattr(plots, "can_plot", lambda: False)
    monkeypatch.setattr(benchmark, "can_plot", lambda: False)
    monkeypatch.setattr(benchmark, "QUICK", replace(SMALL, growth=()))
    arguments = ["bench", "trilinear", "--quick", "-m", str(STAND_IN), "--part", "random", "--output", str(tmp_path)]
    assert cli.main(arguments) == 0
    said = capsys.readouterr()
    assert {path.suffix for path in tmp_path.iterdir()} == {".csv"}
    assert said.err.count("\n") == 1 and "pip install 'anamorph[plots]'" in said.err


def test_nothing_but_drawing_wants_matplotlib():
    assert "matplotlib" not in sys.modules or plots.can_plot()


def test_the_summary_says_what_was_measured(results):
    titles = [str(table.title) for table in summary_tables(results)]
    assert titles[0].startswith("Table 8.1") and titles[2].startswith("Crossover")
    assert summary_tables(Results("", 1)) == []
    assert exact_over_straight(results) is None
    both = [time(ms=3.0), time(str(STRAIGHT), 2.0), time(count=20), time("raytrace")]
    assert "1.50 times as long" in exact_over_straight(Results("", 1, random=both))


def test_printed_lines_are_drawn_as_the_thesis_has_them():
    factors = (1, 10)
    made = [
        TessellationError("2,3", 409600, way, factor, 1.0, 1.0, 0.5, 2.0 * factor, 0.25)
        for way in TESSELLATION
        for factor in factors
    ]
    exact = TessellationError("2,3", 409600, "exact", 0, 1.0, 1.0, 0.0)
    error, mean, spent = tessellation_plots([*made, exact])
    assert {line.kind for line in error.panels[0].lines} == {"tessellate", "slices"}
    assert [line.y for line in mean.panels[0].lines if line.kind == "exact"] == [(0.0, 0.0)]
    assert all(line.y == (2.0, 20.0) for line in spent.panels[1].lines)
    clipped = str(CLIPPED_STRAIGHT)
    pair = [time(str(STRAIGHT), 2.0, known=1.0), time(clipped, 3.0, known=2.0)]
    ours, theirs = clip_plots(pair, str(STRAIGHT), clipped)[0].panels
    assert ours.lines[0].y == (1.5,) and theirs.lines[0].y == (2.0,)
    traced = [time("raytrace", 6.0, known=30.0), time(str(STRAIGHT), 2.0, known=1.0)]
    speed = next(plot for plot in random_plots(traced) if plot.name == "speed-resolution")
    assert [panel.lines[0].y for panel in speed.panels] == [(3.0,), (30.0,)]


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--part", "randm"], "did you mean 'random'"),
        (["-m", "trilinea"], "did you mean 'trilinear'"),
        (["--output", "missing/there"], "no directory"),
        (["--frames", "3"], "unrecognized arguments"),
    ],
)
def test_what_cannot_be_measured_is_one_line(arguments, words, capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert cli.main(["bench", "trilinear", *arguments]) == 2
    said = capsys.readouterr().err
    assert words in said and said.count("\n") == 1
    assert list(tmp_path.iterdir()) == []


def test_a_file_in_the_way_of_the_output_is_told_before_any_work(capsys, tmp_path):
    (tmp_path / "times").write_text("mine")
    assert cli.main(["bench", "trilinear", "--output", str(tmp_path / "times")]) == 2
    assert "times" in capsys.readouterr().err and (tmp_path / "times").read_text() == "mine"


def test_the_columns_of_all_rows_are_plain_figures(results):
    for part in fields(results):
        for row in getattr(results, part.name) if part.name in PARTS else ():
            assert all(isinstance(getattr(row, f.name), int | float | str | None) for f in fields(row))


def test_pixels_on_the_border_of_a_ray_triangle_do_not_count():
    """In configuration 2,3 the scene triangle is seen across the long side, whose pixels only the tracer has."""
    found = measure_tessellation(["2,3"], 64, [4], 1)
    exact = next(row for row in found if row.way == "exact")
    assert exact.relative_error <= 1e-4
    assert all(row.relative_error > 10 * exact.relative_error for row in found if row.way != "exact")
