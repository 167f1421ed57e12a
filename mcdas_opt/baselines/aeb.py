"""Autonomous emergency braking: nothing until the last moment at which braking alone suffices, then everything."""

from __future__ import annotations

from dataclasses import dataclass, replace

from mcdas_opt.baselines.lane import LaneMethod, SteadyLaw, judged, leader_of, neighbours_in, strongest_braking_mps2
from mcdas_opt.domain.plan import Plan
from mcdas_opt.domain.situation import Situation
from mcdas_opt.domain.track import Track
from mcdas_opt.dynamics.car_following import Leader
from mcdas_opt.planning.memory import carried

_MARGIN_M = 1.0  # that is to be left when the closing has ended
_EARLY_S = 0.2  # that sensing and deciding take
_SMOOTHING_S = 0.4  # time constant of the other's acceleration


@dataclass(frozen=True, slots=True, kw_only=True)
class AebTarget:
    """The car ahead as it was seen last, with its smoothed acceleration, and since when there is an intervention (None: there is
    none); handed from cycle to cycle."""

    track: str
    time_s: float
    speed_mps: float
    acceleration_mps2: float = 0.0
    braking_since_s: float | None = None


def needed_gap_m(speed_mps: float, leader: Leader, braking_mps2: float, strength_mps2: float, jerk_mps3: float) -> float:
    """The gap [m] under which full braking, its build-up included, leaves less than the margin to a car that goes on braking as it does
    (by `braking_mps2`, 0 for one that does not).

    That is a brake threat number of 1 (the required deceleration over the possible one: Brannstrom, Sjoberg, Coelingh, IV 2008), with
    the way lost while the brakes build up: about closing x strength / (2 jerk).
    """
    closing, late_s = speed_mps - leader.speed_mps, _EARLY_S + 0.5 * strength_mps2 / jerk_mps3
    closing = max(closing + braking_mps2 * late_s, 0.0)
    theirs = max(leader.speed_mps - braking_mps2 * late_s, 0.0)
    relative = strength_mps2 - braking_mps2
    if relative > 0.0 and closing / relative * braking_mps2 <= theirs:  # nobody stands yet when they are as fast as each other
        way = closing**2 / (2.0 * relative)
    else:
        way = speed_mps**2 / (2.0 * strength_mps2) - (theirs**2 / (2.0 * braking_mps2) if braking_mps2 > 0.0 else 0.0)
    return _MARGIN_M + (speed_mps - leader.speed_mps) * late_s + max(way, 0.0)


class AebMethod(LaneMethod):
    """Brakes only, in the lane, for the car ahead only; what comes from behind it does not know. Its plans are not repaired."""

    name = "aeb"

    def drive(self, situation: Situation, previous: Plan | None) -> Plan:
        ahead = neighbours_in(situation.host_lane, situation, self.vehicle).ahead
        before = carried(previous, AebTarget)
        leader = leader_of(ahead, situation, self.vehicle)
        if ahead is None or leader is None:
            return judged(self.name, situation, self.vehicle, self.settings, law=SteadyLaw(), reason="nobody ahead")
        seen = self._target(situation, ahead, before)
        if not self._must_brake(situation, leader, seen):
            calm = replace(seen, braking_since_s=None)
            return judged(self.name, situation, self.vehicle, self.settings, law=SteadyLaw(), reason="braking can wait", memory=calm)
        going = replace(seen, braking_since_s=situation.time_s if seen.braking_since_s is None else seen.braking_since_s)
        return judged(
            self.name,
            situation,
            self.vehicle,
            self.settings,
            law=SteadyLaw(strength_mps2=strongest_braking_mps2(situation, self.vehicle), until_mps=max(leader.speed_mps, 0.0)),
            reason=f"braking since {going.braking_since_s:.1f} s: {leader.gap_m:.1f} m left",
            warning=True,
            memory=going,
        )

    def _target(self, situation: Situation, ahead: Track, before: AebTarget | None) -> AebTarget:
        """The car ahead now; its acceleration from how its speed has changed, smoothed. Another car begins with none."""
        now = AebTarget(track=ahead.id, time_s=situation.time_s, speed_mps=ahead.speed_s_mps)
        if before is None or before.track != ahead.id or situation.time_s <= before.time_s:
            return now
        step = situation.time_s - before.time_s
        share = step / (step + _SMOOTHING_S)
        change = (ahead.speed_s_mps - before.speed_mps) / step
        smooth = before.acceleration_mps2 + share * (change - before.acceleration_mps2)
        return replace(now, acceleration_mps2=smooth, braking_since_s=before.braking_since_s)

    def _must_brake(self, situation: Situation, leader: Leader, seen: AebTarget) -> bool:
        closing = situation.host.speed_mps - leader.speed_mps
        if closing <= 0.0:
            return False
        strength, jerk = strongest_braking_mps2(situation, self.vehicle), -self.vehicle.jerk_min_mps3
        braking = min(max(-seen.acceleration_mps2, 0.0), strength)
        needed = needed_gap_m(situation.host.speed_mps, leader, braking, strength, jerk)
        return seen.braking_since_s is not None or leader.gap_m <= needed
