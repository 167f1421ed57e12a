"""Who may talk to the studio, and how much: the machine's own browser, on the studio's own page, in bounded pieces.

The page listens on 127.0.0.1, but any web page that the same browser shows can send requests there. So every request must name this
machine as its host (a foreign name that resolves to 127.0.0.1 does not), and where it says which page it comes from, that must be the
studio's. The policy sent along forbids the page itself to load anything from elsewhere.
"""

from __future__ import annotations

import json
from collections.abc import Awaitable, Callable, MutableMapping
from typing import Any
from urllib.parse import urlsplit

LARGEST_BODY = 8_000_000  # bytes
HOSTS = ("127.0.0.1", "localhost")
POLICY = "; ".join(
    (
        "default-src 'self'",
        "script-src 'self' 'unsafe-inline' 'unsafe-eval'",
        "style-src 'self' 'unsafe-inline'",
        "img-src 'self' data: blob:",
        "font-src 'self' data:",
        "connect-src 'self' ws://127.0.0.1:* ws://localhost:*",
        "frame-ancestors 'none'",
        "form-action 'self'",
        "base-uri 'self'",
    )
)

Message = MutableMapping[str, Any]
Receive = Callable[[], Awaitable[Message]]
Send = Callable[[Message], Awaitable[None]]
Application = Callable[[MutableMapping[str, Any], Receive, Send], Awaitable[None]]


class RequestFilter:
    """ASGI middleware: refuses foreign hosts and origins (403), addresses with control characters (400), and bodies over
    `largest_body` bytes (413); sends the policy along.
    """

    def __init__(self, app: Application, largest_body: int = LARGEST_BODY) -> None:
        self.app, self.largest_body = app, largest_body

    async def __call__(self, scope: MutableMapping[str, Any], receive: Receive, send: Send) -> None:
        if scope["type"] not in ("http", "websocket"):
            await self.app(scope, receive, send)
            return
        headers = {name.decode("latin-1").lower(): value.decode("latin-1") for name, value in scope["headers"]}
        refusal = foreign(headers.get("host", ""), headers.get("origin"))
        if refusal:
            await self._refuse(scope, send, 403, refusal)
            return
        if not scope["path"].isprintable():
            await self._refuse(scope, send, 400, "an address holds what cannot be printed")  # whoever logs it would command a terminal
            return
        if scope["type"] == "websocket":
            await self.app(scope, receive, send)
            return
        too_much = f"the body is larger than {self.largest_body} bytes"
        announced = headers.get("content-length", "0")
        if not announced.isdigit() or int(announced) > self.largest_body:
            await self._refuse(scope, send, 413, too_much)
            return
        await self._bounded(scope, receive, send, too_much)

    async def _bounded(self, scope: MutableMapping[str, Any], receive: Receive, send: Send, too_much: str) -> None:
        """Counts what arrives, for bodies whose length was not announced."""
        got, begun, over = 0, False, False

        async def counted() -> Message:
            nonlocal got, over
            message = await receive()
            got += len(message.get("body", b""))
            if got > self.largest_body:
                if not begun and not over:
                    await self._refuse(scope, send, 413, too_much)
                over = True
                return {"type": "http.disconnect"}
            return message

        async def answer(message: Message) -> None:
            nonlocal begun
            if over:
                return
            begun = True
            if message["type"] == "http.response.start":
                message["headers"] = [*message["headers"], (b"content-security-policy", POLICY.encode())]
            await send(message)

        try:
            await self.app(scope, counted, answer)
        except Exception:
            if not over:  # an application that was cut off may say so; it has been answered
                raise

    async def _refuse(self, scope: MutableMapping[str, Any], send: Send, status: int, why: str) -> None:
        if scope["type"] == "websocket":
            await send({"type": "websocket.close", "code": 1008, "reason": why})
            return
        body = json.dumps({"error": why}).encode()
        headers = [(b"content-type", b"application/json"), (b"content-length", str(len(body)).encode()), (b"connection", b"close")]
        await send({"type": "http.response.start", "status": status, "headers": headers})
        await send({"type": "http.response.body", "body": body})


def foreign(host: str, origin: str | None) -> str:
    """Why a request with these headers is refused; empty for one that is our own."""
    try:
        name = urlsplit(f"//{host}").hostname
    except ValueError:
        name = None
    if name not in HOSTS:
        return f"the studio answers to {' and '.join(HOSTS)} only, not to {host!r}"
    if origin is not None and origin not in (f"http://{host}", f"https://{host}"):
        return f"a page of {origin!r} may not talk to the studio"
    return ""
