"""The point that was clicked: where mirrors show it, as eye and scene move, on a canvas without a screen."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from threading import Event
from typing import Any

import numpy as np
import pytest
from PIL import Image
from scenes import CAMERA, surroundings
from viewer_hand import Hand, home_of

from anamorph.methods import Specification
from anamorph.reflections.reflection_points import ReflectionStatus
from anamorph.scene.camera import Camera
from anamorph.scene.model import Scene
from anamorph.viewer import point_follower
from anamorph.viewer.facts import Reflection, Reflections
from anamorph.viewer.navigation import orbit
from anamorph.viewer.numbers import numbered, numbers_of
from anamorph.viewer.point_search import reflections_of
from anamorph.viewer.space import DASHES, HIDDEN_LEG, reflection_marks
from anamorph.viewer.starting import start_of
from anamorph.viewer.state import Drawing, Half, State, looking_eye, with_picked

ORANGE = np.array([255, 196, 0])
"""Of the dot on a mirror, 8-bit sRGB."""

MIRRORED = (0.62, 0.5)
"""A place of the image in the mirror of `flat-mirror`, and what is seen there lies before it."""

DIRECT = (0.5, 0.95)
"""A place of the floor, which the mirror shows, too."""


@pytest.fixture
def hand(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Hand]:
    monkeypatch.chdir(tmp_path)
    hand = Hand(start_of("flat-mirror"), (640, 400))
    hand.settle()
    yield hand
    hand.close()


def answered(snapshot: dict[str, Any]) -> bool:
    return snapshot["reflections"] is not None and snapshot["at_rest"]


def searched(hand: Hand) -> Reflections:
    """What a search of its own finds for the point and the eye of now."""
    state, size = hand.viewer.state, tuple(hand.viewer.snapshot()["full"])
    assert state.point is not None
    return reflections_of(hand.viewer.start.scene, looking_eye(state), size, state.point)


def numbered_at(pixels: np.ndarray, pixel: tuple[float, float]) -> bool:
    """Whether a number, light on dark, stands beside a pixel."""
    x, y = map(round, pixel)
    beside = pixels[y - 14 : y + 1, x + 7 : x + 24].reshape(-1, 3)
    return bool((beside.max(axis=1) < 30).mean() > 0.4 and (beside.min(axis=1) > 150).any())


def image_of(hand: Hand) -> np.ndarray:
    left, top = map(round, hand.place(0.0, 0.0))
    return hand.shown[top:, left:]


def test_a_click_marks_where_the_mirror_shows_what_is_seen_there(hand: Hand) -> None:
    hand.click(*hand.place(*MIRRORED))
    hand.settle(lambda snapshot: snapshot["inspection"])
    hand.settle()
    assert hand.viewer.state.point is None and hand.viewer.snapshot()["reflections"] is None
    hand.key("i")
    hand.settle(answered)
    told = hand.viewer.snapshot()
    assert hand.viewer.state.point == tuple(told["inspection"]["point"]) == told["reflections"]["point"]
    (found,) = searched(hand).found
    assert told["reflections"]["found"] == (vars(found),) and told["reflections"]["status"] == "FOUND"
    picked = told["inspection"]["pixel"]
    assert found.pixel == pytest.approx(np.add(picked, 0.5), abs=0.01) and not found.hidden
    x, y = map(int, found.pixel)
    assert np.abs(image_of(hand)[y, x].astype(int) - ORANGE).max() < 60 and numbered_at(image_of(hand), found.pixel)
    hand.key("i")
    hand.settle()
    assert hand.viewer.snapshot()["reflections"] is None and not numbered_at(image_of(hand), found.pixel)


def test_the_point_stays_and_its_marks_follow_the_eye_and_the_scene(hand: Hand) -> None:
    hand.key("i")
    hand.click(*hand.place(*MIRRORED))
    hand.settle(answered)
    point = hand.viewer.state.point
    before = hand.viewer.snapshot()["reflections"]["found"][0]
    hand.drag(hand.place(0.5, 0.8), hand.place(0.55, 0.8), hand.place(0.56, 0.8))
    hand.settle(answered)
    assert hand.viewer.state.point == point
    moved = hand.viewer.snapshot()["reflections"]
    assert moved["eye"] == hand.viewer.state.camera.position
    assert moved["found"] == tuple(map(vars, searched(hand).found)) and moved["found"][0] != before
    hand.viewer.state = replace(hand.viewer.state, values={"mirror/swivel": 3.0})
    hand.viewer.refresh()
    hand.settle(answered)
    turned = hand.viewer.snapshot()["reflections"]["found"]
    assert hand.viewer.state.point == point and turned[0]["path"] != moved["found"][0]["path"]


def test_another_click_is_another_point_and_escape_drops_it(hand: Hand) -> None:
    hand.key("i")
    hand.click(*hand.place(*MIRRORED))
    hand.settle(answered)
    point = hand.viewer.state.point
    hand.click(*hand.place(0.55, 0.55))
    hand.settle(lambda snapshot: answered(snapshot) and snapshot["state"]["point"] != point)
    assert hand.viewer.snapshot()["reflections"]["point"] == hand.viewer.state.point != point
    hand.key("Escape")
    hand.settle()
    assert hand.viewer.state.point is None and hand.viewer.snapshot()["reflections"] is None


def test_no_other_pixel_names_the_point(hand: Hand) -> None:
    hand.key("i")
    hand.click(*hand.place(*MIRRORED))
    hand.settle(answered)
    state = hand.viewer.state
    # Another pixel is picked just as the eye moves: what was seen at the last one is still all that is known.
    hand.viewer.state = replace(with_picked(state, (0.55, 0.55)), camera=orbit(state.camera, 0.02, 0.0))
    hand.viewer.refresh()
    hand.settle(answered)
    assert hand.viewer.state.point == tuple(hand.viewer.snapshot()["inspection"]["point"]) != state.point


def test_marks_come_when_a_slow_search_ends(hand: Hand, monkeypatch: pytest.MonkeyPatch) -> None:
    begin, search = Event(), point_follower.reflections_of

    def waits(*arguments: Any) -> Reflections:
        assert begin.wait(60.0)
        return search(*arguments)

    monkeypatch.setattr(point_follower, "reflections_of", waits)
    hand.key("i")
    hand.click(*hand.place(*DIRECT))
    hand.settle(lambda snapshot: snapshot["searching"])
    hand.settle()
    (found,) = searched(hand).found
    x, y = map(int, found.pixel)
    assert hand.viewer.snapshot()["reflections"] is None and not numbered_at(image_of(hand), found.pixel)
    assert np.abs(image_of(hand)[y, x].astype(int) - ORANGE).max() > 60
    begin.set()
    hand.settle(answered)
    assert np.abs(image_of(hand)[y, x].astype(int) - ORANGE).max() < 60 and numbered_at(image_of(hand), found.pixel)


def test_from_outside_they_are_those_of_the_eye(hand: Hand) -> None:
    hand.key("i")
    hand.click(*hand.place(*MIRRORED))
    hand.settle(answered)
    found = hand.viewer.snapshot()["reflections"]
    hand.key("o")
    hand.settle(answered)
    assert hand.viewer.snapshot()["reflections"] == found


def test_saved_images_have_the_numbers_and_saved_views_the_point(hand: Hand, tmp_path: Path) -> None:
    hand.key("i")
    hand.click(*hand.place(*MIRRORED))
    hand.settle(answered)
    found = hand.viewer.snapshot()["reflections"]["found"][0]
    hand.key("p")
    hand.settle(lambda snapshot: (tmp_path / "flat-mirror-1.png").exists())
    hand.key("s", "Control")
    hand.settle(lambda snapshot: (tmp_path / "flat-mirror-1.toml").exists())
    with Image.open(tmp_path / "flat-mirror-1.png") as image:
        assert numbered_at(np.asarray(image), found["pixel"])
    state = start_of(tmp_path / "flat-mirror-1.toml").state
    assert (state.point, state.picked) == (hand.viewer.state.point, hand.viewer.state.picked)
    assert Drawing.REFLECTIONS in state.drawings and with_picked(state, (0.1, 0.1)).point is None
    text = (tmp_path / "flat-mirror-1.toml").read_text()
    lines = [line for line in text.splitlines() if not line.startswith(("picked", "drawings"))]
    (tmp_path / "alone.toml").write_text("\n".join(lines))
    assert "point needs picked; give it too, or leave point out" in start_of(tmp_path / "alone.toml").message


def test_a_scene_without_mirrors_says_so_once_and_the_viewer_goes_on() -> None:
    traced = Half(Specification.parse("raytrace"))
    scene = Scene("test", surroundings(), CAMERA)
    hand = Hand(home_of(State(CAMERA, traced, traced, samples=1), scene))
    try:
        hand.key("i")
        hand.click(*hand.place(0.5, 0.8))
        hand.settle(lambda snapshot: snapshot["message"])
        assert "has no mirror" in hand.viewer.snapshot()["message"]
        hand.settle()
        assert hand.viewer.snapshot()["at_rest"] and not hand.viewer.snapshot()["searching"]
    finally:
        hand.close()


def test_what_takes_long_is_searched_when_nothing_moves(monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[bool] = []
    start = start_of("flat-mirror")
    point = (0.0, 1.0, 1.0)
    state = replace(start.state, picked=(0.5, 0.5), point=point, drawings=frozenset({Drawing.REFLECTIONS}))
    scene, none = start.scene, Reflections(point, start.state.camera.position, ReflectionStatus.FOUND, ())

    def search(*_arguments: object) -> Reflections:
        asked.append(True)
        return none

    monkeypatch.setattr(point_follower, "reflections_of", search)
    monkeypatch.setattr(point_follower, "PATIENCE", 60.0)
    follower = point_follower.PointFollower()
    assert follower.update(scene, state, (64, 48), at_rest=False) is None and follower.searching and not asked
    assert follower.update(scene, state, (64, 48), at_rest=True) is none and not follower.searching
    # It took less than is waited for.
    assert follower.update(scene, state, (65, 48), at_rest=False) is none and len(asked) == 2
    monkeypatch.setattr(point_follower, "PATIENCE", 0.0)
    assert follower.update(scene, state, (66, 48), at_rest=False) is None and len(asked) == 2


def test_hidden_ones_are_dashed_and_have_no_colour_and_numbers_tell_the_order() -> None:
    eye, point = (0.0, 0.0, 0.0), (0.0, 0.0, 4.0)
    seen = Reflection("mirror", ((0.0, 1.0, 2.0),), (5.0, 5.0), 4.5, 1, False)
    hidden = Reflection("mirror", ((1.0, 0.0, 2.0),), None, 5.5, -1, True)
    marks = reflection_marks(Reflections(point, eye, ReflectionStatus.FOUND, (seen, hidden)))
    grey = (marks.segments.colors == np.float32(HIDDEN_LEG)).all(axis=1)
    assert grey.sum() == 2 * DASHES and len(grey) == 2 + 2 * DASHES
    assert marks.segments.ends[:2].tolist() == [[[0, 0, 0], [0, 1, 2]], [[0, 1, 2], [0, 0, 4]]]
    dashes = marks.segments.ends[2:]
    # They lie on both legs, and cover half of them.
    lengths = np.linalg.norm(np.diff(dashes, axis=1), axis=2)
    assert lengths.sum() == pytest.approx(0.5 * 2.0 * np.hypot(1.0, 2.0), rel=1e-5)
    assert np.allclose(dashes[:DASHES, :, 0] * 2.0, dashes[:DASHES, :, 2], atol=1e-5)
    through = Reflection("lens/back", ((0.0, 1.0, 2.0), (0.0, 1.0, 3.0)), (5.0, 5.0), 4.5, 1, False)
    marks = reflection_marks(Reflections(point, eye, ReflectionStatus.FOUND, (through,)))
    assert marks.segments.ends.tolist() == [[[0, 0, 0], [0, 1, 2]], [[0, 1, 2], [0, 1, 3]], [[0, 1, 3], [0, 0, 4]]]
    camera = Camera((0.0, 0.5, -1.0), (0.0, 0.5, 3.0))
    found = (seen, hidden, replace(seen, order=0))
    numbers = numbers_of(Reflections(point, eye, ReflectionStatus.FOCUS, found), camera, (200.0, 100.0))
    assert [number.text for number in numbers] == ["1+", "(2\N{MINUS SIGN})", "3*"]
    behind = Camera((0.0, 0.5, 5.0), (0.0, 0.5, 9.0))
    assert numbers_of(Reflections(point, eye, ReflectionStatus.FOUND, (seen,)), behind, (200.0, 100.0)) == ()
    plain = np.full((100, 200, 3), 128, np.uint8)
    assert numbered(plain, ()) is plain
    drawn = numbered(plain, numbers)
    x, y = (round(value) for value in numbers[0].place)
    assert (drawn != plain).any(axis=2)[y : y + 17, x : x + 10].all() and (drawn != plain).any(axis=2).mean() < 0.1
