"""The commands, one a file: each reads, calls one public function and prints. Heavy packages load inside the command that needs them."""

import contextlib
import os
import signal
from collections.abc import Iterator

_LOST = "mcdas-opt: interrupted; what was not yet written is lost\n"

__all__ = ["main"]


def main() -> None:
    """Entry point of `mcdas-opt` and of `python -m mcdas_opt`."""
    with _ended_by_interrupts():
        from mcdas_opt.cli.app import run

        run()


@contextlib.contextmanager
def _ended_by_interrupts() -> Iterator[None]:
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
    """Handles the signal before there is a command, and after it."""
    os.write(2, _LOST.encode())
    os._exit(130)
