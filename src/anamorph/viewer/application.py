"""The viewer: one canvas, whatever it stands in, and all that happens on it."""

from __future__ import annotations

import os
from collections.abc import Callable
from functools import partial
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np
import wgpu
from rendercanvas.base import BaseRenderCanvas

from anamorph.base.errors import AnamorphError
from anamorph.gpu.device import adapter_name, forget_lost_device
from anamorph.projection import camera_projection
from anamorph.scene.model import Scene
from anamorph.viewer import starting
from anamorph.viewer.canvas import DeviceCanvas
from anamorph.viewer.compose import Shown
from anamorph.viewer.controls import edited
from anamorph.viewer.facts import Facts, Request
from anamorph.viewer.failures import failure_text
from anamorph.viewer.inspector import Inspector
from anamorph.viewer.job import Job
from anamorph.viewer.layout import image_area, in_pixels, inside
from anamorph.viewer.marks import NO_MARKS
from anamorph.viewer.numbers import numbered, numbers_of
from anamorph.viewer.panel.panel import Drawn, draw_panel
from anamorph.viewer.point_follower import PointFollower, with_point
from anamorph.viewer.pointer import Pointer
from anamorph.viewer.shortcuts import press
from anamorph.viewer.showing import Showing
from anamorph.viewer.snapshot import snapshot
from anamorph.viewer.space import PreparedScene, space_marks
from anamorph.viewer.starting import Start, carried_over
from anamorph.viewer.state import State, looking_eye, shown_camera
from anamorph.viewer.tasks import Shot, saving_of

SETTLING = 3
"""Frames after the last event: imgui needs them to show what it brought about."""

MOST_SETTLING = 60
"""However many events have come at once."""

REST_DELAY = 0.15
"""Seconds without a change after which the image is refined."""

TIP_DELAY = 0.4
"""Seconds until what the pointer rests on in the panel is explained: a little more than imgui waits."""

LONGEST_REFINING = 0.25
"""Seconds of refining for one image, however long the last one took to be shown."""

ANSWER_DELAY = 0.05
"""Seconds until it is looked again whether a search has ended that takes longer than a frame."""

UNSEEN = 0.25
"""Seconds without an image after which what is being saved goes on without: nobody looks."""

Later = Callable[[float, Callable[[], None]], object]
"""Has something called after so many seconds."""


