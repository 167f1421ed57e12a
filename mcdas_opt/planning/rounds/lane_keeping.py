"""Ordinary driving: the lane is kept, left for one that leads on, or the active manoeuvre goes on, unless it is withdrawn."""

from __future__ import annotations

from collections.abc import Iterator

from mcdas_opt.domain.vocabulary import Mode
from mcdas_opt.planning.candidate import Costed, Proposed
from mcdas_opt.planning.candidates.choice import Round
from mcdas_opt.planning.cycle import Cycle
from mcdas_opt.planning.deadline import Stage
from mcdas_opt.planning.lanes.manoeuvre import Manoeuvre
from mcdas_opt.planning.proposals.brake_for_bend import brake_for_bend
from mcdas_opt.planning.proposals.keep_lane import brake_behind, keep_lane, stop_in_lane
from mcdas_opt.planning.proposals.lane_change import change_lanes, change_on, change_to_required, go_on_unpressed
from mcdas_opt.planning.proposals.yielding import yielding
from mcdas_opt.planning.search import Search


def lane_keeping(search: Search) -> Iterator[Round]:
    """A lane change that is due comes first; if it does not come to a safe end, it waits. Who begins, or kept no lane before, compares the
    lane with the closed forms, which make room for nobody. A bend that is far too tight is braked for at once. Where what is
    comfortable comes to no safe end behind the front car, braking harder is tried before others are troubled."""
    cycle = search.cycle
    if not cycle.is_ordinary:
        return
    if cycle.active is not None and not cycle.is_withdrawn:
        yield from _alone(search, _change_on(cycle, cycle.active))
        yield from _alone(search, go_on_unpressed(cycle, cycle.active))
        return
    yield from _alone(search, stop_in_lane(cycle) if cycle.front_braking.is_to_the_limit else None)
    yield from _alone(search, brake_for_bend(cycle))
    yield from _alone(search, _change(cycle))
    yield from _keep(search)
    yield from _brake_behind(search)


def _alone(search: Search, proposed: Proposed | None) -> Iterator[Round]:
    """A round of this one, where there is one."""
    if proposed is not None:
        yield Round(competing=search.solve((proposed,)), is_comparison=False)


def _change_on(cycle: Cycle, active: Manoeuvre) -> Proposed | None:
    """From the lane change that is half done into the lane beyond, where a gap is open there."""
    required = cycle.required_lane
    return None if required is None or cycle.open_gap is None else change_on(cycle, required, active)


def _change(cycle: Cycle) -> Proposed | None:
    """Into the lane that has to be reached, once a gap is open there; else into one that is wanted."""
    required = cycle.required_lane
    if required is None:
        return change_lanes(cycle)
    return None if cycle.open_gap is None else change_to_required(cycle, required)


def _keep(search: Search) -> Iterator[Round]:
    """The lane, against the closed forms that cost less where it is begun to be kept."""
    cycle = search.cycle
    keep = keep_lane(cycle, _quiet_mode(cycle), cycle.gap)
    search.keep = (keep,)
    passing = search.solve(search.keep)
    makes_room = (cycle.gap is not None and cycle.gap.is_slower) or bool(
        cycle.passed_in_lane.bodies or yielding(cycle, keep.path.target_d_m)
    )
    begins = cycle.memory.chosen != keep.name and not makes_room
    compares = passing and begins and not cycle.is_late_for(Stage.SEARCH)
    cheaper = _cheaper_closed_forms(search, passing[0]) if compares else []
    yield Round(competing=passing + cheaper, is_comparison=False)


def _brake_behind(search: Search) -> Iterator[Round]:
    """Harder than is comfortable; what comes out as accelerating is none of it."""
    harder = brake_behind(search.cycle)
    if harder is not None:
        braking = [one for one in search.solve((harder,)) if one.checked.driven_mode is not Mode.ACCELERATE]
        yield Round(competing=braking, is_comparison=False)


def _quiet_mode(cycle: Cycle) -> Mode:
    """What keeping the lane is called: as the selector does, where it finds one of these; braking where nobody watches ahead."""
    mode = cycle.assessment.mode
    if cycle.slows_blindly and mode is not Mode.PARK:
        return Mode.BRAKE
    return mode if mode in (Mode.CRUISE, Mode.BRAKE, Mode.PARK) else Mode.HOLD


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
