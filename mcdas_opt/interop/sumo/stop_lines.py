"""Where a SUMO vehicle has to wait: at red and amber lights, and where others have the right of way."""

from __future__ import annotations

from dataclasses import dataclass, field

from mcdas_opt.interop.sumo.connection import LaneDomain
from mcdas_opt.interop.sumo.road_frame import RoadFrame
from mcdas_opt.interop.sumo.route import Lane

_RED, _AMBER, _YIELDS = "ru", "yY", "gmsw="  # SUMO's states of a link: also off and blinking lights, which say to yield
_AMBER_MPS2, _YIELDING_MPS2 = (
    3.0,
    2.0,
)  # of braking: amber is driven over where stopping takes more; giving way is begun when it takes so much
_REACTION_S = 0.5
_AHEAD_M = 200.0


@dataclass(slots=True)
class StopLines:
    """The stop lines along the route of one vehicle."""

    lanes: LaneDomain
    _passed: set[str] = field(default_factory=set)  # lanes whose line is driven over at amber, since stopping came too late

    def next_m(self, frame: RoadFrame, front_s_m: float, speed_mps: float, hardest_mps2: float) -> float | None:
        """s [m] of the first line at which a vehicle with its front bumper at `front_s_m` has to wait; None: nowhere that it sees."""
        for section in frame.sections[:-1]:
            way_m = section.end_m - front_s_m
            if 0.0 <= way_m <= _AHEAD_M and any(
                self._waits(lane, way_m, speed_mps, hardest_mps2) for lane in section.edge.lanes if lane.goes_on
            ):
                return section.end_m
        return None

    def _waits(self, lane: Lane, way_m: float, speed_mps: float, hardest_mps2: float) -> bool:
        link = next((link for link in self.lanes.getLinks(lane.id) if str(link[4]) == lane.via), None)
        if link is None:
            return False
        state, is_open = str(link[5]), bool(link[2])
        if state in _YIELDS:
            return not is_open and _is_stoppable(way_m, speed_mps, _YIELDING_MPS2)
        if state not in _RED + _AMBER:
            self._passed.discard(lane.id)
            return False
        if lane.id not in self._passed and not _is_stoppable(way_m, speed_mps, _AMBER_MPS2 if state in _AMBER else hardest_mps2):
            self._passed.add(lane.id)
        return lane.id not in self._passed


def _is_stoppable(way_m: float, speed_mps: float, braking_mps2: float) -> bool:
    return way_m >= speed_mps * _REACTION_S + speed_mps**2 / (2.0 * braking_mps2)
