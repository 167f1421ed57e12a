"""The Intelligent Driver Model along the road, MOBIL across it: the usual driver of traffic simulations."""

from __future__ import annotations

from dataclasses import dataclass, replace

from mcdas_opt.baselines.lane import LaneMethod, judged, leader_of, neighbours_in, strongest_braking_mps2
from mcdas_opt.domain.plan import Plan
from mcdas_opt.domain.situation import Situation
from mcdas_opt.domain.track import Track
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.domain.vocabulary import Side
from mcdas_opt.dynamics.car_following import IdmSettings, Leader, idm_acceleration
from mcdas_opt.planning.candidates.path_driving import Kind
from mcdas_opt.planning.lanes.manoeuvre import Manoeuvre
from mcdas_opt.planning.memory import carried
from mcdas_opt.reference.offset_path import corrected

_STANDING_MPS = 0.5
# Kesting, Treiber, Helbing, Transp. Res. Rec. 1999 (2007) 86: its symmetric rule, with the IDM that it is shown with
IDM = IdmSettings(headway_s=1.5, acceleration_mps2=1.4, deceleration_mps2=2.0, exponent=4.0, jam_distance_m=2.0)
_POLITENESS = 0.25  # chosen within the paper's range
_THRESHOLD_MPS2 = 0.1
_SAFE_BRAKING_MPS2 = 4.0
_LATERAL_MPS2 = 2.0  # of the lane change's path, on which the paper is silent


@dataclass(frozen=True, slots=True, kw_only=True)
class Following:
    """The IDM behind the most demanding of several leaders, who go on as they do."""

    situation: Situation
    vehicle: Vehicle
    leaders: tuple[Track, ...]
    desired_mps: float
    idm: IdmSettings

    @property
    def numbers(self) -> tuple[float, ...]:
        of, own = self.idm, self.vehicle.length_m
        shape = (of.headway_s, of.acceleration_mps2, of.deceleration_mps2, of.exponent, of.jam_distance_m, of.braking_limit_mps2)
        seen = [(track.s_m, track.speed_s_mps, 0.5 * (track.length_m + own)) for track in self.leaders]
        return (Kind.FOLLOWING, self.desired_mps, *shape, len(seen), *(number for other in seen for number in other))

    def wanted_mps2(self, t_s: float, s_m: float, speed_mps: float) -> float:
        seen = [leader_of(track, self.situation, self.vehicle, s_m, t_s) for track in self.leaders]
        return min(idm_acceleration(speed_mps, self.desired_mps, leader, self.idm) for leader in seen or [None])


@dataclass(frozen=True, slots=True, kw_only=True)
class Exchange:
    """What a lane change does to the accelerations [m/s^2] of the host, the follower it gets and the one it leaves."""

    own_before: float
    own_after: float
    new_before: float = 0.0
    new_after: float = 0.0
    old_before: float = 0.0
    old_after: float = 0.0

    @property
    def safe(self) -> bool:
        """Eq 2: the new follower need not brake harder than is safe."""
        return self.new_after >= -_SAFE_BRAKING_MPS2

    @property
    def gain_mps2(self) -> float:
        """Eq 4, left side less the right one: the incentive to change, where positive."""
        others = self.new_after - self.new_before + self.old_after - self.old_before
        return self.own_after - self.own_before + _POLITENESS * others - _THRESHOLD_MPS2


