"""What pointer, wheel and fingers do.

Events are rendercanvas's. Fingers come in "touches": all those that are down, by any key, with their "x" and "y"; where
a backend tells of none or of one, its pointer speaks for it. What is held is forgotten as soon as an event shows that
it was let go of: the event that says so itself gets lost where a pointer leaves a window.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from enum import StrEnum
from functools import partial
from typing import Any

import numpy as np

from anamorph.scene.camera import Camera
from anamorph.viewer.navigation import look, magnify, orbit, pan, steer, zoom
from anamorph.viewer.starting import Start, reset_view
from anamorph.viewer.state import State, with_picked

GESTURES: tuple[tuple[str, str], ...] = (
    ("Drag", "orbit"),
    ("Right drag, Shift+drag", "pan"),
    ("Middle drag, Ctrl+drag", "look around"),
    ("Wheel", "zoom toward the pointer"),
    ("Alt+wheel", "field of view"),
    ("Click", "look into a pixel; again to drop it"),
    ("Double click", "reset the view"),
    ("Drag the divider", "compare the halves"),
    ("One finger", "orbit"),
    ("Two fingers", "pan and zoom"),
)
"""Every gesture and what it does, in the order of the help overlay."""

DIVIDER_REACH = 8.0
"""How far from the divider it is gripped, logical pixels."""

CLICK_REACH = 4.0
"""How far a pointer may stray between press and release of a click, logical pixels."""

DIVIDER_LIMITS = (0.02, 0.98)

ORBIT_TURN = np.pi
"""How far a drag over the image's height orbits, radians."""

WHEEL_STEP = 100.0
"""What a backend tells of one notch of a wheel."""

WHEEL_FACTOR = 1.1
"""How much larger one notch makes the image."""

TOUCHPAD_GAIN = 10.0
"""Browsers tell of pinching on a touchpad as of a wheel with the control key, in steps this much smaller."""

MOST_STEPS = 4.0
"""Of the wheel at once."""

MOST_SPREAD = 4.0
"""How much farther apart fingers can get at once."""

LEFT, RIGHT, MIDDLE = 1, 2, 3
"""Buttons."""

Size = tuple[float, float]
Point = tuple[float, float]
Event = Mapping[str, Any]


class Held(StrEnum):
    """What a pointer or fingers hold."""

    NOTHING = "nothing"
    DIVIDER = "divider"
    ORBIT = "orbit"
    PAN = "pan"
    LOOK = "look"
    PINCH = "pinch"


@dataclass(frozen=True)
class Grip:
    """What is held, from one event to the next.

    Parameters
    ----------
    held : Held
    button : int
        That holds it; 0 for fingers.
    start, last : (x, y)
        Where it began, and where it was last: logical pixels from the top left.
    dragged : bool
        Whether it has gone too far, or begun in such a way, as to be no click.
    touches : mapping of str to (x, y)
        Where the fingers were last.
    """

    held: Held = Held.NOTHING
    button: int = 0
    start: Point = (0.0, 0.0)
    last: Point = (0.0, 0.0)
    dragged: bool = False
    touches: Mapping[str, Point] = field(default_factory=dict)


NO_GRIP = Grip()


def handle(event: Event, grip: Grip, state: State, size: Size, home: Start) -> tuple[Grip, State]:
    """What follows from an event that is not the panel's.

    Parameters
    ----------
    event : mapping
    grip : Grip
        What is held before it; `NO_GRIP` at first.
    state : State
    size : (width, height)
        Of the canvas, logical pixels.
    home : Start

    Returns
    -------
    grip : Grip
    state : State
        The same object, where the event changes nothing.
    """
    match event.get("event_type"):
        case "pointer_down":
            return _down(event, grip, state, size)
        case "pointer_move":
            return _move(event, grip, state, size)
        case "pointer_up":
            return _up(event, grip, state, size)
        case "wheel":
            return grip, _wheel(event, state, size)
        case "double_click" if event.get("button", LEFT) == LEFT:
            return NO_GRIP, _double_click(event, state, size, home)
    return grip, state


def cursor(event: Event, state: State, size: Size, grip: Grip = NO_GRIP) -> str:
    """The name of the cursor to show at a pointer event."""
    over = grip.held is Held.NOTHING and "x" in event and _on_divider(_point(event), state, size)
    return "ew_resize" if over or grip.held is Held.DIVIDER else "default"


def counted_from(event: Event, left: float, top: float) -> Event:
    """A pointer event with its places, its touches' too, counted from a corner and not from the canvas's."""
    counted = {**event, "x": event["x"] - left, "y": event["y"] - top}
    if event.get("touches"):
        counted["touches"] = {
            name: {**touch, "x": touch["x"] - left, "y": touch["y"] - top} for name, touch in event["touches"].items()
        }
    return counted


def _down(event: Event, grip: Grip, state: State, size: Size) -> tuple[Grip, State]:
    touches, point = _touches(event), _point(event)
    if len(touches) > 1:
        return _pinch(touches), state
    buttons = event.get("buttons", ())
    if grip.held is not Held.NOTHING and grip.button in buttons and grip.button != event.get("button"):
        return grip, state
    button = event.get("button", LEFT)
    return Grip(_gripped(event, button, point, state, size), button, point, point, touches=touches), state


def _gripped(event: Event, button: int, point: Point, state: State, size: Size) -> Held:
    modifiers = event.get("modifiers", ())
    if button == RIGHT or (button == LEFT and "Shift" in modifiers):
        return Held.PAN
    if button == MIDDLE or (button == LEFT and "Control" in modifiers):
        return Held.LOOK
    if button != LEFT:
        return Held.NOTHING
    return Held.DIVIDER if _on_divider(point, state, size) else Held.ORBIT


