"""The request filter: only this machine's own page gets through, and no more than so many bytes."""

from __future__ import annotations

import asyncio
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from mcdas_opt.studio.request_filter import HOSTS, RequestFilter, foreign

LARGEST = 1000


class Echo:
    """An application that reads its whole body and says how long it was."""

    def __init__(self) -> None:
        self.calls = 0

    async def __call__(self, scope: Any, receive: Any, send: Any) -> None:
        self.calls += 1
        got = 0
        while True:
            message = await receive()
            if message["type"] != "http.request":
                break
            got += len(message.get("body", b""))
            if not message.get("more_body"):
                break
        await send({"type": "http.response.start", "status": 200, "headers": []})
        await send({"type": "http.response.body", "body": str(got).encode()})


def request(pieces: list[bytes], kind: str = "http", path: str = "/", **headers: str) -> tuple[int, list[Any], Echo]:
    """Status, everything sent, and the application behind."""
    sent: list[Any] = []
    echo = Echo()
    left = list(pieces)

    async def receive() -> dict[str, Any]:
        body = left.pop(0) if left else b""
        return {"type": "http.request", "body": body, "more_body": bool(left)}

    async def send(message: Any) -> None:
        sent.append(message)

    raw = [(name.replace("_", "-").encode(), value.encode()) for name, value in headers.items()]
    asyncio.run(RequestFilter(echo, LARGEST)({"type": kind, "path": path, "headers": raw}, receive, send))
    status = next((m["status"] for m in sent if m["type"] == "http.response.start"), 0)
    return status, sent, echo


@given(st.lists(st.binary(max_size=400), max_size=6), st.booleans())
def test_a_body_gets_through_exactly_when_it_is_not_too_large(pieces: list[bytes], announced: bool) -> None:
    size = sum(map(len, pieces))
    headers = {"content_length": str(size)} if announced else {}
    status, sent, _ = request(pieces, host="127.0.0.1:8090", **headers)
    assert status == (200 if size <= LARGEST else 413)
    assert [m["type"] for m in sent] == ["http.response.start", "http.response.body"]
    if status == 200:
        assert sent[1]["body"] == str(size).encode()


def test_an_announced_flood_never_reaches_the_application() -> None:
    status, sent, echo = request([b"x"], host="localhost", content_length=str(50_000_000))
    assert (status, echo.calls) == (413, 0)
    assert b"larger than" in sent[1]["body"]


@given(st.text(max_size=30))
def test_every_other_host_is_foreign(host: str) -> None:
    own = {name + port for name in HOSTS for port in ("", ":8090", ":1", ":")}
    if host.lower() not in own and not host.lower().startswith(tuple(f"{name}:" for name in HOSTS)) and "@" not in host:
        assert foreign(host, None)


@pytest.mark.parametrize("host", ["127.0.0.1", "127.0.0.1:8090", "localhost:9000", "LOCALHOST"])
def test_this_machine_is_not_foreign(host: str) -> None:
    assert foreign(host, None) == ""
    assert foreign(host, f"http://{host}") == ""


@pytest.mark.parametrize(
    ("host", "origin"),
    [
        ("127.0.0.1.evil.com", None),
        ("evil.com:8090", None),
        ("", None),
        ("[::1", None),
        ("127.0.0.1:8090", "http://evil.com"),
        ("127.0.0.1:8090", "http://127.0.0.1:8091"),
        ("127.0.0.1:8090", "null"),
    ],
)
@pytest.mark.parametrize("kind", ["http", "websocket"])
def test_foreign_requests_end_at_the_filter(host: str, origin: str | None, kind: str) -> None:
    headers = {"host": host} | ({} if origin is None else {"origin": origin})
    status, sent, echo = request([], kind, **headers)
    assert echo.calls == 0
    assert status == 403 if kind == "http" else sent[0]["type"] == "websocket.close"


@pytest.mark.parametrize("path", ["/\x00", "/\x1b]0;title\x07", "/a\nb", "/\u202etxt"])
@pytest.mark.parametrize("kind", ["http", "websocket"])
def test_an_address_that_would_command_a_terminal_is_refused(path: str, kind: str) -> None:
    status, sent, echo = request([], kind, path, host="localhost")
    assert echo.calls == 0
    assert status == 400 if kind == "http" else sent[0]["type"] == "websocket.close"


def test_the_page_may_load_nothing_from_elsewhere() -> None:
    _, sent, _ = request([], host="localhost:8090")
    policy = dict(sent[0]["headers"])[b"content-security-policy"].decode()
    assert "default-src 'self'" in policy
    assert "http:" not in policy
    assert "frame-ancestors 'none'" in policy
