"""Processes beside the server, each with a planner cache of its own: while one solves, the other has already answered.

A process, not a thread: planners compute in Python, which runs one thread at a time, and a solver belongs to one thread.
"""

from __future__ import annotations

import asyncio
import logging
import os
import pickle
import sys
import time
import traceback
from collections import OrderedDict
from collections.abc import AsyncIterator, Awaitable, Callable, Hashable, Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import lru_cache
from pathlib import Path
from typing import Any

from mcdas_opt.catalogue.scenes import Scene
from mcdas_opt.domain.parking import ParkingCase
from mcdas_opt.domain.settings import Settings
from mcdas_opt.errors import McdasError
from mcdas_opt.evaluation.running.messages import Ended, Task, report
from mcdas_opt.evaluation.running.worker import Worker
from mcdas_opt.plotting.player import drive_document
from mcdas_opt.plotting.web import look_of
from mcdas_opt.simulation.loop import simulate
from mcdas_opt.studio.folder import Folder
from mcdas_opt.studio.parking_tab import LIVE, parked
from mcdas_opt.studio.planner_cache import PlannerCache, Question, installed
from mcdas_opt.studio.sandwich_tab import Looked, SandwichTab
from mcdas_opt.studio.turns import EVERY_S, Turns, waiting

_KEPT = 200
_SOLVED = ("mpc",)  # planners of the second worker
_TIMES = "times to react"
_REPORT_S = 0.1  # between two reports of how far a drive or a recording is


class KeptAnswers:
    """Of a planner, or another function of a question, by its name. A question is known by what it is sent to a process as."""

    def __init__(self, kept: int = _KEPT) -> None:
        self._most = kept
        self._answers: OrderedDict[tuple[str, bytes], Any] = OrderedDict()

    async def of(self, name: str, question: Any, work: Callable[[], Awaitable[Any]]) -> Any:
        """The answer that was kept, else what `work` gives; where that raises nothing is kept."""
        key = name, pickle.dumps(question)
        if key not in self._answers:
            self._answers[key] = await work()
        self._answers.move_to_end(key)
        answer = self._answers[key]
        while len(self._answers) > self._most:
            self._answers.popitem(last=False)
        return answer


class LostWorkerError(McdasError):
    """A process died under its work; another is started for the next question."""

    def __init__(self) -> None:
        super().__init__("a planner's process ended unexpectedly; ask again")


class FaultError(McdasError):
    """A planner broke; the whole story is in the server's log."""

    def __init__(self, story: str) -> None:
        super().__init__(f"a fault of ours: {story.strip().splitlines()[-1]}")
        logging.getLogger(__name__).error(story)


class StoppedError(McdasError):
    """Nobody wants the drive any longer."""


class AwaitedWorker:
    """A worker for coroutines: it does one thing at a time, a page's after another's; its first work starts its process."""

    def __init__(self) -> None:
        self._worker = Worker()
        self.turns = Turns()
        self._thread = ThreadPoolExecutor(max_workers=1, thread_name_prefix="worker")  # waits for the process

    async def do(
        self, work: Callable[..., Any], *arguments: Any, page: Hashable = None, heard: Callable[[Any], Any] = lambda _: None
    ) -> Any:
        """What `work`, a function of a module, gives in the process, when it is this page's turn.

        `heard`, on another thread, says something to what it reports. Raises `McdasError` as it was told there, `FaultError` or
        `LostWorkerError`.
        """
        task = Task(_outcome, (work, arguments))
        async with self.turns.turn(page):
            answer = await asyncio.get_running_loop().run_in_executor(self._thread, self._worker.do, task, heard)
        if answer.ended is Ended.DIED:
            raise LostWorkerError
        kind, value = answer.value if answer.ended is Ended.RETURNED else ("fault", answer.reason)
        if kind == "refused":
            raise McdasError(value)
        if kind == "fault":
            raise FaultError(value)
        return value

    def close(self) -> None:
        self._thread.shutdown(wait=False, cancel_futures=True)
        self._worker.close()


