"""The parking tab of an open page: hears its events, and tells it the parts of answers."""

from __future__ import annotations

from collections.abc import Awaitable, Callable, Mapping
from typing import Any, TypeVar

from mcdas_opt.errors import McdasError
from mcdas_opt.studio.connection import Connection
from mcdas_opt.studio.parking_tab import LIVE, ParkingTab
from mcdas_opt.studio.studio import Studio
from mcdas_opt.studio.turns import waiting, with_signs

T = TypeVar("T")


class ParkingSession:
    """One tab of one page."""

    def __init__(self, studio: Studio, tab: ParkingTab, connection: Connection) -> None:
        self.studio, self.tab, self.tell = studio, tab, connection.tell

    async def ready(self) -> None:
        self.tell(await self.studio.editing.do(self.tab.opened, self))

    async def open(self, wish: Mapping[str, Any]) -> None:
        try:
            opened = self.studio.editing.do(lambda: self.tab.open(str(wish.get("kind")), str(wish.get("name"))), self)
            self.tell(await self._signed("opening", opened))
        except McdasError as error:
            self.tell(self.studio.problem(error))

    async def park(self, wish: Mapping[str, Any]) -> None:
        """While the user drags (`live`) the quick planner answers; else the one that is asked for, the search before the program."""
        planner = str(wish.get("planner"))
        try:
            case = await self._signed("editing", self.studio.editing.do(lambda: self.tab.case(_values(wish)), self))
            self.tell({"part": "place", **self.tab.place(case)})
            for name in (LIVE,) if wish.get("live") else ("search", "nlp") if planner == "nlp" else (planner,):
                self.tell(await self._signed("planning", self.studio.workers.park(case, name, self)))
        except McdasError as error:
            self.tell(self.studio.problem(error))
        finally:
            self.tell({"part": "done", "token": wish.get("token")})

    async def _signed(self, what: str, work: Awaitable[T]) -> T:
        return await with_signs(work, lambda: self.tell(waiting(what, self.studio.before(self))))

    async def save(self, wish: Mapping[str, Any], download: Callable[[str, str], None]) -> None:
        try:
            download(*await self.studio.editing.do(lambda: self.tab.toml(_values(wish)), self))
        except McdasError as error:
            self.tell(self.studio.problem(error))


def _values(wish: Mapping[str, Any]) -> dict[str, object]:
    values = wish.get("values")
    return dict(values) if isinstance(values, Mapping) else {}
