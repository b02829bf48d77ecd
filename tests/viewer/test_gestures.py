"""What gestures do to the state: each by its law, and all of them in any order."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from rendercanvas import CursorShape
from scenes import CAMERA, scene_with, spherical_mirror
from viewer_hand import home_of

from anamorph.methods import Specification
from anamorph.scene.camera import Camera
from anamorph.viewer.gestures import DIVIDER_LIMITS, GESTURES, NO_GRIP, Held, cursor, handle
from anamorph.viewer.navigation import FARTHEST, NARROWEST, NEAREST, OUTERMOST, WIDEST
from anamorph.viewer.state import Half, State

SIZE = (800, 600)
STATE = State(CAMERA, Half(Specification.parse("pervertex")), Half(Specification.parse("raytrace")))
HOME = home_of(STATE, scene_with(spherical_mirror()))
LEFT, RIGHT, MIDDLE = 1, 2, 3


def pointer(kind, x, y, button=LEFT, buttons=None, modifiers=(), touches=()):
    """An event as backends make it; `touches` are ids with their points."""
    pressed = (() if kind == "up" else (button,)) if buttons is None else buttons
    fingers = {key: {"x": place[0], "y": place[1], "pressure": 1.0} for key, place in dict(touches).items()}
    return {
        "event_type": f"pointer_{kind}", "x": x, "y": y, "button": button, "buttons": pressed,
        "modifiers": modifiers, "ntouches": len(fingers), "touches": fingers,
    }  # fmt: skip


def wheel(dy, x=400.0, y=300.0, modifiers=()):
    return {"event_type": "wheel", "x": x, "y": y, "dx": 0.0, "dy": dy, "buttons": (), "modifiers": modifiers}


def played(events, state=STATE, grip=NO_GRIP):
    for event in events:
        grip, state = handle(event, grip, state, SIZE, HOME)
    return grip, state


def drag(start, *ends, button=LEFT, modifiers=()):
    down = pointer("down", *start, button, modifiers=modifiers)
    moves = [pointer("move", *end, button, modifiers=modifiers) for end in ends]
    return [down, *moves, pointer("up", *ends[-1], button, modifiers=modifiers)]


def at_target(camera, x, y):
    """The world point under a point of the canvas, at the target's distance."""
    ray = camera.directions(np.array([x, y]), SIZE)
    forward = camera.axes()[2]
    return camera.position + ray * (np.subtract(camera.target, camera.position) @ forward) / (ray @ forward)


def shown(camera, point):
    x, y, w = camera.image(np.array([point]), SIZE)[0]
    return x / w, y / w


def distance(camera):
    return float(np.linalg.norm(np.subtract(camera.position, camera.target)))


def test_a_drag_orbits_with_the_pointer_and_back():
    grip, state = played(drag((400, 300), (500, 300)))
    assert grip == NO_GRIP and state.picked is None
    assert state.camera.target == CAMERA.target and distance(state.camera) == pytest.approx(distance(CAMERA))
    front = np.array(CAMERA.target) - 0.1 * CAMERA.axes()[2]
    assert shown(state.camera, front)[0] > shown(CAMERA, front)[0] + 1.0, "what is in front goes with the pointer"
    _, lower = played(drag((400, 300), (400, 350)))
    assert shown(lower.camera, front)[1] > shown(CAMERA, front)[1] + 1.0
    _, back = played(drag((400, 300), (460, 340), (520, 310), (400, 300)))
    assert back.camera.position == pytest.approx(CAMERA.position, abs=1e-9)


@pytest.mark.parametrize("way", [{"button": RIGHT}, {"modifiers": ("Shift",)}])
def test_what_is_panned_stays_under_the_pointer(way):
    _, state = played(drag((300, 200), (310, 220), (420, 330), **way))
    assert shown(state.camera, at_target(CAMERA, 300, 200)) == pytest.approx((420, 330), abs=1e-6)
    assert state.camera.axes() == pytest.approx(CAMERA.axes())


@pytest.mark.parametrize("way", [{"button": MIDDLE}, {"modifiers": ("Control",)}])
def test_looking_around_keeps_the_eye_and_brings_the_scene_along(way):
    _, state = played(drag((400, 300), (430, 320), **way))
    assert state.camera.position == CAMERA.position
    assert shown(state.camera, CAMERA.target) == pytest.approx((430, 320), abs=2.0)


def test_the_wheel_zooms_toward_the_pointer():
    _, state = played([wheel(-100.0, 200, 150)])
    assert distance(state.camera) == pytest.approx(distance(CAMERA) / 1.1)
    assert shown(state.camera, at_target(CAMERA, 200, 150)) == pytest.approx((200, 150), abs=1e-6)
    _, back = played([wheel(100.0, 200, 150)], state)
    assert back.camera.position == pytest.approx(CAMERA.position)


def test_the_wheel_with_alt_changes_the_field_of_view_alone():
    _, state = played([wheel(-100.0, 200, 150, ("Alt",))])
    assert replace(state.camera, field_of_view=CAMERA.field_of_view) == CAMERA
    half, before = (np.tan(np.radians(each.field_of_view) / 2) for each in (state.camera, CAMERA))
    assert half == pytest.approx(before / 1.1)


