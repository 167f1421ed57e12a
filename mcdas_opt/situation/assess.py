"""Situation to assessment: the one function that the planner calls here."""

from __future__ import annotations

import math
from typing import NamedTuple

from mcdas_opt.domain.assessment import Assessment
from mcdas_opt.domain.settings import SelectorSettings
from mcdas_opt.domain.situation import Situation
from mcdas_opt.domain.track import Track
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.domain.vocabulary import Mode, Request, Sector
from mcdas_opt.dynamics.axle_limits import driving_mps2
from mcdas_opt.situation import one_state
from mcdas_opt.situation.occupancy import blocked_sides
from mcdas_opt.situation.roles import assign_roles, gap_m
from mcdas_opt.situation.rule_table import RULES
from mcdas_opt.situation.selector import MODES, SIDES, Facts, closing_time, mode_code, select_one, side_code
from mcdas_opt.situation.table1 import literal_mode

_TIE_M = 0.1  # a smaller difference between the sides is a tie
_LANE_END_MPS2 = 3.0  # of braking: a lane's end that asks for less is no threat
CLOCK_DIGITS = 4  # of a second: what is finer is rounding, a clock's jitter, or the resolution of seconds since 1970
_LANE_REACHED = 0.75  # of a lane's width: an evasion that came this far counts lanes anew


class _Ahead(NamedTuple):
    """The next in line: a car, the end of the road or of the lane (no id), or nobody (infinite gap)."""

    id: str | None
    gap_m: float
    speed_mps: float | None
    is_road_end: bool = False
    is_lane_end: bool = False


def assess(
    situation: Situation,
    vehicle: Vehicle,
    settings: SelectorSettings,
    previous: Assessment | None = None,
    elapsed_s: float = 0.0,
    *,
    leaves_lane: bool = False,
    attentive: frozenset[str] = frozenset(),
    passed: frozenset[str] = frozenset(),
) -> Assessment:
    """Roles, gaps, times to collision, threats, open sides and the one mode; `previous` is the cycle before (hysteresis), whose time 0 was
    `elapsed_s` before this one's. Whoever changes lanes already (`leaves_lane`) is not threatened by the end of the one that it is in. A
    follower who is `attentive` brakes himself, and threatens nobody; nor does who is `passed` within the lane."""
    host, road, coverage, tracks = situation.host, situation.road, situation.coverage, situation.tracks
    lane = _lane(situation, previous)
    assigned = assign_roles(tracks, lane, host, vehicle, road, settings, passed)
    front_car, rear_car = assigned.front, assigned.rear
    front = _end(situation, lane, vehicle, _car(front_car, situation, vehicle), leaves_lane)
    rear = _car(rear_car, situation, vehicle)
    ttc_front = float(closing_time(front.gap_m, host.speed_mps - (front.speed_mps or 0.0), one_state))
    ttc_rear = float(closing_time(rear.gap_m, (rear.speed_mps or 0.0) - host.speed_mps, one_state))
    before = previous or Assessment()
    blocked = set(blocked_sides(tracks, coverage, lane, host, vehicle, road, settings, before.side))
    if front.is_road_end and ttc_front < settings.ttc_warning_s:  # no lane goes on
        blocked |= {Sector.LEFT, Sector.RIGHT}
    offset = 0.0 if front_car is None else front_car.d_m - host.d_m
    began_s = round(before.since_s - elapsed_s, CLOCK_DIGITS) if elapsed_s else before.since_s
    age = math.inf if previous is None or situation.time_s < began_s else situation.time_s - began_s
    choice = select_one(
        Facts(
            host_speed=host.speed_mps,
            desired_speed=situation.wanted_speed_mps,
            front_seen=coverage.front,
            front_gap=front.gap_m,
            front_speed=front.speed_mps or 0.0,
            rear_seen=coverage.rear,
            rear_gap=rear.gap_m,
            rear_speed=min(rear.speed_mps or 0.0, host.speed_mps) if rear.id in attentive else rear.speed_mps or 0.0,
            left_open=Sector.LEFT not in blocked,
            right_open=Sector.RIGHT not in blocked,
            preferred_side=_preferred_side(-offset if front_car is not None else host.d_m - road.lane_centre_m(lane, host.s_m)),
            park_requested=situation.request is Request.PARK,
            acceleration_mps2=driving_mps2(vehicle, road.friction),
            previous_mode=mode_code(None if previous is None else previous.mode),
            previous_side=side_code(before.side),
            previous_front_threat=Sector.FRONT in before.threats,
            previous_rear_threat=Sector.REAR in before.threats,
            previous_warning=before.warning,
            previous_age_s=age,
        ),
        settings,
    )
    if not coverage.front or choice.front_threat or front.gap_m <= settings.distance_front_long_m:
        blocked.add(Sector.FRONT)
    if not coverage.rear or choice.rear_threat or rear.gap_m <= settings.distance_rear_m:
        blocked.add(Sector.REAR)
    mode, side, rule = MODES[int(choice.mode)], SIDES[int(choice.side)], int(choice.rule)
    threats = [s for s, there in ((Sector.FRONT, choice.front_threat), (Sector.REAR, choice.rear_threat)) if there]
    same = previous is not None and (previous.mode, previous.side) == (mode, side) and math.isfinite(age)
    return Assessment(
        roles=assigned.roles,
        front_id=front.id,
        rear_id=rear.id,
        front_gap_m=front.gap_m,
        rear_gap_m=rear.gap_m,
        front_speed_mps=front.speed_mps,
        lane_ends=front.is_lane_end,
        rear_speed_mps=rear.speed_mps,
        ttc_front_s=ttc_front,
        ttc_rear_s=ttc_rear,
        offset_m=offset,
        occupied=frozenset(blocked),
        threats=frozenset(threats),
        mode=mode,
        side=side,
        warning=bool(choice.warning),
        literal_mode=_table_1(front_car, rear_car, situation, vehicle),
        reason=RULES[rule].reason if rule >= 0 else f"{mode.value} goes on for {settings.hold_s:g} s",
        lane=lane,
        since_s=began_s if same else situation.time_s,
    )


