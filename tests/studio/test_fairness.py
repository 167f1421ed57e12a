"""No page keeps another waiting: what it asks for has limits, is done off the event loop, and a piece at a time."""

from __future__ import annotations

import asyncio
import threading
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("nicegui")

from mcdas_opt.errors import InputError, ParameterError
from mcdas_opt.studio.connection import Connection
from mcdas_opt.studio.edits import WaitingEdits
from mcdas_opt.studio.folder import Folder
from mcdas_opt.studio.page_session import PageSession
from mcdas_opt.studio.sandwich_tab import SandwichTab
from mcdas_opt.studio.share import link_of
from mcdas_opt.studio.studio import Listing, Studio

CARS = [{"s_m": 10.0 * k, "d_m": 0.0, "speed_mps": 10.0} for k in range(1, 100)]
SCENE = {"host": {"speed_mps": 11.0}, "neighbour": CARS}


class Counted(SandwichTab):
    """Remembers what was done to it, and on which threads."""

    def __init__(self, folder: Folder) -> None:
        super().__init__(folder)
        self.done: list[Any] = []
        self.threads: set[int] = set()

    def act(self, action: Any) -> None:
        self.done.append(action)
        self.threads.add(threading.get_ident())
        super().act(action)

    def state(self) -> dict[str, Any]:
        self.threads.add(threading.get_ident())
        return super().state()

    def question(self, moment: object = None) -> Any:
        self.threads.add(threading.get_ident())
        return super().question(moment)


def edit(speed_mps: float, stroke: str | None = None) -> dict[str, Any]:
    return {"do": "edit", "changes": {"neighbour[5].speed_mps": speed_mps}, "stroke": stroke}


class Pages:
    """Two pages of one studio, and what they were told, in order."""

    def __init__(self, folder: Path) -> None:
        self.studio = Studio(Folder(root=folder))
        self.told: list[tuple[str, dict[str, Any]]] = []
        self.sessions = {name: self._session(name) for name in ("greedy", "visitor")}
        self.tab: Any = self.sessions["greedy"].tab
        self.tab.open("link", link_of({"scene": SCENE}))

    def _session(self, name: str) -> PageSession:
        return PageSession(self.studio, Counted(self.studio.folder), Connection(lambda part: self.told.append((name, part))))

    def parts(self, name: str) -> list[str]:
        return [part["part"] for who, part in self.told if who == name]

    def first(self, name: str, part: str) -> int:
        return next(k for k, (who, one) in enumerate(self.told) if (who, one["part"]) == (name, part))


async def _of_a_message(folder: Path, actions: list[dict[str, Any]]) -> Pages:
    """The greedy page sends all of them at once, the visitor asks after it."""
    pages = Pages(folder)
    try:
        wishes = [pages.sessions["greedy"].ask({"actions": actions}), pages.sessions["visitor"].ask({"actions": []})]
        await asyncio.gather(*(asyncio.create_task(wish) for wish in wishes))
    finally:
        pages.studio.close()
    return pages


def test_a_visitor_is_answered_before_a_hundred_edits_are_done(tmp_path: Path) -> None:
    pages = asyncio.run(_of_a_message(tmp_path, [edit(0.1 * k) for k in range(100)]))
    assert len(pages.tab.done) == 100
    assert pages.first("visitor", "picture") < pages.first("greedy", "state")
    assert threading.get_ident() not in pages.tab.threads, "the event loop carries messages and nothing else"


def test_a_thousand_edits_in_one_message_are_refused_in_one_sentence(tmp_path: Path) -> None:
    pages = asyncio.run(_of_a_message(tmp_path, [edit(0.01 * k) for k in range(1000)]))
    problems = [part["text"] for who, part in pages.told if part["part"] == "problem"]
    assert problems == ["actions = 1000: are more edits than the 100 that may wait to be done"]
    assert not pages.tab.done
    assert "done" in pages.parts("greedy")


def test_of_a_drag_only_what_is_shown_is_done(tmp_path: Path) -> None:
    """Every step is a message of its own, sent before the one before is answered."""

    async def run() -> Pages:
        pages = Pages(tmp_path)
        greedy = pages.sessions["greedy"]
        try:
            tasks = []
            for k in range(300):
                tasks.append(asyncio.create_task(greedy.ask({"actions": [edit(0.1 * k, "drag")]})))
                await asyncio.sleep(0)
            await asyncio.gather(*tasks)
        finally:
            pages.studio.close()
        return pages

    pages = asyncio.run(run())
    assert len(pages.tab.done) < 30
    assert pages.tab.at.scene.neighbour[5].speed_mps == pytest.approx(29.9)
    pages.tab.act({"do": "undo"})
    assert pages.tab.at.scene.neighbour[5].speed_mps == 10.0, "a drag is one step"
    assert pages.parts("greedy").count("done") == 300


