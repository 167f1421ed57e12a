"""The interior point's stage functions, as CasADi functions of plain vectors: what both kernels run, interpreted or as C."""

from __future__ import annotations

from typing import Any, NamedTuple

import casadi as ca

from mcdas_opt.solvers.barrier_stage import BarrierStage
from mcdas_opt.solvers.riccati import Factor, backward_gradient, forward, symmetric
from mcdas_opt.solvers.stage_problem import StageProblem


class StageFunctions(NamedTuple):
    """One CasADi function each; vectors only. `flags` = (node, moving), see `BarrierStage`."""

    evaluate: Any  # z s t l p h flags following -> data, t (never under what the rows leave), measures (|r|, |b| / scale)
    gradient: Any  # data s t target flags -> condensed gradient, slack
    terminal: Any  # data gradient -> value (P, p)
    backward: Any  # value data gradient -> value, feedback (K, kf), memory
    again: Any  # p data memory gradient -> p, kf
    forward: Any  # dx data feedback -> dx of the node after, dz
    steps: Any  # data slack t l target flags dz -> ds, dt, dl, measures (-dt / t, -dl / l, |dz| / scale, sum)
    cold: Any  # z p h flags (mu, margin) -> s t l
    warm: Any  # z s t l p h flags (mu, least) -> s t l
    measure: Any  # z p h flags following -> cost, |gap| / scale, least slacks


