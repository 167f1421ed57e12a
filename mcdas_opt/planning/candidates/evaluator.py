"""Evaluates candidates, stage by stage, and keeps what this cycle has found so far."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field, replace

from mcdas_opt.domain.cost_weights import CostWeights
from mcdas_opt.domain.plan import Candidate
from mcdas_opt.domain.vocabulary import Mode, Side
from mcdas_opt.planning.candidate import Checked, Costed, Driven, Ended, Proposed, Refused
from mcdas_opt.planning.candidates.collision_check import verdicts
from mcdas_opt.planning.candidates.continuation import ended
from mcdas_opt.planning.candidates.cost import driving_costs
from mcdas_opt.planning.candidates.driven_closed_form import drive
from mcdas_opt.planning.candidates.lane_change_cost import lane_change_cost
from mcdas_opt.planning.candidates.lane_departure import departure
from mcdas_opt.planning.candidates.nearness import nearness
from mcdas_opt.planning.cycle import Cycle
from mcdas_opt.planning.deadline import Stage

Solve = Callable[[Cycle, Proposed], Driven | Refused]


@dataclass(slots=True)
class Account:
    """What was tried, in order, as the plan tells it; what failed; and what that took."""

    rows: list[Candidate] = field(default_factory=list)
    failed: list[Checked] = field(default_factory=list)
    iterations: int = 0
    solve_s: float = 0.0
    verify_s: float = 0.0

    def note_end(self, found: Ended) -> None:
        """Tells with the candidate how it ends."""
        end = found.continuation.end
        for i, row in enumerate(self.rows):
            if row.name == found.proposed.name and end is not None:
                self.rows[i] = replace(row, end=end.kind)


class Evaluator:
    """`passing` may leave as they are. `departing` pass too, but half out of the lane that they were to keep, to a side that somebody
    watches: they stand at the cost of steering out."""

    def __init__(self, cycle: Cycle, weights: CostWeights) -> None:
        self.cycle, self.weights = cycle, weights
        self.passing: list[Costed] = []
        self.departing: list[Costed] = []
        self.account = Account()
        self._ended: list[tuple[Costed, Ended]] = []

    def solve(self, proposals: Iterable[Proposed], by: Solve) -> list[Costed]:
        """Solves, one by one, then checks and costs them together. Those that pass, which are `passing` from now on."""
        passing, departing = self._evaluated([self._solved(proposed, by) for proposed in proposals])
        self.passing += passing
        self.departing += departing
        return passing

    def drive(self, proposals: Iterable[Proposed]) -> tuple[list[Costed], list[Costed]]:
        """The same manoeuvres as the bicycle drives them without an optimiser: what leaves never costs more than the closed form.

        (passing, departing); neither is kept here.
        """
        named = [replace(proposed, name=f"{proposed.name}-driven") for proposed in proposals if not proposed.refusal]
        return self._evaluated([drive(proposed, self.cycle) for proposed in named])

    def pass_over(self, proposals: Iterable[Proposed], reason: str) -> None:
        """Tells of candidates that are not looked at, and why."""
        self.account.rows += [Refused(proposed=proposed, reason=reason).row() for proposed in proposals]

    def ended(self, candidate: Costed) -> Ended:
        """`candidate` continued to a safe end: once a cycle, however often it is compared."""
        for known, found in self._ended:
            if known.trajectory is candidate.trajectory:
                return found if known is candidate else replace(found, candidate=candidate)
        found = ended(candidate, self.cycle)
        self._ended.append((candidate, found))
        self.account.note_end(found)
        return found

    def _solved(self, proposed: Proposed, by: Solve) -> Driven | Refused:
        """One candidate, unless there is a reason not even to try."""
        if proposed.refusal:
            return Refused(proposed=proposed, reason=proposed.refusal)
        if self.cycle.is_late_for(Stage.SEARCH):
            return Refused(proposed=proposed, reason="the deadline passed before it was tried")
        started = time.perf_counter()
        solved = by(self.cycle, proposed)
        self.account.solve_s += time.perf_counter() - started
        self.account.iterations += solved.iterations
        return solved

    def _evaluated(self, drives: Sequence[Driven | Refused]) -> tuple[list[Costed], list[Costed]]:
        """Checked and costed, all at once, and told of in their order. (passing, departing)"""
        started = time.perf_counter()
        costed = iter(self._costed([one for one in drives if isinstance(one, Driven)]))
        passing: list[Costed] = []
        departing: list[Costed] = []
        for one in drives:
            if isinstance(one, Refused):
                self.account.rows.append(one.row())
                continue
            candidate = next(costed)
            checked = candidate.checked
            if candidate.cost is None or not math.isfinite(candidate.cost):
                self.account.rows.append(Refused(proposed=candidate.proposed, reason="its cost is not finite").row())
                continue
            self.account.rows.append(candidate.row())
            if not checked.verdict.passed:
                self.account.failed.append(checked)
            elif checked.departure is Side.NONE:
                passing.append(candidate)
            elif checked.departure_is_watched:
                departing.append(self._steering_out(candidate))
        self.account.verify_s += time.perf_counter() - started
        return passing, departing

    def _costed(self, drives: Sequence[Driven]) -> list[Costed]:
        if not drives:
            return []
        cycle, weights = self.cycle, self.weights
        trajectories = [driven.trajectory for driven in drives]
        near = nearness(trajectories, cycle)
        judged = verdicts(trajectories, cycle, near)
        costs = driving_costs(near, cycle, weights)
        found = []
        for driven, verdict, cost in zip(drives, judged, costs, strict=True):
            proposed = driven.proposed
            side = departure(driven.trajectory, proposed, cycle)
            watched = side is Side.NONE or cycle.situation.sees_lane(side)
            checked = Checked(driven=driven, verdict=verdict, departure=side, departure_is_watched=watched)
            cost += lane_change_cost(proposed.side, cycle, weights)
            found.append(Costed(checked=checked, cost=cost + (weights.delayed if proposed.is_delayed else 0.0)))
        return found

    def _steering_out(self, departing: Costed) -> Costed:
        """One that departs from its lane, taken as what it does, at the cost of steering out."""
        checked = departing.checked
        side = checked.departure
        as_driven = checked.proposed_as(replace(checked.proposed, mode=Mode.EVADE, side=side))
        cost = (departing.cost or 0.0) + lane_change_cost(side, self.cycle, self.weights)
        return Costed(checked=replace(as_driven, departure=Side.NONE), cost=cost)
