"""The interior point's stage functions, as CasADi functions of plain vectors: what both kernels run, interpreted or as C."""

from __future__ import annotations

from typing import Any, NamedTuple

import casadi as ca

from mcdas_opt.solvers.barrier_stage import BarrierStage, Others
from mcdas_opt.solvers.riccati import Factor, backward_gradient, forward, symmetric
from mcdas_opt.solvers.stage_problem import ProblemFamily, StageProblem


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


class RowFunctions(NamedTuple):
    """Of the row that a family's members have any number of times; each adds to sums, or raises what is largest."""

    evaluate: Any  # z s t l own flags sums numbers -> sums, data, t
    gradient: Any  # data t target sums -> sums
    steps: Any  # data t l target dz ds flags measures -> measures, dt, dl
    least: Any  # z own largest numbers -> largest
    cold: Any  # z own s flags (mu, margin) numbers -> t l
    warm: Any  # z s t l own flags (mu, least) numbers -> t l


def stage_functions(problem: StageProblem) -> tuple[BarrierStage, StageFunctions]:
    """Of one problem."""
    stage, functions, _ = _functions(problem, None)
    return stage, functions


def family_functions(family: ProblemFamily) -> tuple[BarrierStage, StageFunctions, RowFunctions]:
    """Of all members: the member's numbers are an input of those that need them, behind the sums over the repeated rows."""
    stage, functions, row = _functions(family.problem, family)
    assert row is not None
    return stage, functions, row


def _functions(problem: StageProblem, family: ProblemFamily | None) -> tuple[BarrierStage, StageFunctions, RowFunctions | None]:
    sizes = family.sizes if family else 0
    numbers = ca.SX.sym("numbers", sizes + len(BarrierStage(problem).bounds))
    stage = BarrierStage(problem, numbers[sizes:] if family else None)
    stage.np -= sizes
    nx, nu, nz, ns, nc = stage.nx, stage.nu, stage.nz, stage.ns, stage.nc
    z, s, t, lam = (ca.SX.sym(name, size) for name, size in (("z", nz), ("s", ns), ("t", nc), ("lam", nc)))
    own, h, flags, following = ca.SX.sym("p", stage.np), ca.SX.sym("h"), ca.SX.sym("flags", 2), ca.SX.sym("following", nx)
    p = ca.vertcat(own, numbers[:sizes])
    repeated = RepeatedRow(family, stage) if family else None
    known = [numbers] if family else []
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
    reduced = stage.condensed(lin, t_now, lam, node, repeated.others if repeated else None)
    gap = lin.f - following
    parts = [lin.ab, gap, reduced.hessian, lin.gradient, lin.slope, reduced.coupling, reduced.inverse, reduced.sigma, r]
    reach = ca.vertcat(_largest(ca.fabs(r)), moving * _largest(ca.fabs(gap) / x_scale))
    if repeated:
        reach[0] = ca.fmax(reach[0], repeated.reach)
    sums = [repeated.sums] if repeated else []
    evaluate = function(
        "evaluate", [z, s, t, lam, own, h, flags, following, *sums, *known], [ca.vertcat(*[_entries(v) for v in parts]), t_now, reach]
    )
    data = ca.SX.sym("data", sum(v.nnz() for v in parts))
    pieces = ca.vertsplit(data, [0, *_running_sum(v.nnz() for v in parts)])
    ab, gap, hessian, cost, slope, coupling, inverse, sigma, r = (
        ca.SX(v.sparsity(), piece) for v, piece in zip(parts, pieces, strict=True)
    )
    hessian = symmetric(hessian)

    slack = ca.SX.sym("slack", ns)
    pulls = repeated.pulls if repeated else None
    gradient_out = stage.gradient(cost, slope, coupling, inverse, sigma, s, t, r, target, node, pulls)
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
    def needed(rows: Any) -> Any:
        slacks = stage.least_slacks(rows)
        if family and repeated:
            slacks[family.row_slack] = ca.fmax(slacks[family.row_slack], repeated.worst)
        return slacks

    mu, least = ca.SX.sym("mu"), ca.SX.sym("least")
    worst = [repeated.worst] if repeated else []
    s_cold = node * (needed(lin.rows) + least)
    t_cold = ca.if_else(active > 0.5, ca.fmax(-stage.inequalities(z, s_cold, lin.rows), least), 1.0)
    t_warm = ca.if_else(active > 0.5, ca.fmax(ca.fmax(t, -c), least), 1.0)
    functions = StageFunctions(
        evaluate=evaluate,
        gradient=function("gradient", [data, s, t, target, flags, *([repeated.row_sums] if repeated else [])], list(gradient_out)),
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
        cold=function("cold", [z, own, h, flags, mu, least, *worst, *known], [s_cold, t_cold, active * mu / t_cold]),
        warm=function("warm", [z, s, t, lam, own, h, flags, mu, least, *known], [node * s, t_warm, active * ca.fmax(lam, mu / t_warm)]),
        measure=function(
            "measure",
            [z, own, h, flags, following, *worst, *known],
            [
                stage.cost(z, p, moving),
                moving * _largest(ca.fabs(problem.dynamics(z[:nx], z[nx:], p, h) - following) / x_scale),
                node * needed(ca.densify(problem.inequality(z[:nx], z[nx:], p))),
            ],
        ),
    )
    return stage, functions, repeated.functions(numbers) if repeated else None


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


