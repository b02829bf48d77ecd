"""The pointer over the image, from one event to the next: what it holds, and which cursor shows that."""

from __future__ import annotations

from typing import Any

from anamorph.viewer.facts import Rectangle
from anamorph.viewer.gestures import NO_GRIP, counted_from, cursor, handle
from anamorph.viewer.starting import Start
from anamorph.viewer.state import State


class Pointer:
    """What the pointer holds, nothing at first, and the cursor that is shown."""

    def __init__(self) -> None:
        self._grip = NO_GRIP
        self._cursor = "default"
        self._pressed_at = 0.0

    def let_go(self) -> None:
        """Hold nothing any more."""
        self._grip = NO_GRIP

    def is_late(self, event: dict[str, Any]) -> bool:
        """Whether a move is older than the last press: a page holds moves back a while, and sends presses at once."""
        if event["event_type"] in ("pointer_down", "pointer_up"):
            # Of a release too: a page that takes over begins with one, and every page has a clock of its own.
            self._pressed_at = event.get("time_stamp", 0.0)
        return event["event_type"] == "pointer_move" and event.get("time_stamp", 0.0) < self._pressed_at

    def handle(self, event: dict[str, Any], state: State, area: Rectangle, home: Start) -> tuple[State, str | None]:
        """The state that follows from an event over the image in `area`, and the cursor where it is another one."""
        left, top, right, bottom = area
        size, within = (right - left, bottom - top), counted_from(event, left, top)
        self._grip, state = handle(within, self._grip, state, size, home)
        before, self._cursor = self._cursor, cursor(within, state, size, self._grip)
        # Each is a message to every page: the slow ones' would pile up.
        return state, None if self._cursor == before else self._cursor
