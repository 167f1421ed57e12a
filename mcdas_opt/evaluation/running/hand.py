"""One child process that does one task at a time, and is replaced when it hangs or dies."""

from __future__ import annotations

import contextlib
import os
import subprocess
import sys
import threading
from typing import cast

from mcdas_opt.evaluation.running.messages import Answer, Ended, Task, read, write

_THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMEXPR_NUM_THREADS", "VECLIB_MAXIMUM_THREADS")


class Hand:
    """One thread gives it tasks, any may close it. Waiting for an answer costs nothing.

    The child computes in one thread and ends with its parent.
    """

    def __init__(self) -> None:
        self._child: subprocess.Popen[bytes] | None = None

    def do(self, task: Task) -> Answer:
        """The task's answer; never raises for what the task does."""
        child = self._alive()
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
            return cast(Answer, read(child.stdout))
        except (EOFError, OSError, ValueError):  # ValueError: closed by another thread
            code = child.wait()
            self.close()
            if late.is_set():
                return Answer(Ended.TOO_LONG, reason=f"stopped after {task.limit_s:g} s")
            return Answer(Ended.DIED, reason=f"its process ended with code {code}")
        finally:
            if alarm is not None:
                alarm.cancel()

    def close(self) -> None:
        child, self._child = self._child, None
        if child is None:
            return
        child.kill()
        for stream in (child.stdin, child.stdout):
            if stream is not None:
                with contextlib.suppress(OSError):  # unsent bytes for a child that is gone
                    stream.close()
        child.wait()

    def _alive(self) -> subprocess.Popen[bytes]:
        child = self._child  # by a name of its own: `close` may come from another thread
        if child is None or child.poll() is not None:
            self.close()
            child = self._child = subprocess.Popen(
                [sys.executable, "-m", "mcdas_opt.evaluation.running.child"],
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                process_group=0,  # a terminal's Ctrl-C is the parent's affair: it closes its children
                env=os.environ | dict.fromkeys(_THREADS, "1"),
            )
        return child
