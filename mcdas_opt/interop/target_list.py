"""Target lists of a front radar: one target a row of a table, whatever recording it is in, with a small mapping of channel names."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace

import numpy as np

from mcdas_opt.domain.measurement import RadarDetection, Scan
from mcdas_opt.domain.rules import Array
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.domain.vocabulary import Sector
from mcdas_opt.errors import InputError, nearest
from mcdas_opt.interop.host_motion import forward
from mcdas_opt.interop.recordings.csv_table import CsvTable
from mcdas_opt.interop.recordings.recording import TIME, Recording, Row, StatesUnits, Table, Tally, named
from mcdas_opt.interop.sensor_log import (
    SensorLog,
    Source,
    cycles,
    in_order_of_arrival,
    increasing,
    period_without_slots,
    require_clock,
    usual_period,
)
from mcdas_opt.simulation.sensors import mounting

TIME_NAMES = (TIME, "t_s")
_CALLED = {
    "time_s": TIME_NAMES,
    "x_m": ("x_m",),
    "y_m": ("y_m",),
    "range_m": ("range_m", "range"),
    "azimuth_rad": ("azimuth_rad", "azimuth"),
    "range_rate_mps": ("range_rate_mps", "doppler_velocity"),
    "slot": ("slot",),
    "new_track": ("new_track",),
    "host_speed_mps": ("host_speed_mps", "twist.linear.x"),
}
"""What each quantity is called where nobody says: our own name, and that of ROS 2's message."""
_CARTESIAN, _POLAR = ("x_m", "y_m"), ("range_m", "azimuth_rad")
_SCALED = re.compile(r"(-?)(?:(\d*\.?\d+)\*)?(.*)", re.DOTALL)


@dataclass(frozen=True, slots=True, kw_only=True)
class Columns:
    """Which channel of the recording holds what; a leading minus turns the sign (`y_m=-right_m`), a factor scales
    (`range_rate_mps=0.27778*v_kmh`). Empty: by its own name.

    x ahead of the radar, y to the left [m], or range [m] and azimuth [rad], ISO 8855; range rate positive when opening [m/s]. `slot` (a
    number, in a CSV any text) tells the targets of one cycle apart and `new_track` (1: the slot now holds another target) their lives;
    `host_speed_mps` may stand in another table of the recording. The last three may be missing.
    """

    time_s: str = ""
    x_m: str = ""
    y_m: str = ""
    range_m: str = ""
    azimuth_rad: str = ""
    range_rate_mps: str = ""
    slot: str = ""
    new_track: str = ""
    host_speed_mps: str = ""

    @classmethod
    def parse(cls, text: str) -> Columns:
        """From `time_s=t,x_m=dx`. Raises `InputError` for an unknown or repeated name or a part that is no pair."""
        chosen: dict[str, str] = {}
        for part in filter(None, (p.strip() for p in text.split(","))):
            name, _, column = (p.strip() for p in part.partition("="))
            if name in chosen:
                raise InputError("--columns", name, column, "given twice")
            chosen[name] = column
        return cls.of(chosen, "--columns")

    @classmethod
    def of(cls, chosen: Mapping[str, str], said: str = "columns") -> Columns:
        """From `{"time_s": "t", "x_m": "dx"}`. Raises `InputError` for a name or a column that is none; `said` is where they stand."""
        for name, column in chosen.items():
            bare, factor = _scaled(column) if isinstance(column, str) else ("", 1.0)
            if not bare or not 0.0 < abs(factor) < math.inf:
                raise InputError(said, str(name), column or None, "must be NAME=COLUMN, NAME=-COLUMN or NAME=FACTOR*COLUMN")
            if name not in _CALLED:
                raise InputError(said, str(name), column, f"unknown name; {nearest(str(name), _CALLED)}")
        return cls(**chosen)

    def names(self, quantity: str) -> tuple[str, ...]:
        """What the quantity may be called."""
        chosen: str = asdict(self)[quantity]
        return (chosen,) if chosen else _CALLED[quantity]

    def place(self, header: tuple[str, ...]) -> tuple[str, str]:
        """The two quantities that say where a target is: those that were chosen, else those that are there."""
        if not (self.x_m or self.y_m) and (
            self.range_m or self.azimuth_rad or (not _there(header, _CALLED["x_m"]) and _there(header, _CALLED["range_m"]))
        ):
            return _POLAR
        return _CARTESIAN


