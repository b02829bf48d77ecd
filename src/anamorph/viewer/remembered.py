"""Views that are remembered: to come back to, and to go through on a path."""

from __future__ import annotations

from dataclasses import replace

from anamorph.viewer.navigation import steer
from anamorph.viewer.state import EyeSide, State, shown_camera

LEAST = 2
"""Views that a path goes through."""


def remember(state: State) -> State:
    """The state with what is shown as its last view; the same one is not remembered twice in a row."""
    view = shown_camera(state)
    return state if state.views[-1:] == (view,) else replace(state, views=(*state.views, view))


def go_to(state: State, number: int) -> State:
    """The state with the observer where a view was, if one looks, else the eye: just that view is shown then."""
    view = state.views[number]
    return steer(replace(state, eye=state.eye if state.observer else EyeSide.MIDDLE), lambda _: view)


def forget(state: State, number: int) -> State:
    """The state without one of its views."""
    return replace(state, views=(*state.views[:number], *state.views[number + 1 :]))
