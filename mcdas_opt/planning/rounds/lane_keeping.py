"""Ordinary driving: the lane is kept, left for one that leads on, or the active manoeuvre goes on, unless it is withdrawn."""

from __future__ import annotations

from collections.abc import Iterator

from mcdas_opt.domain.vocabulary import Mode
from mcdas_opt.planning.candidate import Costed
from mcdas_opt.planning.choice import Round
from mcdas_opt.planning.proposals.keep_lane import brake_behind, keep_lane, stop_in_lane
from mcdas_opt.planning.proposals.lane_change import change_lanes, change_on, change_to_required, go_on_unpressed
from mcdas_opt.planning.search import Search


def lane_keeping(search: Search) -> Iterator[Round]:
    """A lane change that is due comes first; if it does not come to a safe end, it waits. Who begins, or kept no lane before, compares the
    lane with the closed forms, which make room for nobody. Where what is comfortable comes to no safe end behind the front car, braking
    harder is tried before others are troubled."""
    cycle = search.cycle
    if not cycle.is_ordinary:
        return
    if cycle.active is not None and not cycle.is_withdrawn:
        required = cycle.required_lane
        further = change_on(cycle, required, cycle.active) if required is not None and cycle.open_gap is not None else None
        if further is not None:
            yield Round(competing=search.solve((further,)), is_comparison=False)
        yield Round(competing=search.solve((go_on_unpressed(cycle, cycle.active),)), is_comparison=False)
        return
    if cycle.front_braking.is_to_the_limit:
        yield Round(competing=search.solve((stop_in_lane(cycle),)), is_comparison=False)
    required, gap = cycle.required_lane, cycle.gap
    change = None
    if required is None:
        change = change_lanes(cycle)
    elif cycle.open_gap is not None:
        change = change_to_required(cycle, required)
    if change is not None:
        yield Round(competing=search.solve((change,)), is_comparison=False)
    quiet = cycle.assessment.mode if cycle.assessment.mode in (Mode.CRUISE, Mode.BRAKE, Mode.PARK) else Mode.HOLD
    search.keep = (keep_lane(cycle, quiet, gap),)
    passing = search.solve(search.keep)
    begins = cycle.memory.chosen != search.keep[0].name and not (gap is not None and gap.is_slower)
    cheaper = _cheaper_closed_forms(search, passing[0]) if passing and begins else []
    yield Round(competing=passing + cheaper, is_comparison=False)
    harder = brake_behind(cycle)
    if harder is not None:
        braking = [one for one in search.solve((harder,)) if one.checked.driven_mode is not Mode.ACCELERATE]
        yield Round(competing=braking, is_comparison=False)


def _cheaper_closed_forms(search: Search, solved: Costed) -> list[Costed]:
    """Those that cost notably less than what was solved. A planner that begins looks at all of them where keeping the lane does not pass
    in closed form, or something threatens: the closed form would begin with something else."""
    evaluator = search.evaluator
    passing, departing = evaluator.drive(search.keep)
    if search.cycle.memory.is_empty and (not passing or search.cycle.assessment.threatened):
        passing, more = evaluator.drive(search.basic)
        departing += more
    evaluator.passing += passing
    evaluator.departing += departing
    search.keep = ()
    most = (solved.cost or 0.0) - evaluator.weights.notable
    return [one for one in passing + departing if (one.cost or 0.0) < most]
