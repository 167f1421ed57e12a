"""Who waits is told what for: nothing is silent for long."""

from __future__ import annotations

import asyncio
import threading
import time
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
from mcdas_opt.studio.turns import EVERY_S, waiting, with_signs


def test_others_are_counted() -> None:
    assert waiting("planning", 0) == {"part": "waiting", "text": "planning"}
    assert waiting("planning", 1)["text"] == "planning; one other page comes first"
    assert waiting("planning", 7)["text"] == "planning; 7 other pages come first"


def test_signs_come_until_the_work_is_done_and_what_it_raises_is_raised() -> None:
    async def run() -> None:
        signs = list[float]()
        assert await with_signs(asyncio.sleep(2.5 * EVERY_S, "done"), lambda: signs.append(time.monotonic())) == "done"
        assert len(signs) == 2
        assert await with_signs(asyncio.sleep(0.0, "at once"), lambda: pytest.fail("no sign is needed")) == "at once"

        async def fails() -> None:
            raise ValueError("of the work")

        with pytest.raises(ValueError, match="of the work"):
            await with_signs(fails(), lambda: None)

    asyncio.run(run())


@pytest.mark.parametrize(
    ("where", "words"),
    [
        ("threads", {"ask": "editing", "open": "opening", "park": "editing"}),
        ("processes", {"ask": "planning: MPC, times to react", "drive": "driving", "log": "opening", "park": "planning"}),
    ],
)
def test_a_page_that_waits_for_others_is_told_so_and_for_what(where: str, words: dict[str, str], tmp_path: Path) -> None:
    async def waits(wish: str) -> list[str]:
        told: list[dict[str, Any]] = []
        studio, busy = Studio(Folder(root=tmp_path)), threading.Event()
        session = PageSession(studio, SandwichTab(studio.folder), Connection(told.append))
        parking = ParkingSession(studio, ParkingTab(studio.folder), Connection(told.append))
        wishes = {
            "ask": lambda: session.ask({"planners": ["mpc"]}),
            "drive": lambda: session.drive({"planners": ["closed-form"]}),
            "open": lambda: session.open({"kind": "shipped", "name": "curved-road"}),
            "log": lambda: session.open({"kind": "log", "name": "none.csv"}),
            "park": lambda: parking.park({"planner": "search", "values": {}}),
        }
        try:
            if where == "threads":
                others = [asyncio.create_task(thread.do(busy.wait, "another page")) for thread in (studio.editing, studio.reading)]
            else:
                workers = studio.workers._workers
                others = [asyncio.create_task(one.do(time.sleep, 3.0 * EVERY_S, page="another page")) for one in workers]
            await asyncio.sleep(0)
            task = asyncio.create_task(wishes[wish]())
            await asyncio.sleep(2.0 * EVERY_S)
            busy.set()
            signs = [part["text"] for part in told if part["part"] == "waiting"]
            await asyncio.gather(task, *others)
        finally:
            busy.set()
            studio.close()
        return signs

    for wish, word in words.items():
        signs = asyncio.run(waits(wish))
        assert signs
        assert all(sign.startswith(word) for sign in signs)
        assert signs[0].endswith("; one other page comes first")
