"""Who may look at a viewer that is served: the browser that came with the link first, and nothing that it visits.

Other users of the machine can connect to a port on it, and any page in any browser can send requests there. Hence a
token that is good once, a cookie that scripts cannot read and other sites cannot send, and a check of the names under
which the viewer is asked for, so that no foreign name can be pointed at this machine. Cookies are kept by name and not
by port: whatever else is served on this machine would be sent ours, too, were it not for a folder of which only those
know who have the link.
"""

from __future__ import annotations

import secrets
from collections.abc import Awaitable, Callable, Mapping
from http import HTTPStatus
from typing import Any
from urllib.parse import parse_qs

Application = Callable[[Any, Any, Any], Awaitable[None]]
"""As ASGI has it: scope, receive, send."""

Content = tuple[str, Callable[[], str]]
"""A media type, and what makes the text."""

STREAM = "stream"
"""Where the websocket is, in the folder."""

Headers = Mapping[bytes, list[bytes]]
Answer = tuple[HTTPStatus, str, str, dict[str, str]]
"""Status, media type, text, and further headers."""

_REFUSED = "Open the link that `anamorph view` has printed; it is good for one browser. Start it again for another.\n"


class Gate:
    """An application around another: pages are served here, and only known browsers reach the one inside.

    Parameters
    ----------
    inside : Application
        What answers at `STREAM`.
    port : int
        On which it is served.
    contents : mapping of str to Content
        By name in the folder; the page has none.

    Attributes
    ----------
    folder : str
        The path under which all is served, with a slash at either end.
    link : str
        Opens the page in the browser that follows it first.
    """

    def __init__(self, inside: Application, port: int, contents: Mapping[str, Content]) -> None:
        self._inside = inside
        self._contents = contents
        self._hosts = {f"{name}:{port}".encode() for name in ("127.0.0.1", "localhost")}
        self._token, self._session = secrets.token_urlsafe(32), secrets.token_urlsafe(32)
        self._spent = False
        self._cookie = f"anamorph-{port}"
        self.folder = f"/{secrets.token_urlsafe(16)}/"
        self.link = f"http://127.0.0.1:{port}{self.folder}?token={self._token}"
        self._headers = {
            "Cache-Control": "no-store",
            "Content-Security-Policy": "default-src 'none'; script-src 'self'; style-src 'self'; "
            f"img-src blob: data:; connect-src 'self' blob: ws://127.0.0.1:{port} ws://localhost:{port}; "
            "base-uri 'none'; form-action 'none'; frame-ancestors 'none'",
            "Cross-Origin-Opener-Policy": "same-origin",
            "Cross-Origin-Resource-Policy": "same-origin",
            "Referrer-Policy": "no-referrer",
            "X-Content-Type-Options": "nosniff",
            "X-Frame-Options": "DENY",
        }

    async def __call__(self, scope: Any, receive: Any, send: Any) -> None:
        """Answer one connection."""
        if scope["type"] == "http":
            await self._send(scope["method"], self._answer(scope), send)
        elif scope["type"] == "lifespan" or self._may_stream(scope):
            await self._inside(scope, receive, send)
        else:
            await send({"type": "websocket.close", "code": 1008})

    def _answer(self, scope: Any) -> Answer:
        headers = _by_name(scope)
        known = self._knows(headers)
        given = parse_qs(scope["query_string"].decode("latin-1")).get("token", [])
        if self._host(headers) is None:
            return _said(HTTPStatus.FORBIDDEN)
        if scope["method"] not in ("GET", "HEAD"):
            return _said(HTTPStatus.METHOD_NOT_ALLOWED, Allow="GET, HEAD")
        if scope["path"] == self.folder and given and (known or self._spend(scope["method"], given)):
            cookie = f"{self._cookie}={self._session}; Path={self.folder}; HttpOnly; SameSite=Strict"
            return _said(HTTPStatus.SEE_OTHER, Location=self.folder, **{"Set-Cookie": cookie})
        if not known:
            return _said(HTTPStatus.FORBIDDEN)
        folder, slash, name = scope["path"].rpartition("/")
        if folder + slash != self.folder or name not in self._contents:
            return _said(HTTPStatus.NOT_FOUND)
        media, make = self._contents[name]
        return HTTPStatus.OK, media, make(), {}

    def _spend(self, method: str, given: list[str]) -> bool:
        """Whether the token is given, for the first time; what only looks whether the page is there spends nothing."""
        if self._spent or method != "GET" or not secrets.compare_digest(given[0].encode(), self._token.encode()):
            return False
        self._spent = True
        return True

    def _may_stream(self, scope: Any) -> bool:
        headers = _by_name(scope)
        host = self._host(headers)
        ours = host is not None and headers.get(b"origin") == [b"http://" + host]
        return ours and scope["path"] == self.folder + STREAM and self._knows(headers)

    def _host(self, headers: Headers) -> bytes | None:
        """The name under which we are asked for; None when it is not ours."""
        named = headers.get(b"host", [])
        return named[0] if len(named) == 1 and named[0] in self._hosts else None

    def _knows(self, headers: Headers) -> bool:
        wanted = f"{self._cookie}={self._session}".encode()
        cookies = [each.strip() for line in headers.get(b"cookie", []) for each in line.split(b";")]
        return any([secrets.compare_digest(cookie, wanted) for cookie in cookies])

    async def _send(self, method: str, answer: Answer, send: Any) -> None:
        status, media, text, further = answer
        body = text.encode()
        headers = {"Content-Type": f"{media}; charset=utf-8", "Content-Length": str(len(body))}
        headers |= self._headers | further
        lines = [(name.lower().encode(), value.encode()) for name, value in headers.items()]
        await send({"type": "http.response.start", "status": status.value, "headers": lines})
        await send({"type": "http.response.body", "body": b"" if method == "HEAD" else body})


def _by_name(scope: Any) -> Headers:
    headers: dict[bytes, list[bytes]] = {}
    for name, value in scope["headers"]:
        headers.setdefault(name.lower(), []).append(value)
    return headers


def _said(status: HTTPStatus, **further: str) -> Answer:
    """A line of text for a status without content."""
    text = _REFUSED if status is HTTPStatus.FORBIDDEN else f"{status.phrase}\n"
    return status, "text/plain", text, further
