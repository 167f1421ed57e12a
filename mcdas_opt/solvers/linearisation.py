"""One CasADi call that linearises every stage of a problem at once."""

from __future__ import annotations

from typing import Any, NamedTuple

import casadi as ca
import numpy as np

from mcdas_opt.domain.rules import Array
from mcdas_opt.solvers.stage_problem import StageProblem


class Linearised(NamedTuple):
    """Per stage (first axis): next state F, [A B] = dF/d(x, u), Gauss-Newton Hessian and gradient of the cost, rows g, dg/d(x, u)."""

    f: Array
    ab: Array
    hessian: Array
    gradient: Array
    g: Array
    jg: Array


class Linearisation:
    """Stage functions with their derivatives, mapped over the N + 1 nodes of a horizon."""

    def __init__(self, problem: StageProblem, nodes: int) -> None:
        self.problem, self.nodes = problem, nodes
        nx, nu = problem.nx, problem.nu
        x, u = ca.SX.sym("x", nx), ca.SX.sym("u", nu)
        p, h, last = ca.SX.sym("p", len(problem.parameters)), ca.SX.sym("h"), ca.SX.sym("last")
        z = ca.vertcat(x, u)
        f = problem.dynamics(x, u, p, h)
        ab = ca.jacobian(f, z)
        running, terminal = problem.residual(x, u, p), problem.terminal_residual(x, p)

        def squares(r: Any) -> tuple[Any, Any]:
            j = ca.jacobian(r, z)
            return ca.mtimes(j.T, j), ca.mtimes(j.T, r)

        (hr, gr), (ht, gt) = squares(running), squares(terminal)
        hessian = ca.if_else(last > 0.5, ca.densify(ht), ca.densify(hr))
        gradient = ca.if_else(last > 0.5, ca.densify(gt), ca.densify(gr))
        g = problem.inequality(x, u, p)
        jg = ca.jacobian(g, z)
        outputs = [ca.densify(value) for value in (f, ab, hessian, gradient, g, jg)]
        stage = ca.Function("stage", [x, u, p, h, last], outputs)
        self._map = stage.map(nodes + 1)
        self._last = np.zeros((1, nodes + 1))
        self._last[0, -1] = 1.0
        cost_r = ca.Function("cost_r", [x, u, p], [0.5 * ca.sumsqr(running)]).map(nodes)
        cost_t = ca.Function("cost_t", [x, p], [0.5 * ca.sumsqr(terminal)])
        self._cost_r, self._cost_t = cost_r, cost_t
        self._rows = ca.Function("rows", [x, u, p], [g]).map(nodes + 1)

    def at(self, x: Array, u: Array, p: Array, steps: Array) -> Linearised:
        """At states (N + 1, nx), inputs (N, nu), parameters (N + 1, np), step lengths (N,)."""
        n, nx, nz = self.nodes + 1, self.problem.nx, self.problem.nx + self.problem.nu
        u_all = np.vstack([u, np.zeros((1, self.problem.nu))])
        h_all = np.append(steps, steps[-1])
        out = self._map(x.T, u_all.T, p.T, h_all[None, :], self._last)
        f, ab, hessian, gradient, g, jg = (np.asarray(o) for o in out)

        def blocks(flat: Array, rows: int, columns: int) -> Array:
            # CasADi lays the stages' matrices side by side
            return flat.reshape(rows, n, columns).transpose(1, 0, 2)

        ng = self.problem.ng
        return Linearised(
            f=f.T,
            ab=blocks(ab, nx, nz),
            hessian=blocks(hessian, nz, nz),
            gradient=gradient.T,
            g=g.T,
            jg=blocks(jg, ng, nz),
        )

    def slacks(self, x: Array, u: Array, p: Array) -> Array:
        """(N + 1, ns): the least slacks that satisfy every row; zero at node 0, where no row holds."""
        u_all = np.vstack([u, np.zeros((1, self.problem.nu))])
        g = np.asarray(self._rows(x.T, u_all.T, p.T)).T
        s = np.zeros((self.nodes + 1, self.problem.ns))
        for row, slack in enumerate(self.problem.slack_of):
            s[:, slack] = np.maximum(s[:, slack], g[:, row])
        s[0] = 0.0
        return s

    def objective(self, x: Array, u: Array, s: Array, p: Array) -> float:
        running = float(np.sum(np.asarray(self._cost_r(x[:-1].T, u.T, p[:-1].T))))
        terminal = float(self._cost_t(x[-1], p[-1]))
        return running + terminal + float(np.sum(s @ self.problem.slack_linear + 0.5 * s**2 @ self.problem.slack_quadratic))
