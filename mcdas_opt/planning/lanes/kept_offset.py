"""Where in its lane the host drives: in the middle, or as its destination asks."""

from __future__ import annotations

import math

from mcdas_opt.domain.situation import Situation
from mcdas_opt.domain.vehicle import Vehicle

_OFFSET_AHEAD_S, _OFFSET_SLOWEST_MPS = 4.0, 5.0  # so long before the destination the host goes beside its lane's middle for it
_OFFSET_SPARE_M = 0.2  # inside the offsets that are asked for, and from the body to the lane's border
_HEADING_SPARE_RAD, _HEADING_LEAD_S = 0.02, 1.0  # inside the headings that are asked for; until the host follows a path that turns


def kept_d_m(situation: Situation, vehicle: Vehicle, centre: float) -> float:
    """The middle of the lane, which is `centre` at the host; as near to it as the destination's offsets ask, where that is near ahead, and
    across it as the heading that is asked for there."""
    host, road, destination = situation.host, situation.road, situation.destination
    if destination is None or destination.d_m is None or destination.s_m is None:
        return centre
    place, lane = 0.5 * (destination.s_m[0] + destination.s_m[1]), situation.host_lane
    right, left = destination.d_m
    spare, far_m = min(_OFFSET_SPARE_M, 0.25 * (left - right)), _OFFSET_AHEAD_S * max(host.speed_mps, _OFFSET_SLOWEST_MPS)
    if place - host.s_m > far_m or road.lane_of(0.5 * (right + left), place) != lane:
        return centre
    width = min(road.lane_width_at(lane, host.s_m), road.lane_width_at(lane, place))
    beside = max(0.5 * (width - vehicle.width_m) - _OFFSET_SPARE_M, 0.0)
    there = road.lane_centre_m(lane, place)
    offset = min(max(0.0, right + spare - there), left - spare - there)
    if destination.heading_rad is not None:
        turns = math.tau * round(0.5 * sum(destination.heading_rad) / math.tau)
        least, most = (heading - turns for heading in destination.heading_rad)
        spare = min(_HEADING_SPARE_RAD, 0.25 * (most - least))
        offset += min(max(0.0, least + spare), most - spare) * (host.s_m + _HEADING_LEAD_S * host.speed_mps - place)
    return centre + min(max(offset, -beside), beside)
