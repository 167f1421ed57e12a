"""How a command is stopped: Ctrl-C, the signal by which service managers end a program, or the one of a terminal that goes away."""

from __future__ import annotations

import signal
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType
from typing import NoReturn

from mcdas_opt.cli.ending import end_here
from mcdas_opt.cli.log import complain

INTERRUPTED = 128 + signal.SIGINT
_ENDED_BY = {signal.SIGTERM: "terminated"} | ({} if sys.platform == "win32" else {signal.SIGHUP: "hung up"})
_AGAIN_S = 0.05  # until it is seen whether the module is loaded


class Stopped:
    """By which signal, as far as one came."""

    def __init__(self) -> None:
        self.by = signal.SIGINT

    def end_by(self, number: int, frame: FrameType | None) -> None:
        """Handles a signal that ends as an interrupt, so that whatever waits for one, or holds one off, does."""
        self.by = signal.Signals(number)
        if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:  # in the background of a shell
            raise KeyboardInterrupt
        signal.raise_signal(signal.SIGINT)

    def end(self, what: str) -> NoReturn:
        """Says what is left, and ends with our own code.

        A KeyboardInterrupt that once left an `exec` of text (every dataclass is born in one) has Python end by the signal, whatever code it
        is asked for later, unless it runs another text.
        """
        complain(f"{_ENDED_BY.get(self.by, 'interrupted')}; {what}")
        exec("")
        sys.exit(128 + self.by)


@contextmanager
def interrupted_between_imports() -> Iterator[None]:
    """Ctrl-C while a command loads a module is raised once it is loaded: modules of others may swallow what is raised in them.

    Only in the main thread of a POSIX system, and where the handler is Python's own, or the one before a command.
    """
    handler = signal.getsignal(signal.SIGINT)
    if (
        sys.platform == "win32"
        or threading.current_thread() is not threading.main_thread()
        or handler not in (signal.default_int_handler, end_here)
    ):
        yield
        return
    before = signal.signal(signal.SIGALRM, _again)
    signal.signal(signal.SIGINT, _pressed)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGINT, handler)
        signal.signal(signal.SIGALRM, before)


def _pressed(number: int, frame: FrameType | None) -> None:
    if sys.platform != "win32" and _loads(frame):
        signal.setitimer(signal.ITIMER_REAL, _AGAIN_S)
    else:
        raise KeyboardInterrupt


def _again(number: int, frame: FrameType | None) -> None:
    signal.raise_signal(signal.SIGINT)  # which may be held now


def _loads(frame: FrameType | None) -> bool:
    """Whether what is interrupted is done for an import."""
    while frame is not None:
        if frame.f_code.co_filename.startswith("<frozen importlib"):
            return True
        frame = frame.f_back
    return False


@contextmanager
def ended_as_interrupted() -> Iterator[Stopped]:
    """SIGTERM and SIGHUP stop a command as Ctrl-C does; only in the main thread, and where nobody else handles or ignores them."""
    stopped, handled = Stopped(), []
    if threading.current_thread() is threading.main_thread():
        handled = [number for number in _ENDED_BY if signal.getsignal(number) is signal.SIG_DFL]
    for number in handled:
        signal.signal(number, stopped.end_by)
    try:
        yield stopped
    finally:
        for number in handled:
            signal.signal(number, signal.SIG_DFL)
