"""Timing, the comparison, and its table and page, on frames that need no device."""

from __future__ import annotations

import base64
import io
import json
import re
from dataclasses import dataclass, replace
from html import escape
from html.parser import HTMLParser
from typing import Any

import numpy as np
import pytest
from frames import FakeSession, plane_truth
from PIL import Image
from scenes import flat_mirror, surroundings

from anamorph.base.steps import drain
from anamorph.frame import Status, View
from anamorph.measure import compare as compare_module
from anamorph.measure.compare import Comparison, compare
from anamorph.measure.figures import ROWS, number, rows_of
from anamorph.measure.frame_times import WARM_UP, Timing, eye_path, timing_rounds
from anamorph.measure.heatmap import MILLIRADIANS, VIRIDIS, heat_map, scale_colors
from anamorph.measure.page import comparison_page, specular_box
from anamorph.measure.status import status_shares
from anamorph.measure.table import comparison_table, print_table
from anamorph.methods import METHODS
from anamorph.methods.protocol import Method
from anamorph.scene.camera import Camera
from anamorph.scene.model import Scene

CAMERA = Camera((1.0, 2.0, 3.0), (1.0, 2.0, 1.0))
SCENE = Scene("flat <mirror>", (), CAMERA)
ODD = 'odd:name="<b>&",other=1'


@dataclass(frozen=True)
class Options:
    """Of methods that draw what they are told."""

    name: str = ""
    other: int = 0


@pytest.fixture
def sessions(monkeypatch) -> dict[str, Any]:
    """Three methods, by name: the reference, one that is nearly right, one whose name must be escaped."""
    reference = plane_truth()
    reference.specular[:4] = 0
    reference.object_id[:, 40:] = 6
    reference.status[:] = Status.TRACED
    near = replace(
        reference, position=reference.position + np.float32([0.02, 0.0, 0.0]), status=reference.status.copy()
    )
    near.status[:] = Status.WARPED
    made = {
        "raytrace": FakeSession(reference),
        "pervertex": FakeSession(near),
        ODD: FakeSession(replace(near, color=0.5 * near.color)),
        compare_module.PLAIN: FakeSession(near),
    }

    for name in [name.partition(":")[0] for name in made]:

        def open_session(view: View, options: Options, name: str = name) -> FakeSession:
            made["scene"] = view.scene
            return made[ODD if name == "odd" else name]

        monkeypatch.setitem(METHODS, name, Method(name, "", "", Options, open_session))
    monkeypatch.setattr(compare_module, "adapter_name", lambda: "Fake & Sons (CPU)")
    return made


@pytest.fixture
def comparison(sessions) -> Comparison:
    return compare(SCENE, ["pervertex", ODD], (48, 32), command="anamorph compare 'flat <mirror>'")


def test_the_eye_goes_round_its_place_and_keeps_its_target():
    cameras = eye_path(SCENE, 8)
    offsets = np.array([camera.position for camera in cameras]) - CAMERA.position
    assert np.linalg.norm(offsets, axis=1) == pytest.approx(np.full(8, 0.005 * 2.0))
    assert offsets.mean(axis=0) == pytest.approx(np.zeros(3), abs=1e-12)
    assert offsets @ CAMERA.axes()[2] == pytest.approx(np.zeros(8), abs=1e-12)
    assert {camera.target for camera in cameras} == {CAMERA.target}
    assert len({camera.position for camera in cameras}) == 8


def test_the_eye_keeps_its_distance_from_the_mirror_however_far_its_target_is():
    far = replace(CAMERA, target=(1.0, 2.0, -1e5))
    mirror = flat_mirror()
    nearest = np.linalg.norm(mirror.positions - np.array(far.position), axis=1).min()
    cameras = eye_path(Scene("far", (mirror, *surroundings()), far), 4)
    offsets = np.array([camera.position for camera in cameras]) - far.position
    assert np.linalg.norm(offsets, axis=1) == pytest.approx(np.full(4, 0.005 * nearest))


def test_frames_are_drawn_and_waited_for_but_not_read():
    session = FakeSession(plane_truth())
    timing = drain(timing_rounds({"": session}, eye_path(SCENE, 7), minimum=30))[""]
    assert session.calls == ["draw", "wait"] * (30 + WARM_UP)
    assert all(first != second for first, second in zip(session.eyes, session.eyes[1:], strict=False))
    assert timing.n == 30
    assert 0.0 < timing.min <= timing.median <= timing.max


def test_methods_take_turns():
    order: list[str] = []

    class Turn(FakeSession):
        def wait(self) -> None:
            order.append(self.calls[0])

    def named(name: str) -> Turn:
        session = Turn(plane_truth())
        session.calls.append(name)
        return session

    drain(timing_rounds({"a": named("a"), "b": named("b")}, eye_path(SCENE, 3), minimum=3))
    assert order == ["a", "b"] * (3 + WARM_UP)


