"""Frames of one ESR to its scans, while they arrive; what is missing is counted."""

from __future__ import annotations

from collections import deque
from dataclasses import astuple, dataclass, field
from operator import add
from statistics import median

from mcdas_opt.domain.measurement import RadarDetection, Scan
from mcdas_opt.domain.sensor import Sensor
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.domain.vocabulary import Sector
from mcdas_opt.interop.esr_can import detection_of
from mcdas_opt.interop.esr_codec import EsrCodec, EsrHealth, EsrMotion, EsrTarget, WrongLengthError
from mcdas_opt.interop.live.inbox import Arrival
from mcdas_opt.simulation.sensors import mounting

_INTERVALS = 20  # between scans, to know the radar's period by
_LOST_PERIODS = 1.5  # a longer interval has lost a scan
_INDICES = 65536  # of the radar's scan counter
_RESTARTED = 1000  # scans; a counter that jumps by more began anew


@dataclass(slots=True)
class Drops:
    """What did not arrive as it should have, so far."""

    bad_frames: int = 0  # of a wrong length
    bus_faults: int = 0  # error and remote frames, failures of the bus
    other_frames: int = 0  # sound, and not this radar's
    dropped_scans: int = 0  # by the radar's counter where it sends one, else by the time between scans
    incomplete_scans: int = 0  # with fewer slots than the radar has been sending

    def plus(self, other: Drops) -> Drops:
        return Drops(*map(add, astuple(self), astuple(other)))


@dataclass(slots=True)
class _Open:
    """The scan that is arriving."""

    first_s: float
    seen: set[int] = field(default_factory=set)
    detections: list[RadarDetection] = field(default_factory=list)
    slots: int = 0


class ScanAssembler:
    """Belongs to one radar. A scan ends when a message comes again, or half a period after its first frame."""

    def __init__(self, sector: Sector, codec: EsrCodec, vehicle: Vehicle, sensor: Sensor) -> None:
        self.drops = Drops()
        self.speed: tuple[float, float] | None = None  # (time, m/s) of the host as the radar was told it
        self.heard_s: float | None = None  # of any frame
        self.radar_heard_s: float | None = None  # of a track frame
        self._sector, self._codec, self._sensor, self._place = sector, codec, sensor, mounting(sector, vehicle)
        self._open: _Open | None = None
        self._done: list[Scan] = []
        self._working = True
        self._last_s: float | None = None
        self._intervals: deque[float] = deque(maxlen=_INTERVALS)
        self._index: int | None = None
        self._steps: deque[int] = deque(maxlen=_INTERVALS)  # of the radar's counter
        self._most_slots = 0

    @property
    def period_s(self) -> float:
        """Median time between scans; the sensor's own until some have come."""
        return median(self._intervals) if len(self._intervals) >= 3 else 1.0 / self._sensor.rate_hz

    def take(self, arrival: Arrival) -> None:
        if arrival.fault:
            self.drops.bus_faults += 1
            return
        self.heard_s = arrival.t_s
        try:
            item = self._codec.decode(arrival.identifier, arrival.data)
        except WrongLengthError:
            self.drops.bad_frames += 1
            return
        if item is None:
            self.drops.other_frames += 1
            return
        self._end_if_over(arrival.t_s, arrival.identifier)
        if self._open is None:
            self._open = _Open(first_s=arrival.t_s)
        self._open.seen.add(arrival.identifier)
        if isinstance(item, EsrHealth):
            self._working = item.working
        elif isinstance(item, EsrMotion):
            self.speed = (arrival.t_s, item.speed_mps)
            self._count(item.scan_index)
        else:
            self._note(item, arrival.t_s)

    def ready(self, now: float) -> list[Scan]:
        """The scans that are complete at `now`, oldest first; each is handed out once."""
        self._end_if_over(now, None)
        done, self._done = self._done, []
        return done

    def _note(self, target: EsrTarget, t_s: float) -> None:
        assert self._open is not None
        self.radar_heard_s = t_s
        self._open.slots += 1
        if target.status.measured:
            self._open.detections.append(detection_of(target, self._sensor))

    def _count(self, index: int) -> None:
        """By the radar's own counter, in steps of the smallest seen of late; one that jumps far or stands still began anew, or is none."""
        step = 0 if self._index is None else (index - self._index) % _INDICES
        self._index = index
        if 0 < step < _RESTARTED:
            self._steps.append(step)
            self.drops.dropped_scans += step // min(self._steps) - 1

    def _end_if_over(self, t_s: float, identifier: int | None) -> None:
        scan = self._open
        if scan is None or (identifier not in scan.seen and t_s - scan.first_s <= 0.5 * self.period_s):
            return
        self._open = None
        if not scan.slots:
            return
        if self._last_s is not None:
            interval = scan.first_s - self._last_s
            if not self._steps and interval > _LOST_PERIODS * self.period_s:
                self.drops.dropped_scans += round(interval / self.period_s) - 1
            self._intervals.append(interval)
        self._last_s = scan.first_s
        self.drops.incomplete_scans += scan.slots < self._most_slots
        self._most_slots = max(self._most_slots, scan.slots)
        self._done.append(
            Scan(
                sensor=f"esr-{self._sector.value}",
                sector=self._sector,
                t_s=scan.first_s,
                mounting=self._place,
                radar=tuple(scan.detections),
                working=self._working,
                period_s=self.period_s,
            )
        )
