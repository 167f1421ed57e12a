"""Autonomous emergency braking: nothing until the last moment at which braking alone suffices, then everything."""

from __future__ import annotations

from dataclasses import dataclass

from mcdas_opt.domain.plan import Plan, Refusal
from mcdas_opt.domain.rules import non_negative
from mcdas_opt.domain.settings import Settings
from mcdas_opt.domain.situation import Situation
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.domain.vocabulary import Request
from mcdas_opt.dynamics.car_following import Leader
from mcdas_opt.planning.rivals.lane import judged, leader_of, neighbours_in, strongest_braking_mps2


@dataclass(frozen=True, slots=True, kw_only=True)
class AebSettings:
    """`margin_m`: room that is to be left when the closing has ended. `early_s`: time that sensing and deciding take."""

    margin_m: float = 1.0
    early_s: float = 0.2

    def __post_init__(self) -> None:
        non_negative("margin_m", self.margin_m, "m")
        non_negative("early_s", self.early_s, "s")


@dataclass(frozen=True, slots=True, kw_only=True)
class Braking:
    """An intervention under way; handed from cycle to cycle."""

    since_s: float


@dataclass(frozen=True, slots=True, kw_only=True)
class _Brake:
    """As hard as can be until no faster than the car ahead."""

    strength_mps2: float
    until_mps: float

    def wanted_mps2(self, t_s: float, s_m: float, speed_mps: float) -> float:
        return -self.strength_mps2 if speed_mps > self.until_mps else 0.0


@dataclass(frozen=True, slots=True, kw_only=True)
class _Coast:
    """The driver, who changes nothing."""

    def wanted_mps2(self, t_s: float, s_m: float, speed_mps: float) -> float:
        return 0.0


def needed_gap_m(closing_mps: float, strength_mps2: float, jerk_mps3: float, settings: AebSettings) -> float:
    """The gap [m] under which full braking, its build-up included, leaves less than the margin to a car of constant speed.

    That is a brake threat number of 1 (the required deceleration over the possible one: Brannstrom, Sjoberg, Coelingh, IV 2008), with
    the way lost while the brakes build up: about closing x strength / (2 jerk).
    """
    build_up_s = 0.5 * strength_mps2 / jerk_mps3
    return settings.margin_m + closing_mps * (settings.early_s + build_up_s) + closing_mps**2 / (2.0 * strength_mps2)


class AebMethod:
    """Brakes only, in the lane, for the car ahead only; what comes from behind it does not know. Its plans are not repaired."""

    has_ladder = False
    name = "aeb"

    def __init__(self, vehicle: Vehicle, settings: Settings | None = None, aeb: AebSettings | None = None) -> None:
        self.vehicle, self.settings, self.aeb = vehicle, settings or Settings(), aeb or AebSettings()

    def plan(self, situation: Situation, previous: Plan | None) -> Plan | Refusal:
        if situation.request is Request.PARK:
            return Refusal(reason="parking is planned by park, not by the lane planner")
        ahead = neighbours_in(situation.road.lane_of(situation.host.d_m), situation, self.vehicle).ahead
        leader = leader_of(ahead, situation, self.vehicle)
        going = previous.reference if previous is not None and isinstance(previous.reference, Braking) else None
        if leader is not None and self._must_brake(situation, leader, going):
            going = going or Braking(since_s=situation.time_s)
            return judged(
                self.name,
                situation,
                self.vehicle,
                self.settings,
                law=_Brake(strength_mps2=strongest_braking_mps2(situation, self.vehicle), until_mps=max(leader.speed_mps, 0.0)),
                reason=f"braking since {going.since_s:.1f} s: {leader.gap_m:.1f} m left",
                warning=True,
                reference=going,
            )
        return judged(self.name, situation, self.vehicle, self.settings, law=_Coast(), reason="braking can wait")

    def _must_brake(self, situation: Situation, leader: Leader, going: Braking | None) -> bool:
        closing = situation.host.speed_mps - leader.speed_mps
        if closing <= 0.0:
            return False
        strength = strongest_braking_mps2(situation, self.vehicle)
        return going is not None or leader.gap_m <= needed_gap_m(closing, strength, -self.vehicle.jerk_min_mps3, self.aeb)
