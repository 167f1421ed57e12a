"""An open page: hears what the browser wishes, and tells it the parts of answers. What travels is plain JSON."""

from __future__ import annotations

import asyncio
import tempfile
from collections.abc import Callable, Hashable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from pathlib import Path
from typing import Any

from mcdas_opt.catalogue.data_files import models_folder
from mcdas_opt.errors import McdasError
from mcdas_opt.plotting.outlook import Outlook
from mcdas_opt.plotting.web import PLANNERS, look_of
from mcdas_opt.studio.connection import Connection
from mcdas_opt.studio.folder import ExistsError, Folder
from mcdas_opt.studio.parking_tab import LIVE, ParkingTab
from mcdas_opt.studio.planner_cache import methods
from mcdas_opt.studio.sandwich_tab import SandwichTab
from mcdas_opt.studio.turns import Turns, waiting, with_signs
from mcdas_opt.studio.worker_pool import StoppedError, WorkerPool


class Studio:
    """Everything that the pages of one server share: the folder, the processes that answer, the sessions of open pages.

    What changes a page's state and takes longer than an answer (files, logs) is done on one thread, a page's after another's.
    """

    def __init__(self, folder: Folder) -> None:
        self.folder = folder
        self.workers = WorkerPool(methods())
        self.thread = ThreadPoolExecutor(max_workers=1, thread_name_prefix="studio")
        self.turns = Turns()  # of that thread
        self.sessions: dict[str, PageSession] = {}
        self._installed: tuple[str, ...] | None = None

    async def warm(self) -> None:
        """Lets the processes start and build their solvers before anybody asks; what every page shows first is answered then."""
        async for _ in self.workers.answer(SandwichTab(self.folder).question(), self.planners({})):
            pass
        await self.installed()

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
        for session in self.sessions.values():
            session.stop()
        self.workers.close()
        self.thread.shutdown(wait=False, cancel_futures=True)

    async def compute(self, work: Callable[[], Any], page: Hashable) -> Any:
        """Runs `work` on the studio's thread, when it is this page's turn."""
        async with self.turns.turn(page):
            return await asyncio.get_running_loop().run_in_executor(self.thread, work)

    async def receive(self, key: str, name: str, body: bytes) -> dict[str, Any]:
        """A file that a page sent, opened in that page's session."""
        session = self.sessions.get(key)
        if session is None:
            return {"error": "this page is no longer known: load it again"}
        with tempfile.TemporaryDirectory(prefix="mcdas-studio-") as folder:
            suffix = Path(name).suffix.lower()
            file = Path(folder) / f"sent{suffix if suffix.isascii() and len(suffix) < 8 else ''}"
            file.write_bytes(body)
            try:
                session.waiting = await self.compute(lambda: session.tab.receive(file, Path(name).name), session)
            except McdasError as error:
                return {"error": self.problem(error)["text"]}
        return {"name": name}


