"""The record of a closed-loop drive."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from enum import StrEnum
from itertools import combinations
from typing import Any, ClassVar

import numpy as np

from mcdas_opt.catalogue.scenes import Scene
from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.plan import Plan
from mcdas_opt.domain.result import Columns, Result
from mcdas_opt.domain.rules import Array
from mcdas_opt.domain.track import Track
from mcdas_opt.domain.trajectory import Trajectory
from mcdas_opt.geometry.frenet import FrenetFrame
from mcdas_opt.geometry.rectangle import corners, separation
from mcdas_opt.simulation.contact import TOUCH_WITHIN_M
from mcdas_opt.simulation.metrics import History
from mcdas_opt.simulation.recorded import GONE_M


class Outcome(StrEnum):
    SAFE = "safe"
    COLLISION = "collision"
    LEFT_ROAD = "left_road"


@dataclass(frozen=True, slots=True, kw_only=True)
class CycleTimes:
    """Wall-clock milliseconds of the cycles; the only part of a simulation or a replay that does not repeat."""

    p50: float = 0.0
    p99: float = 0.0
    max: float = 0.0

    @classmethod
    def of(cls, took_ms: Sequence[float]) -> CycleTimes:
        p50, p99, most = (float(q) for q in np.percentile(took_ms, [50, 99, 100]))
        return cls(p50=p50, p99=p99, max=most)


@dataclass(frozen=True, slots=True, kw_only=True)
class NeighbourHistory:
    """Where a neighbour truly was, at the times of the driven trajectory."""

    name: str
    length_m: float
    width_m: float
    s_m: Array
    d_m: Array
    heading_rad: Array
    speed_mps: Array


@dataclass(frozen=True, slots=True, kw_only=True)
class Cycle:
    """One turn of the loop: the host's state, the tracks, the plan, and how long it took."""

    time_s: float
    host: HostState
    tracks: tuple[Track, ...]
    plan: Plan
    took_ms: float = field(default=0.0, compare=False)

    def in_short(self) -> dict[str, Any]:
        """What was planned and why."""
        plan = self.plan
        return {
            "time_s": self.time_s,
            "mode": plan.mode.value,
            "status": plan.status.value,
            "alert": plan.alert.value,
            "chosen": plan.chosen,
            "reason": plan.reason,
        }


