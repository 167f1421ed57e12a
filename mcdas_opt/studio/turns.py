"""Who is next, where several pages want what does one thing at a time: each page in its turn, however much one of them asks for."""

from __future__ import annotations

import asyncio
from collections import deque
from collections.abc import AsyncIterator, Hashable
from contextlib import asynccontextmanager


class Turns:
    """A page's own work is done in the order in which it was asked for. Belongs to one event loop."""

    def __init__(self) -> None:
        self._taken = False
        self._waiting: dict[Hashable, deque[asyncio.Future[None]]] = {}  # the page that is next comes first

    @asynccontextmanager
    async def turn(self, page: Hashable) -> AsyncIterator[None]:
        """Waits for this page's turn, and holds it."""
        if self._taken:
            await self._wait(page)
        self._taken = True
        try:
            yield
        finally:
            self._pass_on()

    def before(self, page: Hashable) -> int:
        """How many pages have their turn before this one, with the one whose turn it is; 0 for one that does not wait."""
        return list(self._waiting).index(page) + 1 if page in self._waiting else 0

    async def _wait(self, page: Hashable) -> None:
        mine: asyncio.Future[None] = asyncio.get_running_loop().create_future()
        self._waiting.setdefault(page, deque()).append(mine)
        try:
            await mine
        except asyncio.CancelledError:
            if mine.cancelled():
                self._forget(page, mine)
            else:  # given up when its turn had come
                self._pass_on()
            raise

    def _forget(self, page: Hashable, one: asyncio.Future[None]) -> None:
        queue = self._waiting.get(page, deque())
        if one in queue:
            queue.remove(one)
        if not queue:
            self._waiting.pop(page, None)

    def _pass_on(self) -> None:
        while self._waiting:
            page = next(iter(self._waiting))
            queue = self._waiting.pop(page)
            first = queue.popleft()
            if queue:
                self._waiting[page] = queue  # behind everybody else
            if not first.done():  # else it was given up a moment ago
                first.set_result(None)
                return
        self._taken = False
