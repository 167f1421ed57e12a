"""Processes beside the server, each with a desk of its own: while one solves, the other has already answered.

A process, not a thread: planners compute in Python, which runs one thread at a time, and a solver belongs to one thread.
"""

from __future__ import annotations

import asyncio
import multiprocessing
import signal
from collections.abc import AsyncIterator
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from typing import Any

from mcdas_opt.domain.parking import ParkingCase
from mcdas_opt.errors import McdasError
from mcdas_opt.studio.desk import Desk, Question
from mcdas_opt.studio.lot import LIVE, parked

_SOLVED = ("mpc",)  # planners of the second process, which also computes the ways out
_desk: list[Desk] = []  # of this process, made by its first question


class LostHandError(McdasError):
    """A process died under its work; another is started for the next question."""

    def __init__(self) -> None:
        super().__init__("a planner's process ended unexpectedly; ask again")


class Hands:
    """Owns the processes, one each for quick planners, for solvers and for parking; each starts with its first question.

    Belongs to the server's event loop.
    """

    def __init__(self, planners: tuple[str, ...]) -> None:
        self.planners = planners
        self._pools = [self._pool() for _ in range(3)]

    def _pool(self) -> ProcessPoolExecutor:
        return ProcessPoolExecutor(max_workers=1, mp_context=multiprocessing.get_context("spawn"), initializer=_ignore_interrupts)

    async def answer(self, question: Question) -> AsyncIterator[dict[str, Any]]:
        """A plan of every planner and the ways out, each as soon as it is ready. Raises `LostHandError`."""
        loop = asyncio.get_running_loop()
        quick, solving, _ = self._pools
        pending = {loop.run_in_executor(solving if name in _SOLVED else quick, _plan, name, question) for name in self.planners}
        pending.add(loop.run_in_executor(solving, _escapes, question))
        try:
            while pending:
                done, pending = await asyncio.wait(pending, return_when=asyncio.FIRST_COMPLETED)
                for one in done:
                    yield one.result()
        except BrokenProcessPool:
            raise self._renewed() from None

    async def park(self, case: ParkingCase, planner: str) -> dict[str, Any]:
        """A planner's answer to a parking case; the quick one does not wait for the others. Raises `LostHandError`."""
        quick, _, parking = self._pools
        try:
            return await asyncio.get_running_loop().run_in_executor(quick if planner == LIVE else parking, parked, case, planner)
        except BrokenProcessPool:
            raise self._renewed() from None

    def _renewed(self) -> LostHandError:
        """New processes for all: which one died is not known."""
        self.close()
        self._pools = [self._pool() for _ in range(3)]
        return LostHandError()

    def close(self) -> None:
        for pool in self._pools:
            pool.shutdown(wait=False, cancel_futures=True)


def _ignore_interrupts() -> None:
    """Ctrl-C ends the server, which ends its hands."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)


def _own() -> Desk:
    if not _desk:
        _desk.append(Desk())
    return _desk[0]


def _plan(name: str, question: Question) -> dict[str, Any]:
    return _own().plan(name, question)


def _escapes(question: Question) -> dict[str, Any]:
    return _own().escapes(question)
