"""Processes beside the server, each with a desk of its own: while one solves, the other has already answered.

A process, not a thread: planners compute in Python, which runs one thread at a time, and a solver belongs to one thread.
"""

from __future__ import annotations

import asyncio
import logging
import multiprocessing
import signal
import traceback
from collections.abc import AsyncIterator, Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from multiprocessing.connection import Connection
from typing import Any

from mcdas_opt.domain.parking import ParkingCase
from mcdas_opt.errors import McdasError
from mcdas_opt.studio.desk import Desk, Question
from mcdas_opt.studio.lot import LIVE, parked

_SOLVED = ("mpc",)  # planners of the second hand, which also computes the ways out


class LostHandError(McdasError):
    """A process died under its work; another is started for the next question."""

    def __init__(self) -> None:
        super().__init__("a planner's process ended unexpectedly; ask again")


class FaultError(McdasError):
    """A planner broke; the whole story is in the server's log."""

    def __init__(self, story: str) -> None:
        super().__init__(f"a fault of ours: {story.strip().splitlines()[-1]}")
        logging.getLogger(__name__).error(story)


class Hand:
    """One process that does one thing at a time, in the order in which it is asked; started by its first work.

    It ends with `close`, and by itself when the server is gone, however that went.
    """

    def __init__(self) -> None:
        self._thread = ThreadPoolExecutor(max_workers=1, thread_name_prefix="hand")  # waits for the process
        self._process: Any = None
        self._line: Connection | None = None
        self._closed = False

    async def do(self, work: Callable[..., Any], *arguments: Any) -> Any:
        """What `work`, a function of a module, gives in the process.

        Raises `McdasError` as it was told there, `FaultError` or `LostHandError`.
        """
        return await asyncio.get_running_loop().run_in_executor(self._thread, self._do, work, arguments)

    def _do(self, work: Callable[..., Any], arguments: tuple[Any, ...]) -> Any:
        line = self._line if self._line is not None and self._process.is_alive() else self._start()
        try:
            line.send((work, arguments))
            outcome, value = line.recv()
        except (EOFError, OSError):
            self._line = None
            raise LostHandError from None
        if outcome == "refused":
            raise McdasError(value)
        if outcome == "fault":
            raise FaultError(value)
        return value

    def _start(self) -> Connection:
        if self._closed:
            raise LostHandError
        spawning = multiprocessing.get_context("spawn")
        self._line, theirs = spawning.Pipe()
        process = spawning.Process(target=_serve, args=(theirs,), daemon=True)
        process.start()
        self._process = process
        theirs.close()
        if self._closed:  # meanwhile, by another thread that found no process yet
            process.terminate()
            raise LostHandError
        return self._line

    def close(self) -> None:
        self._closed = True
        if self._process is not None:
            self._process.terminate()
        self._thread.shutdown(wait=False, cancel_futures=True)


class Hands:
    """One hand for the quick planners, one for the solvers, one for parking. Belongs to the server's event loop."""

    def __init__(self, planners: tuple[str, ...]) -> None:
        self.planners = planners
        self._quick, self._solving, self._parking = Hand(), Hand(), Hand()

    async def answer(self, question: Question, planners: Sequence[str]) -> AsyncIterator[dict[str, Any]]:
        """A plan of each of these planners and the ways out, each as soon as it is ready; a part `problem` for one that could not."""
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

    def close(self) -> None:
        for hand in (self._quick, self._solving, self._parking):
            hand.close()


_desk: list[Desk] = []  # of a hand's process


def _serve(line: Connection) -> None:
    """A hand's whole life: work in, outcome out, until the line is cut. Ctrl-C is the server's affair."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    while True:
        try:
            work, arguments = line.recv()
        except (EOFError, OSError):
            return
        try:
            outcome = ("done", work(*arguments))
        except McdasError as error:
            outcome = ("refused", str(error))
        except Exception:
            outcome = ("fault", traceback.format_exc())
        try:
            line.send(outcome)
        except (BrokenPipeError, OSError):
            return


def _own() -> Desk:
    if not _desk:
        _desk.append(Desk())
    return _desk[0]


def _plan(name: str, question: Question) -> dict[str, Any]:
    return _own().plan(name, question)


def _escapes(question: Question) -> dict[str, Any]:
    return _own().escapes(question)
