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
from mcdas_opt.studio.page_session import PageSession, ParkingSession, Studio
from mcdas_opt.studio.parking_tab import ParkingTab
from mcdas_opt.studio.sandwich_tab import SandwichTab
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


def test_a_page_that_waits_for_others_is_told_so_and_for_what(tmp_path: Path) -> None:
    async def run() -> dict[str, list[str]]:
        told: dict[str, list[dict[str, Any]]] = {"sandwich": [], "parking": []}
        studio = Studio(Folder(root=tmp_path))
        session = PageSession(studio, SandwichTab(studio.folder), Connection(told["sandwich"].append))
        parking = ParkingSession(studio, ParkingTab(studio.folder), Connection(told["parking"].append))
        busy, signs = threading.Event(), dict[str, list[str]]()
        try:
            others = [asyncio.create_task(studio.compute(busy.wait, "another page"))]
            others += [asyncio.create_task(one.do(time.sleep, 3.0 * EVERY_S, page="another page")) for one in studio.workers._workers]
            await asyncio.sleep(0)
            wishes = {
                "ask": session.ask({"planners": ["mpc"]}),
                "drive": session.drive({"planners": ["closed-form"]}),
                "open": session.open({"kind": "shipped", "name": "curved-road"}),
                "park": parking.park({"planner": "search", "values": {}}),
            }
            tasks = {name: asyncio.create_task(wish) for name, wish in wishes.items()}
            await asyncio.sleep(2.0 * EVERY_S)
            busy.set()
            for name, word in (("ask", "planning: MPC, times to react"), ("drive", "driving"), ("open", "opening"), ("park", "planning")):
                heard = told["parking" if name == "park" else "sandwich"]
                signs[name] = [part["text"] for part in heard if part["part"] == "waiting" and part["text"].startswith(word)]
            await asyncio.gather(*tasks.values(), *others)
        finally:
            busy.set()
            studio.close()
        return signs

    for signs in asyncio.run(run()).values():
        assert signs
        assert signs[0].endswith("; one other page comes first")
