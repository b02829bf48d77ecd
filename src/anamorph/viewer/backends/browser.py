"""The viewer as a page in a browser on this machine."""

from __future__ import annotations

import asyncio
import json
import signal
import socket
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from html import escape
from importlib.resources import files
from typing import Any

import uvicorn
from rendercanvas import http
from rendercanvas.http import HttpRenderCanvas, asgi, loop

from anamorph.base.errors import AnamorphError
from anamorph.viewer.application import Viewer
from anamorph.viewer.backends.gate import Content, Gate
from anamorph.viewer.backends.stream import LONGEST_MESSAGE, bounded
from anamorph.viewer.fluency import MOST_IMAGES
from anamorph.viewer.starting import Start

SIGNALS = (signal.SIGINT, signal.SIGTERM)

SCRIPTS = {"page.js": "text/javascript", "input.js": "text/javascript", "page.css": "text/css"}


def serve(start: Start, port: int, size: tuple[int, int], announce: Callable[[str], object]) -> None:
    """Serve the viewer to browsers on this machine, until the process is interrupted.

    Parameters
    ----------
    start : Start
    port : int
        0 for any that is free.
    size : (width, height)
        Of the image until a browser tells its own.
    announce : callable
        Is given the link.

    Raises
    ------
    AnamorphError
        When the port cannot be had.
    """
    with _listen(port) as listener:
        canvas = HttpRenderCanvas(max_fps=MOST_IMAGES, vsync=False)
        canvas._size_info.set_physical_size(*size, 1.0)
        viewer = Viewer(canvas, start, loop.call_later)
        stream = bounded(_drawing, lambda: viewer.frames)
        gate = Gate(stream, listener.getsockname()[1], _contents(viewer))
        config = uvicorn.Config(
            gate,
            http="h11",
            ws="websockets-sansio",
            lifespan="on",
            log_level="warning",
            access_log=False,
            proxy_headers=False,
            server_header=False,
            timeout_graceful_shutdown=1,
            ws_max_size=LONGEST_MESSAGE,
            # What is sent has been compressed as an image.
            ws_per_message_deflate=False,
        )
        announce(gate.link)
        # The server hands on the signal that has ended it, and here it has done its work.
        with _handlers(lambda *_: None):
            uvicorn.Server(config).run([listener])
        viewer.close()
        canvas.close()


def _listen(port: int) -> socket.socket:
    try:
        return socket.create_server(("127.0.0.1", port))
    except OSError as error:
        reason = (error.strerror or str(error)).lower()
        raise AnamorphError(f"--port {port}: {reason}; choose another, or 0 for any that is free") from error


def _contents(viewer: Viewer) -> dict[str, Content]:
    """What is served, by name."""
    contents: dict[str, Content] = {}
    page = files(__package__)
    text = page.joinpath("page.html").read_text()
    contents[""] = "text/html", lambda: text.replace("{title}", escape(viewer.title))
    for name, media in SCRIPTS.items():
        contents[name] = media, page.joinpath(name).read_text
    for name in ("renderview.js", "renderview.css"):
        media, resource = http.resources[name]
        contents[name] = media, partial(str, resource)
    contents["snapshot.json"] = "application/json", lambda: json.dumps(viewer.snapshot(), allow_nan=False)
    return contents


async def _drawing(scope: Any, receive: Any, send: Any) -> None:
    """The canvas's own application, whose loop is started with the server."""
    if scope["type"] == "lifespan":
        # That loop would take over the signals that end the server.
        with _handlers(signal.SIG_DFL):
            loop.kickstart()
            await asyncio.sleep(0.05)
    await asgi(scope, receive, send)


@contextmanager
def _handlers(handler: Any) -> Iterator[None]:
    """While the block runs, signals that end the process go to `handler`."""
    before = {each: signal.signal(each, handler) for each in SIGNALS}
    try:
        yield
    finally:
        for each, kept in before.items():
            signal.signal(each, kept)
