"""What passes between a run and its child processes: length-prefixed pickles, what a task reports, and the answers to it."""

from __future__ import annotations

import pickle
import struct
from collections.abc import Callable
from dataclasses import dataclass
from enum import StrEnum
from typing import IO, Any

_LENGTH = struct.Struct("<Q")


class Ended(StrEnum):
    """How a task ended: it returned, it raised, it was stopped at its time limit, or its process died."""

    RETURNED = "returned"
    RAISED = "raised"
    TOO_LONG = "too long"
    DIED = "died"


@dataclass(frozen=True, slots=True)
class Answer:
    """The answer to one task: its value where it returned, else the reason in words."""

    ended: Ended
    value: Any = None
    reason: str = ""


@dataclass(frozen=True, slots=True)
class Task:
    """A call of a function that a fresh interpreter can import; `limit_s` is wall-clock time, None for no limit."""

    function: Callable[..., Any]
    arguments: tuple[Any, ...]
    limit_s: float | None = None


@dataclass(frozen=True, slots=True)
class Report:
    """What a task tells while it is worked on; it goes on when it has heard what is said to it."""

    value: Any


def write(stream: IO[bytes], message: Any) -> None:
    data = pickle.dumps(message, protocol=pickle.HIGHEST_PROTOCOL)
    stream.write(_LENGTH.pack(len(data)) + data)
    stream.flush()


def read(stream: IO[bytes]) -> Any:
    """Raises `EOFError` where the other side has gone, also in the middle of a message."""
    size = _LENGTH.unpack(_exactly(stream, _LENGTH.size))[0]
    return pickle.loads(_exactly(stream, size))


def _exactly(stream: IO[bytes], count: int) -> bytes:
    data = stream.read(count)
    if data is None or len(data) < count:
        raise EOFError("the other side has gone")
    return data


_parent: Callable[[Any], Any] | None = None


def tell_by(told: Callable[[Any], Any]) -> None:
    """For the child process: `told` carries a report to the parent and gives what that says."""
    global _parent
    _parent = told


def report(value: Any) -> Any:
    """What the parent says to `value`; None where there is none, or it does not listen."""
    return None if _parent is None else _parent(value)
