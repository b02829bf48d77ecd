"""Views that are remembered, the path through them, and whose pixel is looked into from outside."""

from __future__ import annotations

import tomllib
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import assume, example, given
from hypothesis import strategies as st
from PIL import Image
from scenes import CAMERA
from scipy.spatial.transform import Rotation
from viewer_hand import Hand

import anamorph as an
from anamorph.base.errors import AnamorphError
from anamorph.base.srgb import encode_srgb
from anamorph.cli.commands import main
from anamorph.cli.turntable import save_turntable
from anamorph.files.opening import open_scene
from anamorph.files.source import Source
from anamorph.files.view_file import views_of
from anamorph.frame import Frame, View
from anamorph.methods import Specification
from anamorph.scene.camera import Camera
from anamorph.viewer.navigation import orbit as orbited
from anamorph.viewer.remembered import forget, go_to, remember
from anamorph.viewer.starting import start_of
from anamorph.viewer.state import EyeSide, Half, State, shown_camera, with_observer, with_picked
from anamorph.viewer.turntable import LEG, between, orbit

UP = (0.0, 1.0, 0.0)
places = st.tuples(*[st.floats(-5.0, 5.0)] * 3)
ups = st.sampled_from((UP, (0.0, 1.0, 0.0), (0.0, -2.0, 0.0), (0.0, 0.0, 1.0), (0.3, 1.0, -0.2)))


@st.composite
def cameras(draw: st.DrawFn, up: st.SearchStrategy = ups) -> Camera:
    """Also straight opposite to each other, nearly along their upward direction, and at one place."""
    target, upward = draw(places | st.just((0.0, 0.0, 0.0))), draw(up)
    camera = Camera((0.0, 0.0, 0.0), (0.0, 0.0, 0.0), upward, draw(st.floats(1.0, 120.0)))
    steps = st.tuples(*[st.integers(-3, 3)] * 3) | st.tuples(*[st.floats(-3.0, 3.0)] * 3)
    away = draw(steps | st.sampled_from(((1e-4, 2.0, 0.0), (0.0, 0.0, 3.0), (0.0, 0.0, -3.0))))
    along = np.linalg.norm(np.cross(away, upward))
    assume(along > 1e-5 * np.linalg.norm(away) * np.linalg.norm(upward) and np.linalg.norm(away) > 0.1)
    x, y, z = np.add(target, away).tolist()
    return replace(camera, position=(x, y, z), target=target)


def height(camera: Camera) -> float:
    """Of the eye as its target has it, over the upward direction's level: radians."""
    return float(np.arcsin(np.clip(-camera.axes()[2] @ camera.up / np.linalg.norm(camera.up), -1.0, 1.0)))


@given(st.lists(cameras(), min_size=2, max_size=4), st.integers(0, 12))
@example([Camera((0.0, 0.0, 1.0), (0.0,) * 3), Camera((0.0, 0.0, 1.0), (0.0,) * 3, (0.0, -1.0, 0.0))], 3)
@example([Camera((0.0, 0.0, 1.0), (0.0,) * 3), Camera((0.0, 0.0, -1.0), (0.0,) * 3)], 3)
def test_a_path_passes_its_views_and_is_sound_between_them(views: list[Camera], more: int) -> None:
    path = between(views, 4 * (len(views) - 1) + 1)
    assert path[::4] == views
    whole = between(views, len(views) + more)
    assert len(whole) == len(views) + more and (whole[0], whole[-1]) == (views[0], views[-1])
    lengths = [np.linalg.norm(np.subtract(view.target, view.position)) for view in views]
    fields = [view.field_of_view for view in views]
    for camera in whole:
        assert camera.axes() @ camera.axes().T == pytest.approx(np.eye(3), abs=1e-9)
        distance = np.linalg.norm(np.subtract(camera.target, camera.position))
        assert min(lengths) * (1 - 1e-9) <= distance <= max(lengths) * (1 + 1e-9)
        assert min(fields) * (1 - 1e-9) <= camera.field_of_view <= max(fields) * (1 + 1e-9)


