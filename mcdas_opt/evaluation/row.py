"""One drive of one planner as one row of the table, and the time that its plans took, which is no part of it."""

from __future__ import annotations

import time
from dataclasses import dataclass
from operator import attrgetter
from textwrap import shorten
from typing import Any

import numpy as np

from mcdas_opt.domain.document import to_document
from mcdas_opt.domain.settings import Settings, WarningSettings
from mcdas_opt.domain.vocabulary import Alert, Mode, Side, Status
from mcdas_opt.evaluation.case import Case
from mcdas_opt.simulation.idm import STEP_S
from mcdas_opt.simulation.ordinary import HEADWAYS_S, Instant, instants_of, ordinary_driving
from mcdas_opt.simulation.record import Cycle, Outcome, Simulation

HARD_BRAKING_MPS2 = 3.5  # in ordinary following nobody needs as much
SHARP_STEERING_MPS2 = 2.0  # lateral acceleration beyond what the road's bend asks for
_BUMPER_M = 0.6  # bodies that overlap along the road by no more than this at the touch met bumper to bumper
LONGEST_REASON = 400  # characters
_STILL_MPS = 0.05  # sideways; slower than this a lane change has ended
_OF_THE_DRIVE = (  # columns that are figures of the drive as they are
    *("impact_speed_mps", "duration_s", "min_clearance_m", "min_ttc_front_s", "min_ttc_rear_s", "max_lateral_acceleration_mps2"),
    *("max_jerk_mps3", "max_steering_rate_radps", "lane_change_completed"),
    *("plans", "fallbacks", "unavoidable", "unverified_plans", "solver"),
)
_DRIVING = Settings(warning=WarningSettings(escapes=False))  # no figure reads the escape map, and no plan depends on it
CALM_S = 1.0  # so long before the drive's end nothing of an emergency is left
_OFFSET_M, _HEADING_RAD = 0.3, 0.03  # from the lane's middle and its direction
_SLOWER_MPS, _GAINING_MPS2 = 3.0, 0.2  # than it might drive, or gaining speed
_HARD_MPS2 = 3.5


@dataclass(frozen=True, slots=True, kw_only=True)
class Row:
    """A row. `ended`: drove, raised, too long or died; where it did not drive, everything from `outcome` on is empty.

    `hit`: on which face of the host (front, rear, side). `intervention`: steering or braking beyond ordinary driving.
    Time gaps are those that no cut-in had made (`simulation.ordinary`): the least, and the seconds under 0.8 s.
    `settling_error_m`: distance to the target lane's centre when a lane change ended (sideways motion stopped or turned).
    """

    index: int
    scene: str
    family: str
    traffic: str
    nominal: bool
    seed: int
    planner: str
    plant: str
    ended: str = "drove"
    outcome: str = ""
    collided_with: str = ""
    hit: str = ""
    impact_speed_mps: float | None = None
    duration_s: float | None = None
    min_clearance_m: float | None = None
    min_ttc_front_s: float | None = None
    min_ttc_rear_s: float | None = None
    max_lateral_acceleration_mps2: float | None = None
    max_deceleration_mps2: float | None = None
    max_jerk_mps3: float | None = None
    max_steering_rate_radps: float | None = None
    lane_change_completed: bool | None = None
    settling_error_m: float | None = None
    intervention: str = ""
    modes: str = ""
    least_headway_s: float | None = None
    short_headway_s: float | None = None
    outside_iso_s: float | None = None
    lane_changes: int = 0
    followers_braked: int = 0
    ordinary_again: bool | None = None
    plans: int = 0
    fallbacks: int = 0
    unavoidable: int = 0
    unverified_plans: int = 0
    first_reason: str = ""
    solver: str = ""
    error: str = ""

    def to_dict(self) -> dict[str, Any]:
        document: dict[str, Any] = to_document(self)
        return document


@dataclass(frozen=True, slots=True, kw_only=True)
class Driven:
    """A row, the milliseconds of each of its plans, and the seconds of the whole drive: plant, traffic and sensors too."""

    row: Row
    cycles_ms: tuple[float, ...] = ()
    took_s: float = 0.0


def head(case: Case, planner: str, plant: str) -> dict[str, Any]:
    """The columns that are known before anybody drives."""
    return {
        "index": case.index,
        "scene": case.scene.name,
        "family": case.family,
        "traffic": case.traffic.value,
        "nominal": case.nominal,
        "seed": case.scene.seed,
        "planner": planner,
        "plant": plant,
    }


def drive(case: Case, planner: str, plant: str) -> Driven:
    """Drives one planner through one case."""
    from mcdas_opt.simulation.loop import simulate

    started = time.perf_counter()
    run = simulate(case.scene, planner, plant, settings=_DRIVING)
    took = time.perf_counter() - started
    return Driven(row=row_of(case, run), cycles_ms=tuple(round(cycle.took_ms, 3) for cycle in run.cycles), took_s=round(took, 4))


