"""Who is where: roles of the tracks by geometry alone, and gaps from bumper to bumper."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.settings import SelectorSettings
from mcdas_opt.domain.track import Track
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.domain.vocabulary import Role

CROSSES_S = 4.0  # who comes across the road is looked at so far ahead


@dataclass(frozen=True, slots=True, kw_only=True)
class Roles:
    """Everybody's role; `front` and `rear` are the nearest ahead and behind in the host's own lane, further ones are `other`."""

    roles: dict[str, Role]
    front: Track | None
    rear: Track | None


def gap_m(track: Track, host: HostState, vehicle: Vehicle) -> float:
    """Distance along the road from bumper to bumper [m]; negative alongside."""
    return abs(track.s_m - host.s_m) - 0.5 * (track.along_m + vehicle.length_m)


def in_lane(track: Track, lane: int, road: Road, settings: SelectorSettings) -> bool:
    """Whether the body reaches into the lane by the intrusion margin."""
    return reach_into_m(track.s_m, track.d_m, track.across_m, lane, road) >= settings.lane_intrusion_m


def reach_into_m(s_m: float, d_m: float, across_m: float, lane: int, road: Road, moves_m: float = 0.0) -> float:
    """How much of a lane's width a body at (s, d) takes that is so wide, while it moves so far to the left [m]; negative: how far it stays
    beside the lane."""
    return _overlap(d_m + 0.5 * moves_m, across_m + abs(moves_m), road.lane_centre_m(lane, s_m), road.lane_width_at(lane, s_m))


def in_the_way(track: Track, lane: int, host: HostState, vehicle: Vehicle, road: Road, settings: SelectorSettings) -> bool:
    """Whether the body is in the host's lane, or in the width that the host's body sweeps going straight on; never of who crosses it."""
    if track.crosses:
        return False
    swept = vehicle.width_m + 2.0 * settings.swept_margin_m
    return in_lane(track, lane, road, settings) or _overlap(track.d_m, track.across_m, host.d_m, swept) > 0.0


def assign_roles(
    tracks: Sequence[Track],
    lane: int,
    host: HostState,
    vehicle: Vehicle,
    road: Road,
    settings: SelectorSettings,
    passed: frozenset[str] = frozenset(),
) -> Roles:
    """Roles of all tracks, the host being in `lane`. A car alongside is front or rear only if the bodies already overlap sideways; who is
    `passed` within the lane is neither."""
    roles = {track.id: Role.OTHER for track in tracks}
    ahead: list[tuple[float, str, Track]] = []
    behind: list[tuple[float, str, Track]] = []
    for track in tracks:
        gap = gap_m(track, host, vehicle)
        in_way = track.id not in passed and in_the_way(track, lane, host, vehicle, road, settings)
        if in_way and (gap >= 0.0 or _overlap(track.d_m, track.across_m, host.d_m, vehicle.width_m) > 0.0):
            (ahead if track.s_m > host.s_m else behind).append((gap, track.id, track))
        elif abs(track.s_m - host.s_m) <= settings.beside_m:
            if in_lane(track, lane + 1, road, settings):
                roles[track.id] = Role.LEFT
            elif in_lane(track, lane - 1, road, settings):
                roles[track.id] = Role.RIGHT
            elif gap < 0.0 and track.d_m != host.d_m:  # alongside, in no lane of its own
                roles[track.id] = Role.LEFT if track.d_m > host.d_m else Role.RIGHT
    front = min(ahead)[2] if ahead else None
    rear = min(behind)[2] if behind else None
    if front is not None:
        roles[front.id] = Role.FRONT
    if rear is not None:
        roles[rear.id] = Role.REAR
    return Roles(roles=roles, front=front, rear=rear)


def _overlap(d1: float, width1: float, d2: float, width2: float) -> float:
    """Width that two intervals share [m]; negative: the distance between them."""
    return 0.5 * (width1 + width2) - max(abs(d1 - d2), 0.5 * abs(width1 - width2))
