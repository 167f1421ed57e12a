"""Newton steps until the answer has settled: the decisions of the interior point, as they are written in C beside the compiled kernel."""

from __future__ import annotations

import math
from enum import IntEnum
from typing import NamedTuple, Protocol


class Progress(NamedTuple):
    """What one Newton step did: largest scaled change asked for, residual left of what was linearised, mean t l, step lengths taken.

    `total` sums the changes: it is finite only when all of them are.
    """

    step: float = float("nan")
    residual: float = float("nan")
    complementarity: float = float("nan")
    primal: float = float("nan")
    dual: float = float("nan")
    total: float = float("nan")


class LoopRule(NamedTuple):
    """What the loop decides by, in the order of the C text's `Rule`. Tolerances are relative to the problem's scales."""

    step_tolerance: float = 1e-2  # largest change of the last step
    gap_tolerance: float = 1e-3  # largest gap left in the nonlinear dynamics, and in the inequalities as linearised
    mu: float = 1e-5  # barrier that is converged to, and that a warm start keeps
    boundary: float = 0.995  # share of the way to the boundary that a step may take
    plain_iterations: float = 5.0  # of a warm start, before it too turns to predictor and corrector
    unbounded: float = 1e4  # mean complementarity that, with steps blocked, tells an infeasible problem
    step_length: float = 0.9  # a converged step was taken nearly whole
    half: float = 0.5  # steps that turn back ...
    shrunk: float = 0.7  # ... and are longer than this share of the one before are taken by half
    centred: float = 10.0  # and its mean complementarity is at most so many times the barrier's
    diverged: float = 1e9  # scaled step that ends the solve
    blocked: float = 1e-3  # step length that, with multipliers growing without bound, tells an infeasible problem


class LoopEnding(IntEnum):
    """As the C text numbers them."""

    CONVERGED = 0
    LIMIT = 1
    NOT_FINITE = 2
    INFEASIBLE = 3


class LoopEnd(NamedTuple):
    """How it ended, after how many steps, with which last one; objective and gap where there is an answer, which is then in the iterate."""

    ending: LoopEnding
    done: int
    progress: Progress
    objective: float
    gap: float


class Steps(Protocol):
    """What is looped: `iterate.Kernel`."""

    def newton(self, *, corrected: bool, mu: float, boundary: float, longest: float) -> Progress: ...
    def measure(self) -> tuple[float, float]: ...


def looped(kernel: Steps, *, warm: bool, iterations: int, rule: LoopRule) -> LoopEnd:
    """At most so many Newton steps of a kernel that has been started."""
    progress, longest, done = Progress(), 1.0, 0
    for done in range(1, iterations + 1):
        corrected = not warm or done > rule.plain_iterations
        before = progress
        progress = kernel.newton(corrected=corrected, mu=rule.mu, boundary=rule.boundary, longest=longest)
        if not (math.isfinite(progress.total) and progress.step < rule.diverged):
            return LoopEnd(LoopEnding.NOT_FINITE, done, progress, math.nan, math.nan)
        if progress.complementarity > rule.unbounded and progress.primal < rule.blocked:
            return LoopEnd(LoopEnding.INFEASIBLE, done, progress, math.nan, math.nan)
        if progress.step < rule.step_tolerance and progress.residual < rule.gap_tolerance and _centred(progress, longest, rule):
            objective, gap = kernel.measure()
            if gap < rule.gap_tolerance:
                return LoopEnd(LoopEnding.CONVERGED, done, progress, objective, gap)
        longest = rule.half if _turns_back(before, progress, longest, rule) else 1.0
    return LoopEnd(LoopEnding.LIMIT, done, progress, *kernel.measure())


def _centred(progress: Progress, longest: float, rule: LoopRule) -> bool:
    return progress.complementarity < rule.centred * rule.mu and progress.primal > rule.step_length * longest


def _turns_back(before: Progress, progress: Progress, longest: float, rule: LoopRule) -> bool:
    """Full steps to and fro about the answer: the curvature left out is as large as the one kept, and half a step hits it.

    Seen near standstill, where only the dynamics' curvature says what steering does.
    """
    further = progress.step > rule.shrunk * before.step and progress.total * before.total < 0.0
    return further and _centred(progress, longest, rule)