def test_the_json_has_the_keys_that_others_rely_on(comparison):
    figures = json.loads(comparison.to_json())
    assert {"scene", "size", "adapter", "methods"} <= figures.keys()
    assert figures["scene"] == "flat <mirror>"
    assert figures["size"] == [48, 32]
    assert list(figures["methods"]) == ["pervertex", ODD, "raytrace"]
    for result in figures["methods"].values():
        assert result.keys() == {
            "frame_ms",
            "angular_mrad",
            "pixels",
            "other_object_percent",
            "silhouette_percent",
            "rmse",
            "flip",
            "relative_error",
            "status_percent",
            "figures",
        }
        assert result["frame_ms"].keys() == {"median", "min", "max", "n"}
        assert result["angular_mrad"].keys() == result["pixels"].keys() == {"median", "p95", "max"}
        assert result["frame_ms"]["n"] >= 30
    assert figures["methods"]["pervertex"]["pixels"]["median"] == pytest.approx(0.1, rel=1e-2)
    assert figures["methods"]["raytrace"]["rmse"] == 0.0


def test_the_competitor_is_timed_whether_named_or_not(sessions):
    assert [result.name for result in compare(SCENE, [], (48, 32)).methods] == ["raytrace"]
    assert [result.name for result in compare(SCENE, ["raytrace", "raytrace"], (48, 32)).methods] == ["raytrace"]


def test_a_scene_without_mirrors_has_null_errors_and_no_crash(sessions):
    for session in list(sessions.values()):
        session.shown.specular[:] = 0
    comparison = compare(SCENE, ["pervertex"], (48, 32))
    figures = json.loads(comparison.to_json())["methods"]["pervertex"]
    assert figures["angular_mrad"] == {"median": None, "p95": None, "max": None}
    assert figures["flip"] is figures["silhouette_percent"] is None
    assert "<td>-</td>" in comparison_page(comparison)


def test_the_frame_without_mirrors_takes_its_turn(sessions):
    scene = replace(SCENE, meshes=(flat_mirror(), *surroundings()))
    comparison = compare(scene, ["pervertex"], (48, 32))
    assert sessions[compare_module.PLAIN].calls == ["draw", "wait"] * (30 + WARM_UP)
    assert [mesh.name for mesh in sessions["scene"].meshes] == [mesh.name for mesh in surroundings()]
    figures = json.loads(comparison.to_json())
    assert figures["without_mirrors_ms"].keys() == {"median", "min", "max", "n"}
    slow = replace(comparison, without_mirrors=Timing(0.25, 0.2, 0.3, 30))
    slow = replace(slow, methods=tuple(replace(r, timing=Timing(1.0, 1.0, 1.0, 30)) for r in slow.methods))
    (row,) = (row for row in ROWS if row.label == "the frame without mirrors")
    assert [row.cell(slow, result) for result in slow.methods] == ["4.00", "4.00"]
    assert "0.250 ms" in comparison_page(slow)


def test_a_scene_of_mirrors_alone_has_no_frame_without_them(sessions, capsys):
    comparison = compare(replace(SCENE, meshes=(flat_mirror(),)), ["pervertex"], (48, 32))
    assert comparison.without_mirrors is None
    assert json.loads(comparison.to_json())["without_mirrors_ms"] is None
    assert "nothing is left of the scene" in comparison_page(comparison)
    print_table(comparison_table(comparison))
    assert "without mirrors" in capsys.readouterr().out


def test_progress_goes_forward_to_its_end(sessions):
    told: list[tuple[int, int]] = []
    compare(SCENE, ["pervertex"], (48, 32), report=lambda done, total, what: told.append((done, total)))
    assert told == sorted(told)
    assert told[-1][0] == told[-1][1]


