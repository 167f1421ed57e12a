"""One child process that does one task at a time, and is replaced when it hangs or dies."""

from __future__ import annotations

import contextlib
import os
import subprocess
import sys
import threading
from collections.abc import Callable
from typing import Any, cast

from mcdas_opt.evaluation.running.messages import Answer, Ended, Report, Task, read, write

_THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMEXPR_NUM_THREADS", "VECLIB_MAXIMUM_THREADS")


class Worker:
    """One thread gives it tasks, any may close it for good. Waiting for an answer costs nothing.

    The child imports from where this process does, computes in one thread and ends with its parent. A process of its own instead of
    `multiprocessing`: it needs no guarded main module, and a Dask worker, which is a daemon, may have one.
    """

    def __init__(self) -> None:
        self._child: subprocess.Popen[bytes] | None = None
        self._closed = False
        self._starting = threading.Lock()

    def do(self, task: Task, heard: Callable[[Any], Any] = lambda _: None) -> Answer:
        """The task's answer; never raises for what the task does. `heard` says something to what the task reports, and must not raise."""
        child = self._alive()
        if child is None:
            return Answer(Ended.DIED, reason="its worker was closed")
        assert child.stdin is not None
        assert child.stdout is not None
        late = threading.Event()

        def stop() -> None:
            late.set()
            child.kill()

        alarm = threading.Timer(task.limit_s, stop) if task.limit_s is not None else None
        if alarm is not None:
            alarm.daemon = True
            alarm.start()
        try:
            write(child.stdin, (task.function, task.arguments))
            while isinstance(message := read(child.stdout), Report):
                write(child.stdin, heard(message.value))
            return cast(Answer, message)
        except (EOFError, OSError, ValueError):  # ValueError: closed by another thread
            code = child.wait()
            _end(child)
            if late.is_set():
                return Answer(Ended.TOO_LONG, reason=f"stopped after {task.limit_s:g} s")
            return Answer(Ended.DIED, reason=f"its process ended with code {code}")
        finally:
            if alarm is not None:
                alarm.cancel()

    def close(self) -> None:
        with self._starting:
            self._closed = True
        if self._child is not None:
            _end(self._child)

    def _alive(self) -> subprocess.Popen[bytes] | None:
        """The child, a new one where there was none or it has ended; None once closed."""
        with self._starting:
            if self._closed:
                return None
            if self._child is not None and self._child.poll() is None:
                return self._child
            if self._child is not None:
                _end(self._child)
            threads = dict.fromkeys(_THREADS, "1")
            self._child = subprocess.Popen(
                [sys.executable, "-P", "-m", "mcdas_opt.evaluation.running.child"],
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                process_group=0,  # a terminal's Ctrl-C is the parent's affair: it closes its children
                env=os.environ | threads | {"PYTHONPATH": os.pathsep.join(folder or os.getcwd() for folder in sys.path)},
            )
            return self._child


def _end(child: subprocess.Popen[bytes]) -> None:
    child.kill()
    for stream in (child.stdin, child.stdout):
        if stream is not None:
            with contextlib.suppress(OSError):  # unsent bytes for a child that is gone
                stream.close()
    child.wait()
