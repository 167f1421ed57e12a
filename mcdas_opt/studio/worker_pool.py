"""Processes beside the server, each with a planner cache of its own: while one solves, the other has already answered.

A process, not a thread: planners compute in Python, which runs one thread at a time, and a solver belongs to one thread.
"""

from __future__ import annotations

import asyncio
import logging
import traceback
from collections.abc import AsyncIterator, Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import lru_cache
from typing import Any

from mcdas_opt.domain.parking import ParkingCase
from mcdas_opt.errors import McdasError
from mcdas_opt.evaluation.running.messages import Ended, Task
from mcdas_opt.evaluation.running.worker import Worker
from mcdas_opt.studio.parking_tab import LIVE, parked
from mcdas_opt.studio.planner_cache import PlannerCache, Question, installed

_SOLVED = ("mpc",)  # planners of the second worker, which also computes the times to react


class LostWorkerError(McdasError):
    """A process died under its work; another is started for the next question."""

    def __init__(self) -> None:
        super().__init__("a planner's process ended unexpectedly; ask again")


class FaultError(McdasError):
    """A planner broke; the whole story is in the server's log."""

    def __init__(self, story: str) -> None:
        super().__init__(f"a fault of ours: {story.strip().splitlines()[-1]}")
        logging.getLogger(__name__).error(story)


class AwaitedWorker:
    """A worker for coroutines: it does one thing at a time, in the order in which it is asked; its first work starts its process."""

    def __init__(self) -> None:
        self._worker = Worker()
        self._thread = ThreadPoolExecutor(max_workers=1, thread_name_prefix="worker")  # waits for the process

    async def do(self, work: Callable[..., Any], *arguments: Any) -> Any:
        """What `work`, a function of a module, gives in the process.

        Raises `McdasError` as it was told there, `FaultError` or `LostWorkerError`.
        """
        task = Task(_outcome, (work, arguments))
        answer = await asyncio.get_running_loop().run_in_executor(self._thread, self._worker.do, task)
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
    """One worker for the quick planners, one for the solvers, one for parking. Belongs to the server's event loop."""

    def __init__(self, planners: tuple[str, ...]) -> None:
        self.planners = planners
        self._quick, self._solving, self._parking = AwaitedWorker(), AwaitedWorker(), AwaitedWorker()

    async def answer(self, question: Question, planners: Sequence[str]) -> AsyncIterator[dict[str, Any]]:
        """A plan of each of these planners and the times to react, each as soon as it is ready; a part `problem` for one that could not."""
        jobs = [(self._solving if name in _SOLVED else self._quick).do(_plan, name, question) for name in planners]
        pending = {asyncio.ensure_future(job) for job in (*jobs, self._solving.do(_escapes, question))}
        try:
            while pending:
                done, pending = await asyncio.wait(pending, return_when=asyncio.FIRST_COMPLETED)
                for one in done:
                    error = one.exception()
                    if error is not None and not isinstance(error, McdasError):
                        raise error
                    yield {"part": "problem", "text": str(error)} if error is not None else one.result()
        finally:
            for one in pending:
                one.cancel()

    async def park(self, case: ParkingCase, planner: str) -> dict[str, Any]:
        """A planner's answer to a parking case; the quick one does not wait for the others. Raises `McdasError`."""
        answer: dict[str, Any] = await (self._quick if planner == LIVE else self._parking).do(parked, case, planner)
        return answer

    async def installed(self) -> tuple[str, ...]:
        """Those of the planners that can be built here, with what they need installed."""
        found: tuple[str, ...] = await self._parking.do(installed, self.planners)
        return found

    def close(self) -> None:
        for worker in (self._quick, self._solving, self._parking):
            worker.close()


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
    return _own().plan(name, question)


def _escapes(question: Question) -> dict[str, Any]:
    return _own().escapes(question)