def read_targets(
    recording: Recording,
    *,
    columns: Columns | Mapping[str, str] | None = None,
    vehicle: Vehicle | None = None,
    rear: Recording | None = None,
) -> SensorLog:
    """Scans of a radar in the middle of the front bumper, from a table with a target a row; those of one in the middle of the rear bumper
    from the recording `rear`, by the same columns and the same clock, x behind the car and y to its right. The host's speed is the front's.

    Rows without a time, or with text where a number belongs, are left out and counted; other empty or NaN cells become NaN in the
    detection, which the tracker gates; a row with a time alone is a scan that saw nothing. Raises `InputError` for a missing channel
    (the nearest one named, and all there are) or a table of which no row can be read.
    """
    if columns is not None and not isinstance(columns, Columns):
        columns = Columns.of(columns)
    columns = columns or Columns()
    front, streams = _read(recording, columns, vehicle, Sector.FRONT)
    if rear is None:
        return front
    behind, more = _read(rear, columns, vehicle, Sector.REAR)
    scans, arrivals = in_order_of_arrival([streams, more])
    bad = Tally()
    bad.absorb(front.bad, "front: ")
    bad.absorb(behind.bad, "rear: ")
    pieces = None if front.pieces is None or behind.pieces is None else front.pieces + behind.pieces
    return replace(
        front,
        scans=scans,
        arrivals_s=arrivals,
        good=front.good + behind.good,
        bad=bad,
        pieces=pieces,
        sources=front.sources | behind.sources,
    )


def _read(recording: Recording, columns: Columns, vehicle: Vehicle | None, sector: Sector) -> tuple[SensorLog, list[tuple[float, Scan]]]:
    """The log of one radar, and its scans with the times when they were complete."""
    table, bad = _table(recording, columns.names("range_rate_mps")), Tally()
    place = columns.place(table.header)
    chosen = asdict(columns)
    optional = [name for name in ("slot", "new_track") if chosen[name] or _there(table.header, _CALLED[name])]
    found = {name: _locate(table, columns.names(name)) for name in ("time_s", *place, "range_rate_mps", *optional)}
    for name in (*place, "range_rate_mps"):
        _require_unit(recording, table, found[name][0], columns, name)
    if "slot" in found and isinstance(table, CsvTable):
        table = table.numbered(found["slot"][0])
    rows: list[Row] = []
    for row in table.rows([index for index, _ in found.values()], bad):
        if math.isfinite(row.values[0]):
            rows.append(row)
        else:
            bad.add(f"{columns.names('time_s')[0]} is not finite", row.line)
    if not rows:
        said = [f"{kind} ({entry['count']}, first in line {entry['first_line']})" for kind, entry in bad.to_document().items()]
        raise InputError(recording.path, "", None, f"holds no row that can be read: {', '.join(said) or 'it is empty'}")
    read = [{name: sign * value for (name, (_, sign)), value in zip(found.items(), row.values, strict=True)} for row in rows]
    stamps = [values["time_s"] for values in read]
    require_clock(recording.path, table.header[found["time_s"][0]], stamps, [row.line for row in rows])
    keys = [values.get("slot", row.line) for values, row in zip(read, rows, strict=True)]
    slotted = any(not math.isnan(values.get("slot", math.nan)) for values in read)
    period = usual_period(stamps, keys) if slotted else period_without_slots(stamps)
    if period is None:
        rule = (
            "has a time of its own for each target, and does not show where a cycle ends: name what tells the targets of a cycle apart "
            "(--columns slot=...), or give them one time"
        )
        raise InputError(recording.path, table.header[found["time_s"][0]], None, rule)
    mounted = mounting(sector, vehicle or Vehicle())
    stream = []
    for group in cycles(stamps, keys, period):
        seen = (read[k] for k in group if any(math.isfinite(read[k][name]) for name in (*place, "range_rate_mps")))
        detections = tuple(_detection(values, place) for values in seen)
        scan = Scan(sensor=f"radar-{sector}", sector=sector, t_s=stamps[group[0]], mounting=mounted, radar=detections, period_s=period)
        stream.append((max(stamps[k] for k in group), scan))
    scans, arrivals = in_order_of_arrival([stream])
    pieces = _pieces(keys, [values["new_track"] for values in read]) if {"slot", "new_track"} <= set(found) else None
    speed = _host_speed(recording, columns)
    rate, bearing = (table.header[found[name][0]] for name in ("range_rate_mps", "azimuth_rad" if place == _POLAR else "x_m"))
    sources = {sector: Source(file=str(recording.path), range_rate=rate, bearing=bearing)}
    log = SensorLog(scans=scans, arrivals_s=arrivals, good=len(rows), bad=bad, pieces=pieces, host_speed=speed, sources=sources)
    return log, stream


