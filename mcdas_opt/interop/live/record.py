"""The records of the live loop: a line a cycle, and a summary."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

from mcdas_opt.domain.document import SCHEMA_VERSION, to_document
from mcdas_opt.domain.doubt import Doubt
from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.trajectory import Trajectory
from mcdas_opt.domain.vocabulary import Alert
from mcdas_opt.interop.live.assembler import Drops
from mcdas_opt.interop.replay_record import SeenTrack
from mcdas_opt.simulation.record import CycleTimes

WAITING, LATE, FAULT = "waiting", "late", "fault"  # statuses beside those of a plan


@dataclass(frozen=True, slots=True, kw_only=True)
class Line:
    """One cycle. `status` is the plan's, "waiting" (no host speed yet), or "late": no plan in time, so that the last one goes on, or
    "fault": the planner failed, and begins anew; `reason` says how, and the last plan goes on.

    `acceleration_mps2` and `steering_rad` are what the plan asks for a cycle later: at the line's own time they are about the host's
    own. None where there is none, or it has run out. `alert` is the plan's (none, warn, act; warn with a fault), `warning` whether it is
    not none. `doubts` are the plan's: tracks that cannot all be true. `plan_age_s`: since the situation that was planned. `late_s`: how
    long after its beat the cycle began. `late_cycles`, `missed_cycles`, `faults` and `drops` count from the start.
    """

    cycle: int
    t_s: float
    status: str
    mode: str | None = None
    side: str | None = None
    alert: Alert | None = None
    warning: bool = False
    passed: bool | None = None
    reason: str = ""
    doubts: tuple[Doubt, ...] = ()
    plan_age_s: float | None = None
    acceleration_mps2: float | None = None
    steering_rad: float | None = None
    host: HostState | None = None
    covered: tuple[str, ...] = ()
    silent: tuple[str, ...] = ()
    tracks: tuple[SeenTrack, ...] = ()
    scans: int = 0
    late_s: float = 0.0
    took_ms: float = 0.0
    late_cycles: int = 0
    missed_cycles: int = 0
    faults: int = 0
    drops: Drops = field(default_factory=Drops)
    trajectory: Trajectory | None = None

    def to_dict(self) -> dict[str, Any]:
        return {"schema_version": SCHEMA_VERSION, **to_document(self)}


@dataclass(frozen=True, slots=True, kw_only=True)
class LiveSummary:
    """Counts over a whole run. `late_cycles`: lines that said "late"; `missed_cycles`: beats that passed while one was worked on;
    `faults`: cycles in which the planner failed; `tracker`: what its tracker counted, as in a replay's summary."""

    cycles: int
    duration_s: float
    statuses: dict[str, int]
    late_cycles: int
    missed_cycles: int
    unverified_plans: int
    faults: int
    drops: dict[str, Drops]
    tracker: dict[str, int]
    cycle_ms: CycleTimes

    def to_dict(self) -> dict[str, Any]:
        return {"schema_version": SCHEMA_VERSION, **to_document(self)}
