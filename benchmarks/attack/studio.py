"""Many pages of one studio at once: some ask, some are slow, some leave in mid-solve, some send hostile files and wishes.

Each session loads the page and speaks as its script does. Beside them somebody else opens the page again and again, and asks: who waits
more than 2 s longer than alone is a hang. Lost is who asked and was never told that it is done, and memory that does not come back;
foreign is a fault that the server's log tells of.
"""

from __future__ import annotations

import asyncio
import io
import json
import subprocess
import sys
import tempfile
import time
import uuid
from collections.abc import Callable, Coroutine
from pathlib import Path
from typing import Any
from urllib.parse import urlencode

import numpy as np

from benchmarks.attack.mutators import mutated
from benchmarks.attack.tally import HANG_S, Tally
from benchmarks.studio_latency import free_port, ready
from mcdas_opt.catalogue.data_files import models_folder

_PATIENCE_S = 120.0  # for an answer
_ALONE = 5
_AT_ONCE = 40  # sessions that are open together
_SCRIPT = "<img src=x onerror=alert(1)><script>alert(1)</script>"
_GROWN_KIB = 300_000.0  # more than the first pages leave for good
_HOSTILE: tuple[bytes, ...] = (
    b"a." * 50_000 + b"b=1\n",
    b"[" * 100_000,
    b"x = " + b"9" * 5_000,
    b"\x00" * 7_000_000,
    b'name = "' + _SCRIPT.encode() + b'"\nduration_s = nan\n',
    b"PK\x03\x04" + b"\xff" * 1000,
    b"",
)  # fmt: skip
_WISHES: tuple[Any, ...] = (
    None, [], "x", {"actions": 7}, {"actions": [{"do": _SCRIPT}]}, {"planners": 1e308}, {"planners": [[]]}, {"moment": "x"}, {"token": {}},
    {"moment": 1e308}, {"link": "a" * 100_000}, {"kind": "scene", "name": "../../etc/passwd"}, {"kind": {}, "name": _SCRIPT},
)  # fmt: skip


class _Page:
    """A page as a browser has it: what it may tell the server, and what it is told."""

    def __init__(self, url: str) -> None:
        self.url, self.told = url, asyncio.Queue[dict[str, Any]]()

    async def load(self, http: Any) -> float:
        """Seconds until the page is there."""
        began = time.perf_counter()
        async with http.get(self.url) as answer:
            text = await answer.text()
        took = time.perf_counter() - began
        elements = json.JSONDecoder().raw_decode(text.split("parseElements(String.raw`", 1)[1].replace("&quot;", '"'))[0]
        self._client = text.split("'client_id': '", 1)[1].split("'", 1)[0]
        self.upload = self.url + "/studio/file?page=" + text.split("/studio/file?page=", 1)[1][:32]
        self._listeners: dict[str, tuple[int, str]] = {}
        for number, element in elements.items():
            for event in element.get("events", []):
                self._listeners.setdefault(event["type"], (int(number), event["listener_id"]))
        return took

    async def connect(self) -> None:
        import socketio

        self.line = socketio.AsyncClient(reconnection=False)
        self.line.on("*", self._hear)
        who = {"client_id": self._client, "next_message_id": 0, "implicit_handshake": "true", "tab_id": uuid.uuid4(), "old_tab_id": "null"}
        me = urlencode({**who, "document_id": uuid.uuid4()})
        await self.line.connect(f"{self.url}?{me}", socketio_path="/_nicegui_ws/socket.io", transports=["websocket"], wait_timeout=60)

    async def _hear(self, event: str, message: Any = None, *_: Any) -> None:
        if event == "run_javascript" and '"hear", ' in message["code"]:
            self.told.put_nowait(json.loads(message["code"].split('"hear", ', 1)[1].removesuffix(")"))[0])

    async def tell(self, name: str, wish: Any) -> None:
        number, listener = self._listeners[name]
        await self.line.emit("event", {"id": number, "client_id": self._client, "listener_id": listener, "args": [json.dumps(wish)]})

    async def ask(self, **wish: Any) -> float:
        """Seconds until it is told that all is done."""
        token, began = uuid.uuid4().hex, time.perf_counter()
        await self.tell("ask", {"token": token, "planners": ["closed-form-corrected", "mpc"], "actions": [], **wish})
        async with asyncio.timeout(_PATIENCE_S):
            while (part := await self.told.get()).get("part") != "done" or part.get("token") != token:
                pass
        return time.perf_counter() - began


def _edit(speed_mps: float) -> dict[str, Any]:
    return {"do": "edit", "changes": {"host_speed_mps": speed_mps}}


async def _ordinary(page: _Page, http: Any, r: np.random.Generator) -> None:
    await page.tell("ready", {})
    for _ in range(3):
        await page.ask(actions=[_edit(float(r.uniform(5.0, 30.0)))])
        await asyncio.sleep(float(r.uniform(0.2, 1.0)))


async def _slow(page: _Page, http: Any, r: np.random.Generator) -> None:
    """Sends a file a byte at a time, and reads what it is told as slowly."""

    async def byte_by_byte() -> Any:
        for _ in range(20):
            yield b"a"
            await asyncio.sleep(0.5)

    await page.tell("ready", {})
    async with http.post(page.upload + "&name=x.toml", data=byte_by_byte()) as answer:
        await answer.read()


async def _leaver(page: _Page, http: Any, r: np.random.Generator) -> None:
    await page.tell("ready", {})
    await page.tell("drive" if r.random() < 0.5 else "ask", {"token": "x", "planners": ["mpc"], "actions": []})
    await asyncio.sleep(float(r.uniform(0.0, 0.3)))


