"""A primal-dual interior point that uses the stages: Newton steps on the nonlinear problem by a Riccati recursion.

The cost's Hessian is Gauss-Newton's, to which the convex curvature of the rows is added; slacks are eliminated stage by stage. No line
search and no merit function, but steps to and fro are halved. A cold start runs Mehrotra's predictor and corrector from a large barrier;
a warm start keeps a small, fixed one. Sources: Rao, Wright, Rawlings, JOTA 99 (1998) 723; Mehrotra, SIAM J. Optim. 2 (1992) 575.
"""

from __future__ import annotations

import copy
import ctypes
from collections.abc import Callable

import numpy as np

from mcdas_opt.domain.rules import Array
from mcdas_opt.native.form import wanted, warn_interpreted
from mcdas_opt.native.library import NoLibraryError, load
from mcdas_opt.solvers.barrier_stage import BarrierStage
from mcdas_opt.solvers.compiled_kernel import CompiledKernel, fits
from mcdas_opt.solvers.interpreted_kernel import InterpretedKernel, over_horizon
from mcdas_opt.solvers.iterate import Kernel
from mcdas_opt.solvers.newton_loop import LoopEnding, LoopRule
from mcdas_opt.solvers.outcome import Ending, Outcome
from mcdas_opt.solvers.same_problem import poses_the_same
from mcdas_opt.solvers.stage_functions import stage_functions
from mcdas_opt.solvers.stage_problem import Member, StageGuess, StageProblem

_NONE = np.zeros(0)
RULE = LoopRule()
ITERATIONS = 60  # at most, unless told
MU_COLD = 10.0  # barrier that a cold start begins with
LEAST_COLD = 0.1  # least slack and distance to an inequality that a cold start begins with
LEAST_WARM = 1e-4  # the same of a warm start


class InteriorPointEngine:
    """Solves a `StageProblem` over a fixed number of steps. One engine belongs to one planner and one thread.

    It keeps nothing from one solve to the next: a warm start lies in the guess (`shifted`). A guess without multipliers starts cold.
    """

    def __init__(self, problem: StageProblem, nodes: int, *, compiled: bool | None = None, portable: bool = False) -> None:
        """`compiled`: None takes the native library where there is one and it has the problem's stage functions; `portable`: those of them
        that give the same bits on every machine."""
        self.problem, self.nodes = problem, nodes
        stage = BarrierStage(problem)
        self._moves, self._unbound = _shift(stage, nodes)
        self._make, self.reason = _maker(stage, nodes, wanted() if compiled is None else compiled, portable)
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

    def solve(self, x0: Array, p: Array, steps: Array, guess: StageGuess, iterations: int = ITERATIONS) -> Outcome:
        """At most `iterations` Newton steps from `guess`, for the measured x0 (nx,), parameters p (N + 1, np), step lengths (N,)."""
        kernel = self._kernel
        warm = self._load(x0, p, steps, guess)
        finite = kernel.warm(RULE.mu, LEAST_WARM) if warm else kernel.cold(MU_COLD, LEAST_COLD)
        if not finite:
            return self._failed(Ending.NOT_FINITE, guess, 0, "the problem's data are not finite")
        end = kernel.loop(warm=warm, iterations=iterations, rule=RULE)
        if end.ending is LoopEnding.NOT_FINITE:
            return self._failed(Ending.NOT_FINITE, guess, end.done, "the step is not finite")
        if end.ending is LoopEnding.INFEASIBLE:
            message = f"bounds and dynamics contradict each other: {end.progress.residual:.2g} is left"
            return self._failed(Ending.INFEASIBLE, guess, end.done, message)
        converged = end.ending is LoopEnding.CONVERGED
        it, nx = kernel.iterate, self.problem.nx
        return Outcome(
            ending=Ending.CONVERGED if converged else Ending.LIMIT,
            x=it.z[:, :nx].copy(),
            u=it.z[:-1, nx:].copy(),
            s=it.least.copy(),
            multipliers=it.multipliers.copy(),
            objective=end.objective,
            iterations=end.done,
            inner_iterations=end.done,
            message="" if converged else f"last step {end.progress.step:.2g}, gap {end.gap:.2g}",
        )

    def shifted(self, outcome: Outcome, nodes: int = 1) -> StageGuess:
        """The warm start for so many steps later: moved on by as many nodes, the last state drawn on in a straight line, u = 0 there.

        Multipliers of another size are none, and the start is cold.
        """
        x, u, s, multipliers = outcome.x, outcome.u, outcome.s, outcome.multipliers
        if multipliers.size != self._kernel.iterate.multipliers.size:
            multipliers = _NONE
        for _ in range(nodes):
            x, u, s, multipliers = self._one_later(x, u, s, multipliers)
        return StageGuess(x=x, u=u, s=s, multipliers=multipliers)

    def _one_later(self, x: Array, u: Array, s: Array, multipliers: Array) -> tuple[Array, Array, Array, Array]:
        problem = self.problem
        moved_x, moved_u, moved_s = np.empty_like(x), np.empty_like(u), np.empty_like(s)
        moved_x[:-1], moved_u[:-1], moved_s[:-1] = x[1:], u[1:], s[1:]
        np.minimum(np.maximum(2.0 * x[-1] - x[-2], problem.x_lower), problem.x_upper, out=moved_x[-1])
        moved_u[-1], moved_s[-1] = 0.0, s[-1]
        if not multipliers.size:
            return moved_x, moved_u, moved_s, multipliers
        moved = multipliers.copy()
        for to, of in self._moves:
            moved[to] = multipliers[of]
        for unbound in self._unbound:
            moved[unbound] = 0.0
        return moved_x, moved_u, moved_s, moved

    def _load(self, x0: Array, p: Array, steps: Array, guess: StageGuess) -> bool:
        """Puts the problem and its guess into the iterate; whether the guess is a warm one."""
        it, nx = self._kernel.iterate, self.problem.nx
        it.p[:] = p
        it.steps[:-1], it.steps[-1] = steps, steps[-1]
        it.z[:, :nx], it.z[:-1, nx:], it.z[-1, nx:] = guess.x, guess.u, 0.0
        it.z[0, :nx] = x0
        if guess.multipliers.size != it.multipliers.size:
            return False
        it.multipliers[:] = guess.multipliers
        return True

    def _failed(self, ending: Ending, guess: StageGuess, done: int, message: str) -> Outcome:
        return Outcome(ending=ending, x=guess.x, u=guess.u, s=guess.s, iterations=done, inner_iterations=done, message=message)