def test_pinching_on_a_touchpad_zooms_and_no_event_zooms_far():
    _, state = played([wheel(-10.0, modifiers=("Control",))])
    assert distance(state.camera) == pytest.approx(distance(CAMERA) / 1.1)
    _, state = played([wheel(-1e9)])
    assert distance(state.camera) == pytest.approx(distance(CAMERA) / 1.1**4)


def test_two_fingers_keep_what_is_under_them():
    places = [{4: (300, 200), 9: (500, 400)}, {4: (310, 190), 9: (505, 430)}, {4: (250, 100), 9: (610, 460)}]
    down = [pointer("down", 300, 200, touches={4: (300, 200)}), pointer("down", 500, 400, touches=places[0])]
    grip, state = played([*down, *(pointer("move", 0, 0, touches=each) for each in places)])
    assert grip.held is Held.PINCH
    # Equal spreads of both, without a turn: translation and scale alone.
    assert shown(state.camera, at_target(CAMERA, 300, 200)) == pytest.approx((250, 100), abs=1e-5)
    assert shown(state.camera, at_target(CAMERA, 500, 400)) == pytest.approx((610, 460), abs=1e-5)
    assert state.camera.axes() == pytest.approx(CAMERA.axes())


def test_a_finger_that_joins_or_leaves_makes_no_jump():
    one, two = {1: (300, 200)}, {1: (300, 200), 2: (700, 500)}
    events = [
        pointer("down", 300, 200, touches=one),
        pointer("down", 700, 500, touches=two),
        pointer("move", 700, 500, touches=two),
        pointer("up", 300, 200, touches=two),
        pointer("move", 700, 500, touches={2: (700, 500)}),
    ]
    grip, state = played(events)
    assert state.camera == CAMERA and grip.held is Held.ORBIT
    _, turned = played([pointer("move", 650, 500, touches={2: (650, 500)})], state, grip)
    assert turned.camera != CAMERA and turned.camera.target == CAMERA.target
    end, after = played([pointer("up", 700, 500, touches={2: (700, 500)})], state, grip)
    assert end == NO_GRIP and after.picked is None


def test_one_finger_orbits_and_taps_pick():
    touches = {0: (400, 300)}
    events = [
        pointer("down", 400, 300, touches=touches),
        pointer("move", 500, 300, touches={0: (500, 300)}),
        pointer("up", 500, 300, touches={}),
    ]
    assert played(events) == played(drag((400, 300), (500, 300)))
    _, state = played([pointer("down", 400, 300, touches=touches), pointer("up", 401, 300, touches=touches)])
    assert state.picked == pytest.approx((401 / 800, 0.5))


def test_a_click_picks_its_pixel_and_again_drops_it():
    _, state = played(drag((200, 150), (202, 151)))
    assert state.picked == pytest.approx((202 / 800, 151 / 600)) and state.camera == CAMERA
    _, other = played(drag((300, 150), (300, 150)), state)
    assert other.picked == pytest.approx((300 / 800, 0.25))
    _, dropped = played(drag((300, 153), (300, 153)), other)
    assert dropped.picked is None


@pytest.mark.parametrize("way", [{"button": RIGHT}, {"button": MIDDLE}, {"button": 4}, {"modifiers": ("Shift",)}])
def test_nothing_but_a_plain_click_picks(way):
    assert played(drag((200, 150), (201, 150), **way)) == (NO_GRIP, STATE)


def test_a_drag_that_comes_back_is_no_click():
    _, state = played(drag((200, 150), (260, 150), (200, 150)))
    assert state.picked is None


def test_the_divider_is_gripped_near_it_and_follows_within_limits():
    split = replace(STATE, split=True, divider=0.5)
    for start, ends, place in [(392, [192], 0.25), (408, [999, 608], 0.75), (400, [-900], 0.02), (400, [5000], 0.98)]:
        grip, state = played(drag((start, 300), *((x, 40) for x in ends)), split)
        assert (grip, state) == (NO_GRIP, replace(split, divider=pytest.approx(place)))
    assert played(drag((395, 300), (395, 300)), split) == (NO_GRIP, split), "a click there picks nothing"
    for state in (replace(split, split=False), split):
        _, moved = played(drag((409, 300), (300, 300)), state)
        assert moved.camera != CAMERA and moved.divider == 0.5


def test_the_cursor_tells_of_the_divider():
    split = replace(STATE, split=True, divider=0.25)
    over, beside = pointer("move", 207, 10, buttons=()), pointer("move", 209, 10, buttons=())
    assert [cursor(each, split, SIZE) for each in (over, beside)] == ["ew_resize", "default"]
    assert cursor(over, STATE, SIZE) == cursor({"event_type": "pointer_leave"}, split, SIZE) == "default"
    held, _ = played([pointer("down", 200, 10)], split)
    assert cursor(beside, split, SIZE, held) == "ew_resize"
    orbiting, _ = played([pointer("down", 300, 10)], split)
    assert cursor(over, split, SIZE, orbiting) == "default"
    assert {"ew_resize", "default"} <= set(CursorShape.__fields__)


