"""The viewer in a notebook, without one: messages as the page's widget sends them, and the pictures it is sent."""

from __future__ import annotations

import asyncio
import io
from typing import Any

import numpy as np
import pytest
from PIL import Image

import anamorph as an
from anamorph.viewer.backends import choice as backends

pytest.importorskip("anywidget")

SIZE = (480, 320)


class Page:
    """What stands for the browser: it says its size, and confirms the pictures it is sent."""

    def __init__(self, widget: Any) -> None:
        self.widget, self.pictures = widget, []
        widget.send = self.receive
        widget._views, widget._has_visible_views = 1, True
        self.say("resize", width=SIZE[0], height=SIZE[1], pwidth=SIZE[0], pheight=SIZE[1], ratio=1.0)

    def receive(self, message: dict[str, Any], buffers: list[bytes]) -> None:
        if message["type"] == "framebufferdata":
            self.pictures.append(np.asarray(Image.open(io.BytesIO(buffers[0])).convert("RGB")).astype(float))
            feedback = {"index": message["index"], "timestamp": message["timestamp"], "localtime": 0.0}
            asyncio.get_running_loop().call_soon(setattr, self.widget, "_frame_feedback", feedback)

    def say(self, kind: str, **event: Any) -> None:
        self.widget._rfb_handle_msg(self.widget, {"type": kind, "timestamp": 0.0, **event}, [])

    async def picture_like(self, predicate: Any) -> np.ndarray:
        for _ in range(1200):
            if self.pictures and predicate(self.pictures[-1]):
                return self.pictures[-1]
            await asyncio.sleep(0.05)
        raise AssertionError("no such picture came")


def test_a_cell_shows_the_viewer_which_follows_the_pointer(monkeypatch):
    monkeypatch.setattr(backends, "in_notebook", lambda: True)

    async def notebook() -> None:
        widget = an.view("flat-mirror", "environment", size=SIZE)
        assert [float(length.removesuffix("px")) for length in (widget._css_width, widget._css_height)] == [*SIZE]
        page = Page(widget)
        shape = (SIZE[1], SIZE[0], 3)
        first = await page.picture_like(lambda picture: picture.shape == shape and picture[:, 300:].std() > 20.0)
        pointer = {"button": 1, "modifiers": [], "ntouches": 0, "touches": {}}
        page.say("pointer_down", x=350, y=150, buttons=[1], **pointer)
        page.say("pointer_move", x=420, y=170, buttons=[1], **pointer)
        page.say("pointer_up", x=420, y=170, buttons=[], **pointer)
        await page.picture_like(lambda picture: np.mean(np.abs(picture - first)[:, 300:].max(-1) > 24.0) > 0.05)
        widget.close()
        await asyncio.sleep(0.3)
        assert widget.get_closed()

    asyncio.run(notebook())


def test_a_camera_given_is_the_eye(monkeypatch):
    shown = []
    monkeypatch.setattr(backends, "show", lambda beginning, size: shown.append((beginning, size)))
    eye = an.Camera((0.0, 0.5, 3.0), (0.0, 0.5, 0.0))
    assert an.view("flat-mirror", camera=eye, size=(320, 200)) is None
    assert an.view(an.open_scene("flat-mirror")[0], "raytrace", camera=eye) is None
    assert [beginning.state.camera for beginning, _ in shown] == [eye, eye]
    assert [size for _, size in shown] == [(320, 200), (800, 600)]
    assert shown[1][0].state.first.method == "raytrace"
