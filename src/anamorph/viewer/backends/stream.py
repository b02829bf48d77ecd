"""What one page may send and how far it may fall behind, so that nothing that is kept for it grows.

Events wait for the image that shows what they do, and that waits for the page to confirm those before it; what is
told to a page waits until it takes it. A page that does neither is disconnected, and comes anew when it can: behind
others that wait to control the viewer.
"""

from __future__ import annotations

import asyncio
import json
from collections.abc import Callable
from contextlib import suppress
from typing import Any

from uvicorn.protocols.utils import ClientDisconnected

from anamorph.viewer.backends.gate import Application

LONGEST_MESSAGE = 8192
"""From a page, in bytes: an event with ten fingers is one thousand."""

MOST_WAITING = 2000
"""Messages from one page between two images: half a minute of moves, while the slowest image is drawn."""

LONGEST_TAKING = 30.0
"""Seconds in which a page takes what it is sent."""

TRY_AGAIN_LATER = 1013
"""Why a connection is closed, as websockets have it."""

CONFIRMATION = "_framefeedback"
"""What a page says of an image."""


def bounded(inside: Application, drawn: Callable[[], int]) -> Application:
    """An application whose websockets are ended when their pages do not follow.

    Parameters
    ----------
    inside : Application
        Rendercanvas's.
    drawn : callable
        How many images have been drawn: with each, the events that wait have been handled.
    """

    async def application(scope: Any, receive: Any, send: Any) -> None:
        if scope["type"] == "websocket":
            page = _Page(receive, send, drawn)
            await inside(scope, page.receive, page.send)
        else:
            await inside(scope, receive, send)

    return application


class _Page:
    """One connection: `receive` and `send` stand for those of the server."""

    def __init__(self, receive: Any, send: Any, drawn: Callable[[], int]) -> None:
        self._receive, self._send, self._drawn = receive, send, drawn
        self._images = self._waiting = 0
        self._seen = drawn()

    async def receive(self) -> Any:
        """The next message that means something."""
        while True:
            message = await self._receive()
            if message["type"] != "websocket.receive":
                return message
            if self._seen != self._drawn():
                self._seen, self._waiting = self._drawn(), 0
            self._waiting += 1
            if self._waiting > MOST_WAITING:
                # One that takes nothing does not even take this.
                with suppress(ClientDisconnected):
                    await self.send({"type": "websocket.close", "code": TRY_AGAIN_LATER})
                return {"type": "websocket.disconnect", "code": TRY_AGAIN_LATER}
            if self._is_meant(message.get("text") or ""):
                return message

    async def send(self, message: Any) -> None:
        """Send, to a page that takes it."""
        self._images += message.get("bytes") is not None
        try:
            await asyncio.wait_for(self._send(message), LONGEST_TAKING)
        except TimeoutError:
            raise ClientDisconnected from None

    def _is_meant(self, text: str) -> bool:
        """Whether this is an event, or confirms an image that has been sent; others have a meaning inside alone."""
        try:
            said = json.loads(text)
        except (ValueError, RecursionError):
            return False
        kind = said.get("type") if isinstance(said, dict) else None
        if kind == CONFIRMATION:
            return type(said.get("index")) is int and 0 < said["index"] <= self._images
        return isinstance(kind, str) and not kind.startswith("_") and kind != "close"
