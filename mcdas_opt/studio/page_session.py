"""An open page: hears what the browser wishes, and tells it the parts of answers. What travels is plain JSON."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable, Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any, TypeVar

from mcdas_opt.errors import McdasError
from mcdas_opt.plotting.outlook import Outlook
from mcdas_opt.studio.connection import Connection
from mcdas_opt.studio.edits import WaitingEdits
from mcdas_opt.studio.folder import ExistsError
from mcdas_opt.studio.planner_cache import Question
from mcdas_opt.studio.sandwich_tab import Looked, SandwichTab
from mcdas_opt.studio.studio import Studio, looks
from mcdas_opt.studio.turns import waiting, with_signs
from mcdas_opt.studio.worker_pool import StoppedError

_LONG = ("log", "shipped-log", "results")  # what takes long to open
T = TypeVar("T")


class PageSession:
    """One open page: hears the browser's events, and tells it the parts of answers."""

    def __init__(self, studio: Studio, tab: SandwichTab, connection: Connection) -> None:
        self.studio, self.tab, self.connection, self.tell = studio, tab, connection, connection.tell
        self.waiting: dict[str, Any] | None = None
        self._stopped = False
        self._asking: asyncio.Task[Any] | None = None
        self._edits = WaitingEdits()

    async def ready(self, wish: Mapping[str, Any]) -> None:
        """The page has been drawn: shows what its link holds, else the first scene; and which planners can be built here, once known."""
        told: list[dict[str, Any]] = []
        if wish.get("link"):
            try:
                await self._look(await self._read("link", str(wish["link"])))
            except McdasError as error:
                told.append(self.studio.problem(error))
        for part in (self.tab.opened(), *told):
            self.tell(part)
        with suppress(McdasError):  # else those that were offered stay
            self.tell({"part": "planners", "planners": looks(await self.studio.installed())})

    async def open(self, wish: Mapping[str, Any]) -> None:
        async def opened() -> dict[str, Any]:
            return await self._look(await self._read(str(wish.get("kind")), str(wish.get("name"))))

        await with_signs(self._safely(opened(), self.tell), lambda: self._waits("opening"))
        self.tell({"part": "stopped"})

    async def sent(self, file: Path, name: str) -> dict[str, Any]:
        """Opens a file that the page sent. Raises `McdasError`."""
        if name.lower().endswith(".toml"):
            return await self._look(await self.studio.reading.do(lambda: self.tab.read_sent(file, name), self))
        return await self._look(await self.studio.workers.read(self.studio.folder, "", name, self._progress(), self, file))

    async def _read(self, kind: str, name: str) -> Looked:
        if kind in _LONG:
            return await self.studio.workers.read(self.studio.folder, kind, name, self._progress(), self)
        return await self.studio.reading.do(lambda: self.tab.read(kind, name), self)

    async def _look(self, at: Looked) -> dict[str, Any]:
        return await self.studio.editing.do(lambda: self.tab.look(at), self)

    def _progress(self, before: int = 0, parts: int = 1) -> Callable[[int, int], bool]:
        """Tells the page how far work on another thread is, after `before` of so many parts; false once it has left."""
        loop = asyncio.get_running_loop()

        def go_on(done: int, of: int) -> bool:
            loop.call_soon_threadsafe(self.tell, {"part": "progress", "done": before * of + done, "of": parts * of})
            return self.connection.open

        return go_on

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
            self._note(wish)
            question = await with_signs(self._shown(wish.get("moment")), lambda: self._waits("editing"))
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

    async def _shown(self, moment: object) -> Question:
        """Tells the state and the picture after the edits; the question that is then to be answered."""
        await self._edit()
        self.tell(await self.studio.editing.do(self.tab.state, self))

        def pictured() -> tuple[Question, dict[str, Any]]:
            question = self.tab.question(moment)
            return question, Outlook(question.situation, question.vehicle).document()

        question, picture = await self.studio.editing.do(pictured, self)
        self.tell({"part": "picture", "name": question.name, **picture})
        return question

    def _note(self, wish: Mapping[str, Any]) -> None:
        """What was edited since the last wish, to be done before anything else; too much of it is told, and not done."""
        actions = wish.get("actions")
        try:
            self._edits.add(actions if isinstance(actions, list) else [])
        except McdasError as error:
            self.tell(self.studio.problem(error))

    async def _edit(self, wish: Mapping[str, Any] | None = None) -> None:
        """Does what was noted, an edit a turn; whoever is waited for no longer leaves the rest to the next wish."""
        self._note(wish or {})
        loop = asyncio.get_running_loop()

        def one() -> None:
            action = self._edits.take()
            try:
                if action is not None:
                    self.tab.act(action)
            except McdasError as error:  # makes no scene, and changes nothing
                loop.call_soon_threadsafe(self.tell, self.studio.problem(error))

        while self._edits:
            await self.studio.editing.do(one, self)

    async def drive(self, wish: Mapping[str, Any]) -> None:
        """Drives the closed loop to its end with each of the planners, telling how far it is; `stop` ends it."""
        self._stopped = False
        await self._edit(wish)
        planners, scene, settings = self.studio.planners(wish), self.tab.at.scene, self.tab.settings

        for number, planner in enumerate(planners):
            progress = self._progress(number, len(planners))

            def go_on(done: int, of: int, progress: Callable[[int, int], bool] = progress) -> bool:
                return progress(done, of) and not self._stopped

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
        self.tell(waiting(what, self.studio.before(self)))

    async def download(self, wish: Mapping[str, Any], download: Callable[[str, str], None]) -> None:
        await self._edit(wish)
        await self._safely(self.studio.editing.do(self.tab.toml, self), lambda named: download(*named))

    async def save(self, wish: Mapping[str, Any]) -> None:
        """Writes the scene into the folder; over another one only when that is wished."""
        await self._edit(wish)

        async def saved() -> dict[str, Any]:
            name = await self.studio.editing.do(lambda: self.tab.save(str(wish.get("name")), replace=wish.get("replace") is True), self)
            return {"part": "saved", "name": name, "files": (await self.studio.listing(self)).scenes}

        try:
            await self._safely(saved(), self.tell)
        except ExistsError as error:
            self.tell({"part": "exists", "text": str(error)})

    async def _safely(self, work: Awaitable[T], then: Callable[[T], None]) -> None:
        """The outcome of `work` to `then`; bad input is told to the page."""
        try:
            then(await work)
        except ExistsError:
            raise
        except McdasError as error:
            self.tell(self.studio.problem(error))
