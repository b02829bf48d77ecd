"""A viewer at which nobody looks, or that is told more than it can show."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

import pytest
from imgui_bundle import imgui
from PIL import Image
from viewer_hand import Hand

from anamorph.viewer.application import REST_DELAY, UNSEEN
from anamorph.viewer.canvas import MOST_EVENTS
from anamorph.viewer.starting import start_of


class Clock:
    """Keeps what an event loop would have to call."""

    def __init__(self) -> None:
        self.due: list[tuple[float, Callable[[], None]]] = []

    def later(self, seconds: float, call: Callable[[], None]) -> None:
        self.due.append((seconds, call))

    def tick(self) -> None:
        """Call all that is due."""
        due, self.due = self.due, []
        for _, call in due:
            call()

    def run_out(self) -> None:
        """Go on until nothing is left to be called."""
        for _ in range(10_000):
            if not self.due:
                return
            self.tick()
        raise AssertionError("there is no end to it")


@pytest.fixture
def clock() -> Clock:
    return Clock()


@pytest.fixture
def hand(clock: Clock, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Hand]:
    monkeypatch.chdir(tmp_path)
    hand = Hand(start_of("flat-mirror", "environment"), size=(480, 240), later=clock.later)
    yield hand
    hand.close()


def test_what_is_being_saved_goes_on_while_nothing_is_drawn_and_then_all_is_quiet(hand, clock, tmp_path):
    hand.key("p")
    frames = hand.viewer.frames
    assert hand.viewer.snapshot()["progress"] is not None
    saved = tmp_path / "flat-mirror-1.png"
    clock.run_out()
    with Image.open(saved) as image:
        assert image.size == tuple(hand.viewer.snapshot()["full"])
    assert hand.viewer.frames == frames
    snapshot = hand.viewer.snapshot()
    assert (snapshot["progress"], snapshot["message"]) == (None, "saved flat-mirror-1.png")


def test_while_images_are_drawn_they_alone_take_the_steps(hand, clock):
    hand.key("p")
    time.sleep(REST_DELAY)
    for _ in range(3):
        hand.draw()
        done = hand.viewer.snapshot()["samples_done"]
        clock.tick()
        assert hand.viewer.snapshot()["samples_done"] == done
        assert [seconds for seconds, _ in clock.due] == [UNSEEN]


def test_what_is_stopped_or_closed_does_not_go_on_unseen(hand, clock, tmp_path):
    hand.key("p")
    hand.viewer.close()
    clock.run_out()
    assert list(tmp_path.iterdir()) == []


def test_imgui_keeps_no_more_events_than_it_can_show_and_then_holds_nothing(hand):
    hand.send("key_down", key="Shift")
    hand.send("pointer_down", x=300.0, y=100.0, button=1, buttons=(1,))
    hand.draw(3)
    assert imgui.get_io().key_shift and imgui.get_io().mouse_down[0]
    for count in range(MOST_EVENTS):
        for kind in ("key_down", "key_up"):
            event = {"event_type": kind, "key": "abcdefgh"[count % 8], "modifiers": ()}
            hand.canvas.submit_event(event)
    hand.canvas._process_events()
    assert imgui.get_current_context().input_events_queue.size() <= MOST_EVENTS + 1
    hand.draw(3)
    assert not imgui.get_io().key_shift and not imgui.get_io().mouse_down[0]


@pytest.mark.parametrize("key", ["AltGraph", "Dead", "F13", "MediaPlayPause", "\u0130", ""])
def test_keys_that_mean_nothing_here_are_let_pass_without_a_word(hand, caplog, key):
    hand.key(key)
    assert caplog.records == []


def test_a_cursor_is_set_only_when_it_is_another(hand, monkeypatch):
    hand.viewer.state = replace(hand.viewer.state, split=True, second=hand.viewer.state.first)
    told: list[str] = []
    monkeypatch.setattr(hand.canvas, "set_cursor", told.append)
    x, y = hand.place(0.5, 0.5)
    for right in (-60.0, -50.0, 0.0, 1.0, 2.0, 50.0, 60.0):
        hand.send("pointer_move", x=x + right, y=y, button=0)
    assert told == ["ew_resize", "default"]