@dataclass(frozen=True, slots=True, kw_only=True, repr=False)
class Simulation(Result):
    """A drive and its figures; attributes are the keys of the JSON document, but for `scene` and `history` (for drawing).

    `cycles[k].plan` is the plan of cycle k, its `reason` says why; of each the document has `time_s`, `mode`, `status`, `alert`, `chosen`
    and `reason`.

    The drive ends at the scene's duration, at the first touch of another body, or where a corner leaves the road: `duration_s` is the
    time driven. Distances and times are of the true bodies, 0.01 s apart. `impact_speed_mps` is the speed of one body's centre
    relative to the other's; jerk and steering rate are the actuators', so that the jolt with which braking ends at standstill is not
    counted. `lane_changes` is how often the host settled in another lane, `lane_change_completed` whether it ended settled in another one
    than it began in. `destination` says how a drive that had one stands with it at its end; `destination_reached_s` when it was first
    there. `error` says what a plant did that ended the drive; `outcome` is then of the drive up to there.
    """

    drawn_by: ClassVar[str] = "mcdas_opt.plotting.animation:sheet"
    moves_by: ClassVar[str] = "mcdas_opt.plotting.animation:film"
    plays_by: ClassVar[str] = "mcdas_opt.plotting.player:drive_page"

    name: str
    planner: str
    plant: str
    solver: str
    seed: int
    duration_s: float
    outcome: Outcome
    collided_with: str | None
    impact_speed_mps: float
    min_clearance_m: float | None
    min_ttc_front_s: float | None
    min_ttc_rear_s: float | None
    max_lateral_acceleration_mps2: float
    max_jerk_mps3: float
    max_steering_rate_radps: float
    lane_change_completed: bool
    modes: tuple[tuple[float, str], ...]
    plans: int
    fallbacks: int
    unavoidable: int
    unverified_plans: int
    cycle_ms: CycleTimes
    trajectory: Trajectory
    lane_changes: int = 0
    destination: str = ""
    destination_reached_s: float | None = None
    error: str = ""
    neighbours: tuple[NeighbourHistory, ...] = ()
    scene: Scene = field(repr=False, compare=False)
    cycles: tuple[Cycle, ...] = field(repr=False, compare=False)
    history: History = field(repr=False, compare=False)

    @property
    def is_safe(self) -> bool:
        """Safe to the end that was meant: neither the drive nor its plant failed."""
        return self.outcome is Outcome.SAFE and not self.error

    @property
    def ended(self) -> str:
        """In a word or two."""
        return "plant failed" if self.error else self.outcome.value

    @property
    def driven_with(self) -> str:
        """The plant, where it is not the kinematic one, and the seed, in words."""
        return f"seed {self.seed}" if self.plant == "kinematic" else f"{self.plant} plant, seed {self.seed}"

    def to_dict(self) -> dict[str, Any]:
        """The JSON document of the contract; of every cycle, what was planned and why."""
        return {**Result.to_dict(self), "cycles": [cycle.in_short() for cycle in self.cycles]}

    def first_overlap(self) -> tuple[float, str, str] | None:
        """When two neighbours are in one place for the first time [s], and which: a script that nobody can have meant. None: never.

        In the plane, as `surroundings` has it; who has left is nowhere.
        """
        if len(self.neighbours) < 2:
            return None
        found = []
        s = np.concatenate([one.s_m for one in self.neighbours])
        frame = FrenetFrame(road=self.scene.true_road, s_min_m=float(s.min()) - 1.0, s_max_m=float(s.max()) + 1.0)
        shapes = [corners(*frame.to_plane(one.s_m, one.d_m, one.heading_rad), one.length_m, one.width_m) for one in self.neighbours]
        for (one, shape), (other, shape_of_other) in combinations(zip(self.neighbours, shapes, strict=True), 2):
            near = (np.abs(one.s_m - other.s_m) < TOUCH_WITHIN_M) & (np.minimum(one.d_m, other.d_m) < GONE_M)
            overlap = near & (separation(shape, shape_of_other) < 0.0)
            if overlap.any():
                found.append((float(self.trajectory.t_s[int(overlap.argmax())]), one.name, other.name))
        return min(found, default=None)

    @property
    def among_others(self) -> str:
        """The neighbours that drive through each other, in words; empty without."""
        overlap = self.first_overlap()
        if overlap is None:
            return ""
        when, one, other = overlap
        return f"{one} and {other} collide with each other at {when:.1f} s; the host is not involved"

    def in_brief(self) -> tuple[str, str, str]:
        ended = "" if self.collided_with is None else f" with {self.collided_with} at {self.impact_speed_mps:.1f} m/s"
        least = "nobody else" if self.min_clearance_m is None else f"least clearance {self.min_clearance_m:.2f} m"
        return (
            f"Drive of {self.planner} through {self.name} ({self.driven_with}): {self.ended}{ended} after {self.duration_s:.1f} s",
            f"{least}, lateral at most {self.max_lateral_acceleration_mps2:.1f} m/s^2, {', '.join(mode for _, mode in self.modes)}",
            f"{self.plans} plans ({self.fallbacks} fallbacks, {self.unavoidable} unavoidable, {self.unverified_plans} unverified), "
            f"cycle p50 {self.cycle_ms.p50:.1f} ms, p99 {self.cycle_ms.p99:.1f} ms",
        )

    def columns(self) -> Columns:
        """The driven trajectory, then `NAME.s_m` and so on of every neighbour at the same times."""
        theirs = {
            f"{one.name}.{name}": column
            for one in self.neighbours
            for name, column in (("s_m", one.s_m), ("d_m", one.d_m), ("heading_rad", one.heading_rad), ("speed_mps", one.speed_mps))
        }
        return self.trajectory.columns() | theirs