def row_of(case: Case, run: Simulation) -> Row:
    """The figures of a drive."""
    instants = instants_of(run)
    ordinary = ordinary_driving(instants)
    emergencies = [cycle.plan.reason for cycle in run.cycles if cycle.plan.status is not Status.PLANNED]
    return Row(
        **head(case, run.planner, run.plant),
        **{name: attrgetter(name)(run) for name in _OF_THE_DRIVE},
        outcome=run.outcome.value,
        collided_with=run.collided_with or "",
        hit=_face(run),
        max_deceleration_mps2=float(np.maximum(-run.history.states[:, 4], 0.0).max()),
        settling_error_m=settling_error_m(run),
        intervention=_intervention(run),
        modes=" ".join(f"{t:g}:{mode}" for t, mode in run.modes),
        least_headway_s=ordinary.least_headway_s,
        short_headway_s=ordinary.short_headway_s[-1],
        outside_iso_s=ordinary.outside_iso_s,
        lane_changes=ordinary.lane_changes,
        followers_braked=ordinary.followers_braked,
        ordinary_again=ordinary_again(run, instants),
        first_reason=shorten(emergencies[0], LONGEST_REASON, placeholder=" …") if emergencies else "",
    )


def settling_error_m(run: Simulation) -> float | None:
    """How far from the centre of its new lane the host was when its sideways motion first stopped or turned after it had crossed into
    that lane, in a drive that ended there; None without a lane change or where it never stopped. (The paper's Tables 3 and 4 take the
    distance from the target at the end of the path.)"""
    road, s, d = run.scene.true_road, run.history.states[:, 0], run.history.states[:, 1]
    lanes = np.array([road.lane_of(float(here), float(along)) for along, here in zip(s, d, strict=True)])
    lane = int(lanes[-1])
    if lane == lanes[0] or run.outcome is not Outcome.SAFE:
        return None
    crossed = int(np.flatnonzero(lanes != lane)[-1]) + 1
    heading = np.sign(road.lane_centre_m(lane, float(s[-1])) - road.lane_centre_m(int(lanes[0]), float(s[0])))
    sideways = heading * np.diff(d) / STEP_S
    stopped = np.flatnonzero(sideways[crossed:] < _STILL_MPS)
    return abs(float(d[crossed + int(stopped[0])]) - road.lane_centre_m(lane, float(s[-1]))) if stopped.size else None


def _face(run: Simulation) -> str:
    """Which face of the host was hit."""
    if run.collided_with is None:
        return ""
    other = next(other for other in run.neighbours if other.name == run.collided_with)
    apart = float(other.s_m[-1]) - float(run.trajectory.s_m[-1])
    if abs(apart) < 0.5 * (other.length_m + run.scene.vehicle.length_m) - _BUMPER_M:
        return "side"
    return "front" if apart > 0.0 else "rear"


def _intervention(run: Simulation) -> str:
    """What went beyond ordinary driving: steering out, or hard braking. Changing lanes without evading is ordinary."""
    road, states = run.scene.true_road, run.history.states
    bend = states[:-1, 3] ** 2 * np.asarray(road.curvature_at(states[:-1, 0]))
    sharp = np.abs(run.history.lateral_acceleration_mps2 - bend).max(initial=0.0) > SHARP_STEERING_MPS2
    changed = any(cycle.plan.side is not Side.NONE and cycle.plan.mode is not Mode.EVADE for cycle in run.cycles)
    left_lane = not changed and road.lane_of(float(states[-1, 1]), float(states[-1, 0])) != road.lane_of(
        float(states[0, 1]), float(states[0, 0])
    )
    evaded = any(mode == Mode.EVADE.value for _, mode in run.modes)
    braked = float(states[:, 4].min()) < -HARD_BRAKING_MPS2
    return "+".join(word for word, true in (("steering", evaded or sharp or left_lane), ("braking", braked)) if true)


def ordinary_again(run: Simulation, instants: tuple[Instant, ...]) -> bool | None:
    """Whether a drive with an emergency ended in ordinary driving: calm, in the middle of a lane, as fast as desired, limit and leader
    let it (or gaining speed), and with a time gap of 0.8 s (or an opening one). None without an emergency; false where it ended in none."""
    emergencies = [cycle.time_s for cycle in run.cycles if _emergency(cycle)]
    if not emergencies:
        return None
    if run.outcome is not Outcome.SAFE or emergencies[-1] > run.duration_s - CALM_S:
        return False
    road, last = run.scene.true_road, instants[-1]
    s, d, heading = float(run.trajectory.s_m[-1]), float(run.trajectory.d_m[-1]), float(run.trajectory.heading_rad[-1])
    bend = float(road.curvature_at(run.trajectory.s_m[-1])) * run.scene.vehicle.centre_m
    settled = abs(d - road.lane_centre_m(road.lane_of(d, s), s)) < _OFFSET_M and abs(heading + bend) < _HEADING_RAD
    most = min(run.scene.desired_speed_mps, road.speed_limit_mps, *([last.leader.speed_mps] if last.leader is not None else []))
    fast = last.speed_mps > most - _SLOWER_MPS or last.acceleration_mps2 > _GAINING_MPS2
    gap = last.headway_s is None or last.headway_s >= HEADWAYS_S[-1] or (last.leader is not None and last.leader.speed_mps > last.speed_mps)
    return settled and fast and gap


def _emergency(cycle: Cycle) -> bool:
    """Somebody was alarmed, steered out, fell back on a lower rung, or braked hard."""
    plan = cycle.plan
    alarmed = plan.alert is not Alert.NONE or plan.warning or plan.status is not Status.PLANNED
    return alarmed or plan.mode is Mode.EVADE or cycle.host.acceleration_mps2 < -_HARD_MPS2
