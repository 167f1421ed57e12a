"""Adaptive cruise control after ISO 15622: keeps its lane, its speed and its time gap, and brakes by no more than the standard lets it."""

from __future__ import annotations

from dataclasses import dataclass

from mcdas_opt.actuation.adaptive_cruise import AdaptiveCruise
from mcdas_opt.actuation.path_following import STEP_S
from mcdas_opt.baselines.lane import LaneMethod, judged, leader_of, neighbours_in
from mcdas_opt.domain.plan import Plan
from mcdas_opt.domain.settings import Settings
from mcdas_opt.domain.situation import Situation
from mcdas_opt.domain.track import Track
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.dynamics.car_following import iso_15622_limits


@dataclass(frozen=True, slots=True, kw_only=True)
class CruiseLaw:
    """The controller behind a front car that keeps its speed; its acceleration changes no faster than the standard's jerk."""

    cruise: AdaptiveCruise
    situation: Situation
    vehicle: Vehicle
    front: Track | None
    desired_mps: float

    def wanted_mps2(self, t_s: float, s_m: float, speed_mps: float) -> float:
        leader = leader_of(self.front, self.situation, self.vehicle, s_m, t_s)
        wanted = self.cruise.wanted_mps2(speed_mps, self.desired_mps, leader)
        now, turned = self.situation.host.acceleration_mps2, iso_15622_limits(speed_mps)[2] * (t_s + STEP_S)
        return min(max(wanted, now - turned), now + turned)


class AccMethod(LaneMethod):
    """Knows the car ahead in its lane and nothing else; the time gap is `Settings.headway`'s. Its plans are not repaired."""

    name = "acc"

    def __init__(self, vehicle: Vehicle, settings: Settings | None = None) -> None:
        super().__init__(vehicle, settings)
        headway = self.settings.headway
        self.cruise = AdaptiveCruise(time_gap_s=headway.time_gap_s, standstill_m=headway.standstill_m)

    def drive(self, situation: Situation, previous: Plan | None) -> Plan:
        lane = situation.host_lane
        front = neighbours_in(lane, situation, self.vehicle).ahead
        limit = situation.road.limit_mps(lane, situation.host.s_m, self.settings.speed_limit_excess)
        desired = min(situation.wanted_speed_mps, limit)
        law = CruiseLaw(cruise=self.cruise, situation=situation, vehicle=self.vehicle, front=front, desired_mps=desired)
        reason = "keeps its speed" if front is None else f"keeps its speed and its gap to {front.id}"
        return judged(self.name, situation, self.vehicle, self.settings, law=law, reason=reason)
