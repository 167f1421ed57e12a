"""The MPC method: candidates are proposed, solved, checked and costed, round after round; the cheapest that comes to a safe end wins."""

from __future__ import annotations

from dataclasses import replace
from typing import ClassVar

from mcdas_opt.domain.plan import Plan, Refusal, Timing
from mcdas_opt.domain.settings import Settings
from mcdas_opt.domain.situation import Situation
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.domain.vocabulary import Mode, Side
from mcdas_opt.planning.candidate import Ended
from mcdas_opt.planning.candidates.cost import CostWeights
from mcdas_opt.planning.candidates.evaluator import Evaluator
from mcdas_opt.planning.cycle import Cycle
from mcdas_opt.planning.fallback.ladder import NothingPasses
from mcdas_opt.planning.front.headway import ORDINARY_MPS2
from mcdas_opt.planning.lane_problem.lane_mpc_solver import LaneMpcSolver
from mcdas_opt.planning.lanes.manoeuvre import Manoeuvre
from mcdas_opt.planning.lanes.required_lane import RequiredLane
from mcdas_opt.planning.memory import Memory, carried
from mcdas_opt.planning.order import SEARCH
from mcdas_opt.planning.proposals.keep_lane import BRAKE
from mcdas_opt.planning.proposals.unwatched import unwatched
from mcdas_opt.planning.proposals.yielding import yielding
from mcdas_opt.planning.rehearsal import rehearse
from mcdas_opt.planning.reporting.reason import reason
from mcdas_opt.planning.reporting.reliance import reliance_in_words, told_of_followers
from mcdas_opt.planning.search import Found, Search, Solvers, run
from mcdas_opt.planning.solver_settings import SolverSettings

_NOTABLE_MPS = 0.1  # beyond the speed limit


class MpcMethod:
    """Kinematic-bicycle MPC on the sigmoid offset path. Between calls it keeps nothing but its solvers and their warm starts."""

    has_ladder = True
    _is_rehearsed: ClassVar[bool] = False  # in this process

    def __init__(
        self,
        vehicle: Vehicle,
        settings: Settings | None = None,
        solver: SolverSettings | None = None,
        weights: CostWeights | None = None,
    ) -> None:
        self.vehicle, self.settings, self.weights = vehicle, settings or Settings(), weights or CostWeights()
        usual = LaneMpcSolver(vehicle, self.settings, solver)
        self.solvers = Solvers(usual, usual.with_less_clearance(vehicle))
        self._warm_starts: object = None
        for each in self.solvers:
            each.warm_up(vehicle)
        if not MpcMethod._is_rehearsed:
            MpcMethod._is_rehearsed = True
            rehearse(self, self.settings)

    @property
    def solver(self) -> str:
        """Which engine answers first, and in which form."""
        return self.solvers.usual.name

    def plan(self, situation: Situation, previous: Plan | None) -> Plan | Refusal:
        """One plan, or why there is none. `previous` is the plan of the cycle before, with its memory; None begins without."""
        cycle = Cycle.of(situation, self.vehicle, self.settings, carried(previous, Memory))
        answer = self.answer(cycle)
        if isinstance(answer, Plan):
            return cycle.given_from(replace(answer, memory=cycle.remember(answer)))
        return Refusal(reason=answer.reason, candidates=answer.candidates, iterations=answer.iterations)

    def answer(self, cycle: Cycle) -> Plan | NothingPasses:
        """One cycle: a plan that passes, not always to a safe end, or what did not."""
        fits = cycle.memory.warm_starts is not None and cycle.memory.warm_starts is self._warm_starts
        for solver in self.solvers:
            solver.begin() if fits else solver.forget()
        self._warm_starts = object()
        search = Search(Evaluator(cycle, self.weights), self.solvers)
        found = run(search, SEARCH)
        return self._refused(search) if found.best is None else self._plan(search, found, found.best)

    def _refused(self, search: Search) -> NothingPasses:
        account = search.evaluator.account
        refused = "; ".join(f"{row.name}: {row.refusal}" for row in account.rows)
        return NothingPasses(
            reason=f"no candidate passes ({refused})",
            candidates=tuple(account.rows),
            iterations=account.iterations,
            # what was cut short is no plan to fall back on: it would not even mirror with its situation
            failed=tuple(checked.named_as_driven() for checked in account.failed if checked.driven.converged),
            memory=self._memory(chosen=search.cycle.memory.chosen, least_cost=None),
        )

    def _plan(self, search: Search, found: Found, best: Ended) -> Plan:
        cycle, account, proposed, cost = search.cycle, search.evaluator.account, best.proposed, best.candidate.cost or 0.0
        before = None if found.is_comparison else cycle.memory.least_cost
        least_cost = cost if before is None else min(before, cost)
        ending = told_of_followers(best.continuation, cycle)
        return Plan(
            planner="mpc",
            mode=best.candidate.checked.driven_mode,
            side=proposed.side,
            indicator=cycle.indicator,
            warning=cycle.assessment.threatened and proposed.side is not Side.NONE,
            reason=reason(cycle.assessment, best, account.rows, is_comparison=found.is_comparison, answered=_answered(best, cycle))
            + _as_begun(found, best, cycle)
            + _lane_change(best, cycle)
            + _passing(best, cycle)
            + _unwatched(best, cycle)
            + _haste(best, cycle)
            + _stop(best, cycle)
            + reliance_in_words(ending.end, cycle),
            chosen=proposed.name,
            verdict=ending.verdict,
            prediction=cycle.prediction.name,
            trajectory=ending.trajectory,
            candidates=tuple(account.rows),
            timing_ms=Timing(solve=1e3 * account.solve_s, verify=1e3 * account.verify_s),
            iterations=account.iterations,
            converged=best.candidate.checked.driven.converged,
            solver=self.solver,
            literal_mode=cycle.assessment.literal_mode,
            safe_end=ending.end,
            memory=self._memory(chosen=proposed.name, least_cost=least_cost, active=proposed.manoeuvre),
        )

    def _memory(self, *, chosen: str, least_cost: float | None, active: Manoeuvre | None = None) -> Memory:
        return Memory(
            active=active,
            chosen=chosen,
            least_cost=least_cost,
            warm_starts=self._warm_starts,
        )


