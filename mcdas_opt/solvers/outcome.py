"""How a solve ended: read the ending and finiteness before x. An engine is asked by `ask`: whatever it does, an outcome comes back."""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import StrEnum
from typing import Protocol

import numpy as np

from mcdas_opt.domain.rules import Array, all_finite
from mcdas_opt.errors import told
from mcdas_opt.solvers.stage_problem import StageGuess


class Ending(StrEnum):
    """`CONVERGED`: the step fell under tolerance. `LIMIT`: the iteration cap ended it with a finite point. The rest have no point."""

    CONVERGED = "converged"
    LIMIT = "iteration limit"
    INFEASIBLE = "infeasible"
    NOT_FINITE = "not finite"
    FAILED = "failed"


IPOPT_ENDINGS = {  # by its return status
    "Solve_Succeeded": Ending.CONVERGED,
    "Solved_To_Acceptable_Level": Ending.CONVERGED,
    "Maximum_Iterations_Exceeded": Ending.LIMIT,
    "Infeasible_Problem_Detected": Ending.INFEASIBLE,
    "Invalid_Number_Detected": Ending.NOT_FINITE,
}


@dataclass(frozen=True, slots=True, kw_only=True)
class Outcome:
    """`x` (N + 1, nx), `u` (N, nu), `s` (N + 1, ns) may be read only when `usable`."""

    ending: Ending
    x: Array
    u: Array
    s: Array
    multipliers: Array = field(default_factory=lambda: np.zeros(0))
    objective: float = float("nan")
    iterations: int = 0
    inner_iterations: int = 0
    message: str = ""

    @property
    def usable(self) -> bool:
        if self.ending is not Ending.CONVERGED and self.ending is not Ending.LIMIT:
            return False
        return all_finite(self.x) and all_finite(self.u) and all_finite(self.s)


class Engine(Protocol):
    """What solves a stage problem: from the state x0 (nx,), parameters (N + 1, np), steps (N,), a guess and a cap on iterations."""

    def solve(self, x0: Array, p: Array, steps_s: Array, guess: StageGuess, iterations: int, /) -> Outcome: ...


def ask(engine: Engine, x0: Array, p: Array, steps_s: Array, guess: StageGuess, iterations: int) -> Outcome:
    """The engine's outcome; `FAILED`, with the reason, where it raises or what comes back is no outcome of the guess's shape."""
    try:
        outcome = engine.solve(x0, p, steps_s, guess, iterations)
        shapes = outcome.x.shape, outcome.u.shape, outcome.s.shape
    except Exception as error:  # an engine is foreign code: what it throws must not leave the cycle without an answer
        return _failed(guess, told(error))
    if shapes != (guess.x.shape, guess.u.shape, guess.s.shape):
        return _failed(guess, f"the solution has shapes {shapes[0]}, {shapes[1]}, {shapes[2]}")
    return outcome


def _failed(guess: StageGuess, message: str) -> Outcome:
    return Outcome(
        ending=Ending.FAILED,
        x=np.full_like(guess.x, np.nan),
        u=np.full_like(guess.u, np.nan),
        s=np.full_like(guess.s, np.nan),
        message=message,
    )
