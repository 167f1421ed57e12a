"""The search of one cycle: rounds of candidates, gentlest first, until the best of one is good enough."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

from mcdas_opt.domain.vocabulary import Side
from mcdas_opt.planning.candidate import Costed, Ended, Proposed
from mcdas_opt.planning.candidates.choice import Round, choose
from mcdas_opt.planning.candidates.evaluator import Evaluator
from mcdas_opt.planning.cycle import Cycle
from mcdas_opt.planning.deadline import Stage
from mcdas_opt.planning.lane_problem.lane_mpc_solver import LaneMpcSolver
from mcdas_opt.planning.proposals.evade import basic_four

_NOT_NEEDED = "not solved: others rank higher, and pass"


class Solvers(NamedTuple):
    """The lane MPC as it is, and the one that asks for less clearance."""

    usual: LaneMpcSolver
    closer: LaneMpcSolver


class Search:
    """What the rounds of one cycle share. `pending` are proposals that were not looked at yet; `keep` is the lane keeping whose closed
    form takes part in a comparison."""

    def __init__(self, evaluator: Evaluator, solvers: Solvers) -> None:
        self.evaluator, self.solvers = evaluator, solvers
        self.pending: tuple[Proposed, ...] = ()
        self.keep: tuple[Proposed, ...] = ()

    @property
    def cycle(self) -> Cycle:
        return self.evaluator.cycle

    @cached_property
    def basic(self) -> tuple[Proposed, ...]:
        """Braking, accelerating, left, right; the sides alone where the active manoeuvre is half done: the lane that holds the car is then
        the one that it steers for, so that keeping it is no candidate of its own."""
        active = self.cycle.active
        four = basic_four(self.cycle, active)
        if active is not None and active.half_done(self.cycle.situation):
            return tuple(proposed for proposed in four if proposed.side is not Side.NONE)
        return four

    @cached_property
    def closed_forms(self) -> list[Costed]:
        """The closed forms that a comparison is made with: what swings half out of its lane too, at the cost of leaving it. None where the
        deadline leaves no time for them."""
        if self.cycle.is_late_for(Stage.SEARCH):
            return []
        passing, departing = self.evaluator.drive(self.basic + self.keep)
        return passing + departing

    def solve(self, proposals: Iterable[Proposed]) -> list[Costed]:
        """By the lane MPC as it is."""
        return self.evaluator.solve(proposals, self.solvers.usual.solve)


Rounds = Callable[[Search], Iterator[Round]]


@dataclass(frozen=True, slots=True, kw_only=True)
class Found:
    """The best candidate (None: none passes), and whether it stood against others of another kind."""

    best: Ended | None
    is_comparison: bool


def run(search: Search, order: Iterable[Rounds]) -> Found:
    """Round after round, each made only when the one before is not enough; where none is, the best of the last one."""
    best, last = None, None
    for rounds in order:
        for last in rounds(search):
            best = choose(search.evaluator, last)
            if best is not None and best.is_sound and last.is_enough(best.candidate):
                search.evaluator.pass_over(search.pending, _NOT_NEEDED)
                return Found(best=best, is_comparison=last.is_comparison)
    return Found(best=best, is_comparison=last is None or last.is_comparison)
