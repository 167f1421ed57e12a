"""What else a plan does that a driver would ask about, each a clause behind the reason."""

from __future__ import annotations

from mcdas_opt.domain.vocabulary import Mode, Side
from mcdas_opt.planning.candidate import Ended
from mcdas_opt.planning.cycle import Cycle
from mcdas_opt.planning.lane_problem.bends import too_tight_bend
from mcdas_opt.planning.lanes.required_lane import RequiredLane
from mcdas_opt.planning.proposals.brake_for_bend import BRAKE_FOR_BEND
from mcdas_opt.planning.proposals.keep_lane import BRAKE
from mcdas_opt.planning.proposals.unwatched import unwatched
from mcdas_opt.situation.attentive_followers import waits_at_a_line

_NOTABLE_MPS = 0.1  # beyond the speed limit
_CREEPING_MPS = 1.0


def remarks(cycle: Cycle, best: Ended, *, is_comparison: bool) -> str:
    """The clauses that hold of the chosen candidate. Without `is_comparison` it was not compared with those of another kind."""
    return (
        _as_begun(best, cycle, is_comparison)
        + _lane_change(best, cycle)
        + _passing(best, cycle)
        + _unwatched(best, cycle)
        + _haste(best, cycle)
        + _stop(best, cycle)
        + _bend(best)
        + _too_tight(cycle)
    )


def _as_begun(best: Ended, cycle: Cycle, is_comparison: bool) -> str:
    """Said of an evasion that goes on without being compared with the others again."""
    evades = cycle.active is not None and best.proposed.manoeuvre == cycle.active and best.proposed.mode is Mode.EVADE
    return "; goes on as begun" if evades and not is_comparison else ""


def _lane_change(best: Ended, cycle: Cycle) -> str:
    """Said of a lane change that nothing forces."""
    proposed = best.proposed
    if proposed.side is Side.NONE or proposed.mode is not Mode.CRUISE:
        return ""
    required = cycle.required_lane
    if required is not None and required.side is proposed.side:
        why = _why_required(required, cycle.situation.host.s_m)
    else:
        why = "past who is slower" if proposed.side is cycle.settings.manners.inside else "where it keeps to"
    return f"; changes lanes to the {proposed.side.value}, {why}"


def _passing(best: Ended, cycle: Cycle) -> str:
    """Said of driving past somebody at the lane's side, and of letting those through first who come in the lane beside."""
    if best.proposed.side is not Side.NONE:
        return ""
    passed = cycle.passed_in_lane
    waits = (
        "" if passed.waits_for is None else f"; stays behind {passed.waits_for.id} until the lane of oncoming traffic is seen to be free"
    )
    return "".join(f"; passes {one.track.id}, {one.gap_m:.1f} m beside it" for one in passed.bodies) + waits


def _unwatched(best: Ended, cycle: Cycle) -> str:
    """Said of steering on into a lane that nobody watches, and of a lane change that is required and not made for that."""
    situation, required, side = cycle.situation, cycle.required_lane, best.proposed.side
    if side is not Side.NONE:
        why = unwatched(situation, side)
        return f"; {why}" if why else ""
    why = "" if required is None else unwatched(situation, required.side)
    return f"; {why}: stays in its lane, though {_why_required(required, situation.host.s_m)}" if required is not None and why else ""


def _stop(best: Ended, cycle: Cycle) -> str:
    """Said of a stop at a line, and of braking that somebody's braking ahead asks for, though nobody comes near."""
    if cycle.is_ordinary and waits_at_a_line(cycle.situation, cycle.vehicle):
        return "; waits at the stop line"
    stops = best.proposed.name == BRAKE and cycle.is_ordinary and cycle.front_braking.is_to_the_limit
    return f"; {cycle.assessment.front_id} brakes about as hard as the road allows" if stops else ""


def _bend(best: Ended) -> str:
    return "; brakes harder than is comfortable: the bend ahead is too tight for its speed" if best.proposed.name == BRAKE_FOR_BEND else ""


def _too_tight(cycle: Cycle) -> str:
    """Said where a host does not go on before a bend that is too tight for its body."""
    host = cycle.situation.host
    if host.speed_mps >= _CREEPING_MPS or cycle.situation.wanted_speed_mps < _CREEPING_MPS:
        return ""
    found = too_tight_bend(cycle.situation.road, host.s_m, cycle.vehicle)
    if found is None:
        return ""
    way_m, taken_m, width_m = found
    return f"; the bend {f'in {way_m:.0f} m' if way_m >= 0.5 else 'here'} takes {taken_m:.2f} m of a road of {width_m:.2f} m"


def _haste(best: Ended, cycle: Cycle) -> str:
    """Said of a plan that accelerates beyond the speed limit."""
    fastest = float(best.candidate.trajectory.speed_mps.max())
    if fastest <= max(cycle.limit_mps, cycle.situation.host.speed_mps) + _NOTABLE_MPS:
        return ""
    return f"; faster than the speed limit of {cycle.limit_mps:.3g} m/s, {'to escape from behind' if cycle.is_pressed else 'to evade'}"


def _why_required(required: RequiredLane, s_m: float) -> str:
    if required.own_lane_is_undrivable:
        return "out of a lane that is none to drive in"
    return "to the destination's lane" if required.end_m is None else f"its own ends in {required.end_m - s_m:.0f} m"
