"""What the pages of one server share."""

from __future__ import annotations

from collections.abc import Hashable, Mapping, Sequence
from dataclasses import asdict
from functools import partial
from typing import Any, NamedTuple

from mcdas_opt.catalogue.data_files import models_folder
from mcdas_opt.errors import McdasError
from mcdas_opt.parking.park import PLANNERS as PARKERS
from mcdas_opt.plotting.web import PLANNERS, in_script, look_of, palette
from mcdas_opt.studio import knobs, parking_tab
from mcdas_opt.studio.folder import Folder
from mcdas_opt.studio.form import form
from mcdas_opt.studio.parking_tab import ParkingTab
from mcdas_opt.studio.planner_cache import methods
from mcdas_opt.studio.sandwich_tab import SandwichTab
from mcdas_opt.studio.turns import TurnedThread
from mcdas_opt.studio.worker_pool import WorkerPool


class Listing(NamedTuple):
    """What can be opened on the two tabs, in groups, and the form that a scene's keys are edited in."""

    scenes: list[dict[str, Any]]
    cases: list[dict[str, Any]]
    form: list[dict[str, Any]]


class Studio:
    """Everything that the pages of one server share: the folder, and the threads and processes that answer.

    The event loop only carries messages. What changes or shows a page's state is done on one thread (`editing`), files are read and
    written on another (`reading`), recordings in a process; each serves a page after another.
    """

    def __init__(self, folder: Folder) -> None:
        self.folder = folder
        self.workers = WorkerPool(methods())
        self.editing, self.reading = TurnedThread("editing"), TurnedThread("reading")
        self._installed: tuple[str, ...] | None = None
        self._setup: tuple[Listing, str] | None = None  # what it was made of, and the text

    async def warm(self) -> None:
        """Lets the processes start and build their solvers before anybody asks; what every page shows first is answered then."""
        async for _ in self.workers.answer(SandwichTab(self.folder).question(), self.planners({})):
            pass
        await self.installed()
        await self.setup(self)

    async def listing(self, page: Hashable) -> Listing:
        """What can be opened. What a file holds is found out a file a turn, and once as long as it stays as it is."""
        for name in await self.reading.do(lambda: self.folder.names(".toml"), page):
            await self.reading.do(partial(self.folder.holds, name), page)

        def listed() -> Listing:
            return Listing(SandwichTab(self.folder).data_files(), ParkingTab(self.folder).data_files(), form(self.folder))

        return await self.reading.do(listed, page)

    async def setup(self, page: Hashable) -> str:
        """What both tabs begin with, to stand inside a script: the same text for every page as long as the same can be opened."""
        listed = await self.listing(page)
        if self._setup is None or self._setup[0] != listed:
            self._setup = listed, _setup(listed, looks(self.planners({})))
        return self._setup[1]

    async def installed(self) -> tuple[str, ...]:
        """The planners that can be built here."""
        if self._installed is None:
            self._installed = await self.workers.installed()
        return self._installed

    def planners(self, wish: Mapping[str, Any]) -> list[str]:
        """Those that the page wishes, as far as they are known; by default ours."""
        wished = wish.get("planners", tuple(PLANNERS))
        return [name for name in self.workers.planners if isinstance(wished, (list, tuple)) and name in wished]

    def problem(self, error: McdasError) -> dict[str, str]:
        """What went wrong, for the page; files are called by their names in their folders."""
        text = str(error)
        for folder in (self.folder.root, models_folder()):
            text = text.replace(f"{folder}/", "")
        return {"part": "problem", "text": text}

    def close(self) -> None:
        self.workers.close()
        self.editing.close()
        self.reading.close()

    def before(self, page: Hashable) -> int:
        """How many other pages come first, where this one waits in several places at the one with the most."""
        return max(self.workers.before(page), self.editing.turns.before(page), self.reading.turns.before(page))


def _setup(listed: Listing, planners: list[dict[str, Any]]) -> str:
    sandwich = {"knobs": [asdict(knob) for knob in knobs.KNOBS], "planners": planners, "files": listed.scenes, "form": listed.form}
    parking = {"knobs": [asdict(knob) for knob in parking_tab.KNOBS], "planners": PARKERS, "files": listed.cases}
    return in_script({"look": palette(), "sandwich": sandwich, "parking": parking})


def looks(names: Sequence[str]) -> list[dict[str, Any]]:
    """Every planner with its look; ours are shown, the others when they are asked for."""
    others = [name for name in names if name not in PLANNERS]
    return [{"name": name, "shown": name in PLANNERS, **look_of(name, others)} for name in names]
