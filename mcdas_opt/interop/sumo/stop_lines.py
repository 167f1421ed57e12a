"""Where a SUMO vehicle has to wait: at red and amber lights, where others have the right of way, and before a junction that it could not
leave."""

from __future__ import annotations

import math

from mcdas_opt.interop.sumo.connection import Connection, LaneDomain
from mcdas_opt.interop.sumo.road_frame import RoadFrame
from mcdas_opt.interop.sumo.route import Lane, lanes_inside

_STOPPABLE_MPS2 = {"r": 5.0, "u": 5.0, "y": 3.0, "Y": 3.0}  # by SUMO's state of a link: who needs more braking than this drives on
_YIELDING, _YIELDING_MPS2 = "gmsw=", 2.0  # who has to let others go, if there are any: by so much
_REACTION_S = 0.5
_AHEAD_M = 200.0
_FULL_MPS2 = 4.0  # before a junction that cannot be left
_STANDING_MPS, _GAP_M = 2.0, 2.5  # who is no faster leaves no room soon; from one to the next in a queue


def next_stop_line_m(sumo: Connection, frame: RoadFrame, ego: str, front_s_m: float, speed_mps: float) -> float | None:
    """s [m] of the first line at which `ego`, with its front bumper at `front_s_m`, has to wait; None: nowhere within 200 m."""
    for section in frame.sections[:-1]:
        way_m = section.end_m - front_s_m
        if 0.0 <= way_m <= _AHEAD_M:
            leading = [lane for lane in section.edge.lanes if lane.goes_on]
            braking_mps2 = max((_waits_by_mps2(sumo.lane, lane) for lane in leading), default=0.0)
            if leading and all(_has_no_room_behind(sumo, lane, ego) for lane in leading):
                braking_mps2 = max(braking_mps2, _FULL_MPS2)
            if braking_mps2 > 0.0 and way_m >= speed_mps * _REACTION_S + speed_mps**2 / (2.0 * braking_mps2):
                return section.end_m
    return None


def _waits_by_mps2(lanes: LaneDomain, lane: Lane) -> float:
    """Up to which braking one stops at a lane's end now; 0: nobody has to wait there."""
    link = next((link for link in lanes.getLinks(lane.id) if str(link[4]) == lane.via), None)
    if link is None:
        return 0.0
    state, is_open = str(link[5]), bool(link[2])
    if state in _YIELDING:
        return 0.0 if is_open else _YIELDING_MPS2
    return _STOPPABLE_MPS2.get(state, 0.0)


def _has_no_room_behind(sumo: Connection, lane: Lane, ego: str) -> bool:
    """Whether the vehicle would stand in others' way inside the junction at a lane's end: a queue behind it, and whoever is on the way
    there, leave too little room."""
    inside = list(lanes_inside(sumo.lane, lane.via))
    if not any(sumo.lane.getInternalFoes(one) for one in inside):
        return False
    onto = next((str(link[0]) for link in sumo.lane.getLinks(lane.id) if str(link[4]) == lane.via), "")
    room_m = _room_m(sumo, onto, ego)
    on_the_way = [name for one in inside for name in sumo.lane.getLastStepVehicleIDs(one) if name != ego]
    return room_m - sum(sumo.vehicle.getLength(name) + _GAP_M for name in on_the_way) < sumo.vehicle.getLength(ego) + _GAP_M


def _room_m(sumo: Connection, lane: str, ego: str) -> float:
    """From a lane's beginning to the queue that stands on it; endless where the last one drives."""
    there = [name for name in sumo.lane.getLastStepVehicleIDs(lane) if name != ego] if lane else []
    if not there:
        return math.inf
    last = min(there, key=sumo.vehicle.getLanePosition)
    if sumo.vehicle.getSpeed(last) > _STANDING_MPS:
        return math.inf
    return sumo.vehicle.getLanePosition(last) - sumo.vehicle.getLength(last)
