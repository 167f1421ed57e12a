"""The three standard streams as a program may find them: closed, full, no longer read, or of an encoding that lacks letters."""

from __future__ import annotations

import contextlib
import errno
import io
import os
import sys
from collections.abc import Iterator

from mcdas_opt.cli.log import complain
from mcdas_opt.errors import InputError

UNREAD = 141  # as SIGPIPE ends a program


def prepare_streams() -> None:
    """Lets no file that is opened later take the place of a closed stream, and writes a letter that the encoding lacks as its number.

    Raises `InputError` where stdout is closed: there is nobody to answer to.
    """
    closed = sys.stdout is None
    if closed or sys.stderr is None or sys.stdin is None:
        while (descriptor := os.open(os.devnull, os.O_RDWR)) <= 2:  # the lowest that is free
            pass
        os.close(descriptor)
    if sys.stderr is None:
        sys.stderr = open(os.devnull, "w", encoding="utf-8")  # noqa: SIM115
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="backslashreplace")
    if closed:
        raise InputError("stdout", "", None, "is closed")


class _Stdout(io.TextIOWrapper):
    """Another face of stdout, which remembers why it could not be written."""

    fault: OSError | None = None

    def write(self, text: str, /) -> int:
        with self._remembered():
            return super().write(text)

    def flush(self) -> None:
        with self._remembered():
            super().flush()

    @contextlib.contextmanager
    def _remembered(self) -> Iterator[None]:
        try:
            yield
        except OSError as error:
            self.fault = error
            raise


@contextlib.contextmanager
def told_where_stdout_ends() -> Iterator[None]:
    """Turns a failure to write stdout, at the latest when it is flushed here, into one line and the exit code 2; where nobody reads it
    any more, into the exit code alone with which SIGPIPE ends a program, whatever else the failure was turned into on its way."""
    given = sys.stdout
    if not isinstance(given, io.TextIOWrapper) or not _is_first(given):  # somebody else's, as in a test
        yield
        return
    stdout = _Stdout(given.buffer, encoding=given.encoding, errors=given.errors, line_buffering=given.line_buffering)
    sys.stdout = stdout
    try:
        try:
            yield
        finally:
            stdout.flush()
    except (OSError, SystemExit):
        if stdout.fault is None:  # another file's
            raise
    finally:
        _to_nowhere_after(stdout.fault)
        with contextlib.suppress(OSError):
            stdout.detach()
        sys.stdout = given
    if stdout.fault is None:
        return
    if stdout.fault.errno == errno.EPIPE:
        sys.exit(UNREAD)
    complain(f"stdout: cannot be written: {stdout.fault.strerror}")
    sys.exit(2)


@contextlib.contextmanager
def said_before_it_is_written() -> Iterator[None]:
    """Says what is said within at once. Where stdout takes it no more, what the command still has to write is written all the same; how
    it ends is for `told_where_stdout_ends`."""
    stdout = sys.stdout
    try:
        yield
        stdout.flush()
    except OSError:
        if not isinstance(stdout, _Stdout) or stdout.fault is None:
            raise
        _to_nowhere_after(stdout.fault)


def _to_nowhere_after(fault: OSError | None) -> None:
    """Lets whatever is still flushed, by Python at its end too, go nowhere."""
    if fault is not None:
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, 1)
        os.close(nowhere)


def _is_first(stream: io.TextIOWrapper) -> bool:
    with contextlib.suppress(OSError):
        return stream.fileno() == 1
    return False