def stage_functions(problem: StageProblem) -> tuple[BarrierStage, StageFunctions]:
    stage = BarrierStage(problem)
    nx, nu, nz, ns, nc = stage.nx, stage.nu, stage.nz, stage.ns, stage.nc
    z, s, t, lam = (ca.SX.sym(name, size) for name, size in (("z", nz), ("s", ns), ("t", nc), ("lam", nc)))
    p, h, flags, following = ca.SX.sym("p", stage.np), ca.SX.sym("h"), ca.SX.sym("flags", 2), ca.SX.sym("following", nx)
    target, dz = ca.SX.sym("target", nc), ca.SX.sym("dz", nz)
    node, moving = flags[0], flags[1]
    active = stage.active(node, moving)
    x_scale = ca.DM(problem.x_scale)

    def function(name: str, inputs: list[Any], outputs: list[Any]) -> Any:
        return ca.Function(name, inputs, ca.cse([ca.densify(o) for o in outputs]))

    # evaluate: everything of a stage that does not depend on the target
    lin = stage.linear(z, p, h, moving)
    c = stage.inequalities(z, s, lin.rows)
    t_now = ca.if_else(active > 0.5, ca.fmax(t, -c), 1.0)
    r = active * (c + t_now)
    reduced = stage.condensed(lin, t_now, lam, node)
    gap = lin.f - following
    parts = [lin.ab, gap, reduced.hessian, lin.gradient, lin.slope, reduced.coupling, reduced.inverse, reduced.sigma, r]
    reach = ca.vertcat(_largest(ca.fabs(r)), moving * _largest(ca.fabs(gap) / x_scale))
    evaluate = function("evaluate", [z, s, t, lam, p, h, flags, following], [ca.vertcat(*[_entries(v) for v in parts]), t_now, reach])
    data = ca.SX.sym("data", sum(v.nnz() for v in parts))
    pieces = ca.vertsplit(data, [0, *_running_sum(v.nnz() for v in parts)])
    ab, gap, hessian, cost, slope, coupling, inverse, sigma, r = (
        ca.SX(v.sparsity(), piece) for v, piece in zip(parts, pieces, strict=True)
    )
    hessian = symmetric(hessian)

    slack = ca.SX.sym("slack", ns)
    gradient_out = stage.gradient(cost, slope, coupling, inverse, sigma, s, t, r, target, node)
    steps = stage.steps(slope, coupling, inverse, sigma, slack, t, lam, r, target, dz, node, active)
    ratios = ca.vertcat(_largest(-steps[1] / t), _largest(-steps[2] / (lam + 1e-300)), _largest(ca.fabs(dz) / stage.z_scale), ca.sum1(dz))

    # the sweeps
    triangle, inputs = ca.Sparsity.lower(nx), ca.Sparsity.lower(nu)
    value, gradient = ca.SX.sym("value", triangle.nnz() + nx), ca.SX.sym("gradient", nz)
    value_p = value[triangle.nnz() :]
    factor = Factor(symmetric(ca.SX(triangle, value[: triangle.nnz()])), ab, gap, hessian)
    p_new, kf = backward_gradient(nx, ab, factor.s, factor.r, factor.pb, value_p, gradient)
    memory_parts = [factor.s, ca.project(ca.densify(factor.r), inputs), factor.pb]
    memory = ca.SX.sym("memory", nu * nx + inputs.nnz() + nx)
    m_s, m_r, m_pb = memory[: nu * nx], memory[nu * nx : -nx], memory[-nx:]
    p_old = ca.SX.sym("p_old", nx)
    again = backward_gradient(nx, ab, ca.reshape(m_s, nu, nx), symmetric(ca.SX(inputs, m_r)), m_pb, p_old, gradient)
    dx, feedback = ca.SX.sym("dx", nx), ca.SX.sym("feedback", nu * (nx + 1))
    dx_new, du = forward(ab, gap, ca.reshape(feedback[: nu * nx], nu, nx), feedback[nu * nx :], dx)

    # starts, and how good an answer is
    mu, least = ca.SX.sym("mu"), ca.SX.sym("least")
    s_cold = node * (stage.least_slacks(lin.rows) + least)
    t_cold = ca.if_else(active > 0.5, ca.fmax(-stage.inequalities(z, s_cold, lin.rows), least), 1.0)
    t_warm = ca.if_else(active > 0.5, ca.fmax(ca.fmax(t, -c), least), 1.0)
    functions = StageFunctions(
        evaluate=evaluate,
        gradient=function("gradient", [data, s, t, target, flags], list(gradient_out)),
        terminal=function("terminal", [data, gradient], [ca.vertcat(_triangle(hessian[:nx, :nx], triangle), gradient[:nx])]),
        backward=function(
            "backward",
            [value, data, gradient],
            [
                ca.vertcat(_triangle(factor.value, triangle), p_new),
                ca.vertcat(ca.vec(ca.densify(factor.k)), kf),
                ca.vertcat(*[ca.vec(ca.densify(memory_parts[0])), _entries(memory_parts[1]), memory_parts[2]]),
            ],
        ),
        again=function("again", [p_old, data, memory, gradient], list(again)),
        forward=function("forward", [dx, data, feedback], [dx_new, ca.vertcat(dx, du)]),
        steps=function("steps", [data, slack, t, lam, target, flags, dz], [*steps, ratios]),
        cold=function("cold", [z, p, h, flags, mu, least], [s_cold, t_cold, active * mu / t_cold]),
        warm=function("warm", [z, s, t, lam, p, h, flags, mu, least], [node * s, t_warm, active * ca.fmax(lam, mu / t_warm)]),
        measure=function(
            "measure",
            [z, p, h, flags, following],
            [
                stage.cost(z, p, moving),
                moving * _largest(ca.fabs(problem.dynamics(z[:nx], z[nx:], p, h) - following) / x_scale),
                node * stage.least_slacks(ca.densify(problem.inequality(z[:nx], z[nx:], p))),
            ],
        ),
    )
    return stage, functions


def _running_sum(sizes: Any) -> list[int]:
    total, ends = 0, []
    for size in sizes:
        total += size
        ends.append(total)
    return ends


def _entries(matrix: Any) -> Any:
    """The structural nonzeros as a column."""
    return ca.vertcat(ca.SX(0, 1), *matrix.nonzeros())


def _largest(values: Any) -> Any:
    return ca.mmax(ca.vertcat(0.0, values))


def _triangle(matrix: Any, triangle: Any) -> Any:
    return _entries(ca.project(ca.densify(matrix), triangle))
