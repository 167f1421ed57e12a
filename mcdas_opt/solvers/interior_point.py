"""A primal-dual interior point that uses the stages: Newton steps on the nonlinear problem by a Riccati recursion.

The cost's Hessian is Gauss-Newton's, to which the convex curvature of the rows is added; slacks are eliminated stage by stage. No line
search and no merit function, but steps to and fro are halved. A cold start runs Mehrotra's predictor and corrector from a large barrier;
a warm start keeps a small, fixed one. Sources: Rao, Wright, Rawlings, JOTA 99 (1998) 723; Mehrotra, SIAM J. Optim. 2 (1992) 575.
"""

from __future__ import annotations

import copy
import math
import os
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from mcdas_opt.domain.rules import Array
from mcdas_opt.native.compile_cache import SWITCH as SWITCH
from mcdas_opt.native.compile_cache import NoLibraryError, cache_folder, load, to_stderr
from mcdas_opt.solvers.barrier_stage import BarrierStage
from mcdas_opt.solvers.c_text import UnsupportedOperationError
from mcdas_opt.solvers.compiled_kernel import CompiledKernel
from mcdas_opt.solvers.interpreted_kernel import CORRECTION, InterpretedKernel
from mcdas_opt.solvers.iterate import Kernel, Progress
from mcdas_opt.solvers.kernel_source import BUILDS, kernel_source
from mcdas_opt.solvers.outcome import Ending, Outcome
from mcdas_opt.solvers.stage_functions import StageFunctions, stage_functions
from mcdas_opt.solvers.stage_problem import StageGuess, StageProblem

_STEP_LENGTH = 0.9  # a converged step was taken nearly whole
_HALF, _SHRUNK = 0.5, 0.7  # steps that turn back and are longer than this share of the one before are taken by half
_CENTRED = 10.0  # and its mean complementarity is at most so many times the barrier's
_DIVERGED = 1e9  # scaled step that ends the solve
_BLOCKED = 1e-3  # step length that, with multipliers growing without bound, tells an infeasible problem
_UNBOUNDED = 1e3  # mean complementarity over that of a cold start


@dataclass(frozen=True, slots=True, kw_only=True)
class InteriorPointSettings:
    """Tolerances are relative to the problem's scales; every limit is counted, none is a clock."""

    step_tolerance: float = 1e-2  # largest change of the last step
    gap_tolerance: float = 1e-3  # largest gap left in the nonlinear dynamics, and in the inequalities as linearised
    mu_cold: float = 10.0  # barrier that a cold start begins with
    mu_end: float = 1e-5  # barrier that is converged to, and that a warm start keeps
    least_cold: float = 0.1  # least slack and distance to an inequality that a cold start begins with
    least_warm: float = 1e-4  # the same of a warm start
    boundary: float = 0.995  # share of the way to the boundary that a step may take
    plain_iterations: int = 5  # of a warm start, before it too turns to predictor and corrector
    iterations: int = 60


