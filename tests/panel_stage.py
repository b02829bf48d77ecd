"""A canvas with nothing but the panel, and a hand that presses what it finds by its key."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np
from imgui_bundle import imgui
from rendercanvas.offscreen import OffscreenRenderCanvas
from wgpu.utils.imgui import ImguiRenderer

from anamorph.gpu.device import get_device
from anamorph.viewer.facts import Facts, Rectangle, Request
from anamorph.viewer.panel.panel import Drawn, draw_panel
from anamorph.viewer.panel.theme import set_theme
from anamorph.viewer.state import State


class Stage:
    """Draws the panel over a plain ground; `state` is what it has come to."""

    drawn: Drawn
    density: float

    def __init__(self, state: State, facts: Facts, ratio: float = 1.0) -> None:
        self.state, self.facts = state, facts
        self.requests: list[Request] = []
        self.opens: list[str] = []
        self.widths: dict[str, float] = {}
        self._measured: Iterable[str] = ()
        self._device = get_device()
        self.canvas = OffscreenRenderCanvas(size=facts.size, pixel_ratio=ratio)
        self._renderer = ImguiRenderer(self._device, self.canvas)
        set_theme()
        self._renderer.set_gui(self._gui)
        # A press comes with a place of its own, which imgui's renderer does not look at.
        self.canvas.add_event_handler(self._place, "pointer_down", "pointer_up", order=-100)
        self.canvas.request_draw(self._draw)
        self.frames(3)

    def close(self) -> None:
        self.canvas.close()
        imgui.destroy_context(self._renderer.imgui_context)

    def frames(self, count: int = 1) -> np.ndarray:
        """Draw; the last image, (H, W, 4) uint8."""
        for _ in range(count):
            image = np.asarray(self.canvas.draw())
        return image

    def measure(self, texts: Iterable[str]) -> dict[str, float]:
        """How wide texts are in the panel's font."""
        self._measured = texts
        self.frames()
        return self.widths

    def send(self, kind: str, **fields: Any) -> None:
        self.canvas.submit_event({"event_type": kind, "modifiers": (), "buttons": (), **fields})
        self.canvas._process_events()
        self.frames()

    def reveal(self, key: str) -> None:
        """Scroll until a widget of the panel is seen whole."""
        for _ in range(200):
            body, (left, top, right, bottom) = self.drawn.rectangles.get("panel/body"), self.drawn.rectangles[key]
            if body is None or left >= body[2] or (top >= body[1] and bottom <= body[3]):
                return
            x, y = (body[0] + body[2]) / 2, (body[1] + body[3]) / 2
            self.send("pointer_move", x=x, y=y, button=0)
            self.send("wheel", x=x, y=y, dx=0, dy=50 if bottom > body[3] else -50)
            if self.drawn.rectangles[key] == (left, top, right, bottom):
                return

    def place(self, key: str, share: float = 0.5) -> tuple[float, float]:
        left, top, right, bottom = self.drawn.rectangles[key]
        return left + share * (right - left), (top + bottom) / 2

    def type(self, text: str) -> None:
        """Into the field that has the keys."""
        self.send("char", data=text, char_str=text)
        self.frames(2)

    def key(self, name: str) -> None:
        self.send("key_down", key=name)
        self.send("key_up", key=name)
        self.frames(2)

    def press(self, key: str, share: float = 0.5) -> None:
        """Press a widget and let it go."""
        self.reveal(key)
        x, y = self.place(key, share)
        self.send("pointer_move", x=x, y=y, button=0)
        self.send("pointer_down", x=x, y=y, button=1)
        self.send("pointer_up", x=x, y=y, button=1)
        self.frames()

    def drag(self, key: str, start: float, end: float) -> None:
        """Drag along a widget, from one share of its width to another."""
        self.reveal(key)
        (x, y), (there, _) = self.place(key, start), self.place(key, end)
        self.send("pointer_move", x=x, y=y, button=0)
        self.send("pointer_down", x=x, y=y, button=1)
        self.send("pointer_move", x=there, y=y, button=1)
        self.send("pointer_up", x=there, y=y, button=1)
        self.frames()

    def _place(self, event: dict[str, Any]) -> None:
        self._renderer.backend.io.add_mouse_pos_event(event["x"], event["y"])

    def _gui(self) -> None:
        self.drawn = draw_panel(self.state, self.facts)
        self.state = self.drawn.state
        self.requests += self.drawn.requests
        self.opens += [] if self.drawn.opens is None else [self.drawn.opens]
        self.density = imgui.get_font_baked().rasterizer_density
        self.widths = {text: imgui.calc_text_size(text).x for text in self._measured}

    def _draw(self) -> None:
        view = self._renderer._canvas_context.get_current_texture().create_view()
        encoder = self._device.create_command_encoder()
        ground = {"view": view, "clear_value": (0.4, 0.4, 0.4, 1.0), "load_op": "clear", "store_op": "store"}
        encoder.begin_render_pass(color_attachments=[ground]).end()
        self._device.queue.submit([encoder.finish()])
        self._renderer.render()


def overlap(one: Rectangle, other: Rectangle) -> bool:
    """Whether two rectangles share more than an edge."""
    return min(one[2], other[2]) - max(one[0], other[0]) > 0.01 and min(one[3], other[3]) - max(one[1], other[1]) > 0.01


def inside(one: Rectangle, other: Rectangle) -> bool:
    return one[0] >= other[0] and one[1] >= other[1] and one[2] <= other[2] and one[3] <= other[3]
