"""What a reader makes of a file, whatever its format (CAN frames, tables of numbers, the names of what there is), and the readers."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Protocol, runtime_checkable

from mcdas_opt.catalogue.data_files import check_is_file
from mcdas_opt.domain.registry import Registry
from mcdas_opt.errors import InputError, McdasError, ParameterError, nearest, reading

TIME = "time_s"  # the name that every table's time answers to
FOLDER = "/"  # the ending of a recording that is a folder
_LISTED = 40  # channels in a message
ESR_CANDUMP, RADAR_CSV = "esr-candump", "radar-csv"
READERS = Registry(
    group="mcdas_opt.recordings",
    what="format",
    own={
        ESR_CANDUMP: "mcdas_opt.interop.recordings.candump:CandumpRecording",
        RADAR_CSV: "mcdas_opt.interop.recordings.csv_table:CsvTable",
        "mdf4": "mcdas_opt.interop.recordings.mdf4:Mdf4Recording",
        "mcap": "mcdas_opt.interop.recordings.mcap:McapRecording",
        "rosbag2": "mcdas_opt.interop.recordings.rosbag2:Rosbag2Recording",
    },
)


@dataclass(slots=True)
class Tally:
    """Counts by kind with the first line of each kind; grows while a file is read."""

    counts: dict[str, int] = field(default_factory=dict)
    first_lines: dict[str, int] = field(default_factory=dict)

    def add(self, kind: str, line: int) -> None:
        self.counts[kind] = self.counts.get(kind, 0) + 1
        self.first_lines[kind] = min(line, self.first_lines.get(kind, line))

    def absorb(self, other: Tally, prefix: str = "") -> None:
        """Adds another tally; its kinds are named with `prefix`, so that lines of two files stay apart."""
        for kind, count in other.counts.items():
            name = prefix + kind
            self.counts[name] = self.counts.get(name, 0) + count
            line = other.first_lines[kind]
            self.first_lines[name] = min(line, self.first_lines.get(name, line))

    @property
    def total(self) -> int:
        return sum(self.counts.values())

    def to_document(self) -> dict[str, dict[str, int]]:
        """`{kind: {count, first_line}}`, kinds in alphabetical order."""
        return {kind: {"count": self.counts[kind], "first_line": self.first_lines[kind]} for kind in sorted(self.counts)}


@dataclass(frozen=True, slots=True, kw_only=True)
class Frame:
    """One classic CAN data frame; `line` is where it stands in its file, counted from 1 (0: nowhere yet)."""

    t_s: float
    channel: str
    identifier: int
    data: bytes
    line: int = 0

    def to_line(self) -> str:
        """As candump writes it, without the line's end; times to the microsecond."""
        digits = 3 if self.identifier < 0x800 else 8
        return f"({self.t_s:.6f}) {self.channel} {self.identifier:0{digits}X}#{self.data.hex().upper()}"


@dataclass(frozen=True, slots=True, kw_only=True)
class CanLog:
    """Data frames in the order of the file, what was bad, and how many sound entries held no data frame."""

    frames: tuple[Frame, ...]
    bad: Tally = field(default_factory=Tally)
    other: int = 0


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


@runtime_checkable
class StatesUnits(Protocol):
    """A table whose file states units."""

    def unknown_unit(self, column: int) -> str:
        """What the file states, where it is no unit that we know, so that the values stand as they are; else empty."""
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


def check_regular(path: str | Path) -> None:
    """For a recording that a library reads piece by piece, of any size: a file or a folder of them. Raises `InputError` where something is
    no regular file."""
    one = Path(path)
    with reading(path):
        files = [part for part in one.iterdir() if not part.is_dir()] if one.is_dir() else [one]
    for file in files:
        check_is_file(file)


class Reader(Protocol):
    """What an entry point names: a class with the endings of its files' names, built as `Reader(path)`."""

    @property
    def suffixes(self) -> tuple[str, ...]: ...

    def __call__(self, path: str | Path) -> Recording: ...


def format_of(path: Path) -> str:
    """The format whose files end so. Raises `InputError` that lists the formats."""
    ending = FOLDER if path.is_dir() else path.suffix.lower()

    def ends_so(name: str) -> bool:
        reader: Reader = READERS.load(name)
        return ending in reader.suffixes

    ours = next(filter(ends_so, READERS.own), None)
    if ours is not None:
        return ours  # without asking the installed packages
    known = READERS.known()
    other = next(filter(ends_so, known), None)
    if other is None:
        raise InputError(path, "", None, f"is of no known format by its name; say --format, one of {', '.join(known)}")
    return other


def open_recording(path: Path, format: str) -> Recording:
    """The recording, opened. Raises `InputError` for an unknown format or a file that is not of it, `MissingExtraError`."""
    try:
        reader: Reader = READERS.load(format)
    except ParameterError:
        raise InputError("--format", "", format, f"is not a known format; {nearest(format, READERS.known())}") from None
    return reader(path)
