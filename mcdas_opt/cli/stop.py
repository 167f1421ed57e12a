"""How a command is stopped: Ctrl-C, or the signal by which service managers end a program."""

from __future__ import annotations

import signal
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType
from typing import NoReturn

from mcdas_opt.cli.log import complain

INTERRUPTED, TERMINATED = 130, 143
_AGAIN_S = 0.05  # until it is seen whether the module is loaded


class Stopped:
    """By which signal, as far as one came."""

    def __init__(self) -> None:
        self.terminated = False

    def terminate(self, number: int, frame: FrameType | None) -> None:
        """Handles SIGTERM as an interrupt, so that whatever waits for one, or holds one off, does."""
        self.terminated = True
        if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:  # in the background of a shell
            raise KeyboardInterrupt
        signal.raise_signal(signal.SIGINT)

    def end(self, what: str) -> NoReturn:
        """Says what is left, and ends with our own code.

        A KeyboardInterrupt that once left an `exec` of text (every dataclass is born in one) has Python end by the signal, whatever code it
        is asked for later, unless it runs another text.
        """
        complain(f"{'terminated' if self.terminated else 'interrupted'}; {what}")
        exec("")
        sys.exit(TERMINATED if self.terminated else INTERRUPTED)


@contextmanager
def interrupted_between_imports() -> Iterator[None]:
    """Ctrl-C while a command loads a module is raised once it is loaded: modules of others may swallow what is raised in them.

    Only in the main thread of a POSIX system, and where the handler is Python's own.
    """
    if (
        sys.platform == "win32"
        or threading.current_thread() is not threading.main_thread()
        or signal.getsignal(signal.SIGINT) is not signal.default_int_handler
    ):
        yield
        return
    before = signal.signal(signal.SIGALRM, _pressed)
    signal.signal(signal.SIGINT, _pressed)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGINT, signal.default_int_handler)
        signal.signal(signal.SIGALRM, before)


def _pressed(number: int, frame: FrameType | None) -> None:
    if sys.platform != "win32" and _loads(frame):
        signal.setitimer(signal.ITIMER_REAL, _AGAIN_S)
    else:
        raise KeyboardInterrupt


def _loads(frame: FrameType | None) -> bool:
    """Whether what is interrupted is done for an import."""
    while frame is not None:
        if frame.f_code.co_filename.startswith("<frozen importlib"):
            return True
        frame = frame.f_back
    return False


@contextmanager
def terminated_as_interrupted() -> Iterator[Stopped]:
    """SIGTERM stops a command as Ctrl-C does; only in the main thread, and where nobody else handles it."""
    stopped = Stopped()
    if threading.current_thread() is not threading.main_thread() or signal.getsignal(signal.SIGTERM) is not signal.SIG_DFL:
        yield stopped
        return
    signal.signal(signal.SIGTERM, stopped.terminate)
    try:
        yield stopped
    finally:
        signal.signal(signal.SIGTERM, signal.SIG_DFL)
