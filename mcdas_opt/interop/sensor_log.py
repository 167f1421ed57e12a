"""A recording of radars, whatever its format: scans in the order in which they arrived, and what was left out."""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Hashable, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from pathlib import Path
from statistics import median

from mcdas_opt.domain.declared_types import require_types
from mcdas_opt.domain.measurement import Scan
from mcdas_opt.domain.rules import Array, floats
from mcdas_opt.domain.vocabulary import Sector
from mcdas_opt.errors import InputError, ParameterError
from mcdas_opt.interop.recordings.recording import Tally

SHORTEST_S = 0.01  # no radar's cycle is shorter
_LATE_S = 0.5  # a record may come so much later than newer ones, and others for so long


@dataclass(frozen=True, slots=True, kw_only=True)
class Source:
    """Where a radar's numbers stand, for messages: the file, its bus there, and what it calls the range rate and the azimuth (or x)."""

    file: str = "recording"
    bus: str = ""
    range_rate: str = "range_rate_mps"
    bearing: str = "azimuth_rad"

    def __post_init__(self) -> None:
        require_types(self)


@dataclass(frozen=True, slots=True, kw_only=True)
class SensorLog:
    """What a reader hands to the replay.

    `arrivals_s` is when each scan was complete: the largest stamp so far on its bus, so that a scan whose stamp goes back arrives
    late instead of rewriting history. `gated` counts what the reader did not pass on, by reason. `host_speed` is (n, 2) of time and
    speed where the log itself says it. `pieces` is how many targets the sensor's own bookkeeping told apart, where it says so. `sources`
    says where each sector's radar stands.
    """

    scans: tuple[Scan, ...]
    arrivals_s: tuple[float, ...]
    good: int
    bad: Tally
    other: int = 0
    gated: dict[str, int] = field(default_factory=dict)
    host_speed: Array | None = None
    pieces: int | None = None
    sources: dict[Sector, Source] = field(default_factory=dict)

    def __post_init__(self) -> None:
        require_types(self)
        if self.host_speed is not None:
            floats("host_speed", self.host_speed, "must be numbers")
        if not self.scans or len(self.scans) != len(self.arrivals_s):
            raise ParameterError("scans", len(self.scans), "must be at least one, each with its arrival time")

    @property
    def sectors(self) -> tuple[Sector, ...]:
        """Sectors that have a log, in the order of the vocabulary."""
        seen = {scan.sector for scan in self.scans}
        return tuple(sector for sector in Sector if sector in seen)

    @property
    def detections(self) -> int:
        return sum(len(scan.radar) for scan in self.scans)


def require_clock(path: str | Path, key: str, stamps: Sequence[float], lines: Sequence[int]) -> None:
    """Raises `InputError` with the line from which on a clock runs that was set back: what follows would all be too late. A few late
    records are none."""
    latest, back = -math.inf, None
    for k, stamp in enumerate(stamps):
        if stamp >= latest - _LATE_S:
            latest, back = max(latest, stamp), None
        elif back is None:
            back = k
        elif stamp > stamps[back] + _LATE_S:
            rule = f"goes back by {latest - stamps[back]:.3f} s, and on from there: split the recording where its clock was set, or sort it"
            raise InputError(path, f"line {lines[back]}: {key}", stamps[back], rule)


def usual_period(stamps: Sequence[float], keys: Sequence[Hashable]) -> float:
    """Median time [s] between two records of the same key (a CAN identifier, a track slot); 0.1 s where none comes twice."""
    last: dict[Hashable, float] = {}
    steps = []
    for stamp, key in zip(stamps, keys, strict=True):
        if key in last and stamp > last[key]:
            steps.append(stamp - last[key])
        last[key] = stamp
    return round(median(steps), 6) if steps else 0.1


def period_without_slots(stamps: Sequence[float]) -> float | None:
    """Median time [s] between cycles of records that no key tells apart: of one cycle are those that follow one another faster than any
    radar. None where those then last for more than half a period, so that nobody can tell where a cycle ends."""
    period = usual_period(stamps, [0] * len(stamps))
    if period >= SHORTEST_S:
        return period
    firsts = [stamp for before, stamp in pairwise([-math.inf, *stamps]) if stamp - before >= SHORTEST_S]
    period = usual_period(firsts, [0] * len(firsts))
    begun = [firsts[max(bisect_right(firsts, stamp) - 1, 0)] for stamp in stamps]
    return period if max(stamp - first for stamp, first in zip(stamps, begun, strict=True)) <= 0.5 * period else None


def cycles(stamps: Sequence[float], keys: Sequence[Hashable], period_s: float) -> list[list[int]]:
    """Indices of the records of each radar cycle: stamps within half a period of the cycle's first, no key twice."""
    groups: list[list[int]] = []
    seen: set[Hashable] = set()
    for k, (stamp, key) in enumerate(zip(stamps, keys, strict=True)):
        if not groups or key in seen or not 0.0 <= stamp - stamps[groups[-1][0]] <= 0.5 * period_s:
            groups.append([])
            seen = set()
        groups[-1].append(k)
        seen.add(key)
    return groups


def in_order_of_arrival(streams: Sequence[Sequence[tuple[float, Scan]]]) -> tuple[tuple[Scan, ...], tuple[float, ...]]:
    """Scans of several sensors, each given as (time when complete, scan) in its own order, merged by arrival; ties keep the order."""
    arriving: list[tuple[float, Scan]] = []
    for stream in streams:
        latest = -math.inf
        for complete, scan in stream:
            latest = max(latest, complete)
            arriving.append((latest, scan))
    arriving.sort(key=lambda pair: pair[0])
    return tuple(scan for _, scan in arriving), tuple(time for time, _ in arriving)


def increasing(pairs: Sequence[tuple[float, float]]) -> list[tuple[float, float]]:
    """Those whose first number is larger than all before."""
    kept: list[tuple[float, float]] = []
    for pair in pairs:
        if not kept or pair[0] > kept[-1][0]:
            kept.append(pair)
    return kept
