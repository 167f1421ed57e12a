"""A gap between two in the lane that has to be reached, and how soon speed brings the host beside it."""

from __future__ import annotations

from typing import NamedTuple

from mcdas_opt.domain.situation import Situation
from mcdas_opt.domain.track import Track
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.planning.lanes.neighbours import CROSSING_S
from mcdas_opt.planning.lanes.required_lane import next_ahead

BESIDE_SHARE = 0.7  # of the gap that is asked for once there, already now
GAINING_MPS2, LOSING_MPS2 = 1.0, 1.5  # to get ahead of somebody, or behind
SLOWER_MPS = 6.0  # at most, than who is let ahead
FASTER_MPS = 3.0  # than who is passed, where the host wants to be no faster itself
HARDLY_MPS = 0.3  # a relative speed that gains nothing
_OWN_GAP_S = 0.5  # to who is ahead in the own lane, while one gets past somebody in the next


class Gap(NamedTuple):
    """Between two in the required lane (None: nobody), or before or behind all: how soon it can be gone into [s], 0: now; whether the host
    has to be slower for it until then, and the speed [m/s] that it may need for it."""

    behind: Track | None
    ahead: Track | None
    wait_s: float = 0.0
    is_slower: bool = False
    fastest_mps: float = 0.0

    @property
    def is_open(self) -> bool:
        """Whether it can be gone into now."""
        return self.wait_s == 0.0


def short_m(ahead_m: float, opening_mps: float, track: Track, vehicle: Vehicle, asked_m: float) -> float:
    """By how much a distance between two middles, which opens at that speed, is less than what is asked for from bumper to bumper once the
    host is in the lane, and `BESIDE_SHARE` of that now."""
    lengths = 0.5 * (track.length_m + vehicle.length_m)
    return max(lengths + asked_m - ahead_m - opening_mps * CROSSING_S, lengths + BESIDE_SHARE * asked_m - ahead_m)


def fastest_past_mps(behind: Track, way_m: float, situation: Situation, vehicle: Vehicle, limit_mps: float) -> float:
    """How fast the host gets past somebody: no faster than who is ahead in its own lane, where he leaves no room for that."""
    host, road = situation.host, situation.road
    fastest = min(max(situation.wanted_speed_mps, behind.speed_s_mps + FASTER_MPS), limit_mps)
    leader = next_ahead(situation, road.lane_centre_m(situation.host_lane, host.s_m))
    if leader is None:
        return fastest
    room_m = leader.s_m - host.s_m - 0.5 * (leader.length_m + vehicle.length_m) - _OWN_GAP_S * host.speed_mps
    return fastest if way_m <= room_m else min(fastest, leader.speed_s_mps)
