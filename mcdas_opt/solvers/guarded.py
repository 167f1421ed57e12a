"""An engine asked with care: whatever it throws or returns, an `Outcome` comes back that may be read."""

from __future__ import annotations

from typing import Protocol

import numpy as np

from mcdas_opt.domain.rules import Array
from mcdas_opt.solvers.outcome import Ending, Outcome
from mcdas_opt.solvers.stage_problem import StageGuess


class Engine(Protocol):
    """What solves a stage problem: from the state x0 (nx,), parameters (N + 1, np), steps (N,), a guess and a cap on iterations."""

    def solve(self, x0: Array, p: Array, steps_s: Array, guess: StageGuess, iterations: int, /) -> Outcome: ...


def ask(engine: Engine, x0: Array, p: Array, steps_s: Array, guess: StageGuess, iterations: int) -> Outcome:
    """The engine's outcome; `FAILED`, with the reason, where it raises or what comes back is no outcome of the guess's shape."""
    try:
        outcome = engine.solve(x0, p, steps_s, guess, iterations)
        shapes = outcome.x.shape, outcome.u.shape, outcome.s.shape
    except Exception as error:  # an engine is foreign code: what it throws must not leave the cycle without an answer
        return _failed(guess, f"{type(error).__name__}: {error}")
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