def _why_required(required: RequiredLane, s_m: float) -> str:
    if required.end_m is None:
        return "to the destination's lane"
    return "out of a lane that is none to drive in" if required.own_lane_is_undrivable else f"its own ends in {required.end_m - s_m:.0f} m"


def _as_begun(found: Found, best: Ended, cycle: Cycle) -> str:
    """Said of an evasion that goes on without being compared with the others again."""
    evades = cycle.active is not None and best.proposed.manoeuvre == cycle.active and best.proposed.mode is Mode.EVADE
    return "; goes on as begun" if evades and not found.is_comparison else ""


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
    """Said of driving past somebody who stands at the lane's side."""
    if best.proposed.side is not Side.NONE:
        return ""
    return "".join(f"; passes {one.track.id} within its lane, {one.gap_m:.1f} m beside it" for one in cycle.passed.passed)


def _unwatched(best: Ended, cycle: Cycle) -> str:
    """Said of steering on into a lane that nobody watches, and of a lane change that is required and not made for that."""
    situation, required, side = cycle.situation, cycle.required_lane, best.proposed.side
    if side is not Side.NONE:
        why = unwatched(situation, side)
        return f"; {why}" if why else ""
    why = "" if required is None else unwatched(situation, required.side)
    return f"; {why}: stays in its lane, though {_why_required(required, situation.host.s_m)}" if required is not None and why else ""


def _stop(best: Ended, cycle: Cycle) -> str:
    """Said of braking that somebody's braking ahead asks for, though nobody comes near."""
    stops = best.proposed.name == BRAKE and cycle.is_ordinary and cycle.front_braking.is_to_the_limit
    return f"; {cycle.assessment.front_id} brakes about as hard as the road allows" if stops else ""


def _answered(best: Ended, cycle: Cycle) -> str:
    """Who crosses and is let through, or asks for braking ahead, though he does not threaten."""
    proposed, assessment = best.proposed, cycle.assessment
    names = [one.track.id for one in yielding(cycle, proposed.path.target_d_m)] if proposed.is_comfortable else []
    if names:
        return f"{' and '.join(names)} {'crosses and is' if len(names) == 1 else 'cross and are'} let through"
    if cycle.front_braking.stopping_mps2 <= ORDINARY_MPS2 or proposed.side is not Side.NONE:
        return ""
    return f"track {assessment.front_id}, {assessment.front_gap_m:.1f} m ahead, asks for {cycle.front_braking.stopping_mps2:.1f} m/s^2"


def _haste(best: Ended, cycle: Cycle) -> str:
    """Said of a plan that accelerates beyond the speed limit."""
    fastest = float(best.candidate.trajectory.speed_mps.max())
    if fastest <= max(cycle.limit_mps, cycle.situation.host.speed_mps) + _NOTABLE_MPS:
        return ""
    return f"; faster than the speed limit of {cycle.limit_mps:.3g} m/s, {'to escape from behind' if cycle.is_pressed else 'to evade'}"
