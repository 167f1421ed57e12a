"""The interior point's iteration as CasADi functions: needs no compiler, and is the reference for the compiled kernel."""

from __future__ import annotations

import math
from typing import Any

import casadi as ca
import numpy as np

from mcdas_opt.domain.rules import Array
from mcdas_opt.solvers.barrier_stage import BarrierStage
from mcdas_opt.solvers.iterate import Iterate
from mcdas_opt.solvers.newton_loop import LoopEnd, LoopRule, Progress, looped
from mcdas_opt.solvers.stage_functions import StageFunctions

CORRECTION = 10.0  # Mehrotra's second-order term is cut at so many times the target


class InterpretedKernel:
    """Works on an `Iterate`, in place, by the functions of `over_horizon`, which kernels may share.

    CasADi's matrices are the iterate's arrays transposed, so nothing is copied on the way in.
    """

    kind = "interpreted"

    def __init__(self, stage: BarrierStage, whole: dict[str, Any], nodes: int) -> None:
        self.iterate = Iterate(stage, nodes)
        it = self.iterate
        point = [it.z, it.s, it.t, it.multiplier]
        self._mu, self._lengths, self._least = np.zeros(1), np.zeros(2), np.zeros(1)
        self._plain = _Call(whole["plain"], [*point, it.p, it.steps, self._mu, self._lengths])
        self._corrected = _Call(whole["corrected"], [*point, it.p, it.steps, self._mu, self._lengths])
        self._cold = _Call(whole["cold"], [it.z, it.p, it.steps, self._mu, self._least])
        self._warm = _Call(whole["warm"], [*point, it.p, it.steps, self._mu, self._least])
        self._measure = _Call(whole["measure"], [it.z, it.p, it.steps])

    def cold(self, mu: float, least: float) -> bool:
        """Slacks, t and multipliers for the states and inputs there are; whether all that is read is finite."""
        it = self.iterate
        self._start(self._cold, mu, least)
        return _finite(it.z, it.p, it.steps)

    def warm(self, mu: float, least: float) -> bool:
        """Brings those there are off the boundary; whether all that is read is finite."""
        it = self.iterate
        finite = _finite(it.z, it.p, it.steps, it.s, it.t, it.multiplier)
        self._start(self._warm, mu, least)
        return finite

    def _start(self, call: _Call, mu: float, least: float) -> None:
        self._mu[0], self._least[0] = mu, least
        it = self.iterate
        for kept, new in zip((it.s, it.t, it.multiplier), call(), strict=True):
            kept.ravel()[:] = new

    def newton(self, *, corrected: bool, mu: float, boundary: float, longest: float) -> Progress:
        """One step of the iterate towards complementarity `mu`; `corrected`: Mehrotra's predictor and corrector, not under `mu`."""
        self._mu[0], self._lengths[:] = mu, (boundary, longest)
        z, s, t, multiplier, numbers = (self._corrected if corrected else self._plain)()
        it = self.iterate
        it.z.ravel()[:], it.s.ravel()[:], it.t.ravel()[:], it.multiplier.ravel()[:] = z, s, t, multiplier
        return Progress(*numbers.tolist())

    def loop(self, *, warm: bool, iterations: int, rule: LoopRule) -> LoopEnd:
        """Newton steps until the answer has settled."""
        return looped(self, warm=warm, iterations=iterations, rule=rule)

    def measure(self) -> tuple[float, float]:
        """Objective with the least slacks (which replace those of the iterate in `iterate.least`), and the largest scaled gap."""
        cost, gap, least = self._measure()
        self.iterate.least.ravel()[:] = least
        return float(cost[0]), float(gap[0])


def _finite(*arrays: Array) -> bool:
    return all(math.isfinite(float(array.sum())) for array in arrays)


class _Call:
    """A CasADi function called on numpy memory; it keeps the arrays alive, which CasADi's buffer does not."""

    def __init__(self, function: Any, arguments: list[Array]) -> None:
        self._buffer, self._trigger = function.buffer()
        self._arguments = arguments
        self._results = [np.zeros(function.nnz_out(i)) for i in range(function.n_out())]
        for i, argument in enumerate(arguments):
            assert argument.size == function.nnz_in(i)
            assert argument.flags.c_contiguous
            self._buffer.set_arg(i, argument.reshape(-1).data)
        for i, result in enumerate(self._results):
            self._buffer.set_res(i, result.data)

    def __call__(self) -> list[Array]:
        self._trigger()
        return self._results


