"""The way to an open page: what it is told, and what is under way for it."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable
from typing import Any

Tell = Callable[[dict[str, Any]], None]


class Connection:
    """A page that has left is told nothing any more, and what was under way for it is given up. Belongs to the server's event loop."""

    def __init__(self, send: Tell) -> None:
        self._send = send
        self._under_way: set[asyncio.Task[Any]] = set()
        self.open = True

    def tell(self, part: dict[str, Any]) -> None:
        if self.open:
            self._send(part)

    async def serve(self, work: Awaitable[None]) -> None:
        """`work`, until the page leaves."""
        task = asyncio.ensure_future(work)
        self._under_way.add(task)
        task.add_done_callback(self._under_way.discard)
        if not self.open:
            task.cancel()
        try:
            await task
        except asyncio.CancelledError:
            task.cancel()  # where it was the server that gave it up
            if self.open:
                raise

    def close(self) -> None:
        self.open = False
        for task in tuple(self._under_way):
            task.cancel()
