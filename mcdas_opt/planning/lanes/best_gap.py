"""The gap to go for in the lane that has to be reached."""

from __future__ import annotations

from mcdas_opt.domain.settings import Settings
from mcdas_opt.domain.situation import Situation
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.planning.lanes.arriving_gap import arriving_gaps
from mcdas_opt.planning.lanes.gap import Gap
from mcdas_opt.planning.lanes.merging_gap import is_time_to_adapt, merging_gaps
from mcdas_opt.planning.lanes.required_lane import ADAPTING_S, RequiredLane


def best_gap(situation: Situation, vehicle: Vehicle, settings: Settings, required: RequiredLane, limit_mps: float) -> Gap | None:
    """The gap that can be gone into soonest; None where there is none. While there is time only one that is there now counts."""
    found = (merging_gaps if required.own_lane_ends else arriving_gaps)(situation, vehicle, settings, required, limit_mps)
    adapts = is_time_to_adapt(situation, required) if required.own_lane_ends else required.left_s <= ADAPTING_S
    if not adapts:
        found = (gap for gap in found if gap.is_open)
    return min(found, key=lambda gap: gap.wait_s, default=None)