def test_only_the_same_keys_of_the_same_stroke_are_superseded() -> None:
    def left(*actions: dict[str, Any]) -> int:
        edits = WaitingEdits()
        edits.add(actions)
        return len(edits)

    removed = {"do": "edit", "changes": {"neighbour[0]": None}, "stroke": "a"}
    other = {"do": "edit", "changes": {"road.friction": 0.5}, "stroke": "a"}
    assert left(edit(1.0, "a"), edit(2.0, "a"), edit(3.0, "a")) == 1
    assert left(edit(1.0, "a"), edit(2.0, "b")) == left(edit(1.0), edit(2.0)) == left(edit(1.0, "a"), other) == 2
    assert left(removed, removed) == left({"do": "undo"}, {"do": "undo"}) == left({}, {}) == 2
    assert left(edit(1.0, "a"), {"do": "undo"}, edit(2.0, "a")) == 3


@pytest.mark.parametrize("kind", ["link", "scene"])
def test_a_scene_of_too_many_cars_is_refused_before_it_is_checked(kind: str, tmp_path: Path) -> None:
    tab = SandwichTab(Folder(root=tmp_path))
    cars = [{"s_m": 1e-3 * k, "speed_mps": 10.0} for k in range(1500)]  # which no scene may have
    (tmp_path / "many.toml").write_text("[host]\nspeed_mps = 10.0\n" + "[[neighbour]]\ns_m = 0.0\nspeed_mps = 1.0\n" * 1500)
    name = link_of({"scene": {"host": {"speed_mps": 10.0}, "neighbour": cars}}) if kind == "link" else "many.toml"
    with pytest.raises(InputError, match=r"(shared link|many\.toml): neighbour = 1500: are more cars than the studio's 100"):
        tab.open(kind, name)
    knots = [[1.0 * k, 1e-5] for k in range(8000)]
    with pytest.raises(ParameterError, match=r"scene = \d{6}: is more than the 100000 characters that the studio takes"):
        tab.act({"do": "edit", "changes": {"road.curvature": knots}})
    with pytest.raises(ParameterError, match="more cars"):
        tab.act({"do": "edit", "changes": {"neighbour": cars}})


def test_a_scene_is_opened_while_another_page_opens_a_recording(tmp_path: Path) -> None:
    header = "time_s,sector,id,range_m,azimuth_rad,range_rate_mps\n"
    (tmp_path / "long.csv").write_text(header + "".join(f"{0.05 * k:.2f},front,1,30.0,0.0,0.0\n" for k in range(4000)))
    (tmp_path / "long.host.csv").write_text("time_s,speed_mps\n" + "".join(f"{0.05 * k:.2f},10.0\n" for k in range(4000)))

    async def run() -> Pages:
        pages = Pages(tmp_path)
        try:
            recording = asyncio.create_task(pages.sessions["greedy"].open({"kind": "log", "name": "long.csv"}))
            while "progress" not in pages.parts("greedy"):
                await asyncio.sleep(0.01)
                assert not recording.done(), pages.told
            await pages.sessions["visitor"].open({"kind": "shipped", "name": "curved-road"})
            await pages.sessions["visitor"].ask({"actions": [edit(9.0)], "planners": []})
            await recording
        finally:
            pages.studio.close()
        return pages

    pages = asyncio.run(run())
    assert pages.first("visitor", "done") < pages.first("greedy", "opened")
    assert pages.tab.at.log is not None
    assert len(pages.tab.at.log.cycles) > 1000


def test_a_visitor_is_answered_while_the_files_of_a_folder_are_read_for_another_page(tmp_path: Path) -> None:
    """A file a turn: nobody waits for all of them."""
    for k in range(30):
        (tmp_path / f"{k}.toml").write_text("[host]\nspeed_mps = 10.0\n" + "[[neighbour]]\ns_m = 0.0\nspeed_mps = 1.0\n" * 500)

    async def run() -> tuple[bool, Listing]:
        pages = Pages(tmp_path)
        try:
            listing = asyncio.create_task(pages.studio.listing("greedy"))
            await asyncio.sleep(0)
            await pages.sessions["visitor"].open({"kind": "shipped", "name": "curved-road"})
            before = listing.done()
            return before, await listing
        finally:
            pages.studio.close()

    before, listed = asyncio.run(run())
    assert not before
    assert len(next(group["names"] for group in listed.scenes if group["kind"] == "scene")) == 30


def test_every_page_begins_with_the_same_text_until_the_folder_holds_something_else(tmp_path: Path) -> None:
    async def run() -> tuple[str, str, str]:
        studio = Studio(Folder(root=tmp_path))
        try:
            first, second = await studio.setup("one"), await studio.setup("another")
            (tmp_path / "<script>.toml").write_text("[host]\nspeed_mps = 10.0\n")
            return first, second, await studio.setup("one")
        finally:
            studio.close()

    first, second, third = asyncio.run(run())
    assert first is second
    assert "toml" not in first
    assert "\\u003cscript\\u003e.toml" in third
    assert "<" not in third, "no tag begins or ends in it"
