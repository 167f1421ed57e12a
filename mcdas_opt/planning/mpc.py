"""The MPC method: candidates are proposed, solved, checked and costed, round after round; the cheapest that comes to a safe end wins."""

from __future__ import annotations

from dataclasses import replace
from typing import Any, ClassVar

from mcdas_opt.domain.cost_weights import CostWeights
from mcdas_opt.domain.plan import Plan, Refusal, Timing
from mcdas_opt.domain.settings import Settings
from mcdas_opt.domain.situation import Situation
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.domain.vocabulary import Side
from mcdas_opt.planning.candidate import Ended
from mcdas_opt.planning.candidates.evaluator import Evaluator
from mcdas_opt.planning.cycle import Cycle
from mcdas_opt.planning.fallback.ladder import NothingPasses
from mcdas_opt.planning.lane_problem.lane_mpc_solver import LaneMpcSolver
from mcdas_opt.planning.lanes.manoeuvre import Manoeuvre
from mcdas_opt.planning.memory import Memory, carried
from mcdas_opt.planning.order import SEARCH
from mcdas_opt.planning.rehearsal import rehearse
from mcdas_opt.planning.reporting.reason import reason
from mcdas_opt.planning.reporting.reliance import reliance_in_words, told_of_followers
from mcdas_opt.planning.reporting.remarks import remarks
from mcdas_opt.planning.search import Found, Search, Solvers, run
from mcdas_opt.planning.solver_settings import SolverSettings


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

    def __reduce__(self) -> tuple[Any, ...]:
        """Made anew in another process, and by a copy; its warm starts stay behind."""
        return MpcMethod, (self.vehicle, self.settings, self.solvers.usual.own, self.weights)

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
            reason=reason(cycle, best, account.rows, is_comparison=found.is_comparison)
            + remarks(cycle, best, is_comparison=found.is_comparison)
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
