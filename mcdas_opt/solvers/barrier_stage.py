"""One stage of the barrier problem in symbols: every equation of the interior point that concerns a single stage, written once.

A stage holds z = (x, u), the slacks s of its soft rows and, for each inequality c(z, s) + t = 0, a t > 0 with its multiplier l > 0.
The slacks are eliminated stage by stage, so that the Newton step is that of a linear-quadratic problem in z alone.
Sources: Wright, Primal-Dual Interior-Point Methods, 1997, ch. 11; Rao, Wright, Rawlings, JOTA 99 (1998) 723 (stage-wise elimination).
"""

from __future__ import annotations

from typing import Any, NamedTuple

import casadi as ca
import numpy as np

from mcdas_opt.domain.rules import Array
from mcdas_opt.solvers.stage_problem import StageProblem


class Linear(NamedTuple):
    """A stage at its iterate, as CasADi expressions."""

    f: Any  # (nx,) next state
    ab: Any  # (nx, nz) its derivative
    hessian: Any  # (nz, nz) lower triangle of the Gauss-Newton Hessian of the cost
    gradient: Any  # (nz,) of the cost
    rows: Any  # (ng,) soft rows
    slope: Any  # (ng, nz) their derivative
    bend: Any  # (nz, ng) their second derivatives along each variable, where positive


class Condensed(NamedTuple):
    """The slacks eliminated."""

    hessian: Any  # (nz, nz) lower triangle
    sigma: Any  # (nc,) l / t
    coupling: Any  # (ns, nz) Y: sum of sigma_i slope_i over a slack's rows
    inverse: Any  # (ns,) 1 / D: of the slacks' own curvature


class Others(NamedTuple):
    """What rows that are not among the stage's own add up to."""

    hessian: Any  # (nz, nz) lower triangle
    coupling: Any  # (ns, nz)
    stiffness: Any  # (ns,)


