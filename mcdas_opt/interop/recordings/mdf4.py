"""MDF4 files (ASAM measurement data) by asammdf: CAN bus logging, or channels in groups of one time base each."""

from __future__ import annotations

import gc
import logging
import math
import sys
from collections import Counter
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from functools import cached_property
from pathlib import Path
from traceback import clear_frames
from typing import TYPE_CHECKING

import numpy as np

from mcdas_opt.domain.rules import Array
from mcdas_opt.errors import of_extra
from mcdas_opt.interop.recordings.recording import TIME, CanLog, Frame, Row, Tally, check_regular, no_such_channel, position, understood

if TYPE_CHECKING:
    from asammdf import MDF

_FRAMES, _OTHER_FRAMES = "CAN_DataFrame", ("CAN_ErrorFrame", "CAN_RemoteFrame")
_LONGEST = 8  # bytes of a classic frame
_SPELT = {
    1.0: ("", "-", "1", "m", "meter", "metre", "s", "sec", "rad", "radian", "radians", "m/s", "m/sec", "mps", "ms-1", "ms^-1"),
    1 / 3.6: ("km/h", "km/hr", "kmh", "kmph", "kph", "kmh-1", "kmh^-1"),
    0.44704: ("mph", "mi/h", "mi/hr"),
    1.852 / 3.6: ("kn", "kt", "kts", "knot", "knots"),
    math.pi / 180: ("deg", "degree", "degrees", "°"),
    1000.0: ("km",),
    0.3048: ("ft",),
    0.01: ("cm", "cm/s"),
    0.001: ("mm", "mm/s", "mrad", "ms"),
    1e-6: ("us", "\u03bcs"),
}
_SI = {name: factor for factor, names in _SPELT.items() for name in names}
"""By how much a unit is multiplied, as `_folded` writes it."""


class Mdf4Recording:
    """An MDF4 file. Times are seconds since its start. A channel whose unit is km/h, deg, mm and the like is read in SI, one whose unit is
    none that we know as it stands.

    A channel is called by its name, after its group and a slash where several have that name. Raises `InputError` for another file,
    `MissingExtraError` without asammdf.
    """

    suffixes = (".mf4", ".mdf")

    def __init__(self, path: str | Path) -> None:
        self.path = path
        check_regular(path)
        with self._open():
            pass

    @cached_property
    def _places(self) -> dict[str, tuple[int, int]]:
        """Group and index of every channel that is a number over time, by its name."""
        found = []
        with self._open() as mdf:
            for g, group in enumerate(mdf.groups):
                label = str(group.channel_group.acq_name or group.channel_group.comment or g)
                masters = {mdf.masters_db.get(g)}
                names = [str(channel.name) for channel in group.channels]
                found += [(label, name, (g, c)) for c, name in enumerate(names) if c not in masters and not _of_frames(name)]
        often = Counter(name for _, name, _ in found)
        return {name if often[name] == 1 else f"{label}/{name}": place for label, name, place in found}

    @property
    def channels(self) -> tuple[str, ...]:
        log = self.can_log()
        return (*self._places, *sorted({frame.channel for frame in log.frames} if log is not None else ()))

    def can_log(self) -> CanLog | None:
        """The frames of every group of bus logging, in the order of their times."""
        frames, other, is_bus = [], 0, False
        with self._open() as mdf:
            for g, group in enumerate(mdf.groups):
                names = {str(channel.name) for channel in group.channels}
                is_bus = is_bus or _FRAMES in names
                other += group.channel_group.cycles_nr if names & set(_OTHER_FRAMES) else 0
                if _FRAMES in names and group.channel_group.cycles_nr:
                    frames += _frames(mdf, g)
        if not is_bus:
            return None
        data = [frame for frame in frames if len(frame.data) <= _LONGEST]
        return CanLog(frames=tuple(sorted(data, key=lambda frame: frame.t_s)), other=other + len(frames) - len(data))

    def table(self, *names: str) -> GroupTable:
        """The channel group of the first of these names that there is."""
        known = tuple(self._places)
        if not known:
            raise no_such_channel(self.path, names, self.channels)
        group, _ = self._places[known[position(self.path, names, known)]]
        return GroupTable(self, tuple(name for name, place in self._places.items() if place[0] == group))

    def values(self, name: str) -> tuple[Array, Array]:
        """Times and values of a channel, one for each of its group's; a sample that is invalid is NaN."""
        group, index = self._places[name]
        with self._open() as mdf:
            signal = mdf.get(group=group, index=index, ignore_invalidation_bits=True)
            scale = _SI.get(_folded(signal.unit), 1.0)
            found = scale * np.asarray(signal.samples, dtype=np.float64)
            if signal.invalidation_bits is not None:
                found[np.asarray(signal.invalidation_bits, dtype=bool)] = np.nan
            return np.asarray(signal.timestamps, dtype=np.float64), found

    def unknown_unit(self, name: str) -> str:
        """The unit that the file states of a channel, where it is none that we know; else empty."""
        group, index = self._places[name]
        with self._open() as mdf:
            unit = str(mdf.get(group=group, index=index, record_count=1).unit)
        return "" if _folded(unit) in _SI else unit

    @contextmanager
    def _open(self) -> Iterator[MDF]:
        with of_extra("asammdf", "mdf"):
            from asammdf import MDF
        with understood(self.path, "MDF4"), Path(self.path).open("rb") as file:
            with _quiet_when_half_built():
                mdf = MDF(file)
            with mdf:
                yield mdf


