"""What a reader makes of a file, whatever its format: CAN frames, tables of numbers, and the names of what there is."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

from mcdas_opt.errors import InputError, McdasError, nearest
from mcdas_opt.interop.recordings.can_frames import CanLog
from mcdas_opt.interop.recordings.tally import Tally

TIME = "time_s"  # the name that every table's time answers to
FOLDER = "/"  # the ending of a recording that is a folder
_LISTED = 40  # channels in a message


@dataclass(frozen=True, slots=True, kw_only=True)
class Row:
    """One entry of a table: where it stands, counted from 1, and its values in the order of the columns asked for (NaN: nothing)."""

    line: int
    values: tuple[float, ...]


class Table(Protocol):
    """Numbers that belong together, an entry a row; SI where the file says the unit, else as the file has them."""

    @property
    def header(self) -> tuple[str, ...]: ...

    def column(self, *names: str) -> int:
        """Index of the column of the first of `names` that there is; raises `InputError` that lists the columns when there is none."""
        ...

    def rows(self, columns: Sequence[int], bad: Tally) -> Iterator[Row]:
        """The rows' values in these columns; unsound rows are left out and counted in `bad`."""
        ...


class Recording(Protocol):
    """A file that was recorded, opened by a reader: `Reader(path)` raises `InputError` for a file that is not one of its format."""

    @property
    def path(self) -> str | Path: ...

    @property
    def channels(self) -> tuple[str, ...]:
        """What there is: buses, topics' fields, columns."""
        ...

    def can_log(self) -> CanLog | None:
        """Every sound CAN data frame; None where the recording carries no CAN."""
        ...

    def table(self, *names: str) -> Table:
        """The table in which the first of these names stands that there is. Raises `InputError` that lists the channels where none is."""
        ...


def position(path: str | Path, names: Sequence[str], header: Sequence[str], what: str = "channel") -> int:
    """Where the first of `names` that there is stands in `header`. Raises `InputError` where none is there, or a name means several."""
    for name in names:
        found = named(name, header)
        if len(found) > 1:
            raise InputError(path, what, name, f"is the end of several: {', '.join(found)}; name one with --columns")
        if found:
            return list(header).index(found[0])
    raise no_such_channel(path, names, header, what)


def named(name: str, channels: Sequence[str]) -> tuple[str, ...]:
    """The channels that a name means: the one that is called so, else those that end in it after a dot or a slash."""
    return (name,) if name in channels else tuple(c for c in channels if c.endswith((f".{name}", f"/{name}")))


def no_such_channel(path: str | Path, names: Sequence[str], channels: Sequence[str], what: str = "channel") -> InputError:
    """Says which channel is wanted, which is near, and which there are."""
    near = nearest(names[0], channels)
    hint = f"; {near}" if near.startswith("did you mean") else ""
    return InputError(path, what, " or ".join(names), f"no such {what}{hint}; {listed(channels)}")


def listed(channels: Sequence[str]) -> str:
    """'there are: ...', cut off where there are many."""
    more = f" and {len(channels) - _LISTED} more" if len(channels) > _LISTED else ""
    return f"there are: {', '.join(channels[:_LISTED])}{more}" if channels else "there are none"


@contextmanager
def understood(path: str | Path, what: str) -> Iterator[None]:
    """Turns whatever a library raises over a file that it cannot make sense of into an `InputError` that names the file."""
    try:
        yield
    except McdasError:
        raise
    except Exception as error:  # which ones is not fixed by any of these libraries
        said = str(error).splitlines()
        raise InputError(path, "", None, f"cannot be read as {what}: {said[0] if said else type(error).__name__}") from None
