"""The competent and careful human driver of UN R157, who defines which collisions an automated lane keeping system must avoid."""

from __future__ import annotations

from dataclasses import dataclass

from mcdas_opt.baselines.lane import LaneMethod, SteadyLaw, judged, leader_of, neighbours_in, strongest_braking_mps2
from mcdas_opt.domain.plan import Plan
from mcdas_opt.domain.situation import Situation
from mcdas_opt.domain.track import Track
from mcdas_opt.planning.candidates.path_driving import Kind
from mcdas_opt.planning.memory import carried

# UN R157, annex 4, appendix 3: 0.774 g reached in 0.6 s, after a delay of 0.75 s; a wandering zone of 0.375 m
REACTION_S, JERK_MPS3, BRAKING_MPS2, WANDERING_M = 0.75, 12.65, 7.59294, 0.375
# its deceleration scenario: somebody ahead brakes harder than this, for as long as the risk is evaluated; it follows at 2.0 s there
HARD_MPS2, EVALUATION_S = 5.0, 0.4
# as coded in JRC-FSM (European Commission, 2021): the throttle released, and the critical time to collision
RELEASE_MPS2, CRITICAL_TTC_S = 0.4, 2.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Noticed:
    """When the driver has perceived the risk, in the future while it is evaluated still; handed from cycle to cycle."""

    at_s: float


@dataclass(frozen=True, slots=True, kw_only=True)
class ReactionLaw:
    """The throttle released at once, the brake pressed after the reaction time and built up by the jerk, until no faster than the other.

    `since_s` is how long ago the risk was perceived when the law's clock is 0.
    """

    since_s: float
    until_mps: float
    strength_mps2: float

    @property
    def numbers(self) -> tuple[float, ...]:
        return (Kind.REACTION, self.since_s, self.until_mps, self.strength_mps2, REACTION_S, RELEASE_MPS2, JERK_MPS3)

    def wanted_mps2(self, t_s: float, s_m: float, speed_mps: float) -> float:
        if speed_mps <= self.until_mps:
            return 0.0
        pressed = self.since_s + t_s - REACTION_S
        if pressed < -1e-9:
            return -RELEASE_MPS2
        return -min(max(JERK_MPS3 * pressed, RELEASE_MPS2), self.strength_mps2)


class CompetentDriverMethod(LaneMethod):
    """Brakes for whoever is ahead in the lane, or has left the wandering zone of the next one towards it, under a critical time to
    collision; and for whoever is ahead and brakes hard. Never steers out, knows nothing of the rear; its plans are not repaired."""

    name = "un-r157"

    def drive(self, situation: Situation, previous: Plan | None) -> Plan:
        before = carried(previous, Noticed)
        risk = self._risk(situation, before)
        if risk is None:
            return judged(self.name, situation, self.vehicle, self.settings, law=SteadyLaw(), reason="no risk perceived")
        now = situation.time_s
        is_evaluated = before is None and not self._is_critical(risk, situation)
        noticed = before or Noticed(at_s=now + EVALUATION_S if is_evaluated else now)
        if noticed.at_s > now + 1e-9:
            if self._is_critical(risk, situation):
                noticed = Noticed(at_s=now)
            else:
                law, reason = SteadyLaw(), f"{risk.id} brakes: a risk is evaluated"
                return judged(self.name, situation, self.vehicle, self.settings, law=law, reason=reason, memory=noticed)
        reaction = ReactionLaw(
            since_s=now - noticed.at_s,
            until_mps=max(risk.speed_s_mps, 0.0),
            strength_mps2=min(BRAKING_MPS2, strongest_braking_mps2(situation, self.vehicle)),
        )
        reason = f"risk by {risk.id} perceived at {noticed.at_s:.1f} s"
        return judged(self.name, situation, self.vehicle, self.settings, law=reaction, reason=reason, warning=True, memory=noticed)

    def _risk(self, situation: Situation, before: Noticed | None) -> Track | None:
        """The nearest that is closing in critically; whoever is braked for already needs only still be slower."""
        found: Track | None = None
        for track in self._ahead(situation):
            is_risk = before is not None or self._is_critical(track, situation) or _brakes_hard(track)
            if situation.host.speed_mps > track.speed_s_mps and is_risk and (found is None or track.s_m < found.s_m):
                found = track
        return found

    def _is_critical(self, track: Track, situation: Situation) -> bool:
        leader = leader_of(track, situation, self.vehicle)
        assert leader is not None
        return leader.gap_m <= CRITICAL_TTC_S * (situation.host.speed_mps - leader.speed_mps)

    def _ahead(self, situation: Situation) -> list[Track]:
        """Whoever is ahead in the lane, and those who come into it from the next ones."""
        road, host = situation.road, situation.host
        lane = situation.host_lane
        own = neighbours_in(lane, situation, self.vehicle).ahead
        coming = []
        for track in situation.tracks:
            beside = road.lane_of(track.d_m, track.s_m) - lane
            departed = (road.lane_centre_m(lane + beside, track.s_m) - track.d_m) * beside
            if abs(beside) == 1 and track.s_m > host.s_m and departed > WANDERING_M:
                coming.append(track)
        return coming if own is None else [own, *coming]


def _brakes_hard(track: Track) -> bool:
    return track.acceleration_s_sd_mps2 is not None and track.acceleration_s_mps2 < -HARD_MPS2