class IdmMobilMethod(LaneMethod):
    """Follows by the IDM, changes lanes by MOBIL, along the corrected sigmoid at a comfortable bound; its plans are not repaired."""

    name = "idm-mobil"

    def drive(self, situation: Situation, previous: Plan | None) -> Plan:
        going = carried(previous, Manoeuvre)
        if going is not None and going.finished(situation):
            going = None
        going = going or self._change(situation)
        road, host = situation.road, situation.host
        lanes = {situation.host_lane}
        if going is not None:
            lanes.add(road.lane_of(going.target_d_m, host.s_m))
        ahead = [neighbours_in(lane, situation, self.vehicle).ahead for lane in sorted(lanes)]
        law = Following(
            situation=situation,
            vehicle=self.vehicle,
            leaders=tuple(track for track in ahead if track is not None),
            desired_mps=self._desired_mps(situation),
            idm=self._idm(situation),
        )
        return judged(
            self.name,
            situation,
            self.vehicle,
            self.settings,
            law=law,
            path=None if going is None else going.path,
            side=Side.NONE if going is None else going.side,
            lateral_mps2=None if going is None else self._lateral_mps2(situation),
            reason="follows" if going is None else f"changes lanes to the {going.side.value}",
            memory=going,
        )

    def exchange(self, situation: Situation, side: Side) -> Exchange | None:
        """The accelerations on both sides of the choice; None where there is no lane, nobody watches it, or somebody is alongside."""
        road, host = situation.road, situation.host
        lane = situation.host_lane
        other = lane + side.sign
        if not road.has_lane(other, host.s_m) or not situation.sees_lane(side) or host.speed_mps < _STANDING_MPS:
            return None
        here, there = neighbours_in(lane, situation, self.vehicle), neighbours_in(other, situation, self.vehicle)
        new_leader = leader_of(there.ahead, situation, self.vehicle)
        host_seen = None if there.behind is None else self._host_from(there.behind, situation)
        if any(seen is not None and seen.gap_m <= 0.0 for seen in (new_leader, host_seen)):
            return None
        return Exchange(
            own_before=self._acceleration(situation, leader_of(here.ahead, situation, self.vehicle)),
            own_after=self._acceleration(situation, new_leader),
            new_before=self._of(there.behind, there.ahead, situation),
            new_after=self._of(there.behind, host_seen, situation),
            old_before=self._of(here.behind, None if here.behind is None else self._host_from(here.behind, situation), situation),
            old_after=self._of(here.behind, here.ahead, situation),
        )

    def _change(self, situation: Situation) -> Manoeuvre | None:
        """The better of the sides that are safe and have an incentive; the same on both goes to the tie-break side."""
        best: tuple[float, bool, Side] | None = None
        for side in (Side.LEFT, Side.RIGHT):
            trade = self.exchange(situation, side)
            if trade is None or not trade.safe or trade.gain_mps2 <= 0.0:
                continue
            rank = (trade.gain_mps2, side is self.settings.selector.tie_break, side)
            if best is None or rank[:2] > best[:2]:
                best = rank
        if best is None:
            return None
        side, road, host = best[2], situation.road, situation.host
        target = road.lane_centre_m(situation.lane_beside(side), host.s_m)
        path = corrected(
            start_s_m=host.s_m,
            start_d_m=host.d_m,
            target_d_m=target,
            speed_mps=host.speed_mps,
            lateral_acceleration_mps2=self._lateral_mps2(situation),
        )
        return Manoeuvre(side=side, path=path, target_d_m=target, speed_mps=situation.wanted_speed_mps)

    def _lateral_mps2(self, situation: Situation) -> float:
        return min(_LATERAL_MPS2, 0.5 * situation.road.grip_mps2)

    def _idm(self, situation: Situation) -> IdmSettings:
        return replace(IDM, braking_limit_mps2=strongest_braking_mps2(situation, self.vehicle))

    def _desired_mps(self, situation: Situation) -> float:
        road, host = situation.road, situation.host
        limit = road.limit_mps(situation.host_lane, host.s_m, self.settings.speed_limit_excess)
        return min(situation.wanted_speed_mps, limit) if situation.wanted_speed_mps > 0.0 else limit

    def _acceleration(self, situation: Situation, leader: Leader | None) -> float:
        return idm_acceleration(situation.host.speed_mps, self._desired_mps(situation), leader, self._idm(situation))

    def _host_from(self, behind: Track, situation: Situation) -> Leader:
        """The host as a car behind it sees it."""
        host = situation.host
        gap = host.s_m - behind.s_m - 0.5 * (self.vehicle.length_m + behind.length_m)
        return Leader(gap_m=gap, speed_mps=host.speed_mps)

    def _of(self, follower: Track | None, ahead: Track | Leader | None, situation: Situation) -> float:
        """The acceleration of somebody else, who wants the speed that he has."""
        if follower is None or follower.speed_s_mps <= 0.0:
            return 0.0
        if isinstance(ahead, Track):
            gap = ahead.s_m - follower.s_m - 0.5 * (ahead.length_m + follower.length_m)
            ahead = Leader(gap_m=gap, speed_mps=ahead.speed_s_mps)
        return idm_acceleration(follower.speed_s_mps, follower.speed_s_mps, ahead, self._idm(situation))
