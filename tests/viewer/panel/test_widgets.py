"""The panel: each widget changes its field of the state and no other, and nothing is cut off or overlaps."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from itertools import combinations

import numpy as np
import pytest
from panel_stage import Stage, inside, overlap
from scenes import CAMERA, scene_with, spherical_mirror

from anamorph import gallery
from anamorph.measure.errors import Statistics
from anamorph.methods import Specification
from anamorph.reflections.reflection_points import ReflectionStatus
from anamorph.scene.camera import Camera
from anamorph.scene.model import Glass, Scene
from anamorph.viewer.controls import scene_controls
from anamorph.viewer.facts import Facts, Figures, Inspection, Progress, Reflection, Reflections, Request, Stop
from anamorph.viewer.layout import image_area
from anamorph.viewer.observer import first_observer
from anamorph.viewer.panel import reflected, results
from anamorph.viewer.panel.legend import half_caption
from anamorph.viewer.panel.methods import (
    ASPECTS,
    BOUNCES,
    DRAWINGS,
    RESOLUTIONS,
    SAMPLES,
    UNITS,
    few_bounces,
)
from anamorph.viewer.panel.reflected import KNOWN
from anamorph.viewer.panel.results import PATHS, SAVED
from anamorph.viewer.panel.scene import SIDES, curvature_text
from anamorph.viewer.panel.sheet import broken
from anamorph.viewer.panel.wording import decimals, figure, number_text
from anamorph.viewer.shortcuts import SHORTCUTS
from anamorph.viewer.state import Aspect, Drawing, EyeSide, Half, State

SIZE = (800, 600)
SIZES = [((640, 480), 1.0), ((800, 600), 2.0), ((1280, 720), 1.0), ((1920, 1080), 1.0)]
FOLDED = ("section/views", "section/space", "section/quality", "section/save", "section/timing")
BOXES = {"panel", "panel/body", "status", "notice", "help", "divider", "first/caption", "second/caption"}
BOXES |= {f"{half}/{legend}" for half in ("first", "second") for legend in ("scale", "statuses", "counts")}

FIGURES = Figures(
    Statistics(0.04, 1.2, 123.4), Statistics(0.1, 2.3, 800.0), None, {"warped": 80.0, "total_reflection": 20.0}
)
SEEN = Inspection(
    (412, 233), Specification.parse("pervertex"), "box-3", (1.0, -2.0, 3.0), 4.0, "proved",
    (Stop("eye", (0.0, 1.0, 0.0)), Stop("mirror", (0.0, 0.0, 0.0)), Stop("a box of long name", (-1.0, 2.0, -12.0))),
    "a box with a very long name", 12.3, 4.5, True,
)  # fmt: skip

SHOWN = Reflections(
    (1.0, -2.0, 3.0), (0.0, 1.0, 0.0), ReflectionStatus.MANY,
    (Reflection("mirror", ((0.0, 0.0, 0.0),), (412.34, -20.75), 4.5, 1, False),
     Reflection("other", ((0.0, 0.0, 1.0),), None, 5.25, -1, True)),
)  # fmt: skip


@pytest.fixture(scope="module")
def scene() -> Scene:
    return scene_with(spherical_mirror())


@pytest.fixture
def opened(scene: Scene) -> Iterator[Callable[..., Stage]]:
    stages = []

    def open_stage(size=SIZE, ratio=1.0, of=scene, told=None, **state) -> Stage:
        facts = Facts(of, size, size, size, "an adapter with rather a long name, as they have (LLVM 15.0.6, 256 bits)")
        start = State(of.camera, Half(Specification.parse("pervertex")), Half(Specification.parse("raytrace")))
        stages.append(Stage(replace(start, **state), replace(facts, **(told or {})), ratio))
        return stages[-1]

    yield open_stage
    for stage in stages:
        stage.close()


def pressed(stage: Stage, *keys: str) -> State:
    for key in keys:
        stage.press(key)
    return stage.state


@pytest.mark.parametrize(
    ("keys", "changes"),
    [
        (["first/aspect/error"], {"first": Half(Specification.parse("pervertex"), Aspect.ERROR)}),
        (["first/aspect/status"], {"first": Half(Specification.parse("pervertex"), Aspect.STATUS)}),
        (["first/aspect/counts"], {"first": Half(Specification.parse("pervertex"), Aspect.COUNTS)}),
        (["first/method", "first/method/environment"], {"first": Half(Specification.parse("environment"))}),
        (["first/options", "first/align"], {"first": Half(Specification.parse("pervertex:align=false"))}),
        (
            ["first/options", "first/wide", "first/wide/cube"],
            {"first": Half(Specification.parse("pervertex:wide=cube"))},
        ),
        (["first/options", "first/align", "first/reset"], {}),
        (["split"], {"split": True}),
        (["section/quality", "samples/8"], {"samples": 8}),
        (["section/quality", "resolution/0.75"], {"resolution": 0.75}),
        (["eye/side/left"], {"eye": EyeSide.LEFT}),
        (["eye/side/right", "eye/reset"], {}),
        (["panel/hide"], {"panel": False}),
        (["panel/hide", "panel/show"], {}),
        (["help/show"], {"help": True}),
        (["opening/show"], {"opening": ""}),
        (["opening/show", "opening/show"], {}),
        (["help/show", "help/close"], {}),
        *((["section/space", f"space/{each}"], {"drawings": frozenset({each})}) for each in Drawing),
        (["section/views", "views/remember"], {"views": (CAMERA,)}),
        (["section/views", "views/remember", "views/0/forget"], {}),
        (["section/views", "views/remember", "views/clear"], {}),
        (["section/views", "views/clear"], {}),
        *((["section/save", request], {}) for request, _, _ in SAVED if request not in PATHS),
    ],
    ids=lambda value: value[-1] if isinstance(value, list) else "",
)
def test_a_widget_changes_its_own_field_and_no_other(opened, keys, changes) -> None:
    stage = opened()
    start = stage.state
    assert pressed(stage, *keys) == replace(start, **changes)
    wanted = [keys[-1]] if keys[-1] in tuple(Request) else []
    assert stage.requests == wanted


def test_widgets_that_only_sometimes_show_change_their_own_field_too(opened) -> None:
    stage = opened(split=True, second=Half(Specification.parse("pervertex:field=60"), Aspect.ERROR), picked=(0.5, 0.5))
    start = stage.state
    state = pressed(stage, "second/aspect/status")
    assert state == replace(start, second=Half(Specification.parse("pervertex:field=60"), Aspect.STATUS))
    state = pressed(stage, "first/aspect/error", "unit/px")
    assert (state.first.aspect, state.unit) == (Aspect.ERROR, "px")
    assert pressed(stage, "inspection/clear") == replace(state, picked=None)


def test_the_table_of_reflection_points_tells_each_and_what_is_known(opened, monkeypatch) -> None:
    rows: list[tuple[str, ...]] = []
    monkeypatch.setattr(reflected, "row", lambda *cells: rows.append(cells))
    words: list[str] = []
    monkeypatch.setattr(reflected, "wrapped", lambda text, *_: words.append(text))
    monkeypatch.setattr(reflected, "caption", words.append)
    asked = {"picked": (0.5, 0.5), "point": (1.0, -2.0, 3.0), "drawings": frozenset({Drawing.REFLECTIONS})}
    opened(told={"inspection": SEEN, "reflections": SHOWN}, **asked)
    assert rows[-5:] == [
        ("of the point, m", "1.000, \N{MINUS SIGN}2.000, 3.000"),
        ("1  mirror", "4.500 m"),
        ("    at 412.3, \N{MINUS SIGN}20.8", "right way round"),
        ("2  other", "5.250 m"),
        ("    behind the eye", "mirrored, hidden"),
    ]
    assert words[-1] == KNOWN[ReflectionStatus.MANY]
    assert KNOWN.keys() == set(ReflectionStatus)
    opened(told={"searching": True}, **asked)
    assert words[-1] == "Searching …"
    opened(**asked)
    assert words[-1] == "None."
    count = len(rows)
    opened(told={"inspection": SEEN, "reflections": SHOWN}, picked=(0.5, 0.5))
    assert len(rows) == count, "the drawing is not asked for"


def test_the_legend_of_counts_stands_in_its_half(opened) -> None:
    half = Half(Specification.parse("pervertex"), Aspect.COUNTS)
    found = opened(split=True, second=half).drawn.rectangles
    left, _, right, _ = image_area(SIZE, True)
    assert found["second/counts"][0] >= (left + right) / 2.0 and "first/counts" not in found


def test_views_are_shown_again_forgotten_and_gone_through(opened) -> None:
    views = (CAMERA, replace(CAMERA, field_of_view=30.0), Camera((1.0, 1.5, 2.0), (0.0, 0.5, 0.0)))
    stage = opened(views=views[:1])
    start = pressed(stage, "section/views", "section/save", *PATHS)
    assert stage.requests == [], "a path needs two"
    stage.state = start = replace(start, views=views, eye=EyeSide.LEFT)
    stage.frames(2)
    moved = replace(start, camera=views[2], eye=EyeSide.MIDDLE)
    assert pressed(stage, "views/2") == moved
    assert pressed(stage, "views/1/forget") == replace(moved, views=(views[0], views[2]))
    assert pressed(stage, *PATHS) == stage.state and stage.requests == list(PATHS)


def test_looking_on_from_outside_and_back(opened, scene) -> None:
    stage = opened()
    start = stage.state
    assert pressed(stage, "eye/observer") == replace(start, observer=first_observer(scene, scene.camera))
    assert pressed(stage, "eye/observer") == start


def test_a_slider_sets_its_control_and_its_sign_sets_it_back(opened, scene) -> None:
    stage = opened()
    start = stage.state
    assert "mirror/swivel/reset" not in stage.drawn.rectangles
    stage.drag("mirror/swivel", 0.5, 0.75)
    assert stage.state == replace(start, values=stage.state.values)
    assert set(stage.state.values) == {"mirror/swivel"}
    assert stage.state.values["mirror/swivel"] == pytest.approx(22.5, abs=2.0)
    steps = stage.state.values["mirror/swivel"] / scene_controls(scene)[0].step
    assert steps == pytest.approx(round(steps), abs=1e-6)
    stage.drag("mirror/tilt", 0.5, -3.0)
    assert stage.state.values["mirror/tilt"] == -45.0
    assert pressed(stage, "mirror/swivel/reset").values == {"mirror/tilt": -45.0}
    assert pressed(stage, "reset") == start


def test_the_eye_moves_along_one_axis_and_goes_home(opened, scene) -> None:
    stage = opened()
    start = stage.state
    stage.drag("eye/y", 0.5, 0.6)
    x, y, z = stage.state.camera.position
    assert (x, z) == (CAMERA.position[0], CAMERA.position[2]) and y > CAMERA.position[1]
    assert stage.state == replace(start, camera=replace(CAMERA, position=(x, y, z)))
    stage.drag("eye/field_of_view", 0.2, 0.3)
    assert stage.state.camera.field_of_view == pytest.approx(45.7, abs=3.0)
    assert pressed(stage, "eye/reset") == start


def test_an_eye_that_could_see_nothing_is_not_taken(opened) -> None:
    level = Camera((0.0, 1.0, 1.0), (0.0, 0.5, 0.0))
    stage = opened(camera=level)
    typed(stage, "eye/z", "0")
    assert stage.state.camera == level


def typed(stage: Stage, key: str, text: str) -> None:
    """Press with Ctrl, and type."""
    stage.reveal(key)
    x, y = stage.place(key)
    stage.send("pointer_move", x=x, y=y, button=0)
    stage.send("key_down", key="Control")
    stage.send("pointer_down", x=x, y=y, button=1)
    stage.send("pointer_up", x=x, y=y, button=1)
    stage.send("key_up", key="Control")
    stage.frames(2)
    assert stage.drawn.typing
    stage.type(text)
    stage.key("Enter")
    assert not stage.drawn.typing


@pytest.mark.parametrize(("text", "value"), [("12.3", 12.3), ("-7", -7.0), ("1e9", 45.0), ("1e99", None)])
def test_a_value_can_be_typed_finer_than_a_step_but_not_beyond_the_limits(opened, text, value) -> None:
    stage = opened()
    typed(stage, "mirror/swivel", text)
    assert stage.state.values == ({} if value is None else {"mirror/swivel": value})


@pytest.mark.parametrize(("text", "value"), [("46", 45.0), ("-90", -45.0)])
def test_a_number_that_is_typed_beyond_the_limits_says_so_until_another_is_set(opened, text, value) -> None:
    stage = opened()
    typed(stage, "mirror/swivel", text)
    assert stage.state.values == {"mirror/swivel": value}
    assert "mirror/swivel/limit" in stage.drawn.rectangles and "mirror/tilt/limit" not in stage.drawn.rectangles
    typed(stage, "mirror/swivel", "45")
    assert stage.state.values == {"mirror/swivel": 45.0}
    assert "mirror/swivel/limit" not in stage.drawn.rectangles
    typed(stage, "mirror/swivel", text)
    stage.drag("mirror/swivel", 0.5, 0.6)
    assert "mirror/swivel/limit" not in stage.drawn.rectangles
    typed(stage, "mirror/swivel", text)
    assert not pressed(stage, "mirror/swivel/reset").values
    assert "mirror/swivel/limit" not in stage.drawn.rectangles


def test_an_option_without_an_upper_limit_takes_any_typed_value(opened) -> None:
    stage = opened()
    pressed(stage, "first/options")
    typed(stage, "first/tolerance", "2000")
    assert stage.state.first.method.options.tolerance == 2000.0
    typed(stage, "first/bounces", "2000")
    assert stage.state.first.method.options.bounces == 8


def test_a_method_that_does_not_refract_cannot_be_chosen_for_glass(opened, scene) -> None:
    lens = replace(scene, meshes=tuple(replace(m, material=Glass()) if m.specular else m for m in scene.meshes))
    stage = opened(of=lens)
    state = pressed(stage, "first/method", "first/method/environment")
    assert state.first == Half(Specification.parse("pervertex"))
    assert pressed(stage, "first/method/trilinear").first == Half(Specification.parse("trilinear"))


def test_a_half_that_no_method_can_draw_still_lets_another_be_chosen(opened) -> None:
    stage = opened(first=Half(Specification.parse("pervertex:antialias=3")))
    assert pressed(stage, "first/method", "first/method/raytrace").first == Half(Specification.parse("raytrace"))


def test_while_a_list_is_open_the_whole_canvas_is_covered(opened) -> None:
    stage = opened()
    canvas = (0.0, 0.0, 800.0, 600.0)
    assert canvas not in stage.drawn.covered
    stage.press("first/method")
    assert canvas in stage.drawn.covered
    stage.send("pointer_move", x=700.0, y=300.0, button=0)
    stage.send("pointer_down", x=700.0, y=300.0, button=1)
    stage.send("pointer_up", x=700.0, y=300.0, button=1)
    stage.frames(2)
    assert canvas not in stage.drawn.covered


def test_what_runs_can_be_cancelled_and_what_is_said_dismissed(opened) -> None:
    stage = opened(told={"message": "saved", "progress": Progress("Turntable", 3, 8)})
    stage.press("cancel")
    stage.press("message/close")
    assert stage.requests == [Request.CANCEL, Request.DISMISS]
    pressed(stage, "section/save", Request.SAVE_IMAGE)
    assert stage.requests == [Request.CANCEL, Request.DISMISS], "nothing else is saved while something is"


TOLD = {
    "message": "scene.toml: mesh 'mirror': " + "its radius must not be nought; give a radius in metres. " * 4,
    "progress": Progress("Comparison page", 3, 11),
    "inspection": SEEN,
    "reflections": SHOWN,
    "figures": (FIGURES, None),
    "phases_ms": {"vertex rays": 1.2, "maps": 3.4},
    "frame_ms": 12.0,
    "samples_done": 3,
    "samples_total": 16,
}


@pytest.mark.parametrize(("size", "ratio"), SIZES)
def test_nothing_overlaps_and_all_lies_in_the_canvas_or_the_scrolled_panel(opened, size, ratio) -> None:
    first, second = (
        Half(Specification.parse("environment"), Aspect.STATUS),
        Half(Specification.parse("pervertex:map=image,wide=cube"), Aspect.ERROR),
    )
    stage = opened(size, ratio, told=TOLD, split=True, first=first, second=second, picked=(0.5, 0.5))
    stage.state = replace(stage.state, views=(CAMERA, replace(CAMERA, position=(-12345.678,) * 3)))
    stage.state = replace(stage.state, drawings=frozenset({Drawing.REFLECTIONS}), point=(1.0, -2.0, 3.0))
    stage.press("first/options")
    pressed(stage, *FOLDED)
    found, canvas = stage.drawn.rectangles, (0.0, 0.0, *map(float, size))
    widgets = {key: rectangle for key, rectangle in found.items() if key not in BOXES}
    body, heading = found["panel/body"], {"opening/show", "help/show", "panel/hide"}
    for (one, a), (other, b) in combinations(widgets.items(), 2):
        # What is scrolled away lies behind the heading, unseen.
        assert not overlap(a, b) or len({one, other} & heading) == 1, f"{one} and {other}"
    for key, (left, top, right, bottom) in widgets.items():
        if key not in ("cancel", "progress", "message/close"):
            assert body[0] <= left < right <= body[2], key
            assert bottom - top >= 16.0, f"{key} is flat"
    over = [found[key] for key in BOXES - {"panel/body"} if key in found and key != "divider"]
    assert all(inside(each, canvas) for each in over)
    assert not any(overlap(one, other) for one, other in combinations(over, 2))
    left, _, right, _ = image_area(size, True)
    divider = (left + right) / 2
    assert all(found[key][2] <= divider for key in ("first/caption", "first/statuses") if key in found)
    assert found["second/scale"][0] >= divider
    assert "first/statuses" in found
    assert stage.frames().shape[:2] == (int(size[1] * ratio), int(size[0] * ratio))


def test_an_option_that_may_be_very_large_is_small_over_most_of_its_slider(opened) -> None:
    stage = opened(first=Half(Specification.parse("raytrace")))
    stage.press("first/options")
    stage.press("first/bounces", 0.75)
    assert 20 < stage.state.first.method.options.bounces < 100


@pytest.mark.parametrize("size", [size for size, _ in SIZES])
def test_the_help_lists_every_key_within_the_canvas(opened, size) -> None:
    stage = opened(size, help=True)
    assert inside(stage.drawn.rectangles["help"], (0.0, 0.0, *map(float, size)))
    assert stage.drawn.rectangles["help"] in stage.drawn.covered
    assert len(SHORTCUTS) > 10


@pytest.mark.parametrize("divider", [0.0, 0.02, 0.5, 0.98, 1.0])
@pytest.mark.parametrize("panel", [True, False])
def test_legends_keep_to_their_half(opened, divider, panel) -> None:
    half = Half(Specification.parse("pervertex"), Aspect.ERROR)
    stage = opened(split=True, divider=divider, first=half, second=half, panel=panel)
    left, _, right, _ = image_area(SIZE, panel)
    found, x = stage.drawn.rectangles, left + divider * (right - left)
    for name in ("caption", "scale"):
        first, second = found.get(f"first/{name}"), found.get(f"second/{name}")
        assert first is None or (first[2] <= x and not overlap(first, found["panel"]))
        assert second is None or (second[0] >= x and not overlap(second, found["panel"]))
    shown = "first/scale" if divider > 0.5 else "second/scale"
    assert shown in found


def test_words_fit_the_buttons_they_stand_on(opened) -> None:
    stage = opened(first=Half(Specification.parse("pervertex"), Aspect.ERROR))
    pressed(stage, "section/quality", "section/save")
    groups = {"first/aspect": ASPECTS, "unit": UNITS, "samples": SAMPLES, "resolution": RESOLUTIONS, "eye/side": SIDES}
    words = {f"{key}/{value}": text for key, choices in groups.items() for value, text in choices}
    words |= {str(request): text for request, text, _ in SAVED}
    widths = stage.measure(words.values())
    for key, text in words.items():
        left, _, right, _ = stage.drawn.rectangles[key]
        assert widths[text] + 4.0 <= right - left, key


def test_a_very_long_name_and_message_leave_room_for_the_rest(opened, scene) -> None:
    named = replace(scene, name="a scene with a name that goes on and on, " * 40)
    stage = opened((640, 480), of=named, told={"message": "w" * 6000})
    found = stage.drawn.rectangles
    _, top, _, bottom = found["panel/body"]
    assert bottom - top > 250.0 and inside(found["panel/body"], found["panel"])
    assert inside(found["notice"], (0.0, 0.0, 640.0, 480.0)) and not overlap(found["notice"], found["panel"])
    assert inside(found["opening/show"], found["panel"]) and not overlap(found["opening/show"], found["help/show"])
    assert inside(found["help/show"], found["panel"]) and inside(found["message/close"], found["notice"])


def test_a_scene_without_controls_says_so(opened, scene) -> None:
    plain = replace(scene, meshes=tuple(mesh for mesh in scene.meshes if not mesh.specular))
    stage = opened(of=plain)
    assert not any(key.startswith("part/") for key in stage.drawn.rectangles)
    assert {"eye/x", "scene/empty"} <= set(stage.drawn.rectangles) and "reset" not in stage.drawn.rectangles


def test_only_the_first_of_many_parts_is_unfolded(opened) -> None:
    stage = opened(of=gallery.make("facing-mirrors"))
    assert {key for key in stage.drawn.rectangles if key.endswith("/swivel")} == {"mirror-far/swivel"}
    stage.press("part/mirror-near")
    assert "mirror-near/swivel" in stage.drawn.rectangles


def test_a_newly_picked_pixel_is_scrolled_into_view(opened) -> None:
    stage = opened((640, 480), told={"inspection": SEEN})
    stage.state = replace(stage.state, picked=(0.3, 0.4))
    stage.frames(3)
    heading, body = stage.drawn.rectangles["section/inspection"], stage.drawn.rectangles["panel/body"]
    assert inside(heading, body)


def test_a_view_that_opens_with_a_picked_pixel_begins_at_its_top(opened) -> None:
    stage = opened((640, 480), told={"inspection": SEEN}, picked=(0.3, 0.4))
    stage.frames(3)
    top = opened((640, 480)).drawn.rectangles["section/image"]
    assert stage.drawn.rectangles["section/image"] == top
    stage.state = replace(stage.state, opening="")
    stage.frames(2)
    stage.state = replace(stage.state, opening=None, picked=(0.5, 0.5))
    stage.frames(3)
    assert stage.drawn.rectangles["section/image"] == top, "opened from within"
    stage.state = replace(stage.state, picked=(0.6, 0.5))
    stage.frames(3)
    assert stage.drawn.rectangles["section/image"] != top


def told_by(monkeypatch, opened, **told) -> dict[str, tuple[str, ...]]:
    """The rows of the section Timing."""
    rows: dict[str, tuple[str, ...]] = {}
    monkeypatch.setattr(results, "row", lambda label, *values: rows.update({label: values}))
    pressed(opened(told=told), "section/timing")
    return rows


def test_counts_of_nothing_are_left_out(opened, monkeypatch) -> None:
    assert told_by(monkeypatch, opened, samples_done=3, samples_total=16)["samples"] == ("3 of 16",)
    assert "samples" not in told_by(monkeypatch, opened, samples_total=0)
    rows = told_by(monkeypatch, opened, image=(0, 0), samples_total=16)
    assert not {"samples", "drawn", "at rest"} & rows.keys() and "adapter" in rows


def test_the_status_line_says_no_size_of_nothing(opened) -> None:
    bare, empty = opened(told={"image": (0, 0), "samples_total": 16}), opened(told={"image": (0, 0)})
    drawn = opened(told={"samples_total": 16})
    _, top, _, bottom = (round(edge) for edge in bare.drawn.rectangles["status"])
    beside = np.s_[top:bottom, :300]
    assert np.array_equal(bare.frames()[beside], empty.frames()[beside])
    assert len(np.unique(bare.frames()[beside].reshape(-1, 4), axis=0)) == 1
    assert not np.array_equal(bare.frames()[beside], drawn.frames()[beside])


def test_what_is_said_waits_behind_the_help(opened) -> None:
    stage = opened(told={"message": "saved car-mirror-1.toml"})
    assert "notice" in stage.drawn.rectangles
    stage.state = replace(stage.state, help=True)
    stage.frames(2)
    assert "notice" not in stage.drawn.rectangles and "message/close" not in stage.drawn.rectangles
    assert pressed(stage, "help/close").help is False
    stage.frames(2)
    assert "notice" in stage.drawn.rectangles


@pytest.mark.parametrize("width", [60.0, 130.0, 238.0, 440.0, 1e6])
@pytest.mark.parametrize(
    "text",
    [
        "/etc/passwd: is no known model; give one that ends in .toml, .glb, .gltf, .step, .stp, .iges, .igs",
        "a tolerance of 0.5 or 1.25,\nand then another line: it is longer.",
        "  two   spaces ",
        "w" * 90,
        "",
    ],
)
def test_lines_end_between_words(opened, monkeypatch, text, width) -> None:
    lines: list[str] = []
    monkeypatch.setattr(results, "caption", lambda _: lines.extend([] if lines else broken(text, width).split("\n")))
    stage = opened()
    assert " ".join(lines).split() == text.split() and len(lines) > 0
    widths = stage.measure(lines)
    assert all(widths[line] <= width or " " not in line.strip() for line in lines)
    if width == 1e6:
        assert "\n".join(lines) == text


@pytest.mark.parametrize(
    ("specification", "said"),
    [("raytrace", "truth"), ("raytrace:bounces=2", "raytrace, bounces 2"), ("pervertex", "pervertex")],
)
def test_a_method_is_called_the_same_over_the_image_and_beside_it(opened, monkeypatch, specification, said) -> None:
    rows = {}
    monkeypatch.setattr(results, "row", lambda label, *values: rows.update({label: values}))
    stage = opened(told={"inspection": replace(SEEN, method=Specification.parse(specification))}, picked=(0.5, 0.5))
    assert rows["method"] == (said,) and half_caption(Half(Specification.parse(specification)), stage.state) == said


def test_the_panel_says_where_the_truth_follows_more_mirrors() -> None:
    several, one = gallery.make("facing-mirrors"), gallery.make("car-mirror")

    def said(specification: str, scene: Scene) -> str:
        return few_bounces(Specification.parse(specification).options, scene)

    assert said("pervertex:bounces=2", several) == said("trilinear", several) != ""
    assert "2 mirrors" in said("trilinear", several) and "3 mirrors" in said("pervertex", several)
    assert "the reference over 8" in said("pervertex", several) and f"{BOUNCES} in the options" in said(
        "pervertex", several
    )
    for silent in ("pervertex:bounces=8", "raytrace", "raytrace:bounces=20", "environment"):
        assert said(silent, several) == ""
    assert said("pervertex", one) == "" and said("raytrace:bounces=2", several) != ""


@pytest.mark.parametrize("ratio", [1.0, 1.5, 2.0])
def test_letters_are_drawn_as_fine_as_the_canvas_is(opened, ratio) -> None:
    assert opened(ratio=ratio).density == ratio


def test_every_drawing_can_be_chosen() -> None:
    assert len(DRAWINGS) == len(Drawing)


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (None, "\N{EN DASH}"),
        (0.0, "0"),
        (1e-9, "< 0.0001"),
        (0.0001, "0.00010"),
        (0.0004321, "0.00043"),
        (0.00999, "0.0100"),
        (0.04321, "0.043"),
        (0.4321, "0.432"),
        (1.0, "1.00"),
        (12.34, "12.3"),
        (123.4, "123"),
        (1234.5, "1234"),
    ],
)
def test_figures_have_three_digits(value, text) -> None:
    assert figure(value) == text


def test_numbers_have_real_minus_signs_and_nought_has_none() -> None:
    assert number_text(-1.25, 2, "m") == "\N{MINUS SIGN}1.25 m"
    assert number_text(-0.0001, 2, "°") == "0.00°"
    assert [decimals(step) for step in (1.0, 0.5, 0.005, 20.0, 5e-7)] == [0, 1, 3, 0, 6]


@pytest.mark.parametrize(
    ("limit", "curvature", "text"),
    [
        (2.0, 1.0 / 1.4, "0.714 1/m, convex, R = 1.4 m"),
        (2.0, 0.0, "0.000 1/m, flat"),
        (0.002, 1.0 / 1981.0, "0.000505 1/m, convex, R = 1981 m"),
        (0.0002, -0.000123, "\N{MINUS SIGN}0.000123 1/m, concave, R = 8130 m"),
    ],
)
def test_a_curvature_has_the_digits_that_its_slider_sets(opened, scene, limit, curvature, text) -> None:
    control = next(each for each in scene_controls(scene) if each.unit == "1/m")
    own = replace(control, low=-limit, high=limit, step=limit / 400.0)
    assert curvature_text(own, curvature) == text
    assert opened().measure([text])[text] < 223.0, "it fits its slider"


def test_the_panel_says_how_errors_come_to_be_measured(opened, monkeypatch) -> None:
    said: list[str] = []
    monkeypatch.setattr(results, "caption", said.append)
    opened()
    assert results.UNASKED in said
    said.clear()
    opened(first=Half(Specification.parse("pervertex"), Aspect.ERROR))
    assert results.UNASKED not in said and any("nothing moves" in text for text in said)
    said.clear()
    opened(picked=(0.5, 0.5))
    assert results.UNASKED not in said
