"""Who is next, where several pages want what does one thing at a time: each page in its turn, however much one of them asks for.

And what a page that waits is told meanwhile.
"""

from __future__ import annotations

import asyncio
from collections import deque
from collections.abc import AsyncIterator, Awaitable, Callable, Hashable
from concurrent.futures import ThreadPoolExecutor
from contextlib import asynccontextmanager
from typing import Any, TypeVar

T = TypeVar("T")

EVERY_S = 0.5


def waiting(what: str, before: int) -> dict[str, Any]:
    """The part of an answer that says so."""
    others = "" if not before else "; one other page comes first" if before == 1 else f"; {before} other pages come first"
    return {"part": "waiting", "text": f"{what}{others}"}


async def with_signs(work: Awaitable[T], sign: Callable[[], None]) -> T:
    """What `work` gives; `sign` is called every so often until then."""
    task = asyncio.ensure_future(work)
    try:
        while not (await asyncio.wait({task}, timeout=EVERY_S))[0]:
            sign()
        return task.result()
    finally:
        task.cancel()


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


class TurnedThread:
    """A thread for coroutines: it does one thing at a time, a page's after another's."""

    def __init__(self, name: str) -> None:
        self.turns = Turns()
        self._thread = ThreadPoolExecutor(max_workers=1, thread_name_prefix=name)

    async def do(self, work: Callable[[], T], page: Hashable) -> T:
        """What `work` gives, when it is this page's turn; once begun it is done to its end, whether it is still waited for or not."""
        async with self.turns.turn(page):
            return await asyncio.get_running_loop().run_in_executor(self._thread, work)

    def close(self) -> None:
        self._thread.shutdown(wait=False, cancel_futures=True)
