"""What steering out to a side costs, beside what is driven."""

from __future__ import annotations

from mcdas_opt.domain.cost_weights import CostWeights
from mcdas_opt.domain.vocabulary import Mode, Side
from mcdas_opt.planning.cycle import Cycle

_STRAIGHT_M = 0.1  # a smaller offset of the front vehicle prefers neither side


def lane_change_cost(side: Side, cycle: Cycle, weights: CostWeights) -> float:
    """Once for the whole plan; nothing for keeping the lane."""
    if side is Side.NONE or not _needs_no_steering(cycle):
        return needed_lane_change_cost(side, cycle, weights)
    unneeded = weights.inconsiderate if side in cycle.inconsiderate_sides else 0.0
    if not _leads_there(side, cycle):
        unneeded += weights.unneeded_lane_change
    return needed_lane_change_cost(side, cycle, weights) + unneeded


def needed_lane_change_cost(side: Side, cycle: Cycle, weights: CostWeights) -> float:
    """The same where braking or accelerating is not enough, or counts for nothing."""
    if side is Side.NONE or _leads_there(side, cycle):
        return 0.0
    preferred = _preferred_side(cycle)
    other = preferred is not Side.NONE and side is not preferred
    astray = weights.off_destination if _leads_astray(side, cycle) else 0.0
    return weights.lane_change + (weights.other_side if other else 0.0) + astray


def _needs_no_steering(cycle: Cycle) -> bool:
    """Nothing threatens, or the selector finds braking or accelerating enough."""
    return not cycle.assessment.threatened or cycle.assessment.mode in (Mode.BRAKE, Mode.ACCELERATE)


def _leads_there(side: Side, cycle: Cycle) -> bool:
    """Whether the next lane on that side is nearer to the destination's lane, with a gap that is gone into now."""
    required = cycle.required_lane
    return required is not None and not required.own_lane_ends and required.side is side and cycle.open_gap is not None


def _leads_astray(side: Side, cycle: Cycle) -> bool:
    """Whether the next lane on that side is farther from the destination's lane."""
    destination, lane = cycle.situation.destination, cycle.situation.host_lane
    if destination is None or destination.lane is None:
        return False
    return destination.lane <= lane if side is Side.LEFT else destination.lane >= lane


def _preferred_side(cycle: Cycle) -> Side:
    """The side that asks for less lateral movement past the front vehicle (eq 22-23); none when that is straight ahead."""
    ahead = cycle.assessment
    if ahead.front_id is None or abs(ahead.offset_m) <= _STRAIGHT_M:
        return Side.NONE
    return Side.RIGHT if ahead.offset_m > 0.0 else Side.LEFT
