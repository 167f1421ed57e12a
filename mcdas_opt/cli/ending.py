"""Ctrl-C before there is a command, and after it."""

import contextlib
import os
import signal
from collections.abc import Iterator

_LOST = "mcdas-opt: interrupted; what was not yet written is lost\n"


@contextlib.contextmanager
def ended_by_interrupts() -> Iterator[None]:
    """Ctrl-C ends the process here and now, with our line and 130, until a command is told of it: modules that are being loaded may turn
    an exception into another one.

    Only in the main thread, and where the handler is Python's own.
    """
    if signal.getsignal(signal.SIGINT) is not signal.default_int_handler:
        yield
        return
    with contextlib.suppress(ValueError):  # not the main thread
        signal.signal(signal.SIGINT, end_here)
    try:
        yield
    finally:
        with contextlib.suppress(ValueError):
            signal.signal(signal.SIGINT, signal.default_int_handler)


def end_here(number: int, frame: object) -> None:
    """Handles the signal."""
    os.write(2, _LOST.encode())
    os._exit(130)
