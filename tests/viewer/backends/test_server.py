"""Who reaches a viewer that is served, and what happens to it when its browser is slow, gone or back."""

from __future__ import annotations

import asyncio
import http.client
import json
import time
from contextlib import closing
from pathlib import Path
from typing import Any

import pytest
from browser import PATIENCE, Served, served, wait_until
from websockets.asyncio.client import connect
from websockets.exceptions import ConnectionClosed, InvalidStatus

from anamorph.viewer.backends.gate import STREAM, Gate
from anamorph.viewer.backends.stream import MOST_WAITING, TRY_AGAIN_LATER

PORT = 8123
HOST = f"127.0.0.1:{PORT}"


async def _inside(scope: Any, receive: Any, send: Any) -> None:
    await send({"type": "websocket.accept"})


@pytest.fixture
def gate() -> Gate:
    return Gate(_inside, PORT, {"": ("text/html", lambda: "the page"), "snapshot.json": ("text/json", lambda: "{}")})


def ask(gate: Gate, target: str, method: str = "GET", **headers: str) -> tuple[int, dict[str, str], str]:
    """Status, headers and text of a request; headers are given with underscores, and the target in the folder."""
    path, _, query = (target if target.startswith("/") else gate.folder + target).partition("?")
    lines = {"host": HOST, **{name.replace("_", "-"): value for name, value in headers.items()}}
    scope = {
        "type": "http",
        "method": method,
        "path": path,
        "query_string": query.encode(),
        "headers": [(name.encode(), value.encode()) for name, value in lines.items()],
    }
    sent = _spoken(gate, scope)
    answered = {name.decode(): value.decode() for name, value in sent[0]["headers"]}
    return sent[0]["status"], answered, sent[1]["body"].decode()


def stream(gate: Gate, path: str = STREAM, **headers: str) -> bool:
    """Whether a websocket is let in."""
    lines = {"host": HOST, "origin": f"http://{HOST}", **headers}
    scope = {
        "type": "websocket",
        "path": path if path.startswith("/") else gate.folder + path,
        "headers": [(name.encode(), value.encode()) for name, value in lines.items()],
    }
    return _spoken(gate, scope)[0]["type"] == "websocket.accept"


def _spoken(gate: Gate, scope: Any) -> list[dict[str, Any]]:
    sent: list[dict[str, Any]] = []

    async def send(message: dict[str, Any]) -> None:
        sent.append(message)

    asyncio.run(gate(scope, None, send))
    return sent


def admitted(gate: Gate) -> str:
    """The cookie that the link brings."""
    status, headers, _ = ask(gate, gate.link.split(HOST)[1])
    assert (status, headers["location"]) == (303, gate.folder)
    cookie, *attributes = headers["set-cookie"].split("; ")
    assert {"HttpOnly", "SameSite=Strict", f"Path={gate.folder}"} <= set(attributes)
    return cookie


def test_the_link_opens_the_page_for_the_browser_that_had_it_first(gate):
    assert ask(gate, "")[0] == 403
    cookie = admitted(gate)
    assert ask(gate, "", cookie=cookie)[::2] == (200, "the page")
    assert ask(gate, "snapshot.json", cookie=f"other=1; {cookie}")[0] == 200
    again = ask(gate, gate.link.split(HOST)[1])
    assert again[0] == 403
    assert again[2].count("\n") == 1
    assert ask(gate, gate.link.split(HOST)[1], cookie=cookie)[0] == 303


def test_the_cookie_stays_away_from_what_else_is_served_on_this_machine(gate):
    cookie = admitted(gate)
    others = ("/", "/snapshot.json", gate.folder[:-1], f"{gate.folder}../", f"/other{gate.folder}", f"{gate.folder}/")
    assert {ask(gate, path, cookie=cookie)[0] for path in others} == {404}
    assert not stream(gate, cookie=cookie, path=f"/{STREAM}")
    another = Gate(_inside, PORT, {})
    assert len(gate.folder) > 20 and another.folder != gate.folder
    token = gate.link.split("?")[1]
    assert ask(another, f"?{token}")[0] == 403


