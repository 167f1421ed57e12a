"""The corrected sigmoid without an optimiser: the bicycle drives it from the measured state."""

from __future__ import annotations

import math
import warnings
from collections.abc import Iterator
from itertools import chain, islice
from typing import NamedTuple

from mcdas_opt.actuation.path_following import SpeedLaw
from mcdas_opt.domain.cost_weights import CostWeights
from mcdas_opt.domain.vehicle import GRAVITY_MPS2
from mcdas_opt.domain.vocabulary import Mode
from mcdas_opt.errors import PlannerFaultWarning, told
from mcdas_opt.planning.candidate import Checked, Costed, Driven, Proposed
from mcdas_opt.planning.candidates.collision_check import verdicts
from mcdas_opt.planning.candidates.cost import trajectory_cost
from mcdas_opt.planning.candidates.lane_change_cost import needed_lane_change_cost
from mcdas_opt.planning.candidates.path_driving import follow
from mcdas_opt.planning.cycle import Cycle
from mcdas_opt.planning.proposals.evade import basic_four, lateral_bound_mps2
from mcdas_opt.planning.proposals.keep_lane import keep_lane
from mcdas_opt.planning.proposals.lane_change import go_on, go_on_unpressed

_WEIGHTS = CostWeights()
Groups = list[list[Proposed]]


class ClosedForm(NamedTuple):
    """The first candidate that passes, else the first that was tried; and all that were tried, in order."""

    chosen: Costed
    tried: tuple[Costed, ...]


def drive(proposed: Proposed, cycle: Cycle) -> Driven:
    """The bicycle along the candidate's path, at most at the bound that the path was made for."""
    situation = cycle.situation
    hard = proposed.mode in (Mode.BRAKE, Mode.ACCELERATE)
    trajectory = follow(
        situation.host,
        proposed.path,
        SpeedLaw(speed_mps=proposed.speed_mps, acceleration_mps2=0.9 * situation.road.friction * GRAVITY_MPS2 if hard else 2.0),
        vehicle=cycle.vehicle,
        road=situation.road,
        duration_s=float(cycle.settings.grid.times_s[-1]),
        lateral_acceleration_mps2=lateral_bound_mps2(situation, cycle.settings.sigmoid),
    )
    return Driven(proposed=proposed, trajectory=trajectory)


def groups(cycle: Cycle) -> Groups:
    """In the order in which they are tried: the active manoeuvre, or the lane when nothing threatens; the sides; braking; accelerating."""
    brake, accelerate, left, right = basic_four(cycle, None)
    last = [[left, right], [brake], [accelerate]]
    if cycle.active is not None:
        return [[go_on_unpressed(cycle, cycle.active) if cycle.is_ordinary else go_on(cycle.active)], *last]
    if not cycle.assessment.threatened:
        return [[keep_lane(cycle, Mode.CRUISE if cycle.assessment.mode is Mode.CRUISE else Mode.HOLD)], *last]
    return last


def closed_form(cycle: Cycle, in_order: Groups) -> ClosedForm:
    """The cheapest passing candidate of the first group that has one. Costs equal to 1e-5 go to the tie-break side."""
    tried: list[Costed] = []
    first: Costed | None = None
    for group in _driven(cycle, in_order):
        group.sort(
            key=lambda one: (
                math.inf if one.cost is None else round(one.cost, 5),
                0 if one.proposed.side is cycle.settings.selector.tie_break else 1,
            )
        )
        tried += group
        best = next((one for one in group if one.checked.verdict.passed), None)
        if best is not None:
            return ClosedForm(best, tuple(tried))
        first = first or next(iter(group), None)
    assert first is not None  # keeping the lane by braking is never refused
    return ClosedForm(first, tuple(tried))


def _driven(cycle: Cycle, in_order: Groups) -> Iterator[list[Costed]]:
    """Each group, driven, checked and costed: the first by itself, the others, where they are asked for, together."""
    for some in (in_order[:1], in_order[1:]):
        drives = [[drive(proposed, cycle) for proposed in group if not proposed.refusal] for group in some]
        judged = iter(verdicts([driven.trajectory for driven in chain(*drives)], cycle))
        for group in drives:
            checked = (Checked(driven=one, verdict=verdict) for one, verdict in zip(group, islice(judged, len(group)), strict=True))
            yield [_costed(one, cycle) for one in checked]


def _costed(checked: Checked, cycle: Cycle) -> Costed:
    """Without a cost that is finite the order of trial decides: the ladder has to answer. What fails is told in a `PlannerFaultWarning`."""
    try:
        cost = _cost(checked, cycle)
    except Exception as error:
        fault = f"the cost of {checked.proposed.name} failed: {told(error)}"
        warnings.warn(fault, PlannerFaultWarning, stacklevel=2)
        cost = math.nan
    return Costed(checked=checked, cost=cost if math.isfinite(cost) else None)


def _cost(checked: Checked, cycle: Cycle) -> float:
    """Steering out is what the closed form does: that it might not be needed counts for nothing."""
    return trajectory_cost(checked.trajectory, cycle, _WEIGHTS) + needed_lane_change_cost(checked.proposed.side, cycle, _WEIGHTS)
