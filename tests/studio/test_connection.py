"""A page that has left is told nothing any more, and nothing is under way for it."""

from __future__ import annotations

import asyncio
import threading
from collections.abc import Awaitable, Callable
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("nicegui")

from mcdas_opt.studio.connection import Connection
from mcdas_opt.studio.folder import Folder
from mcdas_opt.studio.page_session import PageSession
from mcdas_opt.studio.parking_session import ParkingSession
from mcdas_opt.studio.parking_tab import ParkingTab
from mcdas_opt.studio.sandwich_tab import SandwichTab
from mcdas_opt.studio.studio import Studio


def test_what_is_served_ends_when_the_page_leaves() -> None:
    async def run() -> None:
        told = list[dict[str, Any]]()
        connection = Connection(told.append)
        served = [asyncio.create_task(connection.serve(asyncio.sleep(1000.0))) for _ in range(3)]
        await asyncio.sleep(0)
        connection.tell({"part": 1})
        connection.close()
        connection.tell({"part": 2})
        await asyncio.wait_for(asyncio.gather(*served, connection.serve(asyncio.sleep(1000.0))), timeout=5.0)
        assert told == [{"part": 1}]

    asyncio.run(run())


def test_what_the_server_gives_up_is_given_up() -> None:
    async def run() -> None:
        under_way = list[asyncio.Task[Any]]()

        async def work() -> None:
            task = asyncio.current_task()
            assert task is not None
            under_way.append(task)
            await asyncio.sleep(1000.0)

        served = asyncio.create_task(Connection(lambda part: None).serve(work()))
        await asyncio.sleep(0.01)
        served.cancel()
        with pytest.raises(asyncio.CancelledError):
            await served
        await asyncio.wait(under_way, timeout=5.0)
        assert under_way[0].cancelled()

    asyncio.run(run())


Wished = Callable[[PageSession, ParkingSession, Callable[[str, str], None]], Awaitable[None]]


@pytest.mark.parametrize(
    "wished",
    [
        lambda session, parking, download: session.ask({"token": 1, "planners": ["mpc"]}),
        lambda session, parking, download: session.drive({"planners": ["closed-form", "mpc"]}),
        lambda session, parking, download: session.open({"kind": "shipped", "name": "curved-road"}),
        lambda session, parking, download: session.download({}, download),
        lambda session, parking, download: session.save({"name": "x"}),
        lambda session, parking, download: parking.park({"planner": "search", "values": {}}),
    ],
    ids=["ask", "drive", "open", "download", "save", "park"],
)
def test_nothing_is_told_to_a_page_that_left_whatever_it_wished(wished: Wished, tmp_path: Path) -> None:
    """A download that was ready when its page had left was the traceback in the server's log."""

    async def run() -> None:
        left, told, downloaded = False, list[dict[str, Any]](), list[str]()

        def told_late(part: dict[str, Any]) -> None:
            if left:
                told.append(part)

        studio, connection = Studio(Folder(root=tmp_path)), Connection(told_late)
        session = PageSession(studio, SandwichTab(studio.folder), connection)
        parking = ParkingSession(studio, ParkingTab(studio.folder), connection)
        busy = threading.Event()
        try:
            others = [asyncio.create_task(studio.editing.do(busy.wait, "another page"))]
            others += [asyncio.create_task(worker.do(max, 1, 2, page="another page")) for worker in studio.workers._workers]
            await asyncio.sleep(0)
            wish = asyncio.create_task(connection.serve(wished(session, parking, lambda name, text: downloaded.append(name))))
            await asyncio.sleep(0.05)
            session.leave()
            left = True
            busy.set()
            await asyncio.gather(*others)
            await asyncio.wait_for(wish, timeout=5.0)
            await asyncio.wait_for(studio.editing.do(int, "another page"), timeout=5.0)
            assert (told, downloaded) == ([], [])
        finally:
            busy.set()
            studio.close()

    asyncio.run(run())
