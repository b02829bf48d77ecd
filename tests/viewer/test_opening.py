"""Opening another scene from within the viewer: the panel's page for it, and what stays of the old scene's image."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from itertools import combinations
from pathlib import Path

import numpy as np
import pytest
from panel_stage import Stage, inside, overlap
from scenes import scene_with, spherical_mirror
from viewer_hand import Hand, home_of

from anamorph.base.errors import AnamorphError
from anamorph.files.models import SUFFIXES
from anamorph.files.source import FaceChoice, Source
from anamorph.files.view_file import Opened
from anamorph.gallery import SCENES
from anamorph.methods import Specification
from anamorph.scene.model import Scene
from anamorph.viewer import application, starting
from anamorph.viewer.facts import Facts, Progress
from anamorph.viewer.saving import save_scene
from anamorph.viewer.shortcuts import press
from anamorph.viewer.starting import Start, carried_over, start_of
from anamorph.viewer.state import Aspect, Drawing, Half, State


@pytest.fixture(scope="module")
def scene() -> Scene:
    return scene_with(spherical_mirror())


@pytest.fixture
def opened(scene: Scene) -> Iterator[Callable[..., Stage]]:
    stages = []

    def open_stage(size=(640, 480), of=scene, **state) -> Stage:
        first = State(of.camera, Half(Specification.parse("pervertex")), Half(Specification.parse("raytrace")))
        stages.append(Stage(replace(first, **state), Facts(of, size, size, size, "an adapter")))
        return stages[-1]

    yield open_stage
    for stage in stages:
        stage.close()


@pytest.fixture
def hand(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Hand]:
    monkeypatch.chdir(tmp_path)
    hand = Hand(start_of("flat-mirror"))
    yield hand
    hand.close()


def ask(hand: Hand, name: str) -> None:
    """Type a name as a user does, and wait for what comes of it."""
    if hand.viewer.state.opening is None:
        hand.key("o", "Control")
    hand.type(name)
    hand.key("Enter")
    hand.settle(lambda snapshot: not snapshot["message"].startswith("opening"))


@pytest.mark.parametrize("name", ["car-mirror", "cube-in-wavy-mirror"])
def test_a_built_in_scene_is_opened_by_one_press(opened, name) -> None:
    stage = opened()
    stage.press("opening/show")
    before = stage.state
    stage.press(f"opening/{name}")
    assert stage.opens == [name] and stage.state == before and stage.requests == []


def test_a_path_is_typed_at_once_and_taken_by_enter(opened) -> None:
    stage = opened()
    stage.press("opening/show")
    stage.frames(2)
    assert stage.drawn.typing
    stage.key("Enter")
    stage.type("  ")
    stage.key("Enter")
    assert stage.opens == [], "nothing names no scene"
    stage.type("a folder/mirror.step ")
    assert stage.state.opening == "  a folder/mirror.step "
    stage.key("Enter")
    assert stage.opens == ["a folder/mirror.step"]
    assert stage.state.opening == "  a folder/mirror.step " and stage.drawn.typing, "it can be mended"


def test_escape_leaves_the_page(opened) -> None:
    stage = opened()
    before = stage.state
    stage.press("opening/show")
    stage.type("half a na")
    stage.key("Escape")
    assert stage.state == before and not stage.drawn.typing and stage.opens == []
    home = home_of(before, stage.facts.scene)
    escape = {"key": "Escape"}
    assert press(escape, replace(before, opening="x", picked=(0.5, 0.5)), home)[0] == replace(before, picked=(0.5, 0.5))
    assert press(escape, replace(before, opening="x", help=True), home)[0] == replace(before, opening="x")


def test_the_key_shows_a_hidden_panel_and_hides_only_the_page(scene) -> None:
    state = State(
        scene.camera,
        Half(Specification.parse("pervertex")),
        Half(Specification.parse("raytrace")),
        panel=False,
        opening="typed",
    )
    home, event = home_of(state, scene), {"key": "o", "modifiers": ("Control",)}
    shown, _ = press(event, state, home)
    assert shown == replace(state, panel=True)
    assert press(event, shown, home)[0] == replace(shown, opening=None)


@pytest.mark.parametrize("size", [(640, 480), (800, 600), (1280, 720)])
def test_all_of_the_page_is_seen_without_scrolling(opened, size) -> None:
    stage = opened(size, opening="x" * 300)
    found = stage.drawn.rectangles
    keys = ["opening/path", *(f"opening/{name}" for name in SCENES)]
    assert all(inside(found[key], found["panel/body"]) for key in keys)
    assert not any(overlap(found[one], found[other]) for one, other in combinations([*keys, "opening/show"], 2))
    assert all(found[key][3] - found[key][1] >= 16.0 for key in keys)
    assert "first/method" not in found


@pytest.mark.parametrize("name", ["w" * 1000, "a name that goes on and on " * 20, "…"])
def test_a_name_keeps_to_its_button(opened, scene, name) -> None:
    short, long = opened(), opened(of=replace(scene, name=name))
    _, top, right, bottom = (round(edge) for edge in short.drawn.rectangles["opening/show"])
    beside = np.s_[top:bottom, right - 22 : 276]
    assert np.array_equal(short.frames()[beside], long.frames()[beside])


def test_another_scene_is_announced_and_then_shown_as_if_it_came_first(hand: Hand, monkeypatch) -> None:
    hand.settle()
    hand.key("o", "Control")
    quiet = hand.draw(3)
    announced = []

    def opening(name: str) -> Start:
        told = hand.viewer.snapshot()
        assert (told["scene"], told["message"]) == ("flat-mirror", "opening spheres …")
        left, top, right, bottom = (round(edge) for edge in told["rectangles"]["notice"])
        notice = hand.shown[top:bottom, left:right].astype(int) - quiet[top:bottom, left:right]
        announced.append((np.abs(notice).max(axis=-1) > 20).mean())
        return start_of(name)

    monkeypatch.setattr(starting, "start_of", opening)
    hand.click(*hand.widget("opening/spheres"))
    shown = hand.settle(lambda snapshot: snapshot["scene"] == "spheres" and snapshot["at_rest"])
    assert len(announced) == 1 and announced[0] > 0.5
    told = hand.viewer.snapshot()
    assert told["message"] == "" and told["state"]["opening"] is None
    assert hand.viewer.title == "spheres - Anamorph"
    first = Hand(start_of("spheres"))
    wanted = first.settle()
    assert hand.viewer.state == first.viewer.state
    first.close()
    beside = round(hand.place(0.0, 0.0)[0])
    assert np.abs(shown[:270, beside:].astype(int) - wanted[:270, beside:]).max() <= 1


def test_a_new_scene_sets_the_title(hand: Hand, monkeypatch) -> None:
    titles = []
    monkeypatch.setattr(hand.canvas, "set_title", titles.append)
    ask(hand, "room")
    assert titles == ["room - Anamorph"]


def test_what_cannot_be_opened_is_said_and_the_scene_stays(hand: Hand) -> None:
    hand.viewer.state = replace(hand.viewer.state, split=True, picked=(0.4, 0.4))
    hand.key("o", "Control")
    before = hand.settle()
    state = hand.viewer.state
    ask(hand, "no-such-file.step")
    told = hand.viewer.snapshot()
    assert "no-such-file.step" in told["message"] and "\n" not in told["message"]
    assert told["scene"] == "flat-mirror" and hand.viewer.title.startswith("flat-mirror")
    assert hand.viewer.state == replace(state, opening="no-such-file.step")
    hand.click(*hand.widget("message/close"))
    after = hand.settle()
    beside = round(hand.place(0.0, 0.0)[0])
    assert np.abs(after[:270, beside:].astype(int) - before[:270, beside:]).max() <= 1
    hand.key("Escape")
    ask(hand, "spheres")
    assert hand.viewer.snapshot()["scene"] == "spheres"


def test_a_file_of_the_folder_and_of_the_home_is_opened(hand: Hand, tmp_path: Path, monkeypatch) -> None:
    (tmp_path / "home").mkdir()
    monkeypatch.setenv("HOME", str(tmp_path / "home"))
    text = 'builtin = "flat-mirror"\nname = "{}"\n'
    (tmp_path / "mine.toml").write_text(text.format("mine"))
    (tmp_path / "home" / "ours.toml").write_text(text.format("ours"))
    ask(hand, "mine.toml")
    assert hand.viewer.snapshot()["scene"] == "mine"
    ask(hand, "~/ours.toml")
    assert hand.viewer.snapshot()["scene"] == "ours"


@pytest.mark.parametrize(
    ("typed", "asked"),
    [
        ("mirror.step --scene car-mirror", Source("mirror.step", None, "car-mirror")),
        ("'my mirror.step' --faces 1,rim --flip", Source("my mirror.step", FaceChoice((1, "rim"), flip=True))),
        ("mirror.igs --density 12", Source("mirror.igs", FaceChoice(density=12))),
        ("my mirror.step", "my mirror.step"),
        ("it's.toml", "it's.toml"),
        ("car-mirror", "car-mirror"),
    ],
)
def test_a_cad_file_is_opened_with_the_options_of_the_command_line(monkeypatch, typed, asked) -> None:
    def open_view(
        name: str, choice: FaceChoice | None = None, mirror_of: str | None = None, units: str = "", axes: str = ""
    ) -> Opened:
        given.append(Source(name, choice, mirror_of, units, axes))
        raise AnamorphError("stop")

    given: list[Source] = []
    monkeypatch.setattr(starting, "open_view", open_view)
    assert start_of(typed).message == "stop"
    assert given == [asked if isinstance(asked, Source) else Source(asked)]


@pytest.mark.parametrize(
    ("typed", "words"),
    [
        ("mirror.step --faces", "--faces: expected one argument"),
        ("mirror.step --density many", "'many' is no density"),
        ("mirror.step --method raytrace", "unrecognized arguments"),
        ("mirror.step --help", "unrecognized arguments"),
        ("--flip", "SCENE|MODEL"),
        ("x --flip", "x: "),
        ("car-mirror --flip", "for CAD files"),
        ("it's.step --flip", "quotation mark"),
    ],
)
def test_options_that_cannot_be_taken_are_one_line(typed, words) -> None:
    message = start_of(f" {typed}").message
    assert words in message and "\n" not in message


def test_a_file_whose_name_has_two_dashes_is_only_a_name(tmp_path: Path, monkeypatch) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "a --flip.toml").write_text('builtin = "flat-mirror"\n')
    assert start_of("a --flip.toml").opened.scene.name == "a --flip"


@pytest.mark.parametrize("name", ["passwd", "notes.txt", "folder.d/.hidden"])
def test_a_file_of_no_kind_is_told_of_by_its_name_with_all_that_can_be_opened(tmp_path: Path, name: str) -> None:
    file = tmp_path / name
    file.parent.mkdir(exist_ok=True)
    file.write_text("root:x:0:0\n")
    message = start_of(str(file)).message
    assert message.startswith(f"{file}: ") and "\n" not in message and "''" not in message
    assert all(suffix in message for suffix in (".toml", *SUFFIXES))


def test_a_viewer_that_opened_nothing_opens_something() -> None:
    hand = Hand(start_of("nowhere"))
    ask(hand, "also-nowhere")
    told = hand.viewer.snapshot()
    assert "also-nowhere" in told["message"] and told["scene"] == "nothing opened"
    hand.key("Escape")
    ask(hand, "flat-mirror")
    assert hand.viewer.snapshot()["scene"] == "flat-mirror"
    hand.close()


def test_what_is_being_saved_is_stopped_and_leaves_nothing(
    hand: Hand, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def endless() -> Iterator[Progress]:
        try:
            while True:
                yield Progress("saving", 0, 1)
        finally:
            ended.append(True)

    ended: list[bool] = []
    monkeypatch.setattr(application, "saving_of", lambda *_: endless())
    hand.key("p")
    ask(hand, "spheres")
    told = hand.viewer.snapshot()
    assert ended and told["progress"] is None and told["message"] == "stopped saving"


def test_halves_layers_and_split_are_carried_over_and_the_eye_is_not() -> None:
    old = start_of("flat-mirror").state
    set_there = replace(
        old,
        first=Half(Specification.parse("pervertex:field=60"), Aspect.ERROR),
        second=Half(Specification.parse("environment"), Aspect.STATUS),
        split=True,
        divider=0.3,
        panel=False,
        drawings=frozenset({Drawing.HITS}),
        observer=old.camera,
        values={"mirror/swivel": 3.0},
        picked=(0.5, 0.5),
        picked_outside=True,
        point=(1.0, 2.0, 3.0),
        views=(old.camera,),
        opening="spheres",
        samples=2,
        unit="px",
    )
    start = start_of("spheres")
    left = {"observer": None, "values": {}, "picked": None, "picked_outside": False, "point": None}
    left |= {"opening": None, "views": ()}
    kept = replace(set_there, camera=start.state.camera, **left)
    assert carried_over(set_there, start) == kept
    glass = start_of("magnifier")
    through = carried_over(set_there, glass)
    assert (through.first, through.second) == (set_there.first, Half(glass.state.second.method, Aspect.STATUS))


def test_a_saved_view_brings_its_own(tmp_path: Path) -> None:
    start = start_of("flat-mirror")
    kept = replace(
        start.state,
        first=Half(Specification.parse("environment"), Aspect.ERROR),
        values={"mirror/tilt": 2.0},
        divider=0.2,
    )
    kept = replace(kept, views=(kept.camera, replace(kept.camera, field_of_view=30.0)))
    save_scene(tmp_path / "view.toml", start.opened, kept, (320, 200))
    assert carried_over(replace(start.state, split=True), start_of(tmp_path / "view.toml")) == kept
