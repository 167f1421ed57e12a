"""Which next lanes are open to steer into. A mild test: the optimiser and the judge avoid every neighbour's body anyway."""

from __future__ import annotations

from collections.abc import Sequence

from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.settings import SelectorSettings
from mcdas_opt.domain.track import Coverage, Track
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.domain.vocabulary import Sector, Side
from mcdas_opt.situation.roles import gap_m, in_lane


def blocked_sides(
    tracks: Sequence[Track],
    coverage: Coverage,
    lane: int,
    host: HostState,
    vehicle: Vehicle,
    road: Road,
    settings: SelectorSettings,
    evading: Side = Side.NONE,
) -> frozenset[Sector]:
    """The sides of `lane` without a lane, without coverage beside or behind, or with a car alongside, now or within `occupancy_s` at
    constant speeds.

    The side that the host is already evading to closes only when a car is alongside now (hysteresis).
    """
    blocked = set()
    behind = coverage.rear or road.is_for_others(lane)  # who comes in the next lane
    for sector, side_lane in ((Sector.LEFT, lane + 1), (Sector.RIGHT, lane - 1)):
        if not road.goes_on(side_lane, host.s_m, host.speed_mps) or not (coverage.sees(sector) and behind):
            blocked.add(sector)
            continue
        begun = sector.value == evading.value
        gap, within = (0.0, 0.0) if begun else (settings.occupancy_gap_m, settings.occupancy_s)
        for track in tracks:
            closing = host.speed_mps - track.speed_s_mps if track.s_m > host.s_m else track.speed_s_mps - host.speed_mps
            soon = gap_m(track, host, vehicle) - max(closing, 0.0) * within
            if soon < gap and in_lane(track, side_lane, road, settings):
                blocked.add(sector)
                break
    return frozenset(blocked)
