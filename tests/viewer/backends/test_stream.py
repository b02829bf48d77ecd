"""What a page may send, how far it may fall behind, and that nothing is kept for it without end."""

from __future__ import annotations

import asyncio
import json
from typing import Any

import pytest
from uvicorn.protocols.utils import ClientDisconnected

from anamorph.viewer.backends import stream
from anamorph.viewer.backends.stream import MOST_WAITING, TRY_AGAIN_LATER, bounded

MOVE = json.dumps({"type": "pointer_move", "timestamp": 0.0, "x": 1.0, "y": 1.0})


class Line:
    """A connection over which messages come, and the application at its end, which sends some images first."""

    def __init__(self, *messages: str | bytes, images: int = 0, each_drawn: bool = False) -> None:
        self._coming = [{"type": "websocket.receive", "text" if isinstance(m, str) else "bytes": m} for m in messages]
        self._images, self._each_drawn = images, each_drawn
        self.drawn = 0
        self.heard: list[str] = []
        self.said: list[dict[str, Any]] = []
        self.ended: dict[str, Any] = {}

    async def receive(self) -> dict[str, Any]:
        return self._coming.pop(0) if self._coming else {"type": "websocket.disconnect", "code": 1005}

    async def send(self, message: dict[str, Any]) -> None:
        self.said.append(message)

    async def _inside(self, scope: Any, receive: Any, send: Any) -> None:
        for _ in range(self._images):
            await send({"type": "websocket.send", "text": "{}"})
            await send({"type": "websocket.send", "bytes": b"image"})
        while (message := await receive())["type"] != "websocket.disconnect":
            self.heard.append(message["text"])
            self.drawn += self._each_drawn
        self.ended = message

    def run(self) -> Line:
        application = bounded(self._inside, lambda: self.drawn)
        asyncio.run(application({"type": "websocket"}, self.receive, self.send))
        return self


def confirmed(index: Any) -> str:
    return json.dumps({"type": "_framefeedback", "index": index, "timestamp": 0.0})


def test_a_page_that_sends_on_while_nothing_is_drawn_is_ended():
    line = Line(*[MOVE] * (MOST_WAITING + 10)).run()
    assert len(line.heard) == MOST_WAITING
    assert line.ended["code"] == TRY_AGAIN_LATER
    assert line.said == [{"type": "websocket.close", "code": TRY_AGAIN_LATER}]


def test_so_is_one_whose_messages_mean_nothing():
    line = Line(*["nothing"] * (MOST_WAITING + 1)).run()
    assert (line.heard, line.ended["code"]) == ([], TRY_AGAIN_LATER)


def test_a_page_that_waits_for_images_goes_on():
    line = Line(*[MOVE] * (MOST_WAITING + 10), each_drawn=True).run()
    assert len(line.heard) == MOST_WAITING + 10
    assert line.said == []


def test_images_that_have_not_been_sent_cannot_be_confirmed():
    tried = [0, 1, 2, 3, -1, 10**9, True, 1.0, "1", None, [1], float("nan")]
    line = Line(*map(confirmed, tried), images=2).run()
    assert line.heard == [confirmed(1), confirmed(2)]


@pytest.mark.parametrize(
    "said",
    ["", "[]", "1", "null", "[" * 100_000, b"bytes", "{}"]
    + [json.dumps({"type": kind, "ids": []}) for kind in (1, ["wheel"], "close", "_clients_change")],
)
def test_what_is_no_event_reaches_nobody(said):
    assert Line(said, MOVE).run().heard == [MOVE]


class Stuck(Line):
    """A connection that takes nothing."""

    async def send(self, message: dict[str, Any]) -> None:
        await asyncio.sleep(60.0)
        raise AssertionError("it was waited for")


@pytest.fixture
def impatient(monkeypatch):
    monkeypatch.setattr(stream, "LONGEST_TAKING", 0.01)


def test_a_page_that_takes_nothing_is_ended(impatient):
    with pytest.raises(ClientDisconnected):
        Stuck(images=1).run()


def test_so_is_one_that_sends_on_and_takes_nothing(impatient):
    assert Stuck(*[MOVE] * (MOST_WAITING + 10)).run().ended["code"] == TRY_AGAIN_LATER


def test_requests_that_are_no_pages_pass():
    passed = []

    async def inside(scope: Any, receive: Any, send: Any) -> None:
        passed.append((scope, receive, send))

    asyncio.run(bounded(inside, lambda: 0)({"type": "lifespan"}, 1, 2))
    assert passed == [({"type": "lifespan"}, 1, 2)]
