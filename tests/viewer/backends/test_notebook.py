"""The viewer in a notebook, without one: messages as the page's widget sends them, and the images it is sent.

JupyterLab has messages from the page handled on a thread with an event loop of its own, and so has the page here.
"""

from __future__ import annotations

import asyncio
import gc
import io
import sys
import threading
import weakref
from collections.abc import Callable, Coroutine, Iterator
from contextlib import contextmanager
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from browser import PATIENCE, chromium, needs_chromium
from PIL import Image

import anamorph as an
from anamorph.gpu.device import get_device
from anamorph.gpu.drawing import wait
from anamorph.viewer.backends import choice as backends
from anamorph.viewer.backends.notebook import in_notebook

pytest.importorskip("anywidget")

SIZE = (480, 320)
POINTER: dict[str, Any] = {"button": 1, "modifiers": [], "ntouches": 0, "touches": {}}


class Page:
    """What stands for the browser: it says its size, and confirms the images it is sent."""

    def __init__(self, widget: Any, ear: asyncio.AbstractEventLoop) -> None:
        self.widget, self.images, self._ear = widget, [], ear
        self.threads: set[threading.Thread] = set()
        self._submit = widget.submit_event
        widget.send, widget.submit_event = self.receive, self.submit
        widget.add_event_handler(lambda event: self.threads.add(threading.current_thread()), "before_draw")

    async def open(self) -> None:
        self.set("_views", 1)
        self.say("resize", width=SIZE[0], height=SIZE[1], pwidth=SIZE[0], pheight=SIZE[1], ratio=1.0)
        # So that it is the page which has the first image drawn.
        await until(lambda: self.widget._rfb_draw_requested)
        self.set("_has_visible_views", True)

    def receive(self, message: dict[str, Any], buffers: list[bytes]) -> None:
        if message["type"] == "framebufferdata":
            self.images.append(np.asarray(Image.open(io.BytesIO(buffers[0])).convert("RGB")).astype(float))
            self.set(
                "_frame_feedback", {"index": message["index"], "timestamp": message["timestamp"], "localtime": 0.0}
            )

    def submit(self, event: dict[str, Any]) -> None:
        self.threads.add(threading.current_thread())
        self._submit(event)

    def set(self, name: str, value: Any) -> None:
        self._ear.call_soon_threadsafe(setattr, self.widget, name, value)

    def say(self, kind: str, **event: Any) -> None:
        message = {"type": kind, "timestamp": 0.0, **event}
        self._ear.call_soon_threadsafe(self.widget._rfb_handle_msg, self.widget, message, [])

    def drag(self) -> None:
        self.say("pointer_down", x=350, y=150, buttons=[1], **POINTER)
        self.say("pointer_move", x=420, y=170, buttons=[1], **POINTER)
        self.say("pointer_up", x=420, y=170, buttons=[], **POINTER)

    async def image_like(self, predicate: Any) -> np.ndarray:
        await until(lambda: self.images and predicate(self.images[-1]))
        return self.images[-1]


async def until(happened: Callable[[], Any]) -> None:
    for _ in range(20 * int(PATIENCE)):
        if happened():
            return
        await asyncio.sleep(0.05)
    raise AssertionError("it did not happen")


async def to_the_end(notebook: Callable[[], Coroutine[Any, Any, None]]) -> None:
    """Run a notebook; what the device is still reading then must not come to a closed event loop."""
    await notebook()
    wait()
    await asyncio.sleep(0)


@contextmanager
def ear() -> Iterator[asyncio.AbstractEventLoop]:
    """An event loop that runs on another thread."""
    loop = asyncio.new_event_loop()
    thread = threading.Thread(target=loop.run_forever)
    thread.start()
    try:
        yield loop
    finally:
        loop.call_soon_threadsafe(loop.stop)
        thread.join()
        loop.close()


def show(image: np.ndarray) -> bool:
    """Whether there is more than the panel."""
    return image.shape == (SIZE[1], SIZE[0], 3) and image[:, 300:].std() > 20.0


def share_changed(image: np.ndarray, before: np.ndarray) -> float:
    return float(np.mean(np.abs(image - before)[:, 300:].max(-1) > 24.0))


def test_a_cell_shows_the_viewer_which_follows_the_pointer(monkeypatch):
    monkeypatch.setattr(backends, "in_notebook", lambda: True)

    async def notebook() -> None:
        widget = an.view("flat-mirror", "environment", size=SIZE)
        assert [float(length.removesuffix("px")) for length in (widget._css_width, widget._css_height)] == [*SIZE]
        page = Page(widget, loop)
        await page.open()
        first = await page.image_like(show)
        page.drag()
        await page.image_like(lambda image: share_changed(image, first) > 0.05)
        assert page.threads == {threading.current_thread()}
        widget.close()
        await until(widget.get_closed)

    with ear() as loop:
        asyncio.run(to_the_end(notebook))


def test_a_viewer_that_nobody_sees_is_let_go_of_and_goes_on_where_it_was(monkeypatch):
    monkeypatch.setattr(backends, "in_notebook", lambda: True)

    async def notebook() -> None:
        widget = an.view("flat-mirror", "environment", size=SIZE)
        assert widget._canvas_context is None
        page = Page(widget, loop)
        await page.open()
        first = await page.image_like(show)
        page.drag()
        await page.image_like(lambda image: share_changed(image, first) > 0.05)
        viewer = weakref.ref(widget._draw_frame.__self__)
        page.set("_views", 0)

        def gone() -> bool:
            gc.collect()
            return viewer() is None

        await until(gone)
        assert widget.get_wgpu_context().get_configuration() is None
        page.images.clear()
        page.say("pointer_leave", x=0, y=0, buttons=[], **POINTER)
        page.set("_views", 1)
        again = await page.image_like(show)
        assert share_changed(again, first) > 0.05
        widget.close()
        page.set("_views", 0)
        page.set("_views", 1)
        await asyncio.sleep(0.3)

    with ear() as loop:
        asyncio.run(to_the_end(notebook))


