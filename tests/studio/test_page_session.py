"""An open page that asks again, or leaves: nobody waits for what it asked before."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("nicegui")

from mcdas_opt.studio.connection import Connection
from mcdas_opt.studio.folder import Folder
from mcdas_opt.studio.page_session import PageSession
from mcdas_opt.studio.sandwich_tab import SandwichTab
from mcdas_opt.studio.studio import Studio


class _Waiting:
    """A worker pool whose answers come when the test says so."""

    planners = ("mpc",)

    def __init__(self) -> None:
        self.asked, self.given_up, self.go = 0, 0, asyncio.Event()

    async def answer(self, question: Any, planners: Any, page: Any) -> AsyncIterator[dict[str, Any]]:
        self.asked += 1
        try:
            await self.go.wait()
        except asyncio.CancelledError:
            self.given_up += 1
            raise
        yield {"part": "plan"}

    def close(self) -> None: ...


async def _asked(folder: Path, *, leaves: bool) -> tuple[int, list[dict[str, Any]]]:
    studio, told = Studio(Folder(root=folder)), list[dict[str, Any]]()
    studio.workers.close()
    pool = _Waiting()
    studio.workers = pool  # type: ignore[assignment]
    connection = Connection(told.append)
    session = PageSession(studio, SandwichTab(studio.folder), connection)
    tasks = []
    for token in range(3):
        tasks.append(asyncio.create_task(connection.serve(session.ask({"token": token}))))
        while pool.asked <= token:
            await asyncio.sleep(0.001)
    if leaves:
        session.leave()
    pool.go.set()
    await asyncio.gather(*tasks)
    studio.close()
    return pool.given_up, told


@pytest.mark.parametrize(("leaves", "given_up", "answered"), [(False, 2, 1), (True, 3, 0)])
def test_the_latest_question_alone_is_answered(leaves: bool, given_up: int, answered: int, tmp_path: Path) -> None:
    dropped, told = asyncio.run(_asked(tmp_path, leaves=leaves))
    assert dropped == given_up
    assert [part["part"] for part in told].count("plan") == answered
    assert [part["token"] for part in told if part["part"] == "done"] == ([0, 1] if leaves else [0, 1, 2])


def test_a_file_is_opened_while_another_page_drives(tmp_path: Path) -> None:
    async def run() -> list[str]:
        studio, told = Studio(Folder(root=tmp_path)), list[str]()
        pages = [PageSession(studio, SandwichTab(studio.folder), Connection(lambda part: told.append(part["part"]))) for _ in range(2)]
        try:
            drive = asyncio.create_task(pages[0].drive({"planners": ["mpc"]}))
            await asyncio.sleep(0.01)
            await pages[1].open({"kind": "shipped", "name": "curved-road"})
            assert not drive.done()
            pages[0].stop()
            await drive
        finally:
            studio.close()
        return told

    told = asyncio.run(run())
    assert told.index("opened") < told.index("stopped")
    assert "drive" not in told, "it was stopped"
