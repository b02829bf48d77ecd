"""A viewer on a canvas without a screen, and a hand that moves on it."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from rendercanvas.offscreen import OffscreenRenderCanvas

from anamorph.files.scene_file import Settings
from anamorph.files.view_file import Opened
from anamorph.scene.model import Scene
from anamorph.viewer.application import Later, Viewer
from anamorph.viewer.layout import image_area
from anamorph.viewer.starting import Start
from anamorph.viewer.state import State

PATIENCE = 10_000
"""Frames for what takes a few: a frame does what there is time for, which on a busy machine is little."""


def home_of(state: State, scene: Scene) -> Start:
    """Where a viewer of a scene starts that was opened as it is."""
    return Start(Opened(scene, Settings(), scene.camera), state)


class Hand:
    """Sends events to a viewer, and looks at what it draws."""

    shown: np.ndarray

    def __init__(
        self, start: Start, size: tuple[int, int] = (560, 300), ratio: float = 1.0, later: Later | None = None
    ) -> None:
        self.canvas = OffscreenRenderCanvas(size=size, pixel_ratio=ratio)
        self.viewer = Viewer(self.canvas, start, later)
        self.draw(2)

    def close(self) -> None:
        self.viewer.close()
        self.canvas.close()

    def draw(self, count: int = 1) -> np.ndarray:
        """The canvas after so many frames, (H, W, 3) uint8."""
        for _ in range(count):
            self.shown = np.asarray(self.canvas.draw())[..., :3].copy()
        return self.shown

    def settle(self, done: Callable[[dict[str, Any]], Any] = lambda snapshot: snapshot["at_rest"]) -> np.ndarray:
        """The canvas once the report says that something has happened, or that nothing is left to refine."""
        for _ in range(PATIENCE):
            self.draw()
            if done(self.viewer.snapshot()):
                return self.draw(4)
        raise AssertionError("it did not happen")

    def send(self, kind: str, **fields: Any) -> None:
        self.canvas.submit_event({"event_type": kind, "modifiers": (), "buttons": (), **fields})
        self.canvas._process_events()
        self.draw()

    def key(self, name: str, *modifiers: str) -> None:
        self.send("key_down", key=name, modifiers=modifiers)
        self.send("key_up", key=name, modifiers=modifiers)

    def type(self, text: str) -> None:
        """Into the field that has the keys."""
        self.draw(2)
        self.send("char", data=text, char_str=text)
        self.draw(2)

    def place(self, x: float, y: float) -> tuple[float, float]:
        """On the canvas, from shares of the image's width and height."""
        left, top, right, bottom = image_area(self.canvas.get_logical_size(), self.viewer.state.panel)
        return left + x * (right - left), top + y * (bottom - top)

    def widget(self, key: str, share: float = 0.5) -> tuple[float, float]:
        left, top, right, bottom = self.viewer.snapshot()["rectangles"][key]
        return left + share * (right - left), (top + bottom) / 2.0

    def click(self, x: float, y: float) -> None:
        self.drag((x, y))

    def drag(self, *places: tuple[float, float], button: int = 1) -> None:
        """Press at the first place, move over the others, and let go at the last."""
        (x, y), *others = places
        self.send("pointer_move", x=x, y=y, button=0)
        self.send("pointer_down", x=x, y=y, button=button, buttons=(button,))
        for x, y in others:
            self.send("pointer_move", x=x, y=y, button=button, buttons=(button,))
        self.send("pointer_up", x=x, y=y, button=button)