class BarrierStage:
    """The equations of one stage of `problem`. Inequalities in order: rows, slacks, x lower, x upper, u lower, u upper (finite ones).

    Everywhere `node` is 0 at node 0 and 1 elsewhere (rows, slacks and x bounds hold at 1..N), `moving` 0 at node N and 1 elsewhere
    (u bounds hold at 0..N-1).
    """

    def __init__(self, problem: StageProblem, limits: Any = None) -> None:
        """`limits`: of the finite bounds in the order of `bounds`, in place of the problem's own."""
        self.problem = problem
        self.nx, self.nu, self.ns, self.ng = problem.nx, problem.nu, problem.ns, problem.ng
        self.nz, self.np = self.nx + self.nu, len(problem.parameters)
        lower, upper = np.concatenate([problem.x_lower, problem.u_lower]), np.concatenate([problem.x_upper, problem.u_upper])
        bounds = [(i, sign, limit[i]) for sign, limit in ((-1.0, lower), (1.0, upper)) for i in range(self.nz) if np.isfinite(limit[i])]
        own = [b for b in bounds if b[0] < self.nx] + [b for b in bounds if b[0] >= self.nx]
        self.bounds = own if limits is None else [(i, sign, limits[k]) for k, (i, sign, _) in enumerate(own)]
        self.inner = self.ng + self.ns + sum(1 for b in bounds if b[0] < self.nx)
        self.nc = self.ng + self.ns + len(bounds)
        self.soft = list(problem.slack_of)
        self.member = ca.DM(ca.Sparsity.triplet(self.ns, self.ng, self.soft, list(range(self.ng))), np.ones(self.ng))
        self.z_scale = np.concatenate([problem.x_scale, problem.u_scale])

    def active(self, node: Any, moving: Any) -> Any:
        """(nc,) 1 where an inequality holds, else 0: there t = 1 and l = 0."""
        return ca.vertcat(ca.repmat(node, self.inner, 1), ca.repmat(moving, self.nc - self.inner, 1))

    def linear(self, z: Any, p: Any, h: Any, moving: Any) -> Linear:
        """The cost's Hessian is Gauss-Newton's; of the rows' curvature the convex part along each variable is kept.

        Without it a friction circle or a turned body, once active, makes full steps overshoot for ever; the concave part (the outside
        of a body) is left out, so that the Hessian stays positive.
        """
        problem = self.problem
        x, u = z[: self.nx], z[self.nx :]
        f = problem.dynamics(x, u, p, h)
        residual = ca.vertcat(moving * problem.residual(x, u, p), (1.0 - moving) * problem.terminal_residual(x, p))
        j = ca.jacobian(residual, z)
        rows = ca.densify(problem.inequality(x, u, p))
        second = [ca.diag(ca.hessian(rows[i], z)[0]) for i in range(self.ng)]
        return Linear(
            f=f,
            ab=ca.jacobian(f, z),
            hessian=ca.tril(ca.mtimes(j.T, j)),
            gradient=ca.densify(ca.mtimes(j.T, residual)),
            rows=rows,
            slope=ca.jacobian(rows, z),
            bend=ca.fmax(ca.horzcat(ca.SX(self.nz, 0), *second), 0.0),
        )

    def inequalities(self, z: Any, s: Any, rows: Any) -> Any:
        """c (nc,) <= 0."""
        return ca.vertcat(rows - s[self.soft], -s, *[sign * (z[i] - limit) for i, sign, limit in self.bounds])

    def condensed(self, stage: Linear, t: Any, multiplier: Any, node: Any, others: Others | None = None) -> Condensed:
        ng, ns = self.ng, self.ns
        sigma = multiplier / t
        weighted = ca.mtimes(ca.diag(sigma[:ng]), stage.slope)
        coupling = ca.mtimes(self.member, weighted)
        stiffness = ca.DM(self.problem.slack_quadratic) + ca.mtimes(self.member, sigma[:ng]) + sigma[ng : ng + ns]
        if others is not None:
            coupling, stiffness = coupling + others.coupling, stiffness + others.stiffness
        inverse = 1.0 / (stiffness + (1.0 - node))  # at node 0 no slack moves
        diagonal = ca.mtimes(stage.bend, multiplier[:ng])
        for row, (i, _, _) in enumerate(self.bounds):
            diagonal[i] += sigma[ng + ns + row]
        hessian = stage.hessian + ca.tril(ca.mtimes(stage.slope.T, weighted)) + ca.diag(diagonal)
        if others is not None:
            hessian += others.hessian
        hessian -= ca.tril(ca.mtimes(coupling.T, ca.mtimes(ca.diag(inverse), coupling)))
        return Condensed(hessian=hessian, sigma=sigma, coupling=coupling, inverse=inverse)

    def gradient(
        self,
        cost: Any,
        slope: Any,
        coupling: Any,
        inverse: Any,
        sigma: Any,
        s: Any,
        t: Any,
        r: Any,
        target: Any,
        node: Any,
        others: tuple[Any, Any] | None = None,
    ) -> tuple[Any, Any]:
        """The condensed gradient (nz,) and the slacks' constant step (ns,), for residuals r = c + t and targets of t l. `others`: the sums
        of y (ns,) and of slope'y (nz,) over rows that are not among the stage's own."""
        ng, ns = self.ng, self.ns
        y = target / t + sigma * r
        penalty = ca.DM(self.problem.slack_linear) + ca.DM(self.problem.slack_quadratic) * s
        soft, pull = ca.mtimes(self.member, y[:ng]), ca.mtimes(slope.T, y[:ng])
        if others is not None:
            soft, pull = soft + others[0], pull + others[1]
        slack = node * (penalty - soft - y[ng : ng + ns]) * inverse
        gradient = ca.densify(cost + pull + ca.mtimes(coupling.T, slack))
        for row, (i, sign, _) in enumerate(self.bounds):
            gradient[i] += sign * y[ng + ns + row]
        return gradient, ca.densify(slack)

    def steps(
        self,
        slope: Any,
        coupling: Any,
        inverse: Any,
        sigma: Any,
        slack: Any,
        t: Any,
        multiplier: Any,
        r: Any,
        target: Any,
        dz: Any,
        node: Any,
        active: Any,
    ) -> tuple[Any, Any, Any]:
        """(ds, dt, dl) that belong to the step dz."""
        ds = node * (ca.mtimes(coupling, dz) * inverse - slack)
        dc = ca.vertcat(ca.mtimes(slope, dz) - ds[self.soft], -ds, *[sign * dz[i] for i, sign, _ in self.bounds])
        dt = -active * (r + dc)
        return ds, dt, target / t - multiplier - sigma * dt

    def least_slacks(self, rows: Any) -> Any:
        """(ns,) the least slacks >= 0 that the rows need."""
        least = [ca.SX(0.0)] * self.ns
        for row, slack in enumerate(self.soft):
            least[slack] = ca.fmax(least[slack], rows[row])
        return ca.vertcat(*least)

    def cost(self, z: Any, p: Any, moving: Any) -> Any:
        """Of one stage, without the slacks' penalty."""
        x, u = z[: self.nx], z[self.nx :]
        terminal = ca.sumsqr(self.problem.terminal_residual(x, p))
        return 0.5 * (moving * ca.sumsqr(self.problem.residual(x, u, p)) + (1.0 - moving) * terminal)

    def over(self, nodes: int) -> tuple[Array, Array, int]:
        """Flags (2, N + 1), mask of active inequalities (nc, N + 1), and how many are active (1 if none, to divide by)."""
        flags = np.ones((2, nodes + 1))
        flags[0, 0] = flags[1, -1] = 0.0
        active = np.ones((self.nc, nodes + 1))
        active[: self.inner, 0] = 0.0
        active[self.inner :, -1] = 0.0
        return flags, active, max(int(active.sum()), 1)
