"""The viewer as a whole, on a canvas without a screen: what a hand does there, and what comes of it."""

from __future__ import annotations

import gc
import json
import os
import time
import weakref
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from itertools import count
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import wgpu
from PIL import Image
from viewer_hand import Hand

import anamorph as an
from anamorph.base.errors import AnamorphError
from anamorph.base.srgb import encode_srgb
from anamorph.frame import Frame, View
from anamorph.gallery import make
from anamorph.gpu.device import forget_device, get_device
from anamorph.methods import METHODS, Session, Specification
from anamorph.methods.options import option
from anamorph.viewer import application
from anamorph.viewer.application import SETTLING
from anamorph.viewer.marks import NO_MARKS, Marks
from anamorph.viewer.showing import Showing
from anamorph.viewer.space import PreparedScene
from anamorph.viewer.starting import start_of
from anamorph.viewer.state import Aspect, Drawing, EyeSide, Half, State


@pytest.fixture
def hand(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Hand]:
    monkeypatch.chdir(tmp_path)
    # A device of its own: what other tests have left in this process stays with theirs.
    forget_device()
    hand = Hand(start_of("flat-mirror"))
    yield hand
    hand.close()


def image_of(canvas: np.ndarray, hand: Hand) -> np.ndarray:
    """The image on the canvas, beside the panel and without what lies over its corners."""
    left, top = (round(place) for place in hand.place(0.0, 0.0))
    right, bottom = (round(place) for place in hand.place(1.0, 1.0))
    return canvas[top:bottom, left:right]


def alike(one: np.ndarray, other: np.ndarray) -> bool:
    """Whether two images are the same below captions and messages, but for what rounds to another 8-bit number."""
    return np.abs(one[80:].astype(int) - other[80:]).max() <= 1


def test_the_canvas_shows_what_render_draws(hand: Hand) -> None:
    shown = image_of(hand.settle(), hand)
    height, width = shown.shape[:2]
    wanted = encode_srgb(np.clip(an.render("flat-mirror", size=(width, height), samples=4).color, 0, 1).astype(float))
    inside = np.s_[40:, :]
    assert np.abs(shown[inside] / 255.0 - wanted[inside]).max() < 2.5 / 255.0


def test_a_drag_moves_the_eye_and_a_click_does_not(hand: Hand) -> None:
    before = image_of(hand.settle(), hand)
    camera = hand.viewer.state.camera
    hand.click(*hand.place(0.6, 0.6))
    assert hand.viewer.state.camera == camera
    hand.key("Escape")
    hand.drag(hand.place(0.6, 0.6), hand.place(0.7, 0.6), hand.place(0.75, 0.65))
    moved = hand.viewer.state.camera
    assert moved.target == camera.target and moved.position != camera.position
    after = image_of(hand.settle(), hand)
    assert (np.abs(after.astype(int) - before).max(axis=-1) > 20).mean() > 0.1
    hand.key("r")
    assert hand.viewer.state.camera == camera
    assert alike(image_of(hand.settle(), hand), before)


def test_clicks_that_come_all_at_once_are_all_taken_in(hand: Hand, monkeypatch: pytest.MonkeyPatch) -> None:
    hand.settle()
    asked: list[None] = []
    monkeypatch.setattr(hand.canvas, "request_draw", lambda: asked.append(None))
    for aspect in ("status", "error", "image", "status", "error"):
        x, y = hand.widget(f"first/aspect/{aspect}")
        for kind in ("pointer_move", "pointer_down", "pointer_up"):
            hand.canvas.submit_event({"event_type": kind, "x": x, "y": y, "button": 1, "buttons": (), "modifiers": ()})
    hand.canvas._process_events()
    frames = hand.viewer.frames
    while asked:
        asked.clear()
        hand.draw()
    assert hand.viewer.frames > frames + 10 and hand.viewer.state.first.aspect is Aspect.ERROR