class RepeatedRow:
    """The equations of one repeated row, as `BarrierStage` has them of its own, and the sums that a stage takes over all of them."""

    def __init__(self, family: ProblemFamily, stage: BarrierStage) -> None:
        self._family, self._stage = family, stage
        nx, nz, ns, slack = stage.nx, stage.nz, stage.ns, family.row_slack
        self._z = ca.SX.sym("z", nz)
        self._own, self._sizes = ca.SX.sym("own", family.row_parameters), ca.SX.sym("sizes", family.sizes)
        self._g = family.row(self._z[:nx], self._sizes, self._own)
        self._touched = [i for i in range(nz) if ca.jacobian(self._g, self._z[i]).nnz()]
        self._pairs = [(i, j) for i in self._touched for j in self._touched if j <= i]
        count = len(self._touched)
        self.sums = ca.SX.sym("sums", len(self._pairs) + count + 2)
        products, slopes, (stiffness, self.reach) = (
            self.sums[: len(self._pairs)],
            self.sums[len(self._pairs) : -2],
            ca.vertsplit(self.sums[-2:]),
        )
        hessian, coupling, stiff = ca.SX(nz, nz), ca.SX(ns, nz), ca.SX.zeros(ns)
        for k, (i, j) in enumerate(self._pairs):
            hessian[i, j] = products[k]
        for k, i in enumerate(self._touched):
            coupling[slack, i] = slopes[k]
        stiff[slack] = stiffness
        self.others = Others(hessian=hessian, coupling=coupling, stiffness=stiff)
        self.row_sums = ca.SX.sym("row_sums", 1 + count)
        y, pull = ca.SX.zeros(ns), ca.SX.zeros(nz)
        y[slack] = self.row_sums[0]
        for k, i in enumerate(self._touched):
            pull[i] = self.row_sums[1 + k]
        self.pulls = y, pull
        self.worst = ca.SX.sym("worst")

    def functions(self, numbers: Any) -> RowFunctions:
        stage, slack, count = self._stage, self._family.row_slack, len(self._touched)
        z, own, s, ds, dz = self._z, self._own, ca.SX.sym("s", stage.ns), ca.SX.sym("ds", stage.ns), ca.SX.sym("dz", stage.nz)
        t, lam, target, mu, least = (ca.SX.sym(name) for name in ("t", "lam", "target", "mu", "least"))
        flags, ratios, data = ca.SX.sym("flags", 2), ca.SX.sym("ratios", 2), ca.SX.sym("data", count + 2)
        node = flags[0]
        g, slopes, bends = (
            ca.substitute(e, self._sizes, numbers[: self._family.sizes])
            for e in (
                self._g,
                ca.vertcat(*[ca.jacobian(self._g, z[i]) for i in self._touched]),
                ca.vertcat(*[ca.fmax(ca.hessian(self._g, z[i])[0], 0.0) for i in self._touched]),
            )
        )

        def function(name: str, inputs: list[Any], outputs: list[Any]) -> Any:
            return ca.Function(f"row_{name}", inputs, ca.cse([ca.densify(o) for o in outputs]))

        c = g - s[slack]
        t_now = ca.if_else(node > 0.5, ca.fmax(t, -c), 1.0)
        r, sigma = node * (c + t_now), lam / t_now
        at = {i: k for k, i in enumerate(self._touched)}
        products = [sigma * slopes[at[i]] * slopes[at[j]] + (lam * bends[at[i]] if i == j else 0.0) for i, j in self._pairs]
        added = ca.vertcat(self.sums[:-1] + ca.vertcat(*products, sigma * slopes, sigma), ca.fmax(self.sums[-1], ca.fabs(r)))
        slope, d_sigma, d_r = data[:count], data[count], data[count + 1]
        y = target / t + d_sigma * d_r
        dc = ca.dot(slope, ca.vertcat(*[dz[i] for i in self._touched])) - ds[slack]
        dt = -node * (d_r + dc)
        dlam = target / t - lam - d_sigma * dt
        t_cold = ca.if_else(node > 0.5, ca.fmax(-c, least), 1.0)
        t_warm = ca.if_else(node > 0.5, ca.fmax(ca.fmax(t, -c), least), 1.0)
        return RowFunctions(
            evaluate=function("evaluate", [z, s, t, lam, own, flags, self.sums, numbers], [added, ca.vertcat(slopes, sigma, r), t_now]),
            gradient=function("gradient", [data, t, target, self.row_sums], [self.row_sums + ca.vertcat(y, slope * y)]),
            steps=function(
                "steps",
                [data, t, lam, target, dz, ds, flags, ratios],
                [ca.vertcat(ca.fmax(ratios[0], -dt / t), ca.fmax(ratios[1], -dlam / (lam + 1e-300))), dt, dlam],
            ),
            least=function("least", [z, own, self.worst, numbers], [ca.fmax(self.worst, g)]),
            cold=function("cold", [z, own, s, flags, mu, least, numbers], [t_cold, node * mu / t_cold]),
            warm=function("warm", [z, s, t, lam, own, flags, mu, least, numbers], [t_warm, node * ca.fmax(lam, mu / t_warm)]),
        )
