"""The executor on a Dask cluster: each Dask worker drives through a child process of its own, under the same time limit."""

from __future__ import annotations

import threading
from collections.abc import Iterator, Sequence

from mcdas_opt.errors import InputError, of_extra
from mcdas_opt.evaluation.running.messages import Answer, Ended, Task
from mcdas_opt.evaluation.running.worker import Worker

_CONNECT_S = 30.0
_AT_ONCE = 4  # tasks in one message to a worker


class _Held(threading.local):
    worker: Worker | None = None


_held = _Held()


def do_chunk(tasks: Sequence[Task]) -> list[Answer]:
    """On a Dask worker: the tasks one after another, in a child process that the worker's thread keeps."""
    worker = _held.worker = _held.worker or Worker()
    return [worker.do(task) for task in tasks]


class DaskCluster:
    """Whoever is connected to a scheduler. A worker that dies is replaced by the others: its chunk is done again elsewhere.

    Raises `MissingExtraError` without the package, `InputError` where nobody answers at the address or no worker is there.
    """

    def __init__(self, address: str) -> None:
        with of_extra("distributed", "dask"):
            import distributed
        try:
            self._client = distributed.Client(address, timeout=_CONNECT_S, set_as_default=False)
        except (OSError, ValueError, TimeoutError) as error:
            raise InputError("--scheduler", "", address, f"no Dask scheduler answers there: {error}") from None
        try:
            self._client.wait_for_workers(1, timeout=_CONNECT_S)
        except TimeoutError:
            self._client.close()
            raise InputError("--scheduler", "", address, "has no workers") from None

    def run(self, tasks: Sequence[Task]) -> Iterator[tuple[int, Answer]]:
        from distributed import as_completed

        chunks = [list(range(first, min(first + _AT_ONCE, len(tasks)))) for first in range(0, len(tasks), _AT_ONCE)]
        futures = [self._client.submit(do_chunk, [tasks[k] for k in chunk], pure=False) for chunk in chunks]
        places = {future.key: chunk for future, chunk in zip(futures, chunks, strict=True)}
        try:
            for future in as_completed(futures, loop=self._client.loop):
                chunk = places[future.key]
                if future.status == "finished":
                    answers = future.result()
                else:  # its workers died one after another, or what they sent cannot be read
                    answers = [Answer(Ended.DIED, reason=str(future.exception()))] * len(chunk)
                yield from zip(chunk, answers, strict=True)
                future.release()
        finally:
            self._client.cancel(futures)

    def close(self) -> None:
        self._client.close()
