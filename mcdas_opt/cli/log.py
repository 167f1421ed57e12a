"""What the program says besides results: through `logging`, under the logger `mcdas_opt`, on stderr, a line each.

Errors and warnings stand behind the name of the command; the rest is as it is. In Python it is for the user to say what is shown.
"""

from __future__ import annotations

import contextlib
import logging

import typer

from mcdas_opt.errors import printable

LOGGER = logging.getLogger("mcdas_opt")


class _Stderr(logging.Handler):
    """Writes to the stderr of the moment: a test, or a closed stream, may have put another in its place."""

    def emit(self, record: logging.LogRecord) -> None:
        line = printable(record.getMessage())
        with contextlib.suppress(OSError):  # full, or no longer read: no reason to end what is being done
            typer.echo(f"mcdas-opt: {line}" if record.levelno >= logging.WARNING else line, err=True)


_HANDLER = _Stderr()


def say(quiet: bool = False) -> None:
    """Lets the program be heard; `quiet`: errors alone. Of matplotlib's own messages (fonts that it does without) errors are shown."""
    LOGGER.setLevel(logging.ERROR if quiet else logging.INFO)
    if _HANDLER not in LOGGER.handlers:
        LOGGER.addHandler(_HANDLER)
    logging.getLogger("matplotlib").setLevel(logging.ERROR)


def complain(text: str) -> None:
    """An error."""
    _heard().error("%s", text)


def hint(text: str) -> None:
    """A warning: something is done, and may not be what was meant."""
    _heard().warning("%s", text)


def tell(text: str) -> None:
    """What is being done."""
    _heard().info("%s", text)


def is_quiet() -> bool:
    return not _heard().isEnabledFor(logging.INFO)


def _heard() -> logging.Logger:
    if _HANDLER not in LOGGER.handlers:
        say()
    return LOGGER