def _move(event: Event, grip: Grip, state: State, size: Size) -> tuple[Grip, State]:
    touches, point = _touches(event), _point(event)
    if len(touches) > 1:
        if grip.held is not Held.PINCH or touches.keys() != grip.touches.keys():
            return _pinch(touches), state
        return _pinch(touches), steer(state, partial(_pinched, before=grip.touches, after=touches, size=size))
    if grip.held is Held.PINCH:
        # One finger is left of several: it goes on from where it is.
        held = Held.ORBIT if touches else Held.NOTHING
        return Grip(held, LEFT, point, point, dragged=True, touches=touches), state
    if grip.held is Held.NOTHING:
        return grip, state
    if grip.button not in event.get("buttons", ()) and not touches:
        return NO_GRIP, state
    if grip.held is Held.DIVIDER:
        return _divided(grip, state, point, size)
    if not grip.dragged and _apart(point, grip.start) <= CLICK_REACH:
        return grip, state
    moved = steer(state, partial(_dragged, held=grip.held, before=grip.last, after=point, size=size))
    return replace(grip, last=point, dragged=True), moved


def _up(event: Event, grip: Grip, state: State, size: Size) -> tuple[Grip, State]:
    if grip.held is Held.PINCH and len(_touches(event)) > 0:
        return _pinch(_touches(event)), state
    if event.get("button") != grip.button and grip.button in event.get("buttons", ()):
        return grip, state
    point = _point(event)
    plain = grip.held is Held.ORBIT and event.get("button", LEFT) == grip.button
    if plain and not grip.dragged and _apart(point, grip.start) <= CLICK_REACH:
        return NO_GRIP, _picked(state, point, size)
    return NO_GRIP, state


def _wheel(event: Event, state: State, size: Size) -> State:
    modifiers = event.get("modifiers", ())
    steps = -float(event.get("dy", 0.0)) / WHEEL_STEP * (TOUCHPAD_GAIN if "Control" in modifiers else 1.0)
    factor = WHEEL_FACTOR ** float(np.clip(steps, -MOST_STEPS, MOST_STEPS))
    if "Alt" in modifiers:
        return steer(state, lambda camera: magnify(camera, factor))
    return steer(state, lambda camera: zoom(camera, factor, _from_middle(_point(event), size)))


def _double_click(event: Event, state: State, size: Size, home: Start) -> State:
    if _on_divider(_point(event), state, size):
        return replace(state, divider=home.state.divider)
    return reset_view(state, home)


def _picked(state: State, point: Point, size: Size) -> State:
    width, height = _sides(size)
    # From outside, the eye's point is none of the image that is clicked into.
    here = state.picked if state.picked_outside is (state.observer is not None) else None
    if here is not None and _apart(point, (here[0] * width, here[1] * height)) <= CLICK_REACH:
        return with_picked(state, None)
    x, y = np.clip(np.divide(point, (width, height)), 0.0, 1.0).tolist()
    return with_picked(state, (x, y))


def _divided(grip: Grip, state: State, point: Point, size: Size) -> tuple[Grip, State]:
    """The divider brought along, without a jump: where it cannot follow, the pointer has to come back to it first."""
    width = _sides(size)[0]
    divider = float(np.clip(state.divider + (point[0] - grip.last[0]) / width, *DIVIDER_LIMITS))
    held = (grip.last[0] + (divider - state.divider) * width, point[1])
    return replace(grip, last=held, dragged=True), replace(state, divider=divider)


def _dragged(camera: Camera, held: Held, before: Point, after: Point, size: Size) -> Camera:
    right, up = np.subtract(_from_middle(after, size), _from_middle(before, size)).tolist()
    if held is Held.PAN:
        return pan(camera, right, up)
    if held is Held.LOOK:
        angle = float(np.radians(camera.field_of_view))
        return look(camera, -angle * right, -angle * up)
    return orbit(camera, -ORBIT_TURN * right, -ORBIT_TURN * up)


def _pinched(camera: Camera, before: Mapping[str, Point], after: Mapping[str, Point], size: Size) -> Camera:
    """Panned as the fingers' middle goes, then zoomed toward it as they spread."""
    first, second = (np.array([points[key] for key in sorted(before)]) for points in (before, after))
    start, end = (_from_middle(points.mean(axis=0), size) for points in (first, second))
    narrow, wide = (max(float(np.linalg.norm(points - points.mean(axis=0))), 1.0) for points in (first, second))
    factor = float(np.clip(wide / narrow, 1.0 / MOST_SPREAD, MOST_SPREAD))
    return zoom(pan(camera, *np.subtract(end, start).tolist()), factor, end)


def _pinch(touches: Mapping[str, Point]) -> Grip:
    return Grip(Held.PINCH, dragged=True, touches=touches)


def _on_divider(point: Point, state: State, size: Size) -> bool:
    return state.split and abs(point[0] - state.divider * size[0]) <= DIVIDER_REACH


def _from_middle(point: Sequence[float] | np.ndarray, size: Size) -> Point:
    """Right and up from the image's middle, as shares of its height."""
    width, height = _sides(size)
    return float(point[0] - width / 2.0) / height, float(height / 2.0 - point[1]) / height


def _sides(size: Size) -> Point:
    """A minimised window has none."""
    return max(size[0], 1.0), max(size[1], 1.0)


def _apart(first: Point, second: Point) -> float:
    return float(np.hypot(first[0] - second[0], first[1] - second[1]))


def _point(event: Event) -> Point:
    return float(event.get("x", 0.0)), float(event.get("y", 0.0))


def _touches(event: Event) -> dict[str, Point]:
    return {str(key): (float(touch["x"]), float(touch["y"])) for key, touch in event.get("touches", {}).items()}