@pytest.mark.parametrize("token", ["", "x", "%00", "%C3%A9", "A" * 43])
def test_a_wrong_token_opens_nothing_and_spends_nothing(gate, token):
    assert ask(gate, f"?token={token}")[0] == 403
    assert ask(gate, f"?token={token}", method="POST")[0] in (403, 405)
    admitted(gate)


def test_looking_whether_the_page_is_there_does_not_spend_the_token(gate):
    assert ask(gate, gate.link.split(HOST)[1], method="HEAD")[0] == 403
    admitted(gate)


@pytest.mark.parametrize(
    "host", ["evil.example", f"evil.example:{PORT}", "127.0.0.1", "127.0.0.1:80", f"127.0.0.1:{PORT}.evil", ""]
)
def test_a_foreign_name_is_refused_even_with_the_cookie(gate, host):
    cookie = admitted(gate)
    assert ask(gate, "", cookie=cookie, host=host)[0] == 403
    assert not stream(gate, cookie=cookie, host=host, origin=f"http://{host}")


def test_the_token_does_not_work_under_a_foreign_name(gate):
    assert ask(gate, gate.link.split(HOST)[1], host="evil.example")[0] == 403
    admitted(gate)


def test_only_our_page_with_the_cookie_opens_the_stream(gate):
    cookie = admitted(gate)
    assert stream(gate, cookie=cookie)
    assert not stream(gate)
    assert not stream(gate, cookie=cookie[:-1])
    assert not stream(gate, cookie=cookie, path="")
    for origin in ("http://evil.example", f"https://{HOST}", f"http://localhost:{PORT}", "null", ""):
        assert not stream(gate, cookie=cookie, origin=origin)
    assert stream(gate, cookie=cookie, host=f"localhost:{PORT}", origin=f"http://localhost:{PORT}")


def test_every_answer_forbids_caching_framing_and_foreign_content(gate):
    cookie = admitted(gate)
    answers = [ask(gate, ""), ask(gate, "", cookie=cookie), ask(gate, "none", cookie=cookie)]
    assert [status for status, *_ in answers] == [403, 200, 404]
    for _, headers, _ in answers:
        assert headers["cache-control"] == "no-store"
        assert headers["x-frame-options"] == "DENY"
        assert headers["x-content-type-options"] == "nosniff"
        assert "default-src 'none'" in headers["content-security-policy"]
        assert "unsafe" not in headers["content-security-policy"]
    assert ask(gate, "", method="POST", cookie=cookie)[0] == 405
    assert ask(gate, "", method="HEAD", cookie=cookie)[2] == ""


@pytest.fixture(scope="module")
def viewer(tmp_path_factory):
    with served(Path(tmp_path_factory.mktemp("viewer")), "car-mirror", "--size", "160x120") as running:
        yield running
        code, said = running.interrupt()
        assert code == 0
        assert "Traceback" not in said


def get(viewer: Served, target: str, **headers: str) -> tuple[int, Any, bytes]:
    """Status, headers and content of what is asked for beside the page."""
    target = viewer.page.removeprefix(viewer.origin) + target
    with closing(http.client.HTTPConnection("127.0.0.1", viewer.port)) as connection:
        connection.request("GET", target, headers=headers)
        response = connection.getresponse()
        return response.status, response.headers, response.read()


@pytest.fixture(scope="module")
def cookie(viewer: Served) -> str:
    _, headers, _ = get(viewer, viewer.link.removeprefix(viewer.page))
    return headers["set-cookie"].split(";")[0]


def snapshot(viewer: Served, cookie: str) -> dict[str, Any]:
    return json.loads(get(viewer, "snapshot.json", Cookie=cookie)[2])


def opened(viewer: Served, cookie: str) -> Any:
    address = viewer.page.replace("http", "ws") + STREAM
    return connect(address, origin=viewer.origin, additional_headers={"Cookie": cookie})


def resized(width: int, height: int) -> str:
    size = {"width": width, "height": height, "pwidth": width, "pheight": height, "ratio": 1.0}
    return json.dumps({"type": "resize", "timestamp": 0.0, **size})


async def next_image(socket: Any) -> tuple[dict[str, Any], bytes]:
    """What announces an image, and the image."""
    announced: dict[str, Any] = {}
    while True:
        message = await asyncio.wait_for(socket.recv(), PATIENCE)
        if isinstance(message, bytes):
            return announced, message
        announced = json.loads(message)