@given(st.lists(cameras(st.just(UP)), min_size=2, max_size=2))
def test_a_level_horizon_stays_level_and_no_view_is_steeper_than_both(views: list[Camera]) -> None:
    low, high = sorted(map(height, views))
    for camera in between(views, 9):
        assert np.cross(camera.up, UP) == pytest.approx(np.zeros(3), abs=1e-12)
        assert low - 1e-7 <= height(camera) <= high + 1e-7


@st.composite
def from_before(draw: st.DrawFn) -> Camera:
    """Such that no two are half a turn apart, between which there would be two ways."""
    lean = Rotation.from_euler("xz", draw(st.tuples(st.floats(-0.6, 0.6), st.floats(-0.6, 0.6))))
    around, rise = draw(st.floats(-0.7, 0.7)), draw(st.floats(-1.5, 1.5))
    back = lean.apply([np.cos(rise) * np.sin(around), np.sin(rise), np.cos(rise) * np.cos(around)])
    target, up = draw(places), lean.apply(UP)
    return Camera(tuple(target + draw(st.floats(0.1, 9.0)) * back), target, tuple(up), draw(st.floats(1.0, 120.0)))


@given(st.lists(from_before(), min_size=2, max_size=3))
def test_the_way_back_is_the_way_there(views: list[Camera]) -> None:
    there, back = between(views, 13), between(views[::-1], 13)[::-1]
    for one, other in zip(there, back, strict=True):
        assert one.position == pytest.approx(other.position, abs=1e-9)
        assert one.axes() == pytest.approx(other.axes(), abs=1e-7)
        assert one.field_of_view == pytest.approx(other.field_of_view)


