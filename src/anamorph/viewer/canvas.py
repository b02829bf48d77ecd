"""What draws on the canvas: the halves, what is in space over them, and imgui over all."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from time import perf_counter
from typing import Any

import numpy as np
import wgpu
from imgui_bundle import imgui
from rendercanvas.base import BaseRenderCanvas
from wgpu.utils.imgui import ImguiRenderer

from anamorph.gpu.device import get_device
from anamorph.gpu.targets import PIXEL_FORMAT, make_texture, read_texture
from anamorph.viewer.compose import Composer, Shown, color_pass
from anamorph.viewer.lines import LineRenderer
from anamorph.viewer.marks import Marks
from anamorph.viewer.panel.theme import set_theme

Area = tuple[int, int, int, int]
"""Left, top, width and height, in pixels."""

MOST_EVENTS = 10_000
"""That imgui keeps: of a text that is pasted, each letter is one."""

DOUBLE_CLICK = 0.45
"""Seconds between two taps that are one double tap: slow images tell imgui late of either."""


class Painter:
    """Draws halves, and marks over them, into textures of one `form`, which has no sRGB: the shaders encode colours."""

    def __init__(self, form: str) -> None:
        self._composer = Composer(form)
        self.lines = LineRenderer(form)

    def draw(
        self,
        target: wgpu.GPUTexture,
        area: Area,
        halves: tuple[Shown, ...],
        divider: float,
        clip: np.ndarray,
        ratio: float,
        over: Callable[[wgpu.GPURenderPassEncoder], None] | None = None,
    ) -> None:
        """Draw the image into an area of `target`, all else black.

        Parameters
        ----------
        target : texture
        area : Area
        halves, divider
            As for `Composer.draw`.
        clip : (4, 4) float64
            From world space to the clip space of the image.
        ratio : float
            Pixels for each logical one.
        over : callable, optional
            Draws what comes over all that.
        """
        with color_pass(target) as render_pass:
            self._composer.draw(render_pass, halves, area, divider)
            if min(area[2:]) > 0:
                self.lines.draw(render_pass, clip, area[2:], ratio)
            if over is not None:
                over(render_pass)


class _Handlers:
    """Stands for the canvas where imgui's renderer wants one, and keeps its event handlers.

    On the canvas itself they would stay when the renderer goes, and keep events from others by what the pointer was
    over one event ago.
    """

    def __init__(self, canvas: BaseRenderCanvas) -> None:
        self._canvas = canvas
        self.by_type: dict[str, list[Callable[[dict[str, Any]], None]]] = {}

    def get_wgpu_context(self) -> Any:
        return self._canvas.get_wgpu_context()

    def add_event_handler(self, handler: Callable[[dict[str, Any]], None], *types: str, order: float = 0.0) -> None:
        for each in types:
            self.by_type.setdefault(each, []).append(handler)


class DeviceCanvas:
    """The canvas as one device draws on it, until that is lost."""

    def __init__(self, canvas: BaseRenderCanvas) -> None:
        self._context = canvas.get_wgpu_context()
        if self._context.get_configuration() is not None:
            # What it keeps is of a device that is gone.
            self._context.unconfigure()
        self._device = get_device()
        form = self._context.get_preferred_format(self._device.adapter).removesuffix("-srgb")
        self._context.configure(device=self._device, format=form)
        self._handlers = _Handlers(canvas)
        self.imgui = ImguiRenderer(self._device, self._handlers)
        set_theme()
        imgui.get_io().mouse_double_click_time = DOUBLE_CLICK
        self._painter = Painter(form)
        self._marks: Marks | None = None
        self._shown_at = perf_counter()

    @property
    def outlived(self) -> bool:
        """Whether the process has another device by now: of several viewers, one alone notices that it is lost."""
        return self._device is not get_device()

    def close(self) -> None:
        """Let go of imgui; another one can take this one's place on the canvas."""
        imgui.destroy_context(self.imgui.imgui_context)

    def take(self, event: dict[str, Any]) -> None:
        """Have imgui see an event of the canvas."""
        io = self.imgui.backend.io
        if self.imgui.imgui_context.input_events_queue.size() > MOST_EVENTS:
            # Of presses it takes in one a frame. Who is so far ahead of what is shown starts anew, with nothing held.
            io.clear_events_queue()
            io.clear_input_keys()
            io.clear_input_mouse()
        if "key" in event and len(event["key"].lower()) != 1 and event["key"] not in ImguiRenderer.KEY_MAP:
            # At others, such as "AltGraph", imgui's renderer fails.
            return
        if event["event_type"] in ("pointer_down", "pointer_move"):
            sources = imgui.MouseSource
            io.add_mouse_source_event(sources.touch_screen if event.get("touches") else sources.mouse)
        if event["event_type"] in ("pointer_down", "pointer_up"):
            # A press comes before the move that led to it, and imgui takes its place from moves alone.
            io.add_mouse_pos_event(event["x"], event["y"])
        for handler in self._handlers.by_type.get(event["event_type"], ()):
            handler(dict(event))

    def panel(self, show: Callable[[], None]) -> None:
        """Have `show` call imgui for a frame, which the next `draw` draws.

        The renderer's own `render` does both at once. Apart, what a user does on the panel is in the image that is
        drawn after it, and not in the next.
        """
        imgui.set_current_context(self.imgui.imgui_context)
        io, ratio = self.imgui.backend.io, self._context.pixel_ratio
        io.display_framebuffer_scale = (ratio, ratio)
        io.display_size = self._context.logical_size
        # Left alone, it takes every frame for a sixtieth of a second; and it wants time to go on.
        now = perf_counter()
        io.delta_time, self._shown_at = max(now - self._shown_at, 1e-6), now
        imgui.new_frame()
        try:
            show()
        finally:
            imgui.render()

    def mark(self, marks: Marks) -> None:
        """Replace what is drawn into space."""
        self._marks = marks
        self._painter.lines.upload(marks)

    def draw(self, area: Area, halves: tuple[Shown, ...], divider: float, clip: np.ndarray, ratio: float) -> None:
        """Draw the image, see `Painter.draw`, and the panel over it."""
        panel = partial(self.imgui.backend.render, imgui.get_draw_data())
        self._painter.draw(self._context.get_current_texture(), area, halves, divider, clip, ratio, panel)

    def image(
        self, size: tuple[int, int], halves: tuple[Shown, ...], divider: float, clip: np.ndarray, ratio: float
    ) -> np.ndarray:
        """The image alone, as it is shown: (H, W, 3) uint8 sRGB."""
        painter, target = Painter(PIXEL_FORMAT), make_texture(size, PIXEL_FORMAT)
        if self._marks is not None:
            painter.lines.upload(self._marks)
        painter.draw(target, (0, 0, *size), halves, divider, clip, ratio)
        return read_texture(target)[..., :3]