def _lane(situation: Situation, previous: Assessment | None) -> int:
    """The lane that the host is in; during an evasion the one that it began in, until the next lane's centre is near."""
    road, d, s = situation.road, situation.host.d_m, situation.host.s_m
    if previous is not None and previous.mode is Mode.EVADE and road.has_lane(previous.lane, s):
        moved = (d - road.lane_centre_m(previous.lane, s)) * previous.side.sign
        width = road.lane_width_at(previous.lane, s)
        if -0.5 * width <= moved < _LANE_REACHED * width:
            return previous.lane
    return road.lane_of(d, s)


def _car(track: Track | None, situation: Situation, vehicle: Vehicle) -> _Ahead:
    if track is None:
        return _Ahead(None, math.inf, None)
    return _Ahead(track.id, gap_m(track, situation.host, vehicle), track.speed_s_mps)


def _end(situation: Situation, lane: int, vehicle: Vehicle, front: _Ahead, leaves_lane: bool) -> _Ahead:
    """The end of the road, or of the host's lane, is a wall, where it comes before the front vehicle; of the lane only when it is time to
    brake for it, since there is another lane to go to. A lane that is none to drive in, as one of oncoming traffic, has no end to brake
    for: it is left."""
    host, road = situation.host, situation.road
    end = road.ends_m(lane, host.s_m, vehicle.width_m)
    gap, is_road_end = end - host.s_m - 0.5 * vehicle.length_m, end == road.road_end_s_m
    is_late = not road.is_for_others(lane) and gap < host.speed_mps**2 / (2.0 * _LANE_END_MPS2) and not leaves_lane
    if gap >= front.gap_m or not (is_road_end or is_late):
        return front
    return _Ahead(None, gap, 0.0, is_road_end, is_lane_end=not is_road_end)


def _preferred_side(left_minus_right_m: float) -> int:
    return 0 if abs(left_minus_right_m) <= _TIE_M else int(math.copysign(1, left_minus_right_m))


def _table_1(front: Track | None, rear: Track | None, situation: Situation, vehicle: Vehicle) -> str | None:
    """A vehicle is unknown where no sensor covers its sector and there is no track of it. Half-known states have no row."""
    cars = [None if t is None else (gap_m(t, situation.host, vehicle), t.speed_s_mps) for t in (front, rear)]
    unknown = [car is None and not seen for car, seen in zip(cars, (situation.coverage.front, situation.coverage.rear), strict=True)]
    if any(unknown) and not all(unknown):
        return None
    return literal_mode(cars[0], cars[1], situation.host.speed_mps, known=not all(unknown))
