"""Pages take turns: who asks for much does not keep others waiting for all of it."""

from __future__ import annotations

import asyncio
from itertools import pairwise
from typing import Any

import numpy as np

from mcdas_opt.studio.turns import Turns


async def _served(wanted: list[str], given_up: set[int]) -> list[str]:
    """Who had a turn, in order, where all of `wanted` wait at once and some give up before their turn."""
    turns, served, started = Turns(), list[str](), asyncio.Event()

    async def work(page: str) -> None:
        async with turns.turn(page):
            await asyncio.sleep(0)
            served.append(page)

    async def first() -> None:
        async with turns.turn("first"):
            started.set()
            await asyncio.sleep(0.01)

    begun = asyncio.create_task(first())
    await started.wait()
    tasks = [asyncio.create_task(work(page)) for page in wanted]
    await asyncio.sleep(0)
    assert turns.before("first") == 0
    for k in given_up:
        tasks[k].cancel()
    await asyncio.wait_for(asyncio.gather(begun, *tasks, return_exceptions=True), timeout=10.0)
    assert turns.before("a") == 0
    async with asyncio.timeout(5.0), turns.turn("last"):  # nothing is held
        pass
    return served


def test_each_page_has_its_turn_before_another_has_two() -> None:
    r = np.random.default_rng(5)
    for _ in range(60):
        wanted = [str(page) for page in r.choice(list("abcde"), int(r.integers(1, 30)))]
        given_up = {int(k) for k in r.integers(len(wanted), size=int(r.integers(0, 6)))}
        served = asyncio.run(_served(wanted, given_up))
        left = [page for k, page in enumerate(wanted) if k not in given_up]
        assert sorted(served) == sorted(left)
        for page in set(left):
            places = [k for k, one in enumerate(served) if one == page]
            for here, there in pairwise(places):
                between = served[here + 1 : there]
                assert len(between) == len(set(between)), "nobody twice while somebody waits"


def test_who_comes_late_is_next_however_much_was_asked_before() -> None:
    async def run() -> tuple[int, list[str]]:
        turns, served = Turns(), list[str]()

        async def work(page: str) -> None:
            async with turns.turn(page):
                await asyncio.sleep(0.001)
                served.append(page)

        tasks: list[asyncio.Task[Any]] = [asyncio.create_task(work("greedy")) for _ in range(50)]
        await asyncio.sleep(0)
        tasks.append(asyncio.create_task(work("visitor")))
        await asyncio.sleep(0)
        before = turns.before("visitor")
        await asyncio.gather(*tasks)
        return before, served

    before, served = asyncio.run(run())
    assert before == 2
    assert served.index("visitor") <= 2


def test_who_gives_up_in_the_moment_of_its_turn_passes_it_on() -> None:
    async def run() -> None:
        turns = Turns()

        async def work(page: str) -> None:
            async with turns.turn(page):
                pass

        async with turns.turn("first"):
            given_up, other = asyncio.create_task(work("a")), asyncio.create_task(work("b"))
            await asyncio.sleep(0)
        given_up.cancel()  # its turn has come, and it does not know yet
        await asyncio.wait_for(other, timeout=5.0)
        await asyncio.wait_for(work("c"), timeout=5.0)

    asyncio.run(run())