async def _hostile(page: _Page, http: Any, r: np.random.Generator) -> None:
    sound = sorted((models_folder() / "scenes").glob("*.toml"))
    files = [*_HOSTILE, *(mutated(sound[int(r.integers(len(sound)))].read_bytes(), r) for _ in range(4))]
    for name, data in zip(
        ("x.toml", "x.json", "x.csv", "x.log", f"{_SCRIPT}.toml", "x", "../x.toml"), r.permutation(len(files)), strict=False
    ):
        async with http.post(page.upload, params={"name": name}, data=io.BytesIO(files[int(data)])) as answer:
            said = await answer.json()
        await page.tell("uploaded", {"name": said.get("name", name)})
    for wish in _WISHES:
        for kind in ("ask", "open", "save", "download"):
            await page.tell(kind, wish)
    await page.ask()


_ROLES: tuple[tuple[Callable[[_Page, Any, np.random.Generator], Coroutine[Any, Any, None]], float], ...] = (
    (_ordinary, 0.6), (_slow, 0.1), (_leaver, 0.2), (_hostile, 0.1),
)  # fmt: skip


def attack(tally: Tally, count: int, seed: int) -> None:
    """So many sessions, `_AT_ONCE` of them together."""
    with tempfile.TemporaryDirectory() as folder, (Path(folder) / "log").open("w+b") as log:
        port = free_port()
        command = [sys.executable, "-m", "mcdas_opt", "studio", "--port", str(port), "--folder", folder, "--no-show"]
        server = subprocess.Popen(command, stdout=log, stderr=subprocess.STDOUT)
        try:
            url = ready(port)
            asyncio.run(_crowd(tally, count, np.random.default_rng(seed), url, server.pid))
        finally:
            server.terminate()
            server.wait(30)
        log.seek(0)
        told = log.read().decode(errors="replace")
        if "Traceback" in told:
            tally.foreign += told.count("Traceback")
            tally.note("the server's log: " + [line for line in told.splitlines() if line and line[0] not in " T"][-1][:200], told[-300:])


async def _crowd(tally: Tally, count: int, r: np.random.Generator, url: str, server: int) -> None:
    import aiohttp

    room, over, alone = asyncio.Semaphore(_AT_ONCE), asyncio.Event(), list[float]()
    async with aiohttp.ClientSession(timeout=aiohttp.ClientTimeout(total=_PATIENCE_S)) as http:
        for k in range(2 * _ALONE):  # at first the planners are being built
            took = await _visit(url, http, *(("closed-form-corrected", "mpc") if k < _ALONE else ()), drives=k == 0)
            alone += [took] if k >= _ALONE else []
        before_kib = _resident_kib(server)
        roles = r.choice(len(_ROLES), count, p=[share for _, share in _ROLES])
        somebody = asyncio.create_task(_somebody_else(tally, url, http, over, max(alone)))
        await asyncio.gather(
            *(_session(tally, _ROLES[int(k)][0], url, http, room, np.random.default_rng(r.integers(2**32))) for k in roles)
        )
        over.set()
        await somebody
        await asyncio.sleep(20.0)  # pages that left are given up after ten
        await _visit(url, http)
        grown_kib = _resident_kib(server) - before_kib
    print(f"studio: alone {max(alone):.2f} s, beside {count} sessions {tally.worst_s:.2f} s; memory {grown_kib:+.0f} KiB", file=sys.stderr)
    if grown_kib > _GROWN_KIB:
        tally.lost += 1
        tally.note("memory that does not come back", f"{grown_kib:.0f} KiB")


async def _session(
    tally: Tally,
    role: Callable[[_Page, Any, np.random.Generator], Coroutine[Any, Any, None]],
    url: str,
    http: Any,
    room: asyncio.Semaphore,
    r: np.random.Generator,
) -> None:
    async with room:
        tally.tried += 1
        page = _Page(url)
        try:
            await page.load(http)
            await page.connect()
            await role(page, http, r)
        except Exception as error:
            tally.lost += 1
            tally.note(f"{role.__name__.strip('_')}: {type(error).__name__}: {str(error)[:80]}", role.__name__)
        else:
            tally.answered += 1
        finally:
            if hasattr(page, "line"):
                await page.line.disconnect()


async def _somebody_else(tally: Tally, url: str, http: Any, over: asyncio.Event, alone_s: float) -> None:
    while not over.is_set():
        began = time.perf_counter()
        try:
            took = await _visit(url, http)
        except TimeoutError:
            took = time.perf_counter() - began
        tally.worst_s = max(tally.worst_s, took)
        if took > alone_s + HANG_S:
            tally.hangs += 1
            tally.note("somebody else waited", f"{took:.1f} s, alone {alone_s:.1f} s")
        await asyncio.sleep(0.5)


async def _visit(url: str, http: Any, *planners: str, drives: bool = False) -> float:
    """Seconds to load the page, have its first scene answered and that with another speed, which nobody has asked for before; by the quick
    planner where no others are named."""
    page, named = _Page(url), list(planners or ("closed-form-corrected",))
    took = await page.load(http)
    await page.connect()
    try:
        took += await page.ask(planners=named)
        if drives:
            await page.tell("drive", {"planners": named, "actions": []})
            while (await page.told.get()).get("part") != "stopped":
                pass
        return took + await page.ask(planners=named, actions=[_edit(5.0 + time.monotonic() % 25.0)])
    finally:
        await page.line.disconnect()


def _resident_kib(process: int) -> float:
    """Of the process and those that it started."""
    own = int(Path(f"/proc/{process}/statm").read_text("utf-8").split()[1]) * 4.0
    tasks = Path(f"/proc/{process}/task")
    children = {int(child) for task in tasks.iterdir() for child in (task / "children").read_text("utf-8").split()}
    return own + sum(_resident_kib(child) for child in children)