class Page(HTMLParser):
    """What a page is made of."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.tags: list[tuple[str, dict[str, str | None]]] = []
        self.open: list[str] = []
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        self.tags.append((tag, dict(attrs)))
        if tag not in ("img", "meta", "link", "wbr", "br"):
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag


def test_the_page_asks_for_nothing_from_outside_and_is_well_formed(comparison):
    text = comparison_page(comparison)
    page = Page(text)
    assert page.open == []
    assert not [tag for tag, _ in page.tags if tag in ("script", "iframe", "object")]
    sources = [attributes[key] for _, attributes in page.tags for key in ("src", "href") if key in attributes]
    assert all(source.startswith("data:") for source in sources)
    assert not re.search(r"https?://|url\(|@import", text)


def test_the_page_escapes_names_and_shows_every_figure(comparison):
    text = comparison_page(comparison)
    assert "<b>" not in text
    assert "flat &lt;mirror&gt;" in text
    assert "Fake &amp; Sons (CPU)" in text
    for result in comparison.methods:
        for row in rows_of(comparison):
            assert f"<td>{escape(row.cell(comparison, result))}</td>" in text
    assert "anamorph compare &#x27;flat &lt;mirror&gt;&#x27;" in text


def test_every_image_is_a_png_with_words_and_every_table_cell_has_a_header(comparison):
    page = Page(comparison_page(comparison))
    images = [attributes for tag, attributes in page.tags if tag == "img"]
    # three for each of the two methods that are not the reference, and the whole images
    assert len(images) == 2 * 3 + 3
    for image in images:
        assert image["alt"]
        with Image.open(io.BytesIO(base64.b64decode(image["src"].removeprefix("data:image/png;base64,")))) as decoded:
            assert decoded.format == "PNG"
            assert (str(decoded.width), str(decoded.height)) == (image["width"], image["height"])
    scopes = [attributes.get("scope") for tag, attributes in page.tags if tag == "th"]
    assert scopes.count("col") == 3
    assert scopes.count("row") == len(rows_of(comparison))


def test_the_page_says_how_pixels_got_their_value(comparison):
    assert "got their value: warped 100 %" in comparison_page(comparison)


def test_what_methods_tell_of_themselves_stands_in_rows_of_its_own(comparison, capsys):
    told = ({"maps": 1234.0, "maps_used_percent": 12.345}, {"maps": 2.0, "probes": 0.5}, {})
    methods = tuple(
        replace(result, frame=replace(result.frame, figures=figures))
        for result, figures in zip(comparison.methods, told, strict=True)
    )
    full = replace(comparison, methods=methods)
    cells = {row.label: [row.cell(full, result) for result in methods] for row in rows_of(full)[len(ROWS) :]}
    assert cells == {
        "pixels: warped": ["100", "100", "0"],
        "pixels: traced": ["0", "0", "100"],
        "maps": ["1,234", "2", "-"],
        "maps used": ["12.3", "-", "-"],
        "probes": ["-", "0.500", "-"],
    }
    assert [row.unit for row in rows_of(full)[len(ROWS) :]] == ["%", "%", "", "%", ""]
    figures = json.loads(full.to_json())["methods"]
    assert [figures[result.name]["figures"] for result in methods] == list(told)
    assert figures["pervertex"]["status_percent"] == {"warped": 100.0}
    print_table(comparison_table(full))
    assert "1,234" in capsys.readouterr().out
    assert "<td>1,234</td>" in comparison_page(full)


def test_status_shares_count_only_what_they_are_told_to():
    reference = plane_truth()
    reference.status[:, :24] = Status.TOTAL_REFLECTION
    counted = np.zeros(reference.status.shape, bool)
    counted[:, 12:] = True
    assert status_shares(reference, counted) == pytest.approx(
        {"direct": 100 * 24 / 36, "total reflection": 100 * 12 / 36}
    )
    assert list(status_shares(reference, counted)) == ["direct", "total reflection"]
    assert status_shares(reference, np.zeros_like(counted)) == {}


def test_the_scale_is_logarithmic_and_has_ends():
    first, last = (tuple(int(color[i : i + 2], 16) for i in (1, 3, 5)) for color in (VIRIDIS[0], VIRIDIS[-1]))
    middle = tuple(int(VIRIDIS[4][i : i + 2], 16) for i in (1, 3, 5))
    low, high = MILLIRADIANS.lowest, MILLIRADIANS.highest
    colors = scale_colors(np.array([0.0, low, np.sqrt(low * high), high, 1e9]))
    assert [tuple(int(c) for c in color) for color in colors] == [first, first, middle, last, last]


def test_the_heat_map_colours_only_specular_pixels(comparison):
    maps = comparison.methods[0].errors.maps
    image = heat_map(maps, comparison.reference_frame.color)
    assert np.ptp(image[:4].astype(int), axis=-1).max() == 0
    assert np.ptp(image[4:].astype(int), axis=-1).min() > 0


def test_the_box_holds_every_specular_pixel():
    specular = np.zeros((100, 80), bool)
    assert specular_box(specular) == (slice(0, 100), slice(0, 80))
    specular[40, 5] = specular[50, 70] = True
    assert specular[specular_box(specular)].sum() == 2
    assert specular[specular_box(specular)].shape == (35, 80)


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (None, "-"),
        (0.0, "0"),
        (0.00123, "0.00123"),
        (0.5, "0.500"),
        (12.345, "12.3"),
        (1234.5, "1,234"),
        (1e-9, "< 0.00001"),
    ],
)
def test_numbers_have_three_digits_and_no_exponent(value, text):
    assert number(value) == text


def test_the_table_names_methods_units_and_the_competitor(comparison, capsys):
    print_table(comparison_table(comparison))
    printed = capsys.readouterr().out
    for word in ("pervertex", ODD, "raytrace", "mrad", "as fast as raytrace", "Fake & Sons", "flat <mirror>"):
        assert word in printed
    assert "1.00" in printed
