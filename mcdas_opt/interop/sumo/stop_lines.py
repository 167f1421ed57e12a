"""Where a SUMO vehicle has to wait: at red and amber lights, and where others have the right of way."""

from __future__ import annotations

from mcdas_opt.interop.sumo.connection import LaneDomain
from mcdas_opt.interop.sumo.road_frame import RoadFrame
from mcdas_opt.interop.sumo.route import Lane

_STOPPABLE_MPS2 = {"r": 5.0, "u": 5.0, "y": 3.0, "Y": 3.0}  # by SUMO's state of a link: who needs more braking than this drives on
_YIELDING, _YIELDING_MPS2 = "gmsw=", 2.0  # who has to let others go, if there are any: by so much
_REACTION_S = 0.5
_AHEAD_M = 200.0


def next_stop_line_m(lanes: LaneDomain, frame: RoadFrame, front_s_m: float, speed_mps: float) -> float | None:
    """s [m] of the first line at which a vehicle with its front bumper at `front_s_m` has to wait; None: nowhere within 200 m."""
    for section in frame.sections[:-1]:
        way_m = section.end_m - front_s_m
        if 0.0 <= way_m <= _AHEAD_M:
            braking_mps2 = max((_waits_by_mps2(lanes, lane) for lane in section.edge.lanes if lane.goes_on), default=0.0)
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
