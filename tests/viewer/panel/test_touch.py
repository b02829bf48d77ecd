"""Fingers on the panel: they scroll it, press what they tap, and drag what is there to be dragged."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import count

import pytest
from viewer_hand import Hand

from anamorph.viewer import application, canvas
from anamorph.viewer.panel.panel import draw_panel
from anamorph.viewer.starting import start_of

Point = tuple[float, float]


@pytest.fixture
def hand() -> Iterator[Hand]:
    hand = Hand(start_of("flat-mirror", "environment"), size=(560, 300))
    yield hand
    hand.close()


def slide(hand: Hand, place: Point, up: float, right: float = 0.0, finger: bool = True) -> None:
    """Come down at a place, go up and right in small steps, and be lifted; the mouse does it, or a finger."""

    def touch(kind: str, share: float) -> None:
        now = {"x": place[0] + share * right, "y": place[1] - share * up}
        lifted = kind == "pointer_up"
        touches = {"1": {**now, "pressure": 1.0}} if finger and not lifted else {}
        hand.send(kind, **now, button=1, buttons=() if lifted else (1,), touches=touches, ntouches=len(touches))

    touch("pointer_down", 0.0)
    hand.draw(2)
    for share in (0.2, 0.4, 0.6, 0.8, 1.0) if up or right else ():
        touch("pointer_move", share)
    hand.draw(2)
    touch("pointer_up", 1.0)
    hand.draw(3)


def top(hand: Hand, key: str = "section/scene") -> float:
    """Where a widget of the panel stands, logical pixels from the top."""
    return hand.viewer.snapshot()["rectangles"][key][1]


@pytest.mark.parametrize("key", ["section/scene", "first/method", "first/options", "first/aspect/error", "split"])
def test_a_finger_scrolls_the_panel_and_presses_nothing_that_it_came_down_on(hand, key):
    before, state = top(hand), hand.viewer.state
    widgets = hand.viewer.snapshot()["rectangles"].keys()
    slide(hand, hand.widget(key, 0.7), 100.0)
    assert before - 100.0 <= top(hand) <= before - 80.0
    assert hand.viewer.state == state
    assert hand.viewer.snapshot()["rectangles"].keys() == widgets, "nothing has been folded or opened"
    slide(hand, (265.0, 150.0), -200.0)
    assert top(hand) == before


def test_a_mouse_does_not_scroll_it(hand):
    before = top(hand)
    slide(hand, hand.widget("section/scene"), 100.0, finger=False)
    assert top(hand) == before


def test_a_finger_that_came_down_beside_the_panel_does_not_scroll_it(hand):
    before = top(hand)
    slide(hand, (400.0, 150.0), 100.0)
    slide(hand, (200.0, 285.0), 100.0)
    assert top(hand) == before


def test_a_finger_drags_a_slider_and_the_bar_of_the_scroll(hand):
    before = top(hand)
    slide(hand, hand.widget("mirror/swivel"), 60.0, right=50.0)
    assert top(hand) == before
    assert hand.viewer.state.values["mirror/swivel"] > 0.0
    slide(hand, (270.0, 60.0), -60.0)
    assert top(hand) < before - 100.0


def test_a_finger_on_an_open_list_leaves_the_panel_where_it_is(hand):
    before = top(hand)
    slide(hand, hand.widget("first/method"), 0.0)
    assert "first/method/raytrace" in hand.viewer.snapshot()["rectangles"]
    slide(hand, hand.widget("first/method/raytrace"), 40.0)
    assert top(hand) == before


def test_a_tap_presses(hand):
    slide(hand, hand.widget("split", 0.9), 0.0)
    assert hand.viewer.state.split
    slide(hand, hand.widget("split", 0.05), 0.0)
    assert not hand.viewer.state.split
    slide(hand, hand.widget("section/scene"), 0.0)
    assert "mirror/swivel" not in hand.viewer.snapshot()["rectangles"]


@pytest.fixture
def clock(monkeypatch):
    """Time goes on by a sixtieth of a second a frame, however long the frame takes."""
    monkeypatch.setattr(canvas, "perf_counter", count(0.0, 1.0 / 60.0).__next__)


@pytest.fixture
def panels(monkeypatch):
    """What has been drawn of the panel."""
    drawn = []
    monkeypatch.setattr(application, "draw_panel", lambda *shown: drawn.append(draw_panel(*shown)) or drawn[-1])
    return drawn


def test_a_double_tap_on_a_slider_opens_it_for_typing(clock, panels, hand):
    place = hand.widget("mirror/tilt", 0.5)
    slide(hand, place, 0.0)
    assert not panels[-1].typing
    slide(hand, place, 0.0)
    assert panels[-1].typing
    hand.type("3.5")
    hand.key("Enter")
    hand.draw(3)
    assert hand.viewer.state.values["mirror/tilt"] == 3.5


def test_a_double_click_of_the_mouse_does_not(clock, panels, hand):
    for _ in range(2):
        slide(hand, hand.widget("mirror/tilt", 0.5), 0.0, finger=False)
    assert not panels[-1].typing