def test_a_device_that_is_lost_while_nobody_looks_is_replaced(monkeypatch):
    monkeypatch.setattr(backends, "in_notebook", lambda: True)

    async def notebook() -> None:
        widget = an.view("flat-mirror", "environment", size=SIZE)
        page = Page(widget, loop)
        await page.open()
        await page.image_like(show)
        page.set("_views", 0)
        await until(lambda: widget.get_wgpu_context().get_configuration() is None)
        get_device().destroy()
        page.images.clear()
        page.say("pointer_leave", x=0, y=0, buttons=[], **POINTER)
        page.set("_views", 1)
        await page.image_like(show)
        widget.close()
        await asyncio.sleep(0.3)

    with ear() as loop:
        asyncio.run(to_the_end(notebook))


@pytest.mark.parametrize(
    ("module", "stand_in", "expected"),
    [
        ("IPython", SimpleNamespace(get_ipython=lambda: SimpleNamespace(kernel=object())), True),
        ("IPython", SimpleNamespace(get_ipython=lambda: SimpleNamespace()), False),
        ("IPython", SimpleNamespace(get_ipython=lambda: None), False),
        ("marimo", SimpleNamespace(running_in_notebook=lambda: True), True),
        ("marimo", SimpleNamespace(running_in_notebook=lambda: False), False),
    ],
)
def test_kernels_of_jupyter_and_of_marimo_are_notebooks(monkeypatch, module, stand_in, expected):
    monkeypatch.setitem(sys.modules, module, stand_in)
    assert in_notebook() is expected


MODEL = """async (code) => {
  const { default: widget } = await import(URL.createObjectURL(new Blob([code], { type: 'text/javascript' })))
  window.said = []
  window.traits = { _css_width: '300px', _css_height: '200px', _resizable: true, _title: '', _cursor: 'default' }
  const model = {
    on: () => {},
    get: (name) => window.traits[name],
    set: (name, value) => { window.traits[name] = value },
    save_changes: () => {},
    send: (event) => window.said.push(event)
  }
  const { initialize, render } = widget()
  window.end = initialize({ model })
  window.leave = ['one', 'two'].map((name) => render({ model, el: document.getElementById(name) }))
}"""

KEYS = """() => {
  window.taken = {}
  const later = (event) => setTimeout(() => { window.taken[event.key] = event.defaultPrevented })
  window.addEventListener('keydown', later, { capture: true })
}"""


@needs_chromium
def test_the_widget_tells_of_its_views_takes_two_fingers_and_keeps_its_keys():
    from playwright.sync_api import sync_playwright

    from anamorph.viewer.backends.widget import Widget

    with sync_playwright() as playwright, chromium(playwright) as browser:
        page = browser.new_page(viewport={"width": 400, "height": 500}, has_touch=True)
        page.set_default_timeout(1000 * PATIENCE)
        page.set_content("<div id=one></div><div id=two></div><button>elsewhere</button>")
        page.add_style_tag(content=str(Widget._css))
        page.evaluate(MODEL, str(Widget._esm))
        assert page.evaluate("traits._views") == 2
        page.evaluate(KEYS)
        page.mouse.click(150, 100)
        page.wait_for_function("document.activeElement.tagName === 'INPUT'")
        page.wait_for_timeout(300)
        for key in ("Tab", "F1", "Control+s", "Control+o", "w"):
            page.keyboard.press(key)
        assert page.evaluate("document.activeElement.tagName") == "INPUT"
        page.wait_for_function("taken.w === false")
        assert {key for key, taken in page.evaluate("taken").items() if taken} == {"Tab", "F1", "s", "o"}
        told = page.evaluate("said.filter((event) => event.type === 'key_down').map((event) => event.key)")
        assert [key for key in told if key != "Control"] == ["Tab", "F1", "s", "o", "w"]
        devices = page.context.new_cdp_session(page)
        fingers = [{"x": 60, "y": 80, "id": 0}, {"x": 200, "y": 120, "id": 1}]
        devices.send("Input.dispatchTouchEvent", {"type": "touchStart", "touchPoints": fingers})
        page.wait_for_function("said.at(-1).ntouches === 2")
        left, right = page.evaluate("Object.values(said.at(-1).touches)")
        place = page.locator("img").first.bounding_box()
        assert (left["x"] + place["x"], left["y"] + place["y"]) == (60, 80)
        assert (right["x"] + place["x"], right["y"] + place["y"]) == (200, 120)
        page.evaluate("leave[0]()")
        assert page.evaluate("traits._views") == 1
        page.evaluate("end()")
        assert page.evaluate("traits._views") == 0


def test_a_camera_given_is_the_eye(monkeypatch):
    shown = []
    monkeypatch.setattr(backends, "show", lambda start, size: shown.append((start, size)))
    eye = an.Camera((0.0, 0.5, 3.0), (0.0, 0.5, 0.0))
    assert an.view("flat-mirror", camera=eye, size=(320, 200)) is None
    assert an.view(an.open_scene("flat-mirror")[0], "raytrace", camera=eye) is None
    assert [start.state.camera for start, _ in shown] == [eye, eye]
    assert [size for _, size in shown] == [(320, 200), (800, 600)]
    assert str(shown[1][0].state.first.method) == "raytrace"
