"""The record of a replay: every cycle's tracks, mode and status, and a summary."""

from __future__ import annotations

from dataclasses import dataclass, field
from operator import attrgetter
from typing import Any, ClassVar

import numpy as np

from mcdas_opt.domain.document import to_document
from mcdas_opt.domain.doubt import Doubt
from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.measurement import Mounting
from mcdas_opt.domain.plan import Plan
from mcdas_opt.domain.result import Columns, Result
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.rules import Array
from mcdas_opt.domain.track import Track
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.domain.vocabulary import Alert, Mode, Role, Sector, Side, Status
from mcdas_opt.interop.sensor_log import SensorLog
from mcdas_opt.simulation.record import CycleTimes

_SAID = ("mode", "side", "status", "alert", "warning", "reason")
_ASKED = ("acceleration_mps2", "steering_rad", "speed_mps")
_SEEN = ("id", "role", "s_m", "d_m", "speed_s_mps", "speed_d_mps", "length_m", "width_m", "coasting")


@dataclass(frozen=True, slots=True, kw_only=True)
class SeenTrack:
    """A track at a cycle. `s_m`, `d_m`: its body centre from the host's body centre at that time, along and across the road.

    Speeds are over ground; `covariance` is 4 x 4 in the order (s, s speed, d, d speed).
    """

    id: str
    role: Role
    s_m: float
    d_m: float
    speed_s_mps: float
    speed_d_mps: float
    covariance: Array
    length_m: float
    width_m: float
    coasting: bool

    @classmethod
    def of(cls, track: Track, host: HostState, role: Role) -> SeenTrack:
        """A track as it is seen from the host."""
        return cls(
            id=track.id,
            role=role,
            s_m=track.s_m - host.s_m,
            d_m=track.d_m - host.d_m,
            speed_s_mps=track.speed_s_mps,
            speed_d_mps=track.speed_d_mps,
            covariance=track.covariance,
            length_m=track.length_m,
            width_m=track.width_m,
            coasting=track.coasting,
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class Cycle:
    """One step of the pipeline. `mode` is the plan's, or the selector's where nothing was planned: `status`, `alert`, `plan` are then None.

    `acceleration_mps2`, `steering_rad` and `speed_mps` are what the plan has one cycle later: at the cycle itself they are the host's own.
    `doubts` are the plan's: tracks that cannot all be true. The plan is no part of the document.
    """

    t_s: float
    host: HostState
    tracks: tuple[SeenTrack, ...]
    covered: tuple[Sector, ...]
    mode: Mode
    side: Side
    warning: bool
    status: Status | None
    alert: Alert | None = None
    reason: str = ""
    doubts: tuple[Doubt, ...] = ()
    acceleration_mps2: float | None = None
    steering_rad: float | None = None
    speed_mps: float | None = None
    plan: Plan | None = field(default=None, repr=False, compare=False)


@dataclass(frozen=True, slots=True, kw_only=True)
class Summary:
    """Counts over the whole replay.

    `frames_good`, `frames_bad`, `frames_other`: sound records of the radar, faulty ones (`bad` says which, and where the first
    stands), sound ones that are not the radar's. `gated`: slots that the reader did not pass on, by the radar's own status;
    `tracker`: what the tracker counted. `sensor_pieces`: how many targets the sensor itself told apart. `tracks_started`
    and `tracks_ended` count confirmed tracks. `covered`: share of the cycles in which a working sensor watched the sector.
    `modes` and `statuses` count cycles; `cycles_left_out` are those in which no radar had been heard for long, and nothing was done.
    `radars`: the file, and the bus, of each sector's radar.
    """

    cycles: int
    start_s: float
    end_s: float
    frames_good: int
    frames_bad: int
    frames_other: int
    bad: dict[str, dict[str, int]] = field(default_factory=dict)
    scans: int = 0
    detections: int = 0
    gated: dict[str, int] = field(default_factory=dict)
    tracker: dict[str, int] = field(default_factory=dict)
    sensor_pieces: int | None = None
    tracks_started: int = 0
    tracks_ended: int = 0
    longest_track_s: float = 0.0
    covered: dict[str, float] = field(default_factory=dict)
    plans: int = 0
    unverified_plans: int = 0
    statuses: dict[str, int] = field(default_factory=dict)
    modes: dict[str, int] = field(default_factory=dict)
    cycle_ms: CycleTimes = field(default_factory=CycleTimes)
    cycles_left_out: int = 0
    radars: dict[str, str] = field(default_factory=dict)

    def span(self) -> str:
        """How long it is, and from when on, also where that is counted from 1970."""
        told = f"{self.end_s - self.start_s:.1f} s from {self.start_s:.10g} s"
        return f"{told}, {self.cycles_left_out} without a scan left out" if self.cycles_left_out else told


@dataclass(frozen=True, slots=True, kw_only=True, repr=False)
class Replay(Result):
    """A recording after its run through the pipeline. What it was run with (`road`, `vehicle`, `log`) is not part of the document."""

    drawn_by: ClassVar[str] = "mcdas_opt.plotting.replay:replay_figure"
    plays_by: ClassVar[str] = "mcdas_opt.plotting.replay_player:replay_page"

    name: str
    format: str
    planner: str | None
    cycles: tuple[Cycle, ...]
    summary: Summary
    road: Road = field(repr=False)
    vehicle: Vehicle = field(repr=False)
    log: SensorLog = field(repr=False)

    def mounting(self, sector: Sector) -> Mounting:
        """Where the radar of a sector sits on the host."""
        return next(scan.mounting for scan in self.log.scans if scan.sector is sector)

    def in_brief(self) -> tuple[str, str, str]:
        found = self.summary
        plans = ", ".join(f"{count} {status}" for status, count in found.statuses.items()) or "no plans"
        return (
            f"Replay {self.name} ({self.format}): {found.cycles} cycles, {found.span()}",
            f"{found.detections} detections, {found.tracks_started} tracks, the longest {found.longest_track_s:.1f} s",
            f"{plans}; " + ", ".join(f"{mode} {count}" for mode, count in found.modes.items()),
        )

    def columns(self) -> Columns:
        """A track of a cycle a row, with what was decided in that cycle; a cycle without tracks is a row without one."""
        pairs = [(cycle, track) for cycle in self.cycles for track in (cycle.tracks or (None,))]
        table: dict[str, list[Any]] = {
            "t_s": [cycle.t_s for cycle, _ in pairs],
            "host_s_m": [cycle.host.s_m for cycle, _ in pairs],
            "host_speed_mps": [cycle.host.speed_mps for cycle, _ in pairs],
            **{name: [to_document(attrgetter(name)(cycle)) for cycle, _ in pairs] for name in (*_SAID, *_ASKED)},
            **{f"track_{name}": [None if track is None else to_document(attrgetter(name)(track)) for _, track in pairs] for name in _SEEN},
        }
        for k, name in ((0, "s"), (2, "d")):
            table[f"track_{name}_sd_m"] = [None if track is None else float(np.sqrt(track.covariance[k, k])) for _, track in pairs]
        return table