def test_the_eye_goes_back_to_where_a_saved_view_has_it(hand: Hand, tmp_path: Path) -> None:
    hand.drag(hand.place(0.6, 0.6), hand.place(0.7, 0.6))
    hand.key("s", "Control")
    hand.settle(lambda snapshot: (tmp_path / "flat-mirror-1.toml").exists())
    saved = Hand(start_of(tmp_path / "flat-mirror-1.toml"), (560, 900))
    saved.drag(saved.place(0.5, 0.5), saved.place(0.6, 0.6))
    assert saved.viewer.state.camera != hand.viewer.state.camera
    saved.click(*saved.widget("eye/reset"))
    assert saved.viewer.state.camera == hand.viewer.state.camera
    saved.close()


def test_a_press_on_the_panel_is_the_panels_alone(hand: Hand) -> None:
    hand.settle()
    camera = hand.viewer.state.camera
    x, y = hand.widget("mirror/swivel")
    hand.drag((x, y), (x + 30.0, y), (x + 60.0, y + 40.0))
    assert hand.viewer.state.camera == camera and hand.viewer.state.picked is None
    assert hand.viewer.state.values["mirror/swivel"] > 1.0


def test_a_move_that_a_page_held_back_does_not_undo_the_press(hand: Hand) -> None:
    x, y = hand.place(0.6, 0.6)
    camera = hand.viewer.state.camera
    hand.send("pointer_down", x=x, y=y, button=1, buttons=(1,), time_stamp=2.0)
    hand.send("pointer_move", x=x - 50, y=y, button=0, time_stamp=1.9)
    hand.send("pointer_move", x=x + 40, y=y, button=1, buttons=(1,), time_stamp=2.1)
    assert hand.viewer.state.camera != camera


def test_a_page_that_takes_over_has_a_clock_of_its_own(hand: Hand, monkeypatch: pytest.MonkeyPatch) -> None:
    cursors: list[str] = []
    show(hand, split=True)
    monkeypatch.setattr(hand.canvas, "set_cursor", cursors.append)
    (x, y), divider = hand.place(0.8, 0.6), hand.place(0.5, 0.6)
    hand.send("pointer_down", x=x, y=y, button=1, buttons=(1,), time_stamp=3600.0)
    # What the page of another tab says first.
    hand.send("pointer_up", x=-1, y=-1, button=1, time_stamp=0.5)
    hand.send("pointer_move", x=divider[0], y=divider[1], button=0, time_stamp=0.6)
    assert cursors[-1] == "ew_resize"


def test_a_pointer_that_rests_on_a_slider_is_given_a_frame_that_explains_it() -> None:
    calls: list[tuple[float, Callable[[], None]]] = []
    hand = Hand(start_of("flat-mirror"), later=lambda seconds, call: calls.append((seconds, call)))
    before = hand.settle()
    calls.clear()
    hand.send("pointer_move", **dict(zip("xy", hand.place(0.5, 0.5), strict=True)), button=0)
    assert not calls, "the image has nothing to explain"
    x, y = hand.widget("mirror/swivel")
    hand.send("pointer_move", x=x, y=y, button=0)
    ((seconds, call),) = calls
    assert call == hand.viewer.refresh
    hand.draw(SETTLING)
    time.sleep(seconds)
    explained = np.abs(hand.draw(SETTLING).astype(int) - before).max(-1) > 24
    hand.close()
    assert explained.sum() > 1000


def test_a_slider_turns_the_mirror(hand: Hand) -> None:
    before = image_of(hand.settle(), hand)
    x, y = hand.widget("mirror/swivel")
    hand.drag((x, y), (x + 10.0, y))
    after = image_of(hand.settle(), hand)
    degrees = hand.viewer.state.values["mirror/swivel"]
    assert (np.abs(after.astype(int) - before).max(axis=-1) > 20).mean() > 0.05
    hand.send("pointer_move", x=5.0, y=295.0, button=0)
    hand.key("R", "Shift")
    assert not hand.viewer.state.values and degrees != 0.0
    assert alike(image_of(hand.settle(), hand), before)


