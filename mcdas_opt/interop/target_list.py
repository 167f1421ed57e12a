"""Track lists of a front radar as CSV: one target a row, with a small mapping of column names."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

from mcdas_opt.domain.measurement import RadarDetection, Scan
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.domain.vocabulary import Sector
from mcdas_opt.errors import InputError, nearest
from mcdas_opt.interop.recordings.csv_table import CsvTable, Row
from mcdas_opt.interop.recordings.tally import Tally
from mcdas_opt.interop.sensor_log import SensorLog, cycles, in_order_of_arrival, usual_period
from mcdas_opt.simulation.sensors import mounting

FORMAT = "radar-csv"
NEEDED = ("time_s", "x_m", "y_m", "range_rate_mps")
OPTIONAL = ("slot", "new_track")


@dataclass(frozen=True, slots=True, kw_only=True)
class Columns:
    """Which column of the file holds what; a leading minus turns the sign (`y_m=-right_m`).

    x ahead of the radar, y to the left [m], range rate positive when opening [m/s]. `slot` tells the targets of one cycle apart and
    `new_track` (1: the slot now holds another target) their lives; both may be missing in the file when they keep their own names.
    """

    time_s: str = "time_s"
    x_m: str = "x_m"
    y_m: str = "y_m"
    range_rate_mps: str = "range_rate_mps"
    slot: str = "slot"
    new_track: str = "new_track"

    @classmethod
    def parse(cls, text: str) -> Columns:
        """From `time_s=t,x_m=dx`. Raises `InputError` for an unknown or repeated name or a part that is no pair."""
        chosen: dict[str, str] = {}
        for part in filter(None, (p.strip() for p in text.split(","))):
            name, sign, column = (p.strip() for p in part.partition("="))
            if not sign or not column.lstrip("-"):
                raise InputError("--columns", part, None, "must be NAME=COLUMN")
            if name not in NEEDED + OPTIONAL:
                raise InputError("--columns", name, column, f"unknown name; {nearest(name, NEEDED + OPTIONAL)}")
            if name in chosen:
                raise InputError("--columns", name, column, "given twice")
            chosen[name] = column
        return cls(**chosen)


def read_targets(path: str | Path, *, columns: Columns | Mapping[str, str] | None = None, vehicle: Vehicle | None = None) -> SensorLog:
    """Scans of a radar in the middle of the front bumper.

    Rows without a time, or with text where a number belongs, are left out and counted; other empty or NaN cells become NaN in the
    detection, which the tracker gates. Raises `InputError` for a missing column (the nearest one named) or a file without a row.
    """
    if columns is not None and not isinstance(columns, Columns):
        columns = Columns.parse(",".join(f"{name}={column}" for name, column in columns.items()))
    columns = columns or Columns()
    table, bad = CsvTable(path), Tally()
    called: dict[str, str] = asdict(columns)
    names = [*NEEDED, *(name for name in OPTIONAL if called[name] != name or name in table.header)]
    found = {name: _locate(table, called[name]) for name in names}
    rows: list[Row] = []
    for row in table.rows([index for index, _ in found.values()], bad):
        if math.isfinite(row.values[0]):
            rows.append(row)
        else:
            bad.add(f"{columns.time_s} is not finite", row.line)
    if not rows:
        raise InputError(path, "", None, "holds no row with a time")
    read = [{name: sign * value for (name, (_, sign)), value in zip(found.items(), row.values, strict=True)} for row in rows]
    stamps = [values["time_s"] for values in read]
    keys = [values.get("slot", row.line) for values, row in zip(read, rows, strict=True)]
    period = usual_period(stamps, keys) if "slot" in found else usual_period(stamps, [0] * len(stamps))
    place = mounting(Sector.FRONT, vehicle or Vehicle())
    stream = []
    for group in cycles(stamps, keys, period):
        detections = tuple(_detection(read[k]) for k in group)
        scan = Scan(sensor="radar-front", sector=Sector.FRONT, t_s=stamps[group[0]], mounting=place, radar=detections, period_s=period)
        stream.append((max(stamps[k] for k in group), scan))
    scans, arrivals = in_order_of_arrival([stream])
    pieces = _pieces(keys, [values["new_track"] for values in read]) if {"slot", "new_track"} <= set(found) else None
    return SensorLog(format=FORMAT, scans=scans, arrivals_s=arrivals, good=len(rows), bad=bad, pieces=pieces)


def _pieces(slots: Sequence[float], new: Sequence[float]) -> int:
    """How many targets the slots held, one after another."""
    known: set[float] = set()
    pieces = 0
    for slot, flag in zip(slots, new, strict=True):
        pieces += slot not in known or flag > 0.0
        known.add(slot)
    return pieces


def _locate(table: CsvTable, column: str) -> tuple[int, float]:
    """Index and sign of a column; a name that itself begins with a minus is taken as it stands where the file has it."""
    if column.startswith("-") and column not in table.header:
        return table.column(column[1:]), -1.0
    return table.column(column), 1.0


def _detection(values: Mapping[str, float]) -> RadarDetection:
    x, y = values["x_m"], values["y_m"]
    return RadarDetection(range_m=math.hypot(x, y), azimuth_rad=math.atan2(y, x), range_rate_mps=values["range_rate_mps"])