class WorkerPool:
    """One worker for the quick planners, one for the solvers, one for drives, one for parking, one for recordings. Belongs to the server's
    event loop."""

    def __init__(self, planners: tuple[str, ...]) -> None:
        self.planners = planners
        self._kept = KeptAnswers()
        self._workers = tuple(AwaitedWorker() for _ in range(5))
        self._quick, self._solving, self._driving, self._parking, self._reading = self._workers

    async def answer(self, question: Question, planners: Sequence[str], page: Hashable = None) -> AsyncIterator[dict[str, Any]]:
        """A plan of each of these planners and the times to react, each as soon as it is ready; a part `problem` for one that could not,
        a part `waiting` every so often."""

        async def planned(name: str) -> Any:
            worker = self._solving if name in _SOLVED else self._quick
            return await self._kept.of(name, question, lambda: worker.do(_plan, name, question, page=page))

        async def times() -> Any:
            return await self._kept.of(_TIMES, question, lambda: self._quick.do(_escapes, question, page=page))

        named = {asyncio.ensure_future(planned(name)): look_of(name, planners)["label"] for name in planners}
        named[asyncio.ensure_future(times())] = _TIMES
        pending = set(named)
        try:
            while pending:
                done, pending = await asyncio.wait(pending, timeout=EVERY_S, return_when=asyncio.FIRST_COMPLETED)
                if not done:
                    yield waiting(f"planning: {', '.join(name for one, name in named.items() if one in pending)}", self.before(page))
                for one in done:
                    error = one.exception()
                    if error is not None and not isinstance(error, McdasError):
                        raise error
                    yield {"part": "problem", "text": str(error)} if error is not None else one.result()
        finally:
            for one in pending:
                one.cancel()

    def before(self, page: Hashable) -> int:
        """How many other pages come first, where this one waits for several workers at the one with the most."""
        return max(worker.turns.before(page) for worker in self._workers)

    async def drive(
        self, scene: Scene, planner: str, settings: Settings, go_on: Callable[[int, int], bool], page: Hashable = None
    ) -> dict[str, Any]:
        """The closed loop to its end, as the script plays it. `go_on`, on another thread, hears how far it is and says whether to drive on.

        Raises `McdasError`, a `StoppedError` where it said no.
        """
        drive: dict[str, Any] = await _until_stopped(self._driving, go_on, page, _drive, scene, planner, settings)
        return drive

    async def read(
        self, folder: Folder, kind: str, name: str, go_on: Callable[[int, int], bool], page: Hashable = None, sent: Path | None = None
    ) -> Looked:
        """A recording or a benchmark's table of the folder, or one that was `sent`. Raises as `drive` does."""
        found: Looked = await _until_stopped(self._reading, go_on, page, _read, folder, kind, name, sent)
        return found

    async def park(self, case: ParkingCase, planner: str, page: Hashable = None) -> dict[str, Any]:
        """A planner's answer to a parking case; the quick one does not wait for the others. Raises `McdasError`."""
        worker = self._quick if planner == LIVE else self._parking
        answer: dict[str, Any] = await worker.do(_park, case, planner, page=page)
        return answer

    async def installed(self) -> tuple[str, ...]:
        """Those of the planners that can be built here, with what they need installed."""
        found: tuple[str, ...] = await self._parking.do(installed, self.planners)
        return found

    def close(self) -> None:
        for worker in self._workers:
            worker.close()


async def _until_stopped(
    worker: AwaitedWorker, go_on: Callable[[int, int], bool], page: Hashable, work: Callable[..., Any], *arguments: Any
) -> Any:
    stopped = False

    def heard(turns: tuple[int, int]) -> bool:
        nonlocal stopped
        stopped = not go_on(*turns)
        return not stopped

    try:
        return await worker.do(work, *arguments, page=page, heard=heard)
    except McdasError:
        if stopped:
            raise StoppedError from None
        raise


def _outcome(work: Callable[..., Any], arguments: tuple[Any, ...]) -> tuple[str, Any]:
    """In the worker's process: what came of it, in a form that travels."""
    try:
        return "done", work(*arguments)
    except McdasError as error:
        return "refused", str(error)
    except Exception:
        return "fault", traceback.format_exc()


@lru_cache(maxsize=1)
def _own() -> PlannerCache:
    """Of a worker's process."""
    return PlannerCache()


def _plan(name: str, question: Question) -> dict[str, Any]:
    if name in _SOLVED:
        _give_way(5)
    return _own().plan(name, question)


def _escapes(question: Question) -> dict[str, Any]:
    return _own().escapes(question)


@lru_cache(maxsize=1)
def _give_way(by: int) -> None:
    """This process gives way to the server and the quick planners; one that drives or reads, to the solvers too."""
    if sys.platform != "win32":
        os.nice(by)


def _drive(scene: Scene, planner: str, settings: Settings) -> dict[str, Any]:
    _give_way(15)
    return drive_document(simulate(scene, planner, settings=settings, progress=_reporting()))


def _park(case: ParkingCase, planner: str) -> dict[str, Any]:
    if planner != LIVE:
        _give_way(5)
    return parked(case, planner)


def _read(folder: Folder, kind: str, name: str, sent: Path | None) -> Looked:
    _give_way(15)
    tab = SandwichTab(folder)
    return tab.read(kind, name, _reporting()) if sent is None else tab.read_sent(sent, name, _reporting())


def _reporting() -> Callable[[int, int], None]:
    """Reports how far the work is, now and then; raises `StoppedError` where nobody wants it any longer."""
    reported_s = time.monotonic()

    def progress(done: int, of: int) -> None:
        nonlocal reported_s
        if time.monotonic() - reported_s < _REPORT_S:
            return
        reported_s = time.monotonic()
        if report((done, of)) is False:
            raise StoppedError

    return progress
