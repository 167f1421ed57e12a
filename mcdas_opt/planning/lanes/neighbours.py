"""Who is in a lane, and what it asks of him if the host comes into it."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from typing import NamedTuple

from mcdas_opt.domain.road import Road
from mcdas_opt.domain.settings import Settings
from mcdas_opt.domain.situation import Situation
from mcdas_opt.domain.track import Track
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.dynamics.car_following import IdmSettings
from mcdas_opt.situation.passed_in_lane import INTRUSION_M
from mcdas_opt.situation.roles import gap_m

CROSSING_S = 2.5  # from when a change begins until the body is in the new lane
_RESPONSE_S = 1.0  # of who is behind there
_ACCELERATES_S = 1.5  # who does so
_NONE_MPS2 = 1e-100  # whose square is still a number
_DEVIATIONS = 2.0  # an acceleration of so many standard deviations counts half
_FOLLOWER = IdmSettings(acceleration_mps2=1.5, deceleration_mps2=2.0)
_FOLLOWER_MPS2 = 2.0 * math.sqrt(_FOLLOWER.acceleration_mps2 * _FOLLOWER.deceleration_mps2)


class Neighbour(NamedTuple):
    """Somebody in a lane: the gap from bumper to bumper [m], and the speed [m/s], now and once the host is there."""

    gap_m: float
    speed_mps: float
    is_ahead: bool
    soon_mps: float


def reaches_into(track: Track, centre_m: float, width_m: float) -> bool:
    """Whether a body reaches into the lane around that centre."""
    return abs(track.d_m - centre_m) - 0.5 * track.across_m <= 0.5 * width_m - INTRUSION_M


def reaches_into_lane_at(centre_m: float, track: Track, road: Road) -> bool:
    """The same of the lane that holds this place across, as wide as it is where the body is, and no wider than usual: there is room beside
    somebody at the side of a wide lane."""
    width_m = road.lane_width_at(road.lane_of(centre_m, track.s_m), track.s_m)
    return reaches_into(track, centre_m, min(width_m, road.lane_width_m))


def in_lane(lane: int, situation: Situation) -> Iterator[Track]:
    """Whose body reaches into a lane, as they come in the situation."""
    road = situation.road
    for track in situation.tracks:
        if reaches_into(track, road.lane_centre_m(lane, track.s_m), road.lane_width_at(lane, track.s_m)):
            yield track


def neighbours_in(lane: int, situation: Situation, vehicle: Vehicle) -> list[Neighbour]:
    """Everybody whose body reaches into a lane."""
    host = situation.host
    return [
        Neighbour(
            gap_m=gap_m(track, host, vehicle),
            speed_mps=track.speed_s_mps,
            is_ahead=track.s_m > host.s_m,
            soon_mps=track.speed_s_mps + _ACCELERATES_S * known_acceleration_mps2(track),
        )
        for track in in_lane(lane, situation)
    ]


def known_acceleration_mps2(track: Track) -> float:
    """As far as it is known: half of one of two standard deviations, nearly all of a greater one."""
    a, sd = track.acceleration_s_mps2, track.acceleration_s_sd_mps2
    return 0.0 if sd is None or abs(a) < _NONE_MPS2 else a * a * a / (a * a + (_DEVIATIONS * sd) ** 2)


def follower_gap_m(follower_mps: float, leader_mps: float, time_gap_s: float, braking_mps2: float = 0.0) -> float:
    """The gap [m] in which somebody who follows with that time gap brakes by no more than that: the Intelligent Driver Model's, without its
    free road (Treiber, Hennecke, Helbing, Phys. Rev. E 62 (2000) 1805, eq 3), under MOBIL's criterion of safety (eq 2 there). Whoever
    drives away counts as one who does not."""
    closing = max(follower_mps - leader_mps, 0.0)
    wanted = _FOLLOWER.jam_distance_m + max(follower_mps, 0.0) * (time_gap_s + closing / _FOLLOWER_MPS2)
    return wanted / math.sqrt(1.0 + braking_mps2 / _FOLLOWER.acceleration_mps2)


def gained_in_crossing_mps(towards_mps: float, situation: Situation, settings: Settings) -> float:
    """How much faster a host is that speeds up towards a speed as is comfortable, by the time that its body is in the new lane."""
    mean_mps = 0.5 * (situation.host.speed_mps + max(towards_mps, 0.0))
    return CROSSING_S * settings.comfort.rising_mps2(mean_mps, situation.road.grip_mps2)


def demanded_braking_mps2(there: Iterable[Neighbour], host_mps: float, kept_m: float = 0.0) -> float:
    """The most that somebody behind in a lane must brake by, after its response, to keep so much of its gap if the host comes into it."""
    most = 0.0
    for one in there:
        closing = one.speed_mps - host_mps
        if not one.is_ahead and closing > 0.0:
            room = one.gap_m - kept_m - closing * _RESPONSE_S
            most = max(most, closing * closing / (2.0 * room) if room > 0.0 else math.inf)
    return most
