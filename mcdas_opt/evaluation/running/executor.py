"""The seam between a run and whoever does the work: tasks in, numbered answers out as they come."""

from __future__ import annotations

import queue
import threading
from collections.abc import Iterator, Sequence
from typing import Protocol

from mcdas_opt.domain.rules import positive
from mcdas_opt.evaluation.running.hand import Hand
from mcdas_opt.evaluation.running.messages import Answer, Task

_AGAIN_S = 0.2


class Executor(Protocol):
    """Does tasks in any order. What a task does to its process (raise, hang, die) is an answer, never an exception here."""

    def run(self, tasks: Sequence[Task]) -> Iterator[tuple[int, Answer]]:
        """(index of the task, its answer), as they are ready; each task once."""
        ...

    def close(self) -> None: ...


class ProcessPool:
    """`workers` child processes of this one."""

    def __init__(self, workers: int) -> None:
        positive("workers", workers)
        self._hands = [Hand() for _ in range(workers)]

    def run(self, tasks: Sequence[Task]) -> Iterator[tuple[int, Answer]]:
        waiting = iter(enumerate(tasks))
        lock, stopped = threading.Lock(), threading.Event()
        answers: queue.SimpleQueue[tuple[int, Answer]] = queue.SimpleQueue()

        def work(hand: Hand) -> None:
            while not stopped.is_set():
                with lock:
                    index, task = next(waiting, (-1, None))
                if task is None:
                    return
                answers.put((index, hand.do(task)))

        threads = [threading.Thread(target=work, args=(hand,), daemon=True) for hand in self._hands[: len(tasks)]]
        for thread in threads:
            thread.start()
        try:
            for _ in tasks:
                yield answers.get()
        finally:
            stopped.set()
            for thread, hand in zip(threads, self._hands, strict=False):
                while thread.is_alive():  # again, where it was just about to give its task to a new child
                    hand.close()
                    thread.join(_AGAIN_S)

    def close(self) -> None:
        for hand in self._hands:
            hand.close()
