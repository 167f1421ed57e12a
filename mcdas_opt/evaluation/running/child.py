"""The child process: reads tasks from stdin, answers on what was stdout. `python -m mcdas_opt.evaluation.running.child`."""

from __future__ import annotations

import os
import queue
import sys
import threading
from typing import Any

from mcdas_opt.evaluation.running.messages import Answer, Ended, Report, read, tell_by, write


def main() -> None:
    """Serves until stdin ends: then the parent has gone, and whatever is being worked on is of use to nobody."""
    tasks: queue.SimpleQueue[Any] = queue.SimpleQueue()
    answers = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)  # what a planner or a solver prints must not get between the answers

    def listen() -> None:
        while True:
            try:
                tasks.put(read(sys.stdin.buffer))
            except (EOFError, OSError):
                os._exit(0)
            except Exception as error:  # a task that cannot be unpickled here
                tasks.put(error)

    def told(value: Any) -> Any:
        write(answers, Report(value))
        return tasks.get()

    tell_by(told)
    threading.Thread(target=listen, daemon=True).start()
    while True:
        task = tasks.get()
        try:
            if isinstance(task, Exception):
                raise task
            function, arguments = task
            answer = Answer(Ended.RETURNED, value=function(*arguments))
        except Exception as error:
            answer = Answer(Ended.RAISED, reason=f"{type(error).__name__}: {error}")
        write(answers, answer)


if __name__ == "__main__":
    main()