@pytest.mark.parametrize("upward", [(0.1, 1.0, 0.0), (0.0, -2.0, 0.5)])
def test_between_two_views_of_an_orbit_the_path_is_that_orbit(upward: tuple[float, float, float]) -> None:
    camera = Camera((1.0, 2.0, 5.0), (1.0, 1.5, 1.0), upward)
    around = orbit(camera, 24)
    # Half way between two views the eye has gone half of the way.
    for last in (4, 10, -6):
        assert between([camera, around[last]], 3)[1].position == pytest.approx(around[last // 2].position, abs=1e-12)


def test_a_path_stands_still_for_a_moment_in_each_view() -> None:
    views = [CAMERA, replace(CAMERA, position=(4.0, 2.0, 3.0)), replace(CAMERA, position=(1.0, 4.0, -3.0))]
    positions = np.array([camera.position for camera in between(views, 201)])
    steps = np.linalg.norm(np.diff(positions, axis=0), axis=1)
    assert max(steps[0], steps[99], steps[100], steps[199]) < 0.05 * steps.max()


def test_a_path_is_as_long_as_its_views_want_and_no_longer_than_a_series_may_be(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    views = [CAMERA, orbited(CAMERA, 0.1, 0.0)]
    path = between(views * 2)
    assert len(path) == 3 * LEG + 1 and path[::LEG] == views * 2
    monkeypatch.setattr("anamorph.viewer.turntable.MOST_FRAMES", 70)
    assert len(between(views * 2)) == 70


@pytest.mark.parametrize(
    ("count", "frames", "words"),
    [(0, 3, "at least 2 views, not 0"), (1, None, "at least 2 views, not 1"), (3, 2, "at least 3"), (2, 0, "frames")],
)
def test_a_path_of_no_sense_is_refused_in_one_line(count: int, frames: int | None, words: str) -> None:
    with pytest.raises(AnamorphError, match=rf"^[^\n]*{words}[^\n]*$"):
        between([CAMERA] * count, frames)


states = st.builds(
    State,
    camera=cameras(),
    first=st.just(Half(Specification.parse("pervertex"))),
    second=st.just(Half(Specification.parse("raytrace"))),
    eye=st.sampled_from(EyeSide),
    observer=st.none() | cameras(),
    split=st.booleans(),
    views=st.lists(cameras(), max_size=3).map(tuple),
)


@given(states)
def test_what_is_remembered_is_what_is_shown_once(state: State) -> None:
    kept = remember(state)
    assert kept.views[-1] == shown_camera(state) and kept.views[: len(state.views)] == state.views
    assert len(kept.views) <= len(state.views) + 1 and remember(kept) == kept
    assert replace(kept, views=state.views) == state


@given(states, st.data())
def test_a_view_that_one_goes_to_is_shown_and_only_who_looks_moves(state: State, data: st.DataObject) -> None:
    state = remember(state)
    number = data.draw(st.integers(0, len(state.views) - 1))
    there = go_to(state, number)
    assert shown_camera(there) == state.views[number] and there.views == state.views
    if state.observer is None:
        assert replace(there, camera=state.camera, eye=state.eye) == state and there.eye is EyeSide.MIDDLE
    else:
        assert replace(there, observer=state.observer) == state
    left = forget(state, number).views
    assert (*left[:number], state.views[number], *left[number:]) == state.views


@given(states, st.tuples(st.floats(0.0, 1.0), st.floats(0.0, 1.0)))
def test_a_pixel_is_his_into_whose_image_was_clicked(state: State, place: tuple[float, float]) -> None:
    looked = with_picked(state, place)
    assert looked.picked == place and looked.picked_outside is (state.observer is not None)
    assert with_picked(looked, None) == state
    outside = with_observer(looked, CAMERA)
    assert (outside.picked, outside.picked_outside, outside.observer) == (place, looked.picked_outside, CAMERA)
    # The eye's pixel outlives the observer; his own does not.
    inside = with_observer(outside, None)
    assert inside.picked == (None if looked.picked_outside else place)
    assert inside.observer is None and not inside.picked_outside


@pytest.fixture
def hand(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Hand]:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("anamorph.viewer.turntable.LEG", 2)
    hand = Hand(start_of("flat-mirror"), (560, 600))
    yield hand
    hand.close()


def reveal(hand: Hand, key: str) -> None:
    """Scroll the panel until a widget is in sight."""
    _, top, right, bottom = hand.viewer.snapshot()["rectangles"]["panel/body"]
    x, middle = right - 4.0, (top + bottom) / 2.0
    hand.send("pointer_move", x=x, y=middle, button=0)
    for _ in range(60):
        y = hand.widget(key)[1]
        if top + 8.0 < y < bottom - 8.0:
            return
        hand.send("wheel", x=x, y=middle, dx=0.0, dy=float(np.copysign(60.0, y - top)))
        hand.draw(2)
    raise AssertionError(f"{key} cannot be scrolled into sight")


def push(hand: Hand, *keys: str) -> None:
    for key in keys:
        reveal(hand, key)
        hand.click(*hand.widget(key))
        hand.draw(3)


def test_views_are_remembered_shown_again_forgotten_and_filmed(
    hand: Hand, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    hand.settle()
    hand.key("k")
    hand.drag(hand.place(0.6, 0.6), hand.place(0.7, 0.55))
    push(hand, "section/views", "views/remember")
    hand.key("o")
    hand.key("k")
    eye, other, outside = views = hand.viewer.state.views
    assert outside == hand.viewer.state.observer and other == hand.viewer.state.camera != eye
    assert len(hand.viewer.snapshot()["state"]["views"]) == 3
    push(hand, "views/0")
    assert (hand.viewer.state.observer, hand.viewer.state.camera) == (eye, other)
    hand.key("o")
    push(hand, "views/0", "views/2/forget")
    assert hand.viewer.state.views == views[:2] and hand.viewer.state.camera == eye
    push(hand, "section/save", "save-path-series")
    hand.settle(lambda snapshot: snapshot["message"] == "saved flat-mirror-1")
    path = between(views[:2])
    names = [f"frame-{number:04}.png" for number in (1, 2, 3)]
    assert sorted(each.name for each in (tmp_path / "flat-mirror-1").iterdir()) == names
    left, top = (round(place) for place in hand.place(0.0, 0.0))
    right, bottom = (round(place) for place in hand.place(1.0, 1.0))
    for name, camera in zip(names, path, strict=True):
        wanted = an.render("flat-mirror", camera=camera, size=(right - left, bottom - top), samples=2).color
        with Image.open(tmp_path / "flat-mirror-1" / name) as image:
            assert np.array_equal(np.asarray(image), np.round(255 * encode_srgb(wanted)).astype(np.uint8))
    # So long that it is not done before anybody can cancel it.
    monkeypatch.setattr("anamorph.viewer.turntable.LEG", 500)
    push(hand, "save-path")
    hand.settle(lambda snapshot: snapshot["progress"] and snapshot["progress"]["done"] > 2)
    hand.click(*hand.widget("cancel"))
    hand.settle(lambda snapshot: snapshot["message"] == "stopped")
    monkeypatch.setattr("anamorph.viewer.turntable.LEG", 2)
    assert [each.name for each in tmp_path.iterdir()] == ["flat-mirror-1"], "a stopped one leaves nothing behind"
    push(hand, "save-path")
    hand.settle(lambda snapshot: snapshot["message"] == "saved flat-mirror-1.webm")
    assert (tmp_path / "flat-mirror-1.webm").stat().st_size > 1000
    push(hand, "views/clear")
    push(hand, "save-path")
    assert hand.viewer.state.views == () and hand.viewer.snapshot()["progress"] is None
    hand.key("k")
    hand.key("R", "Shift")
    assert hand.viewer.state.views == ()


@pytest.mark.parametrize("outside", [False, True])
def test_a_pixel_reopens_as_his_whose_it_was(hand: Hand, tmp_path: Path, outside: bool) -> None:
    hand.settle()
    hand.key("k")
    if outside:
        hand.key("o")
        hand.settle()
    hand.click(*hand.place(0.45, 0.45))
    hand.settle(lambda snapshot: snapshot["inspection"] and snapshot["at_rest"])
    seen = hand.viewer.snapshot()["inspection"]
    assert seen["path"][0]["point"] == shown_camera(hand.viewer.state).position
    if not outside:
        hand.key("o")
        hand.settle()
    hand.key("s", "Control")
    hand.settle(lambda snapshot: (tmp_path / "flat-mirror-1.toml").exists())
    again = Hand(start_of(tmp_path / "flat-mirror-1.toml"), (560, 600))
    try:
        again.settle(lambda snapshot: snapshot["inspection"] and snapshot["at_rest"])
        assert again.viewer.state == hand.viewer.state and again.viewer.state.picked_outside is outside
        assert again.viewer.snapshot()["inspection"] == seen
        again.key("o")
        again.settle()
        found = again.viewer.snapshot()["inspection"]
        assert found == (None if outside else seen)
    finally:
        again.close()


def test_a_method_that_cannot_look_for_the_eye_is_told_of_once(hand: Hand, monkeypatch: pytest.MonkeyPatch) -> None:
    hand.key("o")
    hand.settle()
    asked = []

    def failing(view: View, specification: Specification, seen: bool) -> Frame:
        asked.append(view.camera)
        raise AnamorphError("it looks at nothing")

    monkeypatch.setattr("anamorph.viewer.inspector.draw_frame", failing)
    hand.viewer.state = replace(hand.viewer.state, picked=(0.45, 0.45))
    hand.viewer.refresh()
    hand.settle()
    assert asked == [hand.viewer.state.camera] and hand.viewer.snapshot()["inspection"] is None
    assert hand.viewer.snapshot()["message"] == "it looks at nothing"


def test_from_outside_a_click_where_the_eye_has_picked_picks_for_the_observer(hand: Hand) -> None:
    hand.viewer.state = with_picked(hand.viewer.state, (0.45, 0.45))
    hand.settle()
    by_eye = hand.viewer.snapshot()["inspection"]
    hand.key("o")
    hand.click(*hand.place(0.45, 0.45))
    hand.settle()
    assert hand.viewer.state.picked_outside and hand.viewer.snapshot()["inspection"]["path"] != by_eye["path"]
    hand.click(*hand.place(0.45, 0.45))
    assert hand.viewer.state.picked is None


FILE = """builtin = "flat-mirror"
size = [48, 32]
[[part]]
name = "mirror"
turn = [5, 0, 0]
[view]
"""
VIEWS = """[[view.views]]
position = [0.4, 1.2, 2.2]
target = [0, 1, 0]
[[view.views]]
position = [-0.5, 1.4, 2.0]
target = [0, 1, 0]
field_of_view = 30
"""


def test_the_command_follows_the_path_that_a_scene_file_keeps(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("kept.toml").write_text(FILE + VIEWS)
    assert main(["turntable", "kept.toml", "--path", "-o", "a", "--frames", "3", "-m", "raytrace"]) == 0
    assert capsys.readouterr().out == "saved a\n"
    scene, settings = open_scene("kept.toml")
    for number, camera in enumerate(between(views_of(settings.view), 3), start=1):
        wanted = an.render(scene, "raytrace", camera=camera, size=(48, 32)).color
        with Image.open(f"a/frame-{number:04}.png") as image:
            assert np.array_equal(np.asarray(image), np.round(255 * encode_srgb(wanted)).astype(np.uint8))
    assert main(["turntable", "kept.toml", "--path", "-o", "a.webm", "-m", "environment", "--size", "16x16"]) == 0
    # What the viewer saves is what the command follows.
    assert [each["position"] for each in tomllib.loads(FILE + VIEWS)["view"]["views"]] == [
        list(view.position) for view in views_of(settings.view)
    ]


@pytest.mark.parametrize(
    ("text", "arguments", "words"),
    [
        (FILE, ["kept.toml", "--path"], ["kept.toml: keeps 0 views", "needs 2", "remember them in the viewer"]),
        (FILE.replace("[view]", ""), ["kept.toml", "--path"], ["kept.toml: keeps 0 views"]),
        (FILE + VIEWS[: VIEWS.rindex("[[")], ["kept.toml", "--path"], ["keeps 1 view, and"]),
        (FILE, ["flat-mirror", "--path"], ["flat-mirror: keeps 0 views"]),
        (FILE + VIEWS.replace("[0.4, 1.2, 2.2]", "[0.4, 1.2]"), ["kept.toml", "--path"], ["line 8", "three numbers"]),
        (FILE + VIEWS.replace("[0.4, 1.2, 2.2]", "[0, 1, 0]"), ["kept.toml", "--path"], ["number 1 of views"]),
        (FILE + VIEWS, ["kept.toml", "--path", "--frames", "1"], ["frames is 1", "at least 2"]),
        (FILE + VIEWS, ["kept.toml", "--path", "--swing", "9"], ["--swing: not allowed with argument --path"]),
        (FILE + VIEWS, ["kept.toml", "--path=1"], ["--path"]),
    ],
)
def test_a_path_that_cannot_be_followed_is_refused_in_one_line(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture,
    text: str,
    arguments: list[str],
    words: list[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("kept.toml").write_text(text)
    assert main(["turntable", *arguments, "-o", "a.webm"]) == 2
    told = capsys.readouterr()
    assert told.out == "" and told.err.count("\n") == 1 and all(word in told.err for word in words), told.err
    assert [each.name for each in tmp_path.iterdir()] == ["kept.toml"]


def test_a_path_in_python_has_no_swing(tmp_path: Path) -> None:
    with pytest.raises(AnamorphError, match=r"^swing is 5, and a path has none"):
        save_turntable(Source("flat-mirror"), tmp_path / "a", swing=5.0, path=True)
