"""How fast the host drives at which time while nothing threatens: towards its speed, and slowly enough for the bends ahead."""

from __future__ import annotations

from operator import itemgetter
from typing import NamedTuple

import numpy as np

from mcdas_opt.domain.rules import Array
from mcdas_opt.domain.track import Track
from mcdas_opt.domain.vocabulary import Side
from mcdas_opt.planning.cycle import Cycle
from mcdas_opt.planning.headway import ORDINARY_MPS2, asked_time_gap_s
from mcdas_opt.planning.lane_choice import reaches_into
from mcdas_opt.reference.speed_profile import FrontCar, SpeedProfile, profile_ahead, speeds_along

_STANDING_MPS = 0.4
_CLOSED_UP_M = 1.5  # beyond the gap at standstill: nobody drives on for so little


_FADING_S, _BRAKING_FADES_S = 1.0, 2.0
_NONE_MPS2 = 1e-100  # whose square is still a number
_DEVIATIONS = 2.0  # an acceleration of so many standard deviations counts half


class ComfortableSpeed(NamedTuple):
    """The speed to arrive at [m/s], and the speed at each node of the grid on the way there."""

    goal_mps: float
    speeds_mps: Array


def comfortable_speed(cycle: Cycle, towards_mps: float, d_m: float) -> ComfortableSpeed:
    """Along the offset d: gently towards a speed, and no faster than the road's bends allow within the horizon. Who stands behind a front
    car that stands stays where it is."""
    times_s, comfort, profile = cycle.settings.grid.times_s, cycle.settings.comfort, bends_ahead(cycle, d_m)
    host_mps = cycle.situation.host.speed_mps
    towards_mps = 0.0 if _stands(cycle) else towards_mps
    speeds = speeds_along(
        profile,
        host_mps,
        towards_mps,
        times_s,
        rising_mps2=comfort.share * comfort.limits(host_mps).acceleration_mps2,
        falling_mps2=ORDINARY_MPS2,
        late_mps2=comfort.late_braking_mps2,
        fronts=_fronts(cycle, d_m),
    )
    if profile is None:
        return ComfortableSpeed(towards_mps, speeds)
    way_m = np.concatenate([[0.0], np.cumsum(speeds[:-1] * (times_s[1:] - times_s[:-1]))])
    return ComfortableSpeed(min(towards_mps, float(profile.at(profile.start_s_m + way_m).min())), speeds)


def _fronts(cycle: Cycle, d_m: float) -> list[FrontCar]:
    """Who is next ahead along the offset d, and in the lane that the host is in; and whoever must not be passed on the wrong side."""
    host, road, vehicle, times_s = cycle.situation.host, cycle.situation.road, cycle.vehicle, cycle.settings.grid.times_s
    manners, found = cycle.settings.manners, []
    ahead = [(track, track.s_m - host.s_m - 0.5 * (track.length_m + vehicle.length_m)) for track in cycle.situation.tracks]
    for centre in dict.fromkeys((cycle.lane_centre_m, d_m)):
        there = [one for one in ahead if one[0].s_m > host.s_m and reaches_into(one[0], centre, road.lane_width_m)]
        if there:
            front, room_m = min(there, key=itemgetter(1))
            speeds, way = _going_on(front, times_s)
            gaps = asked_time_gap_s(room_m + way, speeds, host.speed_mps, times_s, cycle.headway)
            found.append(FrontCar(room_m + way - cycle.headway.standstill_m, speeds, gaps))
    if manners.passes_inside:
        inner = d_m + (road.lane_width_m if manners.inside is Side.LEFT else -road.lane_width_m)
        for track, room_m in ahead:
            if room_m > 0.0 and track.speed_s_mps > manners.queue_mps and reaches_into(track, inner, road.lane_width_m):
                speeds, way = _going_on(track, times_s)
                found.append(FrontCar(room_m + way, speeds, np.zeros_like(times_s)))
    return found


def _going_on(track: Track, times_s: Array) -> tuple[Array, Array]:
    """(speeds [m/s], way [m]) of somebody whose acceleration, as far as it is known, fades."""
    a, sd = track.acceleration_s_mps2, track.acceleration_s_sd_mps2
    known = 0.0 if sd is None or abs(a) < _NONE_MPS2 else a * a * a / (a * a + (_DEVIATIONS * sd) ** 2)
    fading_s = _BRAKING_FADES_S if known < 0.0 else _FADING_S
    speeds = np.maximum(track.speed_s_mps + known * fading_s * -np.expm1(-times_s / fading_s), 0.0)
    way = np.concatenate([[0.0], np.cumsum(0.5 * (speeds[1:] + speeds[:-1]) * (times_s[1:] - times_s[:-1]))])
    return speeds, way


def _stands(cycle: Cycle) -> bool:
    assessment, front_mps = cycle.assessment, cycle.assessment.front_speed_mps
    both_stand = front_mps is not None and abs(front_mps) < _STANDING_MPS and cycle.situation.host.speed_mps < _STANDING_MPS
    return both_stand and assessment.front_gap_m < cycle.settings.headway.standstill_m + _CLOSED_UP_M


def bends_ahead(cycle: Cycle, d_m: float) -> SpeedProfile | None:
    """What the road's bends allow along the offset d from where the host is."""
    situation = cycle.situation
    fastest = max(situation.host.speed_mps, situation.wanted_speed_mps)
    return profile_ahead(situation.road, situation.host.s_m, d_m, fastest, cycle.settings.comfort)
