"""Who is ahead and behind in a lane, and a drive in it put before the judge: what every baseline needs."""

from __future__ import annotations

import time
from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import NamedTuple

from mcdas_opt.actuation.path_following import AccelerationLaw
from mcdas_opt.domain.plan import Candidate, Plan, Refusal, Timing
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.settings import SelectorSettings, Settings
from mcdas_opt.domain.situation import Situation
from mcdas_opt.domain.track import Track
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.domain.vocabulary import Mode, Request, Side
from mcdas_opt.dynamics.car_following import Leader
from mcdas_opt.planning.candidates.path_driving import Kind, follow
from mcdas_opt.reference.lane_centre import LaneCentre
from mcdas_opt.reference.offset_path import OffsetPath
from mcdas_opt.situation.roles import CROSSES_S, reach_into_m
from mcdas_opt.tracking.prediction import predict_for
from mcdas_opt.verification.judge import judge

_INTRUSION_M = SelectorSettings().lane_intrusion_m
_STEADY_MPS2 = 0.2  # what accelerates or brakes by less keeps its speed


class LaneMethod(ABC):
    """A method that drives along the road and does nothing else; its plans are not repaired."""

    has_ladder = False

    def __init__(self, vehicle: Vehicle, settings: Settings | None = None) -> None:
        self.vehicle, self.settings = vehicle, settings or Settings()

    def plan(self, situation: Situation, previous: Plan | None) -> Plan | Refusal:
        if situation.request is Request.PARK:
            return Refusal(reason="parking is planned by park, not by the lane planner")
        return self.drive(situation, previous)

    @abstractmethod
    def drive(self, situation: Situation, previous: Plan | None) -> Plan: ...


class Neighbours(NamedTuple):
    """The nearest body ahead and behind in a lane; None where there is none."""

    ahead: Track | None
    behind: Track | None


def neighbours_in(lane: int, situation: Situation, vehicle: Vehicle) -> Neighbours:
    """By their centres. In a lane is whose centre is in it, and in the host's own whoever it would touch, too. `Road.lane_of` counts
    who is beside the road to its outermost lane: there is only who reaches into it, or will on his way across."""
    host, road = situation.host, situation.road
    own = lane == situation.host_lane
    there = [
        track
        for track in situation.tracks
        if (road.lane_of(track.d_m, track.s_m) == lane and _comes_into(lane, track, road))
        or (own and abs(track.d_m - host.d_m) < 0.5 * (track.width_m + vehicle.width_m))
    ]
    ahead = min((track for track in there if track.s_m > host.s_m), key=lambda track: track.s_m, default=None)
    behind = max((track for track in there if track.s_m <= host.s_m), key=lambda track: track.s_m, default=None)
    return Neighbours(ahead=ahead, behind=behind)


def _comes_into(lane: int, track: Track, road: Road) -> bool:
    moves = CROSSES_S * track.speed_d_mps if track.crosses else 0.0
    return reach_into_m(track.s_m, track.d_m, track.across_m, lane, road, moves) >= _INTRUSION_M


def leader_of(track: Track | None, situation: Situation, vehicle: Vehicle, s_m: float | None = None, t_s: float = 0.0) -> Leader | None:
    """The gap to a body ahead and its speed, for a host at s (default where it is) after t, the other going on as it does."""
    if track is None:
        return None
    place = situation.host.s_m if s_m is None else s_m
    gap = track.s_m + track.speed_s_mps * t_s - place - 0.5 * (track.length_m + vehicle.length_m)
    return Leader(gap_m=gap, speed_mps=track.speed_s_mps)


def lane_centre(situation: Situation) -> LaneCentre:
    """The middle of the lane that the host is in."""
    road, host = situation.road, situation.host
    return LaneCentre(d_m=road.lane_centre_m(situation.host_lane, host.s_m))


def strongest_braking_mps2(situation: Situation, vehicle: Vehicle) -> float:
    """What the brakes and the assumed grip give, positive."""
    return min(-vehicle.acceleration_min_mps2, situation.road.grip_mps2)


def judged(
    name: str,
    situation: Situation,
    vehicle: Vehicle,
    settings: Settings,
    *,
    law: AccelerationLaw,
    reason: str,
    path: OffsetPath | None = None,
    side: Side = Side.NONE,
    warning: bool = False,
    lateral_mps2: float | None = None,
    memory: object = None,
) -> Plan:
    """The plan of a baseline: the bicycle under its law along its path (default the lane), with the judge's verdict as it is."""
    started = time.perf_counter()
    trajectory = follow(
        situation.host,
        path or lane_centre(situation),
        law,
        vehicle=vehicle,
        road=situation.road,
        duration_s=float(settings.grid.times_s[-1]),
        lateral_acceleration_mps2=lateral_mps2 or 0.5 * situation.road.grip_mps2,
    )
    solved = time.perf_counter()
    prediction = predict_for(situation, settings.prediction)
    verdict = judge(trajectory, situation.host, vehicle, situation.road, prediction)
    judging = time.perf_counter()
    mode = _mode(law.wanted_mps2(0.0, situation.host.s_m, situation.host.speed_mps), side)
    chosen = side.value if side is not Side.NONE else mode.value
    return Plan(
        planner=name,
        mode=mode,
        side=side,
        warning=warning,
        reason=reason,
        verdict=verdict,
        prediction=prediction.name,
        trajectory=trajectory,
        candidates=(Candidate(name=chosen, cost=None, passed=verdict.passed, refusal="" if verdict.passed else verdict.reason),),
        timing_ms=Timing(solve=1e3 * (solved - started), verify=1e3 * (judging - solved)),
        chosen=chosen,
        time_s=situation.time_s,
        memory=memory,
    )


def _mode(wanted_mps2: float, side: Side) -> Mode:
    if side is not Side.NONE:
        return Mode.EVADE
    if abs(wanted_mps2) < _STEADY_MPS2:
        return Mode.HOLD
    return Mode.BRAKE if wanted_mps2 < 0.0 else Mode.ACCELERATE


@dataclass(frozen=True, slots=True, kw_only=True)
class SteadyLaw:
    """Brakes by `strength_mps2` until no faster than `until_mps`, then keeps its speed; as it is born, it keeps its speed at once."""

    strength_mps2: float = 0.0
    until_mps: float = 0.0

    @property
    def numbers(self) -> tuple[float, ...]:
        return (Kind.STEADY, self.strength_mps2, self.until_mps)

    def wanted_mps2(self, t_s: float, s_m: float, speed_mps: float) -> float:
        return -self.strength_mps2 if speed_mps > self.until_mps else 0.0