class InteriorPointEngine:
    """Solves a `StageProblem` over a fixed number of steps. One engine belongs to one planner and one thread.

    It keeps nothing from one solve to the next: a warm start lies in the guess (`shifted`). A guess without multipliers starts cold.
    """

    def __init__(
        self,
        problem: StageProblem,
        nodes: int,
        settings: InteriorPointSettings | None = None,
        *,
        compiled: bool | None = None,
        builds: Sequence[str] = BUILDS,
        announce: Callable[[str], None] = to_stderr,
    ) -> None:
        """`compiled`: None takes the compiler there is, unless MCDAS_OPT_COMPILE=0; `builds`: its flags, best first.

        `announce` is told when the first build begins.
        """
        self.problem, self.nodes = problem, nodes
        self.settings = settings or InteriorPointSettings()
        self._stage, functions = stage_functions(problem)
        wanted = os.environ.get(SWITCH, "1") != "0" if compiled is None else compiled
        self._make, self.reason = _maker(self._stage, functions, nodes, builds if wanted else (), announce)
        self._kernel = self._make()

    def twin(self) -> InteriorPointEngine:
        """Another engine for the same problem, with memory of its own; nothing is built again."""
        twin = copy.copy(self)
        twin._kernel = self._make()
        return twin

    @property
    def kind(self) -> str:
        """ "compiled" or "interpreted" (then `reason` says why)."""
        return self._kernel.kind

    def solve(self, x0: Array, p: Array, steps: Array, guess: StageGuess, iterations: int | None = None) -> Outcome:
        """At most `iterations` Newton steps from `guess`, for the measured x0 (nx,), parameters p (N + 1, np), step lengths (N,)."""
        settings, kernel = self.settings, self._kernel
        warm = self._load(x0, p, steps, guess)
        finite = kernel.warm(settings.mu_end, settings.least_warm) if warm else kernel.cold(settings.mu_cold, settings.least_cold)
        if not finite:
            return self._failed(Ending.NOT_FINITE, guess, 0, "the problem's data are not finite")
        progress, objective, gap = Progress(), math.nan, math.nan
        ending, done, longest = Ending.LIMIT, 0, 1.0
        for done in range(1, (settings.iterations if iterations is None else iterations) + 1):
            corrected = not warm or done > settings.plain_iterations
            before = progress
            progress = kernel.newton(corrected=corrected, mu=settings.mu_end, boundary=settings.boundary, longest=longest)
            if not (math.isfinite(progress.total) and progress.step < _DIVERGED):
                return self._failed(Ending.NOT_FINITE, guess, done, "the step is not finite")
            if progress.complementarity > _UNBOUNDED * settings.mu_cold and progress.primal < _BLOCKED:
                message = f"bounds and dynamics contradict each other: {progress.residual:.2g} is left"
                return self._failed(Ending.INFEASIBLE, guess, done, message)
            if self._settled(progress, longest):
                objective, gap = kernel.measure()
                if gap < settings.gap_tolerance:
                    ending = Ending.CONVERGED
                    break
            longest = _HALF if self._turns_back(before, progress, longest) else 1.0
        message = ""
        if ending is Ending.LIMIT:
            objective, gap = kernel.measure()
            message = f"last step {progress.step:.2g}, gap {gap:.2g}"
        it, nx = kernel.iterate, self.problem.nx
        return Outcome(
            ending=ending,
            x=it.z[:, :nx].copy(),
            u=it.z[:-1, nx:].copy(),
            s=it.least.copy(),
            multipliers=np.concatenate((it.s, it.t, it.multiplier), axis=1).ravel(),
            objective=objective,
            iterations=done,
            inner_iterations=done,
            message=message,
        )

    def shifted(self, outcome: Outcome) -> StageGuess:
        """The warm start for one step later: everything moved on by one node, the last state drawn on in a straight line, u = 0 there.

        The multipliers hold slacks, t and multipliers of every node, side by side; of another size they are none, and the start is cold.
        """
        problem, stage = self.problem, self._stage
        x, u = outcome.x, outcome.u
        beyond = np.minimum(np.maximum(2.0 * x[-1] - x[-2], problem.x_lower), problem.x_upper)
        kept = np.zeros((0, 0))
        if outcome.multipliers.size == self._kernel.iterate.multipliers:
            kept = outcome.multipliers.reshape(self.nodes + 1, -1)
            kept = np.concatenate((kept[1:], kept[-1:]))
            for first in (
                stage.ns,
                stage.ns + stage.nc,
            ):  # the input's bounds did not hold at the node that was the last: no t, no multiplier
                kept[-2, first + stage.inner : first + stage.nc] = 0.0
        return StageGuess(
            x=np.concatenate((x[1:], beyond[None])),
            u=np.concatenate((u[1:], np.zeros((1, problem.nu)))),
            s=np.concatenate((outcome.s[1:], outcome.s[-1:])),
            multipliers=kept.ravel(),
        )

    def reset(self) -> None:
        """Nothing to throw away: the engine keeps nothing between solves."""

    def _load(self, x0: Array, p: Array, steps: Array, guess: StageGuess) -> bool:
        """Puts the problem and its guess into the iterate; whether the guess is a warm one."""
        it, nx = self._kernel.iterate, self.problem.nx
        it.p[:], it.steps[:-1], it.steps[-1] = p, steps, steps[-1]
        it.z[:, :nx], it.z[:-1, nx:], it.z[-1, nx:] = guess.x, guess.u, 0.0
        it.z[0, :nx] = x0
        if guess.multipliers.size != it.multipliers:
            return False
        kept = guess.multipliers.reshape(self.nodes + 1, -1)
        ns, nc = self._stage.ns, self._stage.nc
        it.s[:], it.t[:], it.multiplier[:] = kept[:, :ns], kept[:, ns : ns + nc], kept[:, ns + nc :]
        return True

    def _settled(self, progress: Progress, longest: float) -> bool:
        settings = self.settings
        small = progress.step < settings.step_tolerance and progress.residual < settings.gap_tolerance
        return small and self._centred(progress, longest)

    def _turns_back(self, before: Progress, progress: Progress, longest: float) -> bool:
        """Full steps to and fro about the answer: the curvature left out is as large as the one kept, and half a step hits it.

        Seen near standstill, where only the dynamics' curvature says what steering does.
        """
        return self._centred(progress, longest) and progress.step > _SHRUNK * before.step and progress.total * before.total < 0.0

    def _centred(self, progress: Progress, longest: float) -> bool:
        return progress.complementarity < _CENTRED * self.settings.mu_end and progress.primal > _STEP_LENGTH * longest

    def _failed(self, ending: Ending, guess: StageGuess, done: int, message: str) -> Outcome:
        return Outcome(ending=ending, x=guess.x, u=guess.u, s=guess.s, iterations=done, inner_iterations=done, message=message)


def _maker(
    stage: BarrierStage, functions: StageFunctions, nodes: int, builds: Sequence[str], announce: Callable[[str], None]
) -> tuple[Callable[[], Kernel], str]:
    """Makes compiled kernels, or interpreted ones (always without `builds`), with the reason for it."""
    reason = "compiling is switched off"
    if builds:
        try:
            library = load(kernel_source(stage, functions, nodes, CORRECTION), builds, folder=cache_folder(), announce=announce)
            return lambda: CompiledKernel(library, stage, nodes), ""
        except (NoLibraryError, UnsupportedOperationError) as error:
            reason = str(error)
    return lambda: InterpretedKernel(stage, functions, nodes), reason