def _shift(stage: BarrierStage, nodes: int) -> tuple[list[tuple[slice, slice]], list[slice]]:
    """Of an iterate's `multipliers` one step later: which parts move where (the last node's stay), and which are nothing then.

    The inputs' bounds did not hold at the node that was the last: at the one before it there is no t, and no multiplier.
    """
    ns, nc, first = stage.ns, stage.nc, 0
    moves, unbound = [], []
    for width in (ns, nc, nc):
        end = first + (nodes + 1) * width
        moves.append((slice(first, end - width), slice(first + width, end)))
        if first > 0:
            unbound.append(slice(end - 2 * width + stage.inner, end - width))
        first = end
    return moves, unbound


def _maker(stage: BarrierStage, nodes: int, compiled: bool, portable: bool) -> tuple[Callable[[], Kernel], str]:
    """Makes compiled kernels, or interpreted ones, with the reason for it."""
    reason, member = "the compiled form is switched off", stage.problem.member
    if compiled and member is None:
        reason = f"the native library has no stage functions of this {stage.problem.name} problem"
    elif compiled and member is not None:
        try:
            return _compiled_maker(stage, member, nodes, load(portable=portable)), ""
        except NoLibraryError as error:
            reason = str(error)
            warn_interpreted(reason)
    whole = over_horizon(stage, stage_functions(stage.problem)[1], nodes)
    return lambda: InterpretedKernel(stage, whole, nodes), reason


def _compiled_maker(stage: BarrierStage, member: Member, nodes: int, library: ctypes.CDLL) -> Callable[[], Kernel]:
    """Raises `NoLibraryError` where the library's stage functions pose another problem."""
    if not fits(stage, member) or not poses_the_same(CompiledKernel(library, stage, member, nodes), stage):
        raise NoLibraryError("the native library has the stage functions of another lane problem (`mcdas_opt.planning.generated_texts`)")
    return lambda: CompiledKernel(library, stage, member, nodes)
