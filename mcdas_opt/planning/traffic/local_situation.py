"""A situation as a cycle plans in it: from near the host and from now, its tracks in order, its desired speed one that may be driven."""

from __future__ import annotations

import operator
from collections.abc import Sequence
from dataclasses import replace

from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.settings import Settings
from mcdas_opt.domain.situation import Situation
from mcdas_opt.domain.track import Track
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.planning.front.headway import ORDINARY_MPS2
from mcdas_opt.reference.arrival import arrival_speed_mps

_IN_TRAFFIC_M = 20_000.0  # who is farther away does not come here while anything is planned
_BESIDE_SHARE = 0.7  # of the desired speed: no less is driven for a destination in another lane, whose own lane goes on
_FASTEST_SHARE = 0.98  # of the car's top speed


def seen_locally(given: Situation, origin_m: float) -> Situation:
    """From the origin and from now, with who may be in traffic there, in order; a host whose tyres slip as one that grips."""
    near = [track for track in _ordered(given.tracks) if max(abs(track.s_m - origin_m), abs(track.d_m)) <= _IN_TRAFFIC_M]
    if given.host.sideslip_rad != 0.0:
        given = replace(given, host=HostState.from_vector(given.host.to_vector()))
    destination = given.destination and given.destination.seen_from(origin_m, given.time_s)
    if origin_m == 0.0:
        return replace(given, time_s=0.0, tracks=tuple(near), destination=destination)
    tracks = tuple(track.seen_from(origin_m) for track in near)
    host, road = given.host.seen_from(origin_m), given.road.seen_from(origin_m)
    line_m = None if given.stop_line_s_m is None else given.stop_line_s_m - origin_m
    return replace(given, time_s=0.0, host=host, tracks=tracks, road=road, destination=destination, stop_line_s_m=line_m)


def in_order(given: Situation) -> Situation:
    """The tracks from behind to ahead, whatever the order and the names that they were given: sums over them have the same last bits."""
    ordered = _ordered(given.tracks)
    return given if all(map(operator.is_, ordered, given.tracks)) else replace(given, tracks=tuple(ordered))


def _ordered(tracks: Sequence[Track]) -> list[Track]:
    return sorted(tracks, key=_place)


def _place(track: Track) -> tuple[float | str, ...]:
    """Of two in mirrored places the one that is named first: a mirrored scene has the mirrored order."""
    moving = track.speed_s_mps, abs(track.speed_d_mps), track.acceleration_s_mps2
    return (track.s_m, abs(track.d_m), *moving, track.length_m, track.width_m, track.id)


def with_wanted_speed(situation: Situation, settings: Settings, vehicle: Vehicle) -> Situation:
    """With a desired speed that is there in time, in another lane than the destination's not much slower than desired, and within the
    limit; without a destination that cannot be had any more."""
    destination, wanted = situation.destination, situation.wanted_speed_mps
    if destination is not None:
        if destination.why_unreachable(situation.host, situation.time_s, situation.road, vehicle):
            situation = replace(situation, destination=None, desired_speed_mps=wanted)
        else:
            host, comfort = situation.host, settings.comfort
            rising_mps2 = comfort.rising_mps2(host.speed_mps, situation.road.grip_mps2)
            arriving = arrival_speed_mps(
                destination,
                host,
                situation.time_s,
                wanted,
                fastest_mps=_FASTEST_SHARE * vehicle.speed_max_mps,
                rising_mps2=rising_mps2,
                falling_mps2=comfort.share * ORDINARY_MPS2,
            )
            is_beside = destination.lane is not None and destination.lane != situation.host_lane
            wanted = max(arriving, _BESIDE_SHARE * wanted) if is_beside else arriving
            situation = replace(situation, desired_speed_mps=wanted)
    limit = limit_mps(situation, settings)
    return replace(situation, desired_speed_mps=limit) if wanted > limit else situation


def limit_mps(situation: Situation, settings: Settings) -> float:
    """The fastest that ordinary driving is where the host is."""
    road, host = situation.road, situation.host
    return road.limit_mps(situation.host_lane, host.s_m, settings.speed_limit_excess)
