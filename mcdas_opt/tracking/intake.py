"""What of the scans is taken in: the sound ones in their order, and of each the sound detections. The rest is counted."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Sequence
from typing import TypeVar

from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.measurement import BodyDetection, RadarDetection, Scan
from mcdas_opt.domain.vocabulary import Sector
from mcdas_opt.tracking.screening import COUNTERS, FUTURE_TOLERANCE_S, MOST_DETECTIONS, MOST_SCANS, body_fault, radar_fault
from mcdas_opt.tracking.track_life import MOST_SOURCES

T = TypeVar("T")


class Intake:
    """`counters` counts what became of scans and detections (`screening.COUNTERS`)."""

    def __init__(self) -> None:
        self.counters: dict[str, int] = dict.fromkeys(COUNTERS, 0)
        self._refused: dict[tuple[str, Sector], int] = {}  # of each sensor, how many scans in a row

    def in_order(self, scans: Sequence[Scan], now: float) -> list[Scan]:
        """In the order of their times; of more than can be taken in the latest, and those that will be refused."""
        ordered = sorted(scans, key=lambda scan: scan.t_s if math.isfinite(scan.t_s) else math.inf)
        if len(ordered) <= MOST_SCANS:
            return ordered
        refused = sum(not scan.t_s <= now + FUTURE_TOLERANCE_S for scan in ordered)
        beyond = max(len(ordered) - refused - MOST_SCANS, 0)
        self.counters["too_many"] += beyond
        return ordered[beyond:]

    def take(self, scan: Scan, host: HostState) -> tuple[list[RadarDetection], list[BodyDetection], str | None]:
        """The sound detections, and the fault of the first where none of them is."""
        points, bodies = self.points(scan), self.bodies(scan, host)
        if points or bodies:
            return points, bodies, None
        return points, bodies, next(filter(None, (*map(radar_fault, scan.radar), *map(body_fault, scan.bodies))), None)

    def refused(self, scan: Scan) -> int:
        """Nothing was taken of this scan: of how many of its sensor's in a row that is so now."""
        if len(self._refused) > MOST_SOURCES:
            self._refused.clear()
        source = (scan.sensor, scan.sector)
        self._refused[source] = self._refused.get(source, 0) + 1
        return self._refused[source]

    def accepted(self, scan: Scan) -> None:
        """This one was taken."""
        self._refused.pop((scan.sensor, scan.sector), None)

    def points(self, scan: Scan) -> list[RadarDetection]:
        """The sound ones, each once; of more than are followed the nearest."""
        sound = dict[RadarDetection, None]()
        for point in scan.radar:
            fault = radar_fault(point) or ("duplicate" if point in sound else None)
            if fault is None:
                sound[point] = None
            else:
                self.counters[fault] += 1
        return self.most(sound, MOST_DETECTIONS, lambda point: point.range_m)

    def bodies(self, scan: Scan, host: HostState) -> list[BodyDetection]:
        """The sound ones, each name once; of more than are followed those nearest to the host."""
        sound = dict[str, BodyDetection]()
        for body in scan.bodies:
            fault = body_fault(body) or ("duplicate" if body.name in sound else None)
            if fault is None:
                sound[body.name] = body
            else:
                self.counters[fault] += 1
        return self.most(sound.values(), MOST_DETECTIONS, lambda body: math.hypot(body.s_m - host.s_m, body.d_m - host.d_m))

    def most(self, given: Collection[T], most: int, rank: Callable[[T], float | tuple[bool, float]]) -> list[T]:
        """All of them, or so many that rank first, in the order that they had; the others are counted."""
        if len(given) <= most:
            return list(given)
        self.counters["too_many"] += len(given) - most
        kept = set(sorted(range(len(given)), key=[rank(one) for one in given].__getitem__)[:most])
        return [one for k, one in enumerate(given) if k in kept]
