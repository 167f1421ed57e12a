"""The seam between a run and whoever does the work: tasks in, numbered answers out as they come."""

from __future__ import annotations

import queue
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor, as_completed
from contextlib import contextmanager
from typing import Protocol

from mcdas_opt.domain.rules import within
from mcdas_opt.evaluation.running.messages import Answer, Task
from mcdas_opt.evaluation.running.worker import Worker

_MOST_WORKERS = 1024


class Executor(Protocol):
    """Does tasks in any order. What a task does to its process (raise, hang, die) is an answer, never an exception here."""

    def run(self, tasks: Sequence[Task]) -> Iterator[tuple[int, Answer]]:
        """(index of the task, its answer), as they are ready; each task once."""
        ...

    def close(self) -> None: ...


@contextmanager
def working(workers: int, scheduler: str | None = None) -> Iterator[Executor]:
    """So many child processes here, or the Dask cluster behind the scheduler's address; closed in the end."""
    executor: Executor
    if scheduler is None:
        executor = ProcessPool(workers)
    else:
        from mcdas_opt.evaluation.running.dask_cluster import DaskCluster

        executor = DaskCluster(scheduler)
    try:
        yield executor
    finally:
        executor.close()


class ProcessPool:
    """`workers` child processes of this one, each with a thread that waits for it."""

    def __init__(self, workers: int) -> None:
        within("workers", workers, 1, _MOST_WORKERS)
        self._workers = [Worker() for _ in range(workers)]

    def run(self, tasks: Sequence[Task]) -> Iterator[tuple[int, Answer]]:
        idle: queue.SimpleQueue[Worker] = queue.SimpleQueue()
        for worker in self._workers:
            idle.put(worker)

        def do(task: Task) -> Answer:
            worker = idle.get()
            try:
                return worker.do(task)
            finally:
                idle.put(worker)

        with ThreadPoolExecutor(len(self._workers)) as threads:
            waiting = {threads.submit(do, task): index for index, task in enumerate(tasks)}
            try:
                for future in as_completed(list(waiting)):
                    yield waiting.pop(future), future.result()
            finally:
                if waiting:  # nobody asks for the rest
                    threads.shutdown(wait=False, cancel_futures=True)
                    self.close()
                    self._workers = [Worker() for _ in self._workers]

    def close(self) -> None:
        for worker in self._workers:
            worker.close()