def test_a_double_click_resets_the_view_or_the_divider():
    _, moved = played([*drag((400, 300), (500, 200)), wheel(-300.0)], replace(STATE, split=True, divider=0.3))
    assert moved.camera != CAMERA
    event = {"event_type": "double_click", "x": 500, "y": 300, "button": LEFT, "buttons": (), "modifiers": ()}
    _, reset = played([event], moved)
    assert reset == replace(moved, camera=CAMERA)
    _, centred = played([{**event, "x": 240}], moved)
    assert centred == replace(moved, divider=0.5)
    assert played([{**event, "button": RIGHT}], moved)[1] is moved


def test_from_outside_the_observer_is_steered_and_the_eye_stays():
    outside = replace(STATE, observer=Camera((3.0, 2.0, 3.0), (0.0, 0.5, 0.5)))
    for events in (drag((400, 300), (500, 200)), drag((400, 300), (500, 200), button=RIGHT), [wheel(-100.0)]):
        _, state = played(events, outside)
        assert state.camera == CAMERA and state.observer != outside.observer


@pytest.mark.parametrize("lost", [pointer("move", 600, 300, buttons=()), pointer("down", 600, 300)])
def test_a_release_that_got_lost_leaves_no_grip(lost):
    grip, state = played([pointer("down", 400, 300), pointer("move", 500, 300)])
    grip, after = played([{"event_type": "pointer_leave"}, lost], state, grip)
    assert after == state and grip.held is (Held.NOTHING if lost["event_type"] == "pointer_move" else Held.ORBIT)
    assert not grip.dragged


def test_another_button_does_not_take_a_drag_over_nor_end_it():
    events = [
        pointer("down", 400, 300),
        pointer("move", 450, 300),
        pointer("down", 450, 300, RIGHT, buttons=(LEFT, RIGHT)),
        pointer("move", 500, 300, 0, buttons=(LEFT, RIGHT)),
        pointer("up", 500, 300, RIGHT, buttons=(LEFT,)),
        pointer("move", 550, 300, 0, buttons=(LEFT,)),
        pointer("up", 550, 300),
    ]
    grip, state = played(events)
    assert grip == NO_GRIP
    assert state.camera.position == pytest.approx(played(drag((400, 300), (550, 300)))[1].camera.position)


places = st.one_of(st.sampled_from([0.0, 400.0, 799.0, -1e5, 1e7]), st.floats(-100.0, 900.0))
points = st.tuples(places, places)
buttons = st.integers(0, 5)
modifiers = st.sets(st.sampled_from(["Shift", "Control", "Alt", "Meta"])).map(tuple)
events = st.one_of(
    st.builds(
        pointer,
        st.sampled_from(["down", "move", "up"]),
        places,
        places,
        buttons,
        st.sets(buttons).map(tuple),
        modifiers,
        st.dictionaries(st.one_of(st.integers(0, 3), st.sampled_from("0123")), points, max_size=4),
    ),
    st.builds(wheel, st.one_of(st.sampled_from([0.0, -1e9, 1e9]), st.floats(-500.0, 500.0)), places, places, modifiers),
    st.builds(lambda x, button: {"event_type": "double_click", "x": x, "y": 5.0, "button": button}, places, buttons),
    st.sampled_from([{"event_type": kind} for kind in ("pointer_leave", "pointer_enter", "resize", "close")]),
    st.just({"event_type": "key_down", "key": "a", "modifiers": ()}),
)  # fmt: skip


@settings(max_examples=150)
@given(st.lists(events, max_size=40), st.booleans(), st.booleans(), st.sampled_from([SIZE, (1, 1), (0, 0), (5000, 20)]))
def test_no_order_of_events_breaks_anything(sequence, split, outside, size):
    grip = NO_GRIP
    state = replace(STATE, split=split, observer=Camera((3.0, 2.0, 3.0), (0.0, 0.5, 0.5)) if outside else None)
    for event in sequence:
        grip, state = handle(event, grip, state, size, HOME)
        assert cursor(event, state, size, grip) in ("default", "ew_resize")
        for camera in filter(None, (state.camera, state.observer)):
            assert np.isfinite(camera.axes()).all() and np.abs(camera.target).max() <= OUTERMOST
            assert 0.99 * NEAREST <= distance(camera) <= 1.01 * FARTHEST
            assert NARROWEST <= camera.field_of_view <= WIDEST
        assert DIVIDER_LIMITS[0] <= state.divider <= DIVIDER_LIMITS[1]
        assert state.picked is None or all(0.0 <= share <= 1.0 for share in state.picked)
        assert state.values == {} and (state.observer is not None) is outside
    released = pointer("move", 300, 200, buttons=())
    grip, after = handle(released, grip, state, size, HOME)
    assert grip.held is Held.NOTHING and after is state


def test_every_gesture_is_told():
    assert all(name and effect for name, effect in GESTURES)
    assert len({name for name, _ in GESTURES}) == len(GESTURES)
