"""The competent and careful human driver of UN R157, who defines which collisions an automated lane keeping system must avoid."""

from __future__ import annotations

from dataclasses import dataclass

from mcdas_opt.baselines.lane import judged, leader_of, neighbours_in, strongest_braking_mps2
from mcdas_opt.baselines.steady import SteadyLaw
from mcdas_opt.domain.plan import Plan, Refusal
from mcdas_opt.domain.rules import positive, require
from mcdas_opt.domain.settings import Settings
from mcdas_opt.domain.situation import Situation
from mcdas_opt.domain.track import Track
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.domain.vocabulary import Request
from mcdas_opt.planning.memory import carried
from mcdas_opt.planning.path_driving import Kind


@dataclass(frozen=True, slots=True, kw_only=True)
class CompetentDriverSettings:
    """UN R157, annex 4, appendix 3 (0.774 g reached in 0.6 s, after a delay of 0.75 s; a wandering zone of 0.375 m), with the critical
    time to collision and the deceleration of a released throttle as coded in JRC-FSM (European Commission, 2021)."""

    reaction_s: float = 0.75
    release_mps2: float = 0.4
    jerk_mps3: float = 12.65
    braking_mps2: float = 7.59294
    critical_ttc_s: float = 2.0
    wandering_m: float = 0.375

    def __post_init__(self) -> None:
        require(self, positive, *self.__slots__)


@dataclass(frozen=True, slots=True, kw_only=True)
class Noticed:
    """When the driver perceived the risk, and of whom; handed from cycle to cycle."""

    at_s: float
    track: str


@dataclass(frozen=True, slots=True, kw_only=True)
class ReactionLaw:
    """The throttle released at once, the brake pressed after the reaction time and built up by the jerk, until no faster than the other.

    `since_s` is how long ago the risk was perceived when the law's clock is 0.
    """

    since_s: float
    until_mps: float
    strength_mps2: float
    settings: CompetentDriverSettings

    @property
    def numbers(self) -> tuple[float, ...]:
        of = self.settings
        return (Kind.REACTION, self.since_s, self.until_mps, self.strength_mps2, of.reaction_s, of.release_mps2, of.jerk_mps3)

    def wanted_mps2(self, t_s: float, s_m: float, speed_mps: float) -> float:
        if speed_mps <= self.until_mps:
            return 0.0
        pressed = self.since_s + t_s - self.settings.reaction_s
        if pressed < -1e-9:
            return -self.settings.release_mps2
        return -min(max(self.settings.jerk_mps3 * pressed, self.settings.release_mps2), self.strength_mps2)


class CompetentDriverMethod:
    """Brakes for whoever is ahead in the lane, or has left the wandering zone of the next one towards it, under a critical time to
    collision. Never steers out, knows nothing of the rear; its plans are not repaired."""

    has_ladder = False
    name = "un-r157"

    def __init__(self, vehicle: Vehicle, settings: Settings | None = None, driver: CompetentDriverSettings | None = None) -> None:
        self.vehicle, self.settings, self.driver = vehicle, settings or Settings(), driver or CompetentDriverSettings()

    def plan(self, situation: Situation, previous: Plan | None) -> Plan | Refusal:
        if situation.request is Request.PARK:
            return Refusal(reason="parking is planned by park, not by the lane planner")
        before = carried(previous, Noticed)
        risk = self._risk(situation, before)
        if risk is None:
            return judged(self.name, situation, self.vehicle, self.settings, law=SteadyLaw(), reason="no risk perceived")
        noticed = before or Noticed(at_s=situation.time_s, track=risk.id)
        law = ReactionLaw(
            since_s=situation.time_s - noticed.at_s,
            until_mps=max(risk.speed_s_mps, 0.0),
            strength_mps2=min(self.driver.braking_mps2, strongest_braking_mps2(situation, self.vehicle)),
            settings=self.driver,
        )
        reason = f"risk by {risk.id} perceived at {noticed.at_s:.1f} s"
        return judged(self.name, situation, self.vehicle, self.settings, law=law, reason=reason, warning=True, memory=noticed)

    def _risk(self, situation: Situation, before: Noticed | None) -> Track | None:
        """The nearest that is closing in critically; whoever is braked for already needs only still be slower."""
        found: Track | None = None
        for track in self._ahead(situation):
            leader = leader_of(track, situation, self.vehicle)
            assert leader is not None
            closing = situation.host.speed_mps - leader.speed_mps
            critical = leader.gap_m <= self.driver.critical_ttc_s * closing
            if closing > 0.0 and (critical or before is not None) and (found is None or track.s_m < found.s_m):
                found = track
        return found

    def _ahead(self, situation: Situation) -> list[Track]:
        """Whoever is ahead in the lane, and those who come into it from the next ones."""
        road, host = situation.road, situation.host
        lane = road.lane_of(host.d_m)
        own = neighbours_in(lane, situation, self.vehicle).ahead
        coming = []
        for track in situation.tracks:
            beside = road.lane_of(track.d_m) - lane
            strayed = (road.lane_centre_m(lane + beside) - track.d_m) * beside
            if abs(beside) == 1 and track.s_m > host.s_m and strayed > self.driver.wandering_m:
                coming.append(track)
        return coming if own is None else [own, *coming]
