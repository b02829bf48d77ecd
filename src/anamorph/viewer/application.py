"""The viewer: one canvas, whatever it stands in, and all that happens on it."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterator
from time import perf_counter
from typing import Any

import numpy as np
import wgpu
from rendercanvas.base import BaseRenderCanvas
from wgpu.utils.imgui import ImguiRenderer

from anamorph.errors import AnamorphError
from anamorph.gpu.device import adapter_name, device_lost, forget_device, get_device
from anamorph.projection import camera_projection
from anamorph.scene.model import Scene
from anamorph.viewer.compose import Composer, Shown
from anamorph.viewer.controls import edited
from anamorph.viewer.facts import Facts, Inspection, Progress, Rectangle, Request
from anamorph.viewer.gestures import FREE, Grip, cursor, handle
from anamorph.viewer.home import Home
from anamorph.viewer.inspection import inspect
from anamorph.viewer.lines import LineRenderer
from anamorph.viewer.opened import Opened
from anamorph.viewer.panel import Drawn, draw_panel
from anamorph.viewer.shortcuts import press
from anamorph.viewer.showing import TRUTH, Showing
from anamorph.viewer.space import Space
from anamorph.viewer.state import State, looking_eye, shown_camera
from anamorph.viewer.theme import set_theme

SETTLING = 3
"""Frames after the last event: imgui needs them to show what it brought about."""

REST_DELAY = 0.15
"""Seconds without a change after which the picture is refined."""

Later = Callable[[float, Callable[[], None]], object]
"""Has something called after so many seconds."""


class Surface:
    """What draws on one canvas: the halves, what is in space, and imgui."""

    def __init__(self, canvas: BaseRenderCanvas) -> None:
        self._context = canvas.get_wgpu_context()
        # Colours come out of the shaders, and of imgui, as sRGB already.
        form = self._context.get_preferred_format(get_device().adapter).removesuffix("-srgb")
        self._context.configure(device=get_device(), format=form)
        self.imgui = ImguiRenderer(get_device(), canvas)
        set_theme()
        self.composer = Composer(form)
        self.lines = LineRenderer(form)

    def draw(self, halves: tuple[Shown, ...], divider: float, clip: np.ndarray, size: tuple[int, int]) -> None:
        """Everything but imgui, which comes over it."""
        encoder = get_device().create_command_encoder()
        attachment = {
            "view": self._context.get_current_texture().create_view(),
            "clear_value": (0.0, 0.0, 0.0, 1.0),
            "load_op": "clear",
            "store_op": "store",
        }
        render_pass = encoder.begin_render_pass(color_attachments=[attachment])
        self.composer.draw(render_pass, halves, size, divider)
        self.lines.draw(render_pass, clip, size)
        render_pass.end()
        get_device().queue.submit([encoder.finish()])


class Viewer:
    """Shows a scene on a canvas, and does what its user does there.

    Parameters
    ----------
    canvas : BaseRenderCanvas
        Of any backend.
    opened : Opened
    later : callable, optional
        The event loop's; without one, refining begins with the first frame in which nothing moves.
    """

    def __init__(self, canvas: BaseRenderCanvas, opened: Opened, later: Later | None = None) -> None:
        self._canvas, self._later = canvas, later
        self._grip: Grip = FREE
        self._settling = SETTLING
        self._changed_at = 0.0
        self._frames = 0
        self._drawn = Drawn(opened.state)
        self._job: Iterator[Progress] | None = None
        self._progress: Progress | None = None
        self._surface = Surface(canvas)
        self._surface.imgui.set_gui(self._draw_panel)
        canvas.add_event_handler(self._place_pointer, "pointer_down", "pointer_up", order=-100)
        canvas.add_event_handler(
            self._on_pointer, "pointer_down", "pointer_move", "pointer_up", "wheel", "double_click"
        )
        canvas.add_event_handler(self._on_key, "key_down")
        canvas.add_event_handler(self._on_any, "key_up", "char", "resize", "pointer_leave")
        canvas.add_event_handler(self._on_close, "close")
        self.open(opened)
        canvas.request_draw(self._draw)

    def open(self, opened: Opened) -> None:
        """Show another scene, or say why there is none."""
        self.opened = opened
        self.state = opened.state
        self._home = Home(opened.state, opened.scene)
        self._scene, self._values = opened.scene, opened.state.values
        self._showing = Showing()
        self._space: Space | None = None
        self._inspected: tuple[Any, Inspection] | None = None
        self.message = opened.message
        self._refresh()

    def close(self) -> None:
        """Let go of everything on the device."""
        self._end_job()
        self._showing = Showing()
        self._space = None

    def _refresh(self) -> None:
        self._settling = SETTLING
        self._canvas.request_draw()

    def _place_pointer(self, event: dict[str, Any]) -> None:
        """A press comes before the move that led to it, and imgui takes its place from moves alone."""
        self._surface.imgui.backend.io.add_mouse_pos_event(event["x"], event["y"])

    def _on_any(self, event: dict[str, Any]) -> None:
        self._refresh()

    def _on_close(self, event: dict[str, Any]) -> None:
        self.close()

    def _on_pointer(self, event: dict[str, Any]) -> None:
        self._refresh()
        starts = event["event_type"] not in ("pointer_move", "pointer_up")
        if self._grip == FREE and starts and _inside(event["x"], event["y"], self._drawn.covered):
            return
        size = self._canvas.get_logical_size()
        self._grip, self.state = handle(event, self._grip, self.state, size, self._home)
        self._canvas.set_cursor(cursor(event, self._grip, self.state, size))

    def _on_key(self, event: dict[str, Any]) -> None:
        self._refresh()
        if self._surface.imgui.backend.io.want_text_input:
            return
        self.state, requests = press(event, self.state, self._home)
        for request in requests:
            self._obey(request)

    def _draw(self) -> None:
        """One frame: whatever is due, and then the canvas."""
        try:
            self._advance()
            self._paint()
        except (wgpu.GPUError, RuntimeError) as error:
            self._recover(error)
        self._frames += 1
        if self._settling > 0:
            self._settling -= 1
            self._canvas.request_draw()

    def _advance(self) -> None:
        """Draw what has moved; else take one step of what is to be done at rest."""
        scene = self._edited_scene()
        size = self._canvas.get_physical_size()
        now = perf_counter()
        if not scene.meshes or min(size) < 1:
            return
        if self._showing.update(scene, self.state, size):
            self._changed_at = now
            self._wake(REST_DELAY)
        elif self._later is None or now - self._changed_at >= REST_DELAY:
            if self._step_job() | self._showing.rest():
                self._canvas.request_draw()
        elif self._settling == 0:
            self._wake(REST_DELAY - (now - self._changed_at))

    def _wake(self, seconds: float) -> None:
        if self._later is None:
            self._canvas.request_draw()
        else:
            self._later(seconds, self._canvas.request_draw)

    def _paint(self) -> None:
        width, height = self._canvas.get_physical_size()
        camera = shown_camera(self.state)
        if self._scene.meshes:
            if self._space is None or self._space.scene is not self._scene:
                self._space = Space(self._scene)
            eye = looking_eye(self.state)
            self._surface.lines.upload(self._space.marks(self.state, eye, (width, height), self._inspection()))
        clip = camera_projection(camera, (width, height)).clip
        self._surface.draw(self._showing.halves, self.state.divider, clip, (width, height))
        self._surface.imgui.render()

    def _draw_panel(self) -> None:
        self._drawn = draw_panel(self.state, self._facts())
        if self._drawn.state != self.state:
            self.state = self._drawn.state
            self._refresh()
        for request in self._drawn.requests:
            self._obey(request)

    def _edited_scene(self) -> Scene:
        """The scene with what its controls have been set to; where that cannot be, the last one that could."""
        if self.state.values != self._values:
            self._values = self.state.values
            try:
                self._scene = edited(self.opened.scene, self._values)
                self.message = ""
            except AnamorphError as error:
                self.message = str(error)
        return self._scene

    def _inspection(self) -> Inspection | None:
        """What is seen at the picked pixel, once its frames are there."""
        if self.state.picked is None:
            self._inspected = None
            return None
        first, second = self.state.first.method, self.state.second.method
        x, y = self.state.picked
        method = second if self.state.split and x >= self.state.divider else first
        frames, measured = self._showing.frames, self._showing.measured
        if self._showing.at_rest and method in measured:
            key = (self.state.picked, measured[method])
            if self._inspected is None or self._inspected[0] != key:
                size = self._canvas.get_physical_size()
                pixel = min(int(x * size[0]), size[0] - 1), min(int(y * size[1]), size[1] - 1)
                camera = shown_camera(self.state)
                found = inspect(self._scene, camera, size, pixel, method, measured[method])
                self._inspected = key, found
        return self._inspected[1] if self._inspected else None

    def _facts(self) -> Facts:
        showing = self._showing
        measured = [showing.measured.get(half.method) for half in self.state.halves]
        return Facts(
            scene=self.opened.scene,
            size=self._canvas.get_logical_size(),
            picture=showing.picture,
            full=self._canvas.get_physical_size(),
            adapter=adapter_name(),
            frame_ms=showing.frame_ms,
            phases_ms=showing.phases,
            samples_done=showing.samples_done,
            samples_total=self.state.samples**2 if self.state.samples > 1 else 0,
            figures=tuple(each.figures if each else None for each in measured),
            inspection=self._inspected[1] if self._inspected else None,
            message=" ".join(filter(None, (self.message, *showing.failures))),
            progress=self._progress,
        )

    def report(self) -> dict[str, Any]:
        """What the viewer shows, and where: plain data, for scripts and tests."""
        facts = self._facts()
        told = {name: getattr(facts, name) for name in ("picture", "full", "size", "adapter", "frame_ms", "message")}
        return {
            "scene": facts.scene.name,
            "state": dataclasses.asdict(self.state) | {"drawings": sorted(self.state.drawings)},
            "rectangles": dict(self._drawn.rectangles),
            "covered": list(self._drawn.covered),
            "frames": self._frames,
            "at_rest": self._showing.at_rest and facts.samples_done >= facts.samples_total,
            "samples_done": facts.samples_done,
            "phases_ms": dict(facts.phases_ms),
            "inspection": facts.inspection and dataclasses.asdict(facts.inspection),
            "figures": [each and dataclasses.asdict(each) for each in facts.figures],
            "progress": facts.progress and dataclasses.asdict(facts.progress),
            **told,
        }