def test_halves_are_compared_across_a_divider_that_is_dragged(hand: Hand) -> None:
    hand.settle()
    hand.key("s")
    assert hand.viewer.state.split
    hand.drag(hand.place(0.5, 0.3), hand.place(0.4, 0.3), hand.place(0.25, 0.3))
    assert hand.viewer.state.divider == pytest.approx(0.25, abs=0.02)
    shown = image_of(hand.settle(), hand)
    height, width = shown.shape[:2]
    for method, part in (("pervertex", np.s_[:, : width // 4 - 12]), ("raytrace", np.s_[:, width // 4 + 12 :])):
        wanted = an.render("flat-mirror", method, size=(width, height), samples=4).color
        assert alike(shown[part], np.rint(255.0 * encode_srgb(np.clip(wanted, 0, 1).astype(float)))[part])


def test_keys_show_layers_eyes_and_what_is_in_space(hand: Hand) -> None:
    plain = image_of(hand.settle(), hand)
    hand.key("2")
    assert hand.viewer.state.first.aspect is Aspect.ERROR
    error = image_of(hand.settle(), hand)
    assert (np.abs(error.astype(int) - plain).max(axis=-1) > 20).mean() > 0.3
    hand.key("1")
    hand.key("e")
    assert hand.viewer.state.eye is not EyeSide.MIDDLE
    assert not np.array_equal(image_of(hand.settle(), hand), plain)
    hand.key("r")
    hand.key("w")
    hand.key("h")
    assert {Drawing.WIREFRAME, Drawing.HITS} <= hand.viewer.state.drawings
    hand.key("o")
    assert hand.viewer.state.observer is not None
    hand.settle()


def test_a_click_tells_what_is_seen_there_and_draws_its_path(hand: Hand) -> None:
    plain = hand.settle()
    mirror = np.argwhere(an.render("flat-mirror", size=(284, 276), seen=True).specular != 0).mean(axis=0)
    hand.click(*hand.place(mirror[1] / 284, mirror[0] / 276))
    looked = hand.settle(lambda snapshot: snapshot["inspection"] and snapshot["at_rest"])
    seen = hand.viewer.snapshot()["inspection"]
    assert [stop["name"] for stop in seen["path"]][:2] == ["eye", "mirror"] and len(seen["path"]) >= 3
    assert seen["seen"] == seen["reference"] and seen["angular_mrad"] < 0.5
    assert not np.array_equal(looked, plain)
    # From outside, the path that the eye has looked into stays.
    hand.key("o")
    hand.settle()
    assert hand.viewer.snapshot()["inspection"] == seen
    # And it follows the mirror that it meets.
    hand.viewer.state = replace(hand.viewer.state, values={"mirror/swivel": 5.0})
    hand.viewer.refresh()
    hand.settle()
    path = hand.viewer.snapshot()["inspection"]["path"]
    assert path[0] == seen["path"][0] and path[-1] != seen["path"][-1]
    hand.key("o")
    hand.settle()
    hand.key("Escape")
    hand.settle()
    assert hand.viewer.snapshot()["inspection"] is None


def test_the_report_is_plain_data(hand: Hand) -> None:
    hand.settle()
    told = json.loads(json.dumps(hand.viewer.snapshot(), allow_nan=False))
    assert told["scene"] == "flat-mirror" and told["state"]["first"]["method"] == "auto"
    assert told["frames"] > 0 and "prepare" in told["phases_ms"] and "first/method" in told["rectangles"]


@pytest.mark.parametrize("size", [(300, 40), (200, 200), (276, 100), (640, 24), (1, 1)])
def test_no_canvas_is_too_small(size: tuple[int, int]) -> None:
    hand = Hand(start_of("flat-mirror"), size)
    hand.draw(5)
    hand.key("Tab")
    hand.draw(5)
    hand.close()


def test_a_fine_screen_gets_a_fine_image() -> None:
    hand = Hand(start_of("flat-mirror"), (400, 200), ratio=2.0)
    hand.settle()
    assert hand.viewer.snapshot()["image"] == ((400 - 276) * 2, (200 - 24) * 2)
    hand.close()


def test_a_scene_that_cannot_be_opened_leaves_the_viewer_open_with_the_reason() -> None:
    hand = Hand(start_of("no-such-scene"))
    hand.draw(5)
    told = hand.viewer.snapshot()
    assert "no-such-scene" in told["message"] and told["scene"] == "nothing opened"
    hand.drag(hand.place(0.3, 0.3), hand.place(0.5, 0.5))
    for key in ("s", "2", "o", "w", "p", "m"):
        hand.key(key)
    hand.draw(5)
    hand.viewer.open(start_of("flat-mirror"))
    hand.settle()
    assert hand.viewer.snapshot()["message"] == ""
    hand.close()


def test_a_method_that_cannot_draw_the_scene_is_refused_in_one_line() -> None:
    refused = start_of("magnifier", "environment")
    assert "glass" in refused.message and "\n" not in refused.message
    assert start_of("magnifier", "nonsense").message and not start_of("magnifier").message


def test_what_a_control_cannot_do_is_said_and_the_last_scene_stays(hand: Hand) -> None:
    hand.settle()
    hand.viewer.state = replace(hand.viewer.state, values={"mirror/curvature": 1e9})
    hand.viewer.refresh()
    hand.settle()
    assert hand.viewer.snapshot()["message"]
    hand.viewer.state = replace(hand.viewer.state, values={})
    hand.viewer.refresh()
    hand.settle()
    assert hand.viewer.snapshot()["message"] == ""


def test_the_image_is_saved_as_it_is_shown(hand: Hand, tmp_path: Path) -> None:
    hand.viewer.message = "of something before"
    hand.key("p")
    assert hand.viewer.snapshot()["message"] != "of something before"
    hand.settle(lambda snapshot: (tmp_path / "flat-mirror-1.png").exists())
    assert "flat-mirror-1.png" in hand.viewer.snapshot()["message"]
    saved = np.asarray(Image.open(tmp_path / "flat-mirror-1.png"))
    shown = image_of(hand.settle(), hand)
    assert alike(saved, shown)


def test_what_is_asked_for_while_something_is_saved_has_to_wait(hand: Hand, tmp_path: Path) -> None:
    # The image waits until it is refined.
    hand.viewer.state = replace(hand.viewer.state, samples=8)
    hand.key("p")
    hand.key("s", "Control")
    assert "wait" in hand.viewer.snapshot()["message"]
    hand.settle(lambda snapshot: (tmp_path / "flat-mirror-1.png").exists())
    assert [path.name for path in tmp_path.iterdir()] == ["flat-mirror-1.png"]


def test_the_view_is_saved_and_opens_as_it_was(hand: Hand, tmp_path: Path) -> None:
    x, y = hand.widget("mirror/tilt")
    hand.drag((x, y), (x + 5.0, y))
    hand.key("s")
    hand.key("s", "Control")
    hand.settle(lambda snapshot: (tmp_path / "flat-mirror-1.toml").exists())
    assert start_of(tmp_path / "flat-mirror-1.toml").state == hand.viewer.state


def test_a_lost_device_is_replaced(hand: Hand) -> None:
    before = image_of(hand.settle(), hand)
    lost = weakref.ref(get_device())
    get_device().destroy()
    hand.settle()
    assert "lost" in hand.viewer.snapshot()["message"]
    hand.click(*hand.widget("message/close"))
    assert alike(image_of(hand.settle(), hand), before)
    hand.key("s")
    hand.drag(hand.place(0.6, 0.6), hand.place(0.7, 0.6))
    hand.settle()
    # On a busy machine a thread that has finished may not have let go yet.
    for _ in range(100):
        gc.collect()
        if lost() is None:
            break
        time.sleep(0.05)
    assert lost() is None


def test_viewers_that_share_a_lost_device_all_go_on(hand: Hand) -> None:
    other = Hand(start_of("flat-mirror", "environment"))
    try:
        before = image_of(other.settle(), other)
        get_device().destroy()
        for each in (hand, other):
            each.settle()
            assert "lost" in each.viewer.snapshot()["message"]
        other.click(*other.widget("message/close"))
        assert alike(image_of(other.settle(), other), before)
    finally:
        other.close()


def toy(monkeypatch: pytest.MonkeyPatch, opened: Callable[[View, Any], Session]) -> None:
    """Register a method that is opened so."""
    monkeypatch.setitem(METHODS, "toy", replace(METHODS["pervertex"], name="toy", summary="A toy", open=opened))


def show(hand: Hand, **fields: Any) -> None:
    hand.viewer.state = replace(hand.viewer.state, **fields)
    hand.viewer.refresh()
    hand.settle()


def test_a_new_method_needs_no_change_to_the_viewer(monkeypatch: pytest.MonkeyPatch) -> None:
    @dataclass(frozen=True)
    class ToyOptions:
        """What a toy can be told.

        Parameters
        ----------
        grain : int
            How grainy it is.
        """

        grain: int = option(1, low=1, high=7)

    drawn = []

    def opened(view: View, options: ToyOptions) -> Session:
        drawn.append(options.grain)
        return METHODS["raytrace"].open(view, METHODS["raytrace"].options())

    method = replace(METHODS["raytrace"], name="toy", summary="A toy", options=ToyOptions, open=opened)
    monkeypatch.setitem(METHODS, "toy", method)
    hand = Hand(start_of("flat-mirror"), (380, 500))
    show(hand, samples=1)
    for key in ("first/method", "first/method/toy", "first/options"):
        hand.click(*hand.widget(key))
        hand.draw(3)
    assert str(hand.viewer.state.first.method) == "toy" and "first/grain" in hand.viewer.snapshot()["rectangles"]
    hand.click(*hand.widget("first/grain", 0.99))
    assert str(hand.viewer.state.first.method) == "toy:grain=7"
    assert set(drawn) == {1, 7}
    hand.send("pointer_move", x=5.0, y=495.0, button=0)
    shown = image_of(hand.settle(), hand)
    wanted = an.render("flat-mirror", "raytrace", size=shown.shape[1::-1]).color
    differs = np.abs(shown - 255.0 * encode_srgb(np.clip(wanted, 0, 1).astype(float)))[80:]
    assert differs.max() < 2.5, np.percentile(differs, [50, 99, 99.9, 100])
    hand.close()


def broken(view: View, options: Any) -> Session:
    raise ZeroDivisionError("a toy that breaks\nwherever it is drawn")


def too_large(view: View, options: Any) -> Session:
    get_device().create_texture(size=(1 << 20, 1, 1), format="rgba8unorm", usage=wgpu.TextureUsage.COPY_DST)
    raise AssertionError("the device has made it")


def unreadable(view: View, options: Any) -> Session:
    session = METHODS["pervertex"].open(view, METHODS["pervertex"].options())

    def frame(seen: bool = False) -> Frame:
        raise AnamorphError("toy: it cannot be read; give another")

    session.frame = frame  # type: ignore[method-assign]
    return session


@pytest.mark.parametrize(
    ("opened", "said"), [(broken, "ZeroDivisionError"), (too_large, "graphics device"), (unreadable, "cannot be read")]
)
def test_a_method_that_fails_is_told_of_and_the_rest_goes_on(
    hand: Hand, monkeypatch: pytest.MonkeyPatch, opened: Callable[[View, Any], Session], said: str
) -> None:
    before = image_of(hand.settle(), hand)
    toy(monkeypatch, opened)
    show(hand, first=Half(Specification.parse("toy"), Aspect.STATUS), split=True)
    told = hand.viewer.snapshot()["message"]
    assert said in told and "\n" not in told
    assert np.ptp(image_of(hand.draw(), hand)[100:, 160:].astype(int)) > 50
    show(hand, first=Half(Specification.parse("auto")), split=False)
    assert not hand.viewer.snapshot()["message"]
    assert alike(image_of(hand.draw(), hand), before)


def test_what_cannot_be_measured_is_told_of(hand: Hand, monkeypatch: pytest.MonkeyPatch) -> None:
    def refusing(reference: Frame, frame: Frame) -> None:
        raise AnamorphError("frame: it cannot be measured")

    hand.settle()
    monkeypatch.setattr("anamorph.viewer.showing.measure_half", refusing)
    show(hand, first=Half(Specification.parse("pervertex"), Aspect.ERROR))
    assert "cannot be measured" in hand.viewer.snapshot()["message"]


def test_what_is_in_space_follows_the_other_half(hand: Hand, monkeypatch: pytest.MonkeyPatch) -> None:
    show(
        hand,
        first=Half(Specification.parse("raytrace")),
        second=Half(Specification.parse("pervertex")),
        split=True,
        drawings=frozenset({Drawing.VOLUME}),
    )
    asked: list[State] = []

    def marking(space: PreparedScene, state: State, *others: Any) -> Marks:
        asked.append(state)
        return NO_MARKS

    monkeypatch.setattr("anamorph.viewer.application.space_marks", marking)
    show(hand, second=Half(Specification.parse("pervertex:align=false")))
    assert [str(each.second.method) for each in asked] == ["pervertex:align=false"]


def test_a_folder_that_is_gone_is_told_of(hand: Hand, tmp_path: Path) -> None:
    hand.settle()
    (tmp_path / "gone").mkdir()
    os.chdir(tmp_path / "gone")
    (tmp_path / "gone").rmdir()
    for key in (("p",), ("s", "Control")):
        hand.key(*key)
        hand.settle(lambda snapshot: snapshot["message"])
        assert "saving" in hand.viewer.snapshot()["message"] or "cannot be written" in hand.viewer.snapshot()["message"]
        hand.click(*hand.widget("message/close"))
    assert hand.viewer.snapshot()["progress"] is None


def test_from_outside_no_error_is_told_of_a_path_that_has_moved(hand: Hand) -> None:
    show(hand, picked=(0.5, 0.5))
    looked = hand.viewer.snapshot()["inspection"]
    assert looked["angular_mrad"] is not None
    hand.key("o")
    hand.settle()
    assert hand.viewer.snapshot()["inspection"] == looked
    show(hand, values={"mirror/swivel": 20.0})
    moved = hand.viewer.snapshot()["inspection"]
    assert moved["path"] != looked["path"] and moved["angular_mrad"] is None
    assert moved["reference"] == moved["path"][-1]["name"]


def test_every_builtin_scene_opens() -> None:
    for name in ("spheres", "spectacles-minus"):
        hand = Hand(start_of(name))
        hand.draw(2)
        assert hand.viewer.snapshot()["message"] == "" and make(name).name == hand.viewer.snapshot()["scene"]
        hand.close()


def test_keys_pointer_and_panel_answer_while_a_slow_image_is_drawn(monkeypatch: pytest.MonkeyPatch) -> None:
    showing = Showing()
    monkeypatch.setattr(application, "Showing", lambda: showing)
    hand = Hand(start_of("flat-mirror"))
    monkeypatch.setattr("anamorph.viewer.showing.FRAME", 0.0)
    monkeypatch.setattr("anamorph.methods.tracing.paths.GRAIN", 64)
    monkeypatch.setattr("anamorph.base.compiled.cores", lambda: 1)
    viewer = hand.viewer
    hand.settle()
    viewer.state = replace(viewer.state, first=Half(Specification.parse("raytrace")), resolution=1.0)
    before = hand.draw()
    assert showing.moving
    hand.key("F1")
    assert viewer.state.help and showing.moving
    hand.key("F1")
    hand.drag(hand.place(0.5, 0.5), hand.place(0.6, 0.5))
    assert showing.moving and viewer.state.camera != viewer.start.state.camera
    left = hand.viewer.snapshot()["covered"][0][2]
    assert np.array_equal(hand.draw()[:, int(left) + 1 :], before[:, int(left) + 1 :]), "the last finished image"
    while showing.moving:
        hand.draw()
    assert not np.array_equal(hand.draw()[:, int(left) + 1 :], before[:, int(left) + 1 :])
    hand.close()


def test_a_page_that_takes_long_to_show_images_is_sent_fewer(hand: Hand, monkeypatch: pytest.MonkeyPatch) -> None:
    def frames_to_rest(seconds_between: float) -> int:
        now = count(0.0, 0.001)
        late = [0.0]
        monkeypatch.setattr(application, "perf_counter", lambda: next(now) + late[0])
        hand.key("Right")
        before = hand.viewer.frames
        while not hand.viewer.snapshot()["at_rest"]:
            late[0] += seconds_between
            hand.draw()
        assert hand.viewer.snapshot()["samples_done"] == 16
        return hand.viewer.frames - before

    prompt, slow = frames_to_rest(0.0), frames_to_rest(2.0)
    assert prompt > 16 and slow < 8
