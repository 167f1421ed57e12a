"""Whether compiled stage functions pose a problem as its own CasADi functions do: both are asked at one point."""

from __future__ import annotations

from typing import Any

import numpy as np

from mcdas_opt.domain.rules import Array
from mcdas_opt.solvers.iterate import Kernel
from mcdas_opt.solvers.stage_problem import StageProblem

_STEP_S = 0.1
_RELATIVE = 1e-9


def poses_the_same(kernel: Kernel, problem: StageProblem) -> bool:
    """Objective and gap, slacks and penalties with them, of the same state and input at every node, drawn once."""
    rng, it = np.random.default_rng(1), kernel.iterate
    n, nx = it.steps.size - 1, problem.nx
    x = problem.x_scale * rng.uniform(1.0, 2.0, nx)
    u = problem.u_scale * rng.uniform(1.0, 2.0, problem.nu)
    p = rng.uniform(1.1, 1.9, len(problem.parameters))
    it.z[:, :nx], it.z[:-1, nx:], it.z[-1, nx:] = x, u, 0.0
    it.p[:], it.steps[:] = p, _STEP_S
    kernel.cold(1.0, 0.1)
    objective, gap = kernel.measure()

    def squares(residual: Any) -> float:
        return 0.5 * float((residual.full() ** 2).sum())

    def penalty(inputs: Array) -> float:
        slack = np.zeros(problem.ns)
        np.maximum.at(slack, list(problem.slack_of), problem.inequality(x, inputs, p).full().ravel())
        return float(slack @ (problem.slack_linear + 0.5 * problem.slack_quadratic * slack))

    expected = n * squares(problem.residual(x, u, p)) + squares(problem.terminal_residual(x, p))
    expected += (n - 1) * penalty(u) + penalty(np.zeros(problem.nu))
    jump = np.abs(problem.dynamics(x, u, p, _STEP_S).full().ravel() - x) / problem.x_scale
    return bool(np.isclose(objective, expected, rtol=_RELATIVE) and np.isclose(gap, jump.max(), rtol=_RELATIVE))
