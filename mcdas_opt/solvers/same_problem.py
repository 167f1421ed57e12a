"""Whether compiled stage functions pose a problem as its own CasADi functions do: both are asked at drawn points, one a node."""

from __future__ import annotations

from typing import Any

import numpy as np

from mcdas_opt.domain.rules import Array
from mcdas_opt.solvers.barrier_stage import BarrierStage
from mcdas_opt.solvers.iterate import Kernel

_STEP_S = 0.1
_SHORT_S = 0.01  # of a roll-out, that stays near where it begins
_MARGIN = 0.1  # between a slack and the largest of its rows: how far each row lies below its slack can then be read off
_RELATIVE = 1e-9


def poses_the_same(kernel: Kernel, stage: BarrierStage) -> bool:
    """Every row, active or not, and every bound at every node; the sum of costs and penalties; and the dynamics of every state."""
    rng = np.random.default_rng(1)
    return _same_terms(kernel, stage, rng) and _same_dynamics(kernel, stage, rng)


def _same_terms(kernel: Kernel, stage: BarrierStage, rng: np.random.Generator) -> bool:
    """At points all over the bounds."""
    it, problem = kernel.iterate, stage.problem
    n, nx = it.steps.size - 1, problem.nx
    it.z[:, :nx] = _drawn(rng, problem.x_lower, problem.x_upper, problem.x_scale, n + 1)
    it.z[:, nx:] = _drawn(rng, problem.u_lower, problem.u_upper, problem.u_scale, n + 1)
    it.z[-1, nx:] = 0.0
    it.p[:], it.steps[:] = rng.uniform(0.1, 2.0, it.p.shape), _STEP_S
    kernel.cold(1.0, _MARGIN)
    objective, _ = kernel.measure()

    x, u = it.z[:, :nx], it.z[:, nx:]
    rows = _of(problem.inequality, x, u, it.p)
    least = np.zeros((n + 1, problem.ns))
    for row, column in enumerate(problem.slack_of):
        least[1:, column] = np.maximum(least[1:, column], rows[1:, row])
    slack = least + _MARGIN
    bounds = [sign * (it.z[:, i] - limit) for i, sign, limit in stage.bounds]
    distance = np.maximum(-np.column_stack([rows - slack[:, stage.soft], -slack, *bounds]), _MARGIN)
    active = stage.over(n)[1].T > 0.0

    running, terminal = _of(problem.residual, x[:-1], u[:-1], it.p[:-1]), _of(problem.terminal_residual, x[-1:], it.p[-1:])
    costs = 0.5 * (running**2).sum() + 0.5 * (terminal**2).sum()
    paid = (it.least * (problem.slack_linear + 0.5 * problem.slack_quadratic * it.least)).sum()  # a thousand times the costs
    return _close(it.least, least) and _close(it.t[active], distance[active]) and _close(objective - paid, costs)


def _same_dynamics(kernel: Kernel, stage: BarrierStage, rng: np.random.Generator) -> bool:
    """Along a roll-out there is no gap, and a jump of one state is its size."""
    it, problem = kernel.iterate, stage.problem
    n, nx = it.steps.size - 1, problem.nx
    it.z[:] = stage.z_scale * rng.uniform(1.0, 2.0, it.z.shape)
    it.p[:], it.steps[:] = rng.uniform(0.1, 1.0, it.p.shape), _SHORT_S
    for k in range(n):
        it.z[k + 1, :nx] = problem.dynamics(it.z[k, :nx], it.z[k, nx:], it.p[k], _SHORT_S).full().ravel()
    it.z[-1, nx:] = 0.0
    rolled_out = it.z.copy()
    gaps = []
    for jump in np.vstack([np.zeros(nx), np.diag(problem.x_scale)]):
        it.z[:] = rolled_out
        it.z[-1, :nx] += jump
        kernel.cold(1.0, _MARGIN)
        gaps.append(kernel.measure()[1])
    return _close(gaps, [0.0, *np.ones(nx)])


def _drawn(rng: np.random.Generator, lower: Array, upper: Array, scale: Array, count: int) -> Array:
    """Between the bounds; as far as 20 scales where there are none."""
    low, high = np.where(np.isfinite(lower), lower, -20.0 * scale), np.where(np.isfinite(upper), upper, 20.0 * scale)
    return np.asarray(rng.uniform(low, high, (count, scale.size)))


def _of(function: Any, *rows: Array) -> Array:
    """A CasADi function of each of these rows, as rows."""
    return np.asarray(function(*(each.T for each in rows)).full().T)


def _close(one: Any, other: Any) -> bool:
    return bool(np.allclose(one, other, rtol=_RELATIVE, atol=_RELATIVE))