@contextmanager
def _quiet_when_half_built() -> Iterator[None]:
    """An MDF that fails while it is built tells it on stderr, and fails once more when it is thrown away, which Python would tell there.

    Raises `ValueError` that says what it said.
    """
    before, logger = sys.unraisablehook, logging.getLogger("asammdf")
    level = logger.level
    sys.unraisablehook = lambda told: None
    logger.setLevel(logging.CRITICAL)
    try:
        yield
    except Exception as error:
        said = str(error)
        one: BaseException | None = error
        while one is not None:  # thrown away here and now, with whatever still holds it
            clear_frames(one.__traceback__)
            one = one.__context__
        del error
        gc.collect()
        raise ValueError(said) from None
    finally:
        sys.unraisablehook = before
        logger.setLevel(level)


class GroupTable:
    """The channels of one group, a row for each of its records: several may have one time, as the targets of one cycle do."""

    def __init__(self, recording: Mdf4Recording, names: tuple[str, ...]) -> None:
        self._recording, self._names = recording, names
        self.header = names if TIME in names else (*names, TIME)

    def column(self, *names: str) -> int:
        return position(self._recording.path, names, self.header)

    def unknown_unit(self, column: int) -> str:
        name = self.header[column]
        return self._recording.unknown_unit(name) if name in self._names else ""

    def rows(self, columns: Sequence[int], bad: Tally) -> Iterator[Row]:
        chosen = [self.header[column] for column in columns]
        read = {name: self._recording.values(name) for name in chosen if name in self._names}
        times = next(t for t, _ in read.values())
        table = [read[name][1] if name in read else times for name in chosen]
        for k, values in enumerate(zip(*(column.tolist() for column in table), strict=True)):
            yield Row(line=k + 1, values=values)


def _folded(unit: object) -> str:
    """Without capitals, blanks and a middle dot or star between factors."""
    return "".join(one for one in str(unit).casefold() if one not in " \t*\u00b7\u22c5")


def _of_frames(name: str) -> bool:
    return name.partition(".")[0] in (_FRAMES, *_OTHER_FRAMES)


def _frames(mdf: MDF, group: int) -> list[Frame]:
    signal = mdf.get(_FRAMES, group=group)
    columns = {name.rpartition(".")[2]: signal.samples[name] for name in signal.samples.dtype.names}
    t, identifiers, lengths = signal.timestamps, columns["ID"], columns["DataLength"]
    buses = columns.get("BusChannel", np.zeros(len(t), dtype=np.uint8))
    return [
        Frame(
            t_s=float(t[k]),
            channel=f"can{int(buses[k])}",
            identifier=int(identifiers[k]) & 0x1FFFFFFF,
            data=columns["DataBytes"][k][: int(lengths[k])].tobytes(),
            line=k + 1,
        )
        for k in range(len(t))
    ]