async def confirm(socket: Any, image: dict[str, Any]) -> None:
    said = {"type": "_framefeedback", "index": image["index"], "timestamp": image["timestamp"], "localtime": 0.0}
    await socket.send(json.dumps(said))


def test_a_live_server_refuses_strangers(viewer, cookie):
    assert get(viewer, "snapshot.json")[0] == 403

    async def knock() -> None:
        with pytest.raises(InvalidStatus):
            await connect(viewer.page.replace("http", "ws") + STREAM, origin=viewer.origin)
        with pytest.raises(InvalidStatus):
            await connect(
                viewer.page.replace("http", "ws") + STREAM,
                origin="http://evil.example",
                additional_headers={"Cookie": cookie},
            )

    asyncio.run(knock())


def test_a_browser_that_confirms_nothing_is_sent_two_images_and_no_more(viewer, cookie):
    async def stare() -> list[dict[str, Any]]:
        images = []
        async with opened(viewer, cookie) as socket:
            for count in range(2):
                await socket.send(resized(160, 120 + count))
                images.append((await next_image(socket))[0])
            for count in range(20):
                await socket.send(resized(160, 130 + count))
            with pytest.raises(TimeoutError):
                await asyncio.wait_for(next_image(socket), 1.0)
            await confirm(socket, images[-1])
            images.append((await next_image(socket))[0])
        return images

    assert [image["index"] for image in asyncio.run(stare())] == [1, 2, 3]


def test_a_page_that_sends_and_confirms_nothing_makes_way_for_the_next(viewer, cookie):
    key = {"timestamp": 0.0, "modifiers": [], "key": "Shift"}
    presses = [json.dumps({**key, "type": kind}) for kind in ("key_down", "key_up")]

    async def flood() -> None:
        async with opened(viewer, cookie) as flooding, opened(viewer, cookie) as waiting:
            with pytest.raises(ConnectionClosed) as closed:
                async with asyncio.timeout(PATIENCE):
                    while True:
                        for said in presses * (MOST_WAITING // 8):
                            await flooding.send(said)
                        await asyncio.sleep(0.01)
            assert closed.value.rcvd.code == TRY_AGAIN_LATER
            await waiting.send(resized(300, 120))
            while snapshot(viewer, cookie)["size"] != [300, 120]:
                await confirm(waiting, (await next_image(waiting))[0])

    asyncio.run(flood())


def test_who_comes_after_a_closed_tab_sees_the_image_in_its_own_size(viewer, cookie):
    async def look(width: int) -> bytes:
        async with opened(viewer, cookie) as socket:
            await socket.send(resized(width, 120))
            while True:
                announced, data = await next_image(socket)
                await confirm(socket, announced)
                if snapshot(viewer, cookie)["size"] == [width, 120]:
                    return data

    assert all(asyncio.run(look(width)) for width in (200, 240))


def test_nothing_is_drawn_while_nobody_looks(viewer, cookie):
    def rests() -> bool:
        before = snapshot(viewer, cookie)["frames"]
        time.sleep(0.5)
        return snapshot(viewer, cookie)["frames"] == before

    wait_until(rests, "an end of the drawing")


def test_what_is_no_event_ends_nothing(viewer, cookie):
    async def babble() -> None:
        async with opened(viewer, cookie) as socket:
            for said in ("", "no json", "[]", "{}", '{"type": 1}', '{"type": "resize"}', '{"type": "pointer_move"}'):
                await socket.send(said)
            await socket.send(b"bytes")
            await socket.send(resized(160, 120))
            await next_image(socket)

    asyncio.run(babble())
    assert snapshot(viewer, cookie)["scene"] == "car-mirror"


def test_a_taken_port_is_told_in_one_line(viewer, capsys):
    from anamorph.cli.commands import main

    assert main(["view", "car-mirror", "--backend", "browser", "--port", str(viewer.port)]) == 2
    said = capsys.readouterr().err
    assert said.startswith(f"anamorph: error: --port {viewer.port}: ")
    assert said.count("\n") == 1