class Viewer:
    """Shows a scene on a canvas, and does what its user does there.

    Parameters
    ----------
    canvas : BaseRenderCanvas
        Of any backend.
    start : Start
    later : callable, optional
        The event loop's; without one, refining begins with the first frame in which nothing moves.

    Attributes
    ----------
    state : State
        What is shown; whoever sets another calls `refresh`.
    frames : int
        How many have been drawn.
    """

    def __init__(self, canvas: BaseRenderCanvas, start: Start, later: Later | None = None) -> None:
        self._canvas, self._later = canvas, later
        self._job: Job | None = None
        # One in a notebook may begin long after the device was made.
        forget_lost_device()
        self._device_canvas = DeviceCanvas(self._canvas)
        self._handlers = {
            self._on_pointer: ("pointer_down", "pointer_move", "pointer_up", "wheel", "double_click"),
            self._on_key: ("key_down",),
            self._take: ("key_up", "char", "resize", "pointer_leave"),
            self._on_close: ("close",),
        }
        for handler, types in self._handlers.items():
            canvas.add_event_handler(handler, *types)
        self.frames = 0
        self._settling = SETTLING
        self._pointer = Pointer()
        self._closed = False
        self._begin(start, start.state)
        canvas.request_draw(self._draw)

    def open(self, start: Start) -> None:
        """Show another scene with what is set now; where there is none, say why and go on with this one."""
        if start.message:
            self.message = start.message
            self.refresh()
        else:
            self._begin(start, carried_over(self.state, start))

    def _begin(self, start: Start, state: State) -> None:
        self.start, self.state = start, state
        self.message = start.message or ("stopped saving" if self._job is not None else "")
        self._scene = start.opened.scene
        self._values: object = {}
        self._pointer.let_go()
        self._drawn: Drawn | None = None
        self._asked: tuple[str, int] | None = None
        self._let_go()
        self._canvas.set_title(self.title)
        self.refresh()

    @property
    def title(self) -> str:
        """Of the window or the page."""
        return f"{self.start.opened.scene.name} - Anamorph"

    def refresh(self) -> None:
        """Draw again soon, because something may have changed."""
        self._settling = max(self._settling, SETTLING)
        self._canvas.request_draw()

    def snapshot(self) -> dict[str, Any]:
        """What the viewer shows, and where: plain data, for scripts and tests."""
        return snapshot(self._facts(), self.state, self._drawn, self.frames, self._showing.finished)

    def close(self) -> None:
        """End what runs, and let go of the canvas, and of everything on the device and in imgui."""
        if not self._closed:
            self._closed = True
            for handler, types in self._handlers.items():
                self._canvas.remove_event_handler(handler, *types)
            self._let_go()
            self._device_canvas.close()

    def _let_go(self) -> None:
        """Of everything that belongs to a scene, or to a device that may be lost."""
        self._stop_saving()
        self._showing, self._space = Showing(), PreparedScene(self._scene)
        self._marked: object = None
        self._inspector, self._follower = Inspector(), PointFollower()
        self._changed_at, self._refined_at = 0.0, np.inf

    def _take(self, event: dict[str, Any]) -> None:
        """Have imgui see an event, and give it frames: of presses and releases it takes in one a frame."""
        self.refresh()
        if event["event_type"] != "pointer_move":
            self._settling = min(self._settling + 1, MOST_SETTLING)
        self._device_canvas.take(event)

    def _on_close(self, event: dict[str, Any]) -> None:
        self.close()

    def _on_pointer(self, event: dict[str, Any]) -> None:
        if self._pointer.is_late(event):
            return
        self._take(event)
        follows = event["event_type"] in ("pointer_move", "pointer_up")
        covered = self._drawn.covered if self._drawn else ()
        over_panel = any(inside(event["x"], event["y"], area) for area in covered)
        if over_panel and self._later is not None:
            # imgui counts how long the pointer rests, but only sees it at a frame.
            self._later(TIP_DELAY, self.refresh)
        if over_panel and not follows:
            return
        self.state, cursor = self._pointer.handle(event, self.state, self._area, self.start)
        if cursor is not None:
            self._canvas.set_cursor(cursor)

    def _on_key(self, event: dict[str, Any]) -> None:
        self._take(event)
        if self._drawn is not None and self._drawn.typing:
            return
        self.state, requests = press(event, self.state, self.start)
        self._obey(requests)

    @property
    def _area(self) -> tuple[float, float, float, float]:
        return image_area(self._canvas.get_logical_size(), self.state.panel)

    @property
    def _pixels(self) -> tuple[int, int, int, int]:
        """Left, top, width and height of the image on the canvas."""
        return in_pixels(self._area, self._canvas.get_pixel_ratio())

    def _draw(self) -> None:
        """One frame: whatever is due, and then the canvas."""
        if self._closed:
            return
        # To ask a window for its texture on a lost device would end the process.
        forget_lost_device()
        if self._device_canvas.outlived:
            self._recover()
        # Each for itself: whatever fails, the panel is there to say so.
        for step in (self._open_asked, self._show_panel, self._advance, self._mark, self._paint):
            self._attempt(step)
        self.frames += 1
        if self._settling > 0:
            self._settling -= 1
            self._canvas.request_draw()

    def _attempt(self, step: Callable[[], None]) -> None:
        try:
            step()
        except wgpu.DrawCancelled:
            # A window that cannot be drawn into now; the canvas tries again.
            raise
        except Exception as error:
            message = failure_text(error, "drawing")
            # It may come up again with every frame, which needs no frame for each.
            if message != self.message:
                self.message = message
                self.refresh()
            if isinstance(error, wgpu.GPUError):
                self._let_go()

    def _recover(self) -> None:
        """Go on with a new device, because the old one is lost, with everything opened anew."""
        self._let_go()
        # Closed last: where there is no other device, events go on to reach the old one.
        self._device_canvas, old = DeviceCanvas(self._canvas), self._device_canvas
        old.close()
        self.message = "the graphics device was lost; this is drawn with a new one"

    def _advance(self) -> None:
        """Draw what has moved; else take a step of what is to be done at rest."""
        scene, size, now = self._edited_scene(), self._pixels[2:], perf_counter()
        if not scene.meshes or min(size) < 1:
            return
        if self._showing.update(scene, self.state, size):
            self._changed_at, self._refined_at = now, np.inf
            self._draw_after(0.0 if self._showing.moving else REST_DELAY)
            return
        if self._job is not None:
            self._save(self._job)
        waited = now - self._changed_at
        if self._later is not None and waited < REST_DELAY:
            return
        # Whoever takes long to show an image is sent fewer: what is refined for one takes as long again.
        taken = min(now - self._refined_at, LONGEST_REFINING)
        while self._showing.rest():
            self._canvas.request_draw()
            self._refined_at = perf_counter()
            if self._refined_at - now >= taken:
                break

    def _draw_after(self, seconds: float) -> None:
        """Draw again, once nothing has to be waited for."""
        if self._later is None or seconds == 0.0:
            self._canvas.request_draw()
        else:
            self._later(seconds, self._canvas.request_draw)

    def _paint(self) -> None:
        pixels = self._pixels
        self._device_canvas.draw(pixels, *self._shown((max(pixels[2], 1), max(pixels[3], 1))))

    def _shown(self, size: tuple[int, int]) -> tuple[tuple[Shown, ...], float, np.ndarray, float]:
        """Halves, divider, clip space and pixel ratio, as the canvas takes them."""
        clip = camera_projection(shown_camera(self.state), size).clip
        return self._showing.halves, self.state.divider, clip, self._canvas.get_pixel_ratio()

    def _mark(self) -> None:
        """Put into space what is to be drawn there, where that has changed."""
        size, eye = self._pixels[2:], looking_eye(self.state)
        if not self._scene.meshes or min(size) < 1:
            return
        inspection = self._inspector.update(self._space, self.state, size, self._showing)
        self.state = with_point(self.state, self._inspector)
        reflections = self._follower.update(self._scene, self.state, size, self._showing.at_rest)
        if self._follower.searching:
            self._draw_after(ANSWER_DELAY)
        methods = tuple(half.method for half in self.state.halves)
        marked = (self._scene, self.state.drawings, self.state.observer, methods, eye, size, inspection, reflections)
        if marked != self._marked:
            self._marked = marked
            # Should the new ones fail, the old ones must not stay.
            self._device_canvas.mark(NO_MARKS)
            self._device_canvas.mark(space_marks(self._space, self.state, eye, size, inspection, reflections))

    def _show_panel(self) -> None:
        self._device_canvas.panel(self._draw_panel)

    def _draw_panel(self) -> None:
        self._drawn = draw_panel(self.state, self._facts())
        if self._drawn.state != self.state:
            self.state = self._drawn.state
            self.refresh()
        self._obey(self._drawn.requests)
        if self._drawn.opens is not None:
            self._asked = self._drawn.opens, self.frames
            self.message = f"opening {self._drawn.opens} …"
            self.refresh()

    def _open_asked(self) -> None:
        """Open what was asked for, which may take seconds, once it is seen that this is being done."""
        if self._asked is not None and self.frames >= self._asked[1] + SETTLING:
            name, self._asked = self._asked[0], None
            self.open(starting.start_of(os.path.expanduser(name)))

    def _edited_scene(self) -> Scene:
        """The scene with what its controls have been set to; where that cannot be, the last one that could."""
        if self.state.values != self._values:
            self._values = self.state.values
            try:
                self._scene = edited(self.start.opened.scene, self.state.values)
                self._space = PreparedScene(self._scene)
                self.message = ""
            except AnamorphError as error:
                self.message = str(error)
        return self._scene

    def _obey(self, requests: tuple[Request, ...]) -> None:
        """Begin what was asked for: one thing after the other, so that no two take each other's time."""
        for request in requests:
            if request is Request.DISMISS:
                self.message = ""
            elif request is Request.CANCEL:
                self.message = "stopped" if self._job is not None else self.message
                self._stop_saving()
            elif self._job is not None:
                self.message = "something is being saved; wait for it, or cancel it"
            elif self._scene.meshes:
                size = self._pixels[2:]
                self.message = ""
                shot = Shot(self.start.opened, self._scene, self.state, size, self._showing, self._image)
                self._job = Job(saving_of(request, shot, Path()))
                self._save_unseen(self._job, frames=-1)
            self.refresh()

    def _save(self, job: Job) -> None:
        """Go on with what is being saved."""
        ended = job.advance()
        if ended is not None:
            self.message = ended
            self._stop_saving()
        self.refresh()

    def _save_unseen(self, job: Job, frames: int) -> None:
        """Go on with what is being saved where nothing has been drawn since so many frames: closed tabs end nothing."""
        if job is self._job and self._later is not None:
            unseen = frames == self.frames
            if unseen:
                self._attempt(self._advance)
            self._later(0.01 if unseen else UNSEEN, partial(self._save_unseen, job, self.frames))

    def _stop_saving(self) -> None:
        if self._job is not None:
            self._job.stop()
        self._job = None

    def _image(self) -> np.ndarray:
        """The image as it is shown, without the panel, (H, W, 3) uint8 sRGB."""
        size, ratio = self._pixels[2:], self._canvas.get_pixel_ratio()
        left, top, right, bottom = self._area
        numbers = numbers_of(self._follower.reflections, shown_camera(self.state), (right - left, bottom - top))
        return numbered(self._device_canvas.image(size, *self._shown(size)), numbers, ratio)

    def _facts(self) -> Facts:
        showing, width_height = self._showing, self._pixels[2:]
        measured = [showing.measured.get(half.method) for half in self.state.halves]
        width, height = self._canvas.get_logical_size()
        return Facts(
            scene=self.start.opened.scene,
            home=self.start.state.camera,
            size=(round(width), round(height)),
            image=showing.image,
            full=(max(width_height[0], 0), max(width_height[1], 0)),
            adapter=adapter_name(),
            frame_ms=showing.frame_ms,
            phases_ms=showing.phases,
            samples_done=showing.samples_done,
            samples_total=self.state.samples**2 if self.state.samples > 1 else 0,
            figures=tuple(each.figures if each else None for each in measured),
            inspection=self._inspector.inspection,
            reflections=self._follower.reflections,
            searching=self._follower.searching or showing.counting,
            message=" ".join(filter(None, (self.message, *showing.failures))),
            progress=self._job.progress if self._job else None,
        )
