"""What the keys do."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np

from anamorph.methods.specification import Specification
from anamorph.viewer.facts import Request
from anamorph.viewer.navigation import orbit, steer, zoom
from anamorph.viewer.observer import first_observer
from anamorph.viewer.remembered import remember
from anamorph.viewer.starting import Start, reset_view
from anamorph.viewer.state import Aspect, Drawing, EyeSide, Half, State, with_observer, with_picked

TURN = float(np.radians(5.0))
"""How far an arrow key goes around the target, radians."""

NEARER = 1.1
"""How much larger a key makes the image."""


@dataclass(frozen=True)
class Shortcut:
    """What a key does.

    Parameters
    ----------
    keys : tuple of str
        Any of these, as a user reads them: "S", "Shift+M", "Ctrl+S", "Left", "?".
    group : str
        The heading under which help lists it.
    summary : str
    change : callable, optional
        (State, Start) -> State.
    request : Request, optional
        What it asks for instead.
    """

    keys: tuple[str, ...]
    group: str
    summary: str
    change: Callable[[State, Start], State] | None = None
    request: Request | None = None


def press(event: Mapping[str, Any], state: State, home: Start) -> tuple[State, tuple[Request, ...]]:
    """What follows when a key goes down.

    Parameters
    ----------
    event : mapping
        A key_down event: its "key" and its "modifiers".
    state : State
    home : Start

    Returns
    -------
    state : State
        The same object, where the key does nothing to it.
    requests : tuple of Request
    """
    shortcut = _BY_KEY.get(_chord(event))
    if shortcut is None:
        return state, ()
    changed = state if shortcut.change is None else shortcut.change(state, home)
    return changed, () if shortcut.request is None else (shortcut.request,)


def _chord(event: Mapping[str, Any]) -> str:
    """A key with its modifiers, as shortcuts are written."""
    key, modifiers = str(event.get("key", "")), event.get("modifiers", ())
    if "Shift" in modifiers:
        # A window tells which key is pressed, a page which character comes of it.
        key = {"/": "?", "=": "+"}.get(key, key)
    key = key.removeprefix("Arrow")
    # Caps lock makes capitals without shift; other characters already tell that shift made them.
    letter = len(key) == 1 and key.isalpha()
    shift = "Shift" in modifiers and (letter or len(key) > 1)
    control = "Control" in modifiers or "Meta" in modifiers
    held = [("Ctrl", control), ("Alt", "Alt" in modifiers), ("Shift", shift)]
    return "+".join([name for name, down in held if down] + [key.upper() if letter else key])


def _next_method(state: State, home: Start, half: str) -> State:
    shown: Half = getattr(state, half)
    names, name = home.methods, shown.method.method.name
    following = names[(names.index(name) + 1) % len(names)] if name in names else names[0]
    return _with_half(state, half, replace(shown, method=Specification.parse(following)))


def _set_aspect(state: State, home: Start, half: str, aspect: Aspect) -> State:
    return _with_half(state, half, replace(getattr(state, half), aspect=aspect))


def _with_half(state: State, half: str, shown: Half) -> State:
    """What is set of the second half is also seen."""
    return replace(state, first=shown) if half == "first" else replace(state, second=shown, split=True)


def _swap(state: State, home: Start) -> State:
    return replace(state, first=state.second, second=state.first)


def _toggle(state: State, home: Start, flag: str) -> State:
    flipped: dict[str, Any] = {flag: not getattr(state, flag)}
    return replace(state, **flipped)


def _toggle_drawing(state: State, home: Start, drawing: Drawing) -> State:
    return replace(state, drawings=state.drawings ^ {drawing})


def _other_unit(state: State, home: Start) -> State:
    return replace(state, unit="px" if state.unit == "mrad" else "mrad")


def _next_eye(state: State, home: Start) -> State:
    sides = list(EyeSide)
    return replace(state, eye=sides[(sides.index(state.eye) + 1) % len(sides)])


def _toggle_observer(state: State, home: Start) -> State:
    return with_observer(state, first_observer(home.scene, state.camera) if state.observer is None else None)


def _orbit(state: State, home: Start, right: float, up: float) -> State:
    return steer(state, lambda camera: orbit(camera, right, up))


def _zoom(state: State, home: Start, factor: float) -> State:
    return steer(state, lambda camera: zoom(camera, factor))


def _toggle_opening(state: State, home: Start) -> State:
    if state.panel and state.opening is not None:
        return replace(state, opening=None)
    return replace(state, panel=True, opening=state.opening or "")


def _clear(state: State, home: Start) -> State:
    """What lies on top first: it hides the rest."""
    if state.help:
        return replace(state, help=False)
    return with_picked(state, None) if state.opening is None else replace(state, opening=None)


def _reset(state: State, home: Start) -> State:
    return replace(home.state, panel=state.panel)


SHORTCUTS: tuple[Shortcut, ...] = (
    Shortcut(("F1", "?"), "Viewer", "this help", partial(_toggle, flag="help")),
    Shortcut(("Tab",), "Viewer", "the panel", partial(_toggle, flag="panel")),
    Shortcut(("Escape",), "Viewer", "close the help; drop the picked point", _clear),
    Shortcut(("Ctrl+O",), "Viewer", "open another scene", _toggle_opening),
    Shortcut(("P",), "Viewer", "save the image", request=Request.SAVE_IMAGE),
    Shortcut(("Ctrl+S",), "Viewer", "save the view as a scene file", request=Request.SAVE_SCENE),
    Shortcut(("Shift+R",), "Viewer", "reset all", _reset),
    Shortcut(("R", "Home"), "View", "reset the view", reset_view),
    Shortcut(("Left",), "View", "orbit left", partial(_orbit, right=-TURN, up=0.0)),
    Shortcut(("Right",), "View", "orbit right", partial(_orbit, right=TURN, up=0.0)),
    Shortcut(("Up",), "View", "orbit up", partial(_orbit, right=0.0, up=TURN)),
    Shortcut(("Down",), "View", "orbit down", partial(_orbit, right=0.0, up=-TURN)),
    Shortcut(("+", "="), "View", "nearer", partial(_zoom, factor=NEARER)),
    Shortcut(("-",), "View", "farther", partial(_zoom, factor=1.0 / NEARER)),
    Shortcut(("E",), "View", "left, middle or right eye", _next_eye),
    Shortcut(("O",), "View", "look from outside", _toggle_observer),
    Shortcut(("K",), "View", "remember the view", lambda state, home: remember(state)),
    Shortcut(("W",), "Drawings", "wireframe", partial(_toggle_drawing, drawing=Drawing.WIREFRAME)),
    Shortcut(("H",), "Drawings", "hit balls", partial(_toggle_drawing, drawing=Drawing.HITS)),
    Shortcut(("V",), "Drawings", "virtual viewpoint", partial(_toggle_drawing, drawing=Drawing.VIEWPOINT)),
    Shortcut(("B",), "Drawings", "view volume", partial(_toggle_drawing, drawing=Drawing.VOLUME)),
    Shortcut(("I",), "Drawings", "reflection points", partial(_toggle_drawing, drawing=Drawing.REFLECTIONS)),
    Shortcut(("S",), "Halves", "split the image", partial(_toggle, flag="split")),
    Shortcut(("X",), "Halves", "swap the halves", _swap),
    Shortcut(("M",), "Halves", "next method, first half", partial(_next_method, half="first")),
    Shortcut(("Shift+M",), "Halves", "next method, second half", partial(_next_method, half="second")),
    *(
        Shortcut((str(key),), "Halves", f"{aspect}, {half} half", partial(_set_aspect, half=half, aspect=aspect))
        for key, (half, aspect) in enumerate(
            (
                *((half, aspect) for half in ("first", "second") for aspect in Aspect if aspect is not Aspect.COUNTS),
                *((half, Aspect.COUNTS) for half in ("first", "second")),
            ),
            start=1,
        )
    ),
    Shortcut(("U",), "Halves", "errors in mrad or in pixels", _other_unit),
)
"""Every shortcut, in the order of the help overlay."""

_BY_KEY = {key: shortcut for shortcut in SHORTCUTS for key in shortcut.keys}