def over_horizon(stage: BarrierStage, f: StageFunctions, nodes: int) -> dict[str, Any]:
    """The stage functions side by side, and folded, over the horizon."""
    nx, nu, n = stage.nx, stage.nu, nodes + 1
    z, s, t, lam = (ca.MX.sym(name, size, n) for name, size in (("z", stage.nz), ("s", stage.ns), ("t", stage.nc), ("lam", stage.nc)))
    p, h, mu, lengths, least = (
        ca.MX.sym("p", stage.np, n),
        ca.MX.sym("h", 1, n),
        ca.MX.sym("mu"),
        ca.MX.sym("lengths", 2),
        ca.MX.sym("least"),
    )
    flags_of, active_of, count = stage.over(nodes)
    flags, active = ca.MX(ca.DM(flags_of)), ca.MX(ca.DM(active_of))
    following = ca.horzcat(z[:nx, 1:], z[:nx, nodes])

    def reverse(a: Any) -> Any:
        return a[:, :nodes][:, ::-1]

    data, t_now, reach = side_by_side(f.evaluate, n)(z, s, t, lam, p, h, flags, following)
    residual, average = ca.mmax(reach), ca.dot(t_now * active, lam) / count
    gradient_of, steps_of = side_by_side(f.gradient, n), side_by_side(f.steps, n)
    backward, again, forward = f.backward.mapaccum(nodes), f.again.mapaccum(nodes), f.forward.mapaccum(nodes)

    def step(target: Any, factor: Any = None) -> tuple[Any, Any]:
        """Newton's step for a target of t l, and the factorisation, to be used again."""
        gradient, slack = gradient_of(data, s, t_now, target, flags)
        if factor is None:
            value = f.terminal(data[:, nodes], gradient[:, nodes])
            _, feedback, memory = backward(value, reverse(data), reverse(gradient))
        else:
            feedback, memory = factor
            _, constant = again(gradient[:nx, nodes], reverse(data), memory, reverse(gradient))
            feedback = ca.vertcat(feedback[: nu * nx, :], constant)
        dx, dz = forward(ca.MX.zeros(nx), data[:, :nodes], feedback[:, ::-1])
        dz = ca.horzcat(dz, ca.vertcat(dx[:, nodes - 1], ca.MX.zeros(nu)))
        ds, dt, dlam, ratios = steps_of(data, slack, t_now, lam, target, flags, dz)
        primal, dual = (1.0 / ca.fmax(ca.mmax(ratios[i, :]), 1e-9) for i in (0, 1))
        return (dz, ds, dt, dlam, primal, dual, ca.mmax(ratios[2, :]), ca.sum2(ratios[3, :])), (feedback, memory)

    def taken(newton: Any) -> list[Any]:
        dz, ds, dt, dlam, primal, dual, size, total = newton
        primal, dual = (ca.fmin(lengths[1], lengths[0] * reaching) for reaching in (primal, dual))
        t_new, lam_new = t_now + primal * dt, lam + dual * dlam
        numbers = ca.vertcat(size, (1.0 - primal) * residual, ca.dot(t_new * active, lam_new) / count, primal, dual, total)
        return [z + primal * dz, s + primal * ds, t_new, lam_new, numbers]

    arguments = [z, s, t, lam, p, h, mu, lengths]
    affine, factor = step(ca.MX.zeros(stage.nc, n))
    primal, dual = ca.fmin(1.0, affine[4]), ca.fmin(1.0, affine[5])
    reached = ca.dot((t_now + primal * affine[2]) * active, lam + dual * affine[3]) / count
    centre = ca.fmax(mu, (reached / average) ** 3 * average)
    second = ca.fmax(-CORRECTION * centre, ca.fmin(CORRECTION * centre, affine[2] * affine[3]))
    cost, gap, slacks = side_by_side(f.measure, n)(z, p, h, flags, following)
    problem = stage.problem
    paid = ca.mtimes(ca.DM(problem.slack_linear).T, slacks) + 0.5 * ca.mtimes(ca.DM(problem.slack_quadratic).T, slacks**2)
    return {
        "plain": ca.Function("plain", arguments, taken(step(mu * active)[0])),
        "corrected": ca.Function("corrected", arguments, taken(step(active * (centre - second), factor)[0])),
        "cold": ca.Function("cold", [z, p, h, mu, least], side_by_side(f.cold, n)(z, p, h, flags, mu, least)),
        "warm": ca.Function("warm", [z, s, t, lam, p, h, mu, least], side_by_side(f.warm, n)(z, s, t, lam, p, h, flags, mu, least)),
        "measure": ca.Function("measure", [z, p, h], [ca.sum2(cost + paid), ca.mmax(gap), slacks]),
    }


def side_by_side(function: Any, stages: int) -> Any:
    """An SX function of columns, as `function.map(stages)`, and equal to it to the bit, in a third of the time.

    Its instructions are read once instead of once a stage, each on a column with one number a stage. They become part of the function
    that calls it, which saves copies.
    """
    arguments = [ca.MX.sym(f"a{i}", function.nnz_in(i), stages) for i in range(function.n_in())]
    columns = [ca.horzsplit(argument.T) for argument in arguments]
    results = [[ca.MX()] * function.nnz_out(i) for i in range(function.n_out())]
    work: dict[int, Any] = {}
    for k in range(function.n_instructions()):
        op, inputs, outputs = function.instruction_id(k), function.instruction_input(k), function.instruction_output(k)
        if op == ca.OP_OUTPUT:
            value = work[inputs[0]]
            results[outputs[0]][outputs[1]] = ca.repmat(value, stages, 1) if value.is_scalar() else value
        elif op == ca.OP_INPUT:
            work[outputs[0]] = columns[inputs[0]][inputs[1]]
        elif op == ca.OP_CONST:
            work[outputs[0]] = ca.MX(function.instruction_constant(k))
        else:
            apply = ca.MX.unary if len(inputs) == 1 else ca.MX.binary
            work[outputs[0]] = apply(op, *(work[i] for i in inputs))
    stacked = [ca.horzcat(ca.MX(stages, 0), *result).T for result in results]
    return ca.Function(function.name(), arguments, stacked, {"always_inline": True})