def _host_speed(recording: Recording, columns: Columns) -> Array | None:
    """(n, 2) of time and speed [m/s], increasing in time; None where the recording does not say it and nobody says that it does."""
    if not columns.host_speed_mps and not _there(recording.channels, columns.names("host_speed_mps")):
        return None
    table = _table(recording, columns.names("host_speed_mps"))
    (time, _), (speed, sign) = _locate(table, columns.names("time_s")), _locate(table, columns.names("host_speed_mps"))
    _require_unit(recording, table, speed, columns, "host_speed_mps")
    pairs = []
    for row in table.rows([time, speed], Tally()):
        t, v = row.values
        if math.isfinite(t) and math.isfinite(v):
            pairs.append((t, forward(recording.path, row.line, table.header[speed], sign * v)))
    return np.array(increasing(pairs)).reshape(-1, 2)


def _pieces(slots: Sequence[float], new: Sequence[float]) -> int:
    """How many targets the slots held, one after another."""
    known: set[float] = set()
    pieces = 0
    for slot, flag in zip(slots, new, strict=True):
        pieces += slot not in known or flag > 0.0
        known.add(slot)
    return pieces


def _table(recording: Recording, names: Sequence[str]) -> Table:
    """The table in which one of these, its sign and factor aside, stands."""
    return recording.table(*(name if name in recording.channels else _scaled(name)[0] for name in names))


def _locate(table: Table, names: Sequence[str]) -> tuple[int, float]:
    """Index and factor of a column; a name that itself begins with a minus or a factor is taken as it stands where the file has it."""
    bare, factor = _scaled(names[0])
    return (table.column(*names), 1.0) if bare == names[0] or names[0] in table.header else (table.column(bare), factor)


def _require_unit(recording: Recording, table: Table, column: int, columns: Columns, quantity: str) -> None:
    """Raises `InputError` where the file states a unit that we do not know, unless a factor is given."""
    name = table.header[column]
    unit = table.unknown_unit(column) if isinstance(table, StatesUnits) else ""
    if unit and "*" not in columns.names(quantity)[0].removesuffix(name):
        rule = f"is no unit that we know: give the factor to SI, --columns {quantity}=FACTOR*{name}"
        raise InputError(recording.path, f"unit of {name}", unit, rule)


def _scaled(name: str) -> tuple[str, float]:
    """The column that is meant, and what it is multiplied by."""
    found = _SCALED.fullmatch(name)
    assert found is not None  # it takes any text
    sign, number, bare = found.groups()
    return bare, float(f"{sign}{number or 1}")


def _there(channels: Sequence[str], names: Sequence[str]) -> bool:
    return any(named(name, channels) for name in names)


def _detection(values: Mapping[str, float], place: tuple[str, str]) -> RadarDetection:
    first, second = (values[name] for name in place)
    range_m, azimuth = (first, second) if place == _POLAR else (math.hypot(first, second), math.atan2(second, first))
    return RadarDetection(range_m=range_m, azimuth_rad=azimuth, range_rate_mps=values["range_rate_mps"])
