"""What a page that waits is told meanwhile: what for, and how many other pages come first."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable
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