class PageSession:
    """One open page: hears the browser's events, and tells it the parts of answers."""

    def __init__(self, studio: Studio, tab: SandwichTab, connection: Connection) -> None:
        self.studio, self.tab, self.connection, self.tell = studio, tab, connection, connection.tell
        self.waiting: dict[str, Any] | None = None
        self._stopped = False
        self._asking: asyncio.Task[Any] | None = None

    async def ready(self, wish: Mapping[str, Any]) -> None:
        """The page has been drawn: shows what its link holds, else the first scene; and which planners can be built here, once known."""
        told: list[dict[str, Any]] = []
        if wish.get("link"):
            try:
                self.tab.open("link", str(wish["link"]))
            except McdasError as error:
                told.append(self.studio.problem(error))
        for part in (self.tab.opened(), *told):
            self.tell(part)
        with suppress(McdasError):  # else those that were offered stay
            self.tell({"part": "planners", "planners": looks(await self.studio.installed())})

    async def open(self, wish: Mapping[str, Any]) -> None:
        loop = asyncio.get_running_loop()

        def progress(done: int, of: int) -> None:
            if done % 20 == 0:
                loop.call_soon_threadsafe(self.tell, {"part": "progress", "done": done, "of": of})

        opened = self._safely(lambda: self.tab.open(str(wish.get("kind")), str(wish.get("name")), progress), self.tell)
        await with_signs(opened, lambda: self._waits("opening"))
        self.tell({"part": "stopped"})

    def uploaded(self) -> None:
        if self.waiting is not None:
            self.tell(self.waiting)
            self.waiting = None

    async def ask(self, wish: Mapping[str, Any]) -> None:
        """Does what was edited, then answers in parts; the last one, `done`, always comes. Who asks again no longer waits for what was
        asked before: a page that asks on and on keeps nobody else waiting."""
        token = wish.get("token")
        self._ask_no_longer()
        mine = self._asking = asyncio.current_task()
        try:
            self._edit(wish)
            self.tell(self.tab.state())
            question = self.tab.question(wish.get("moment"))
            self.tell({"part": "picture", "name": question.name, **Outlook(question.situation, question.vehicle).document()})
            async for part in self.studio.workers.answer(question, self.studio.planners(wish), self):
                self.tell(part)
        except McdasError as error:
            self.tell(self.studio.problem(error))
        except asyncio.CancelledError:
            if self._asking is mine:  # by somebody else than this page
                raise
        finally:
            self.tell({"part": "done", "token": token})
            self._asking = None if self._asking is mine else self._asking

    def _edit(self, wish: Mapping[str, Any]) -> None:
        """What was edited since the last wish. An edit that makes no scene is told, and changes nothing."""
        actions = wish.get("actions")
        for action in actions if isinstance(actions, list) else []:
            try:
                self.tab.act(action if isinstance(action, Mapping) else {})
            except McdasError as error:
                self.tell(self.studio.problem(error))

    async def drive(self, wish: Mapping[str, Any]) -> None:
        """Drives the closed loop to its end with each of the planners, telling how far it is; `stop` ends it."""
        loop = asyncio.get_running_loop()
        self._stopped = False
        self._edit(wish)
        planners, scene, settings = self.studio.planners(wish), self.tab.at.scene, self.tab.settings

        for number, planner in enumerate(planners):

            def go_on(done: int, of: int, number: int = number) -> bool:
                told = {"part": "progress", "done": number * of + done, "of": len(planners) * of}
                loop.call_soon_threadsafe(self.tell, told)
                return not self._stopped

            try:
                drive = await with_signs(self.studio.workers.drive(scene, planner, settings, go_on, self), lambda: self._waits("driving"))
            except StoppedError:
                break
            except McdasError as error:
                self.tell(self.studio.problem(error))
            else:
                self.tell({"part": "drive", "planner": planner, "drive": drive, "first": number == 0})
        self.tell({"part": "stopped"})

    def stop(self) -> None:
        self._stopped = True

    def leave(self) -> None:
        """The page is no longer there: nobody is to wait for what it asked."""
        self.stop()
        self.connection.close()

    def _ask_no_longer(self) -> None:
        asking, self._asking = self._asking, None
        if asking is not None:
            asking.cancel()

    def _waits(self, what: str) -> None:
        self.tell(waiting(what, max(self.studio.workers.before(self), self.studio.turns.before(self))))

    async def download(self, wish: Mapping[str, Any], download: Callable[[str, str], None]) -> None:
        self._edit(wish)
        await self._safely(self.tab.toml, lambda named: download(*named))

    async def save(self, wish: Mapping[str, Any]) -> None:
        """Writes the scene into the folder; over another one only when that is wished."""
        self._edit(wish)

        def saved(name: str) -> None:
            self.tell({"part": "saved", "name": name, "files": self.tab.data_files()})

        try:
            await self._safely(lambda: self.tab.save(str(wish.get("name")), replace=wish.get("replace") is True), saved)
        except ExistsError as error:
            self.tell({"part": "exists", "text": str(error)})

    async def _safely(self, work: Callable[[], Any], then: Callable[[Any], None]) -> None:
        """`work` on the studio's thread, its outcome to `then`; bad input is told to the page."""
        try:
            then(await self.studio.compute(work, self))
        except ExistsError:
            raise
        except McdasError as error:
            self.tell(self.studio.problem(error))


class ParkingSession:
    """The parking tab of an open page: hears its events, and tells it the parts of answers."""

    def __init__(self, studio: Studio, tab: ParkingTab, connection: Connection) -> None:
        self.studio, self.tab, self.tell = studio, tab, connection.tell

    async def open(self, wish: Mapping[str, Any]) -> None:
        try:
            self.tell(self.tab.open(str(wish.get("kind")), str(wish.get("name"))))
        except McdasError as error:
            self.tell(self.studio.problem(error))

    async def park(self, wish: Mapping[str, Any]) -> None:
        """While the user drags (`live`) the quick planner answers; else the one that is asked for, the search before the program."""
        planner = str(wish.get("planner"))
        try:
            case = self.tab.case(_values(wish))
            self.tell({"part": "place", **self.tab.place(case)})
            for name in (LIVE,) if wish.get("live") else ("search", "nlp") if planner == "nlp" else (planner,):
                parked = self.studio.workers.park(case, name, self)
                self.tell(await with_signs(parked, lambda: self.tell(waiting("planning", self.studio.workers.before(self)))))
        except McdasError as error:
            self.tell(self.studio.problem(error))
        finally:
            self.tell({"part": "done", "token": wish.get("token")})

    async def save(self, wish: Mapping[str, Any], download: Callable[[str, str], None]) -> None:
        try:
            download(*self.tab.toml(_values(wish)))
        except McdasError as error:
            self.tell(self.studio.problem(error))


def looks(names: Sequence[str]) -> list[dict[str, Any]]:
    """Every planner with its look; ours are shown, the others when they are asked for."""
    others = [name for name in names if name not in PLANNERS]
    return [{"name": name, "shown": name in PLANNERS, **look_of(name, others)} for name in names]


def _values(wish: Mapping[str, Any]) -> dict[str, object]:
    values = wish.get("values")
    return dict(values) if isinstance(values, Mapping) else {}
