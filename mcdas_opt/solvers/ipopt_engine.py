"""IPOPT on the same stage functions, by multiple shooting: the reference solution, and a second opinion for cold starts.

Source: Waechter, Biegler, Math. Prog. 106 (2006) 25. IPOPT returns a point on "infeasible" too: its status is read first.
"""

from __future__ import annotations

from typing import Any

import casadi as ca
import numpy as np

from mcdas_opt.domain.rules import Array
from mcdas_opt.solvers.held_interrupts import held_interrupts
from mcdas_opt.solvers.linearisation import Linearisation
from mcdas_opt.solvers.outcome import IPOPT_ENDINGS, Ending, Outcome
from mcdas_opt.solvers.stage_problem import StageGuess, StageProblem


class IpoptEngine:
    """Exact Hessian, tolerance `tolerance` (IPOPT's), linear solver mumps."""

    def __init__(self, problem: StageProblem, nodes: int, tolerance: float = 1e-8) -> None:
        self.problem, self.nodes = problem, nodes
        self.linearisation = Linearisation(problem, nodes)
        nx, nu, ns, np_ = problem.nx, problem.nu, problem.ns, len(problem.parameters)
        x, u = ca.SX.sym("x", nx, nodes + 1), ca.SX.sym("u", nu, nodes)
        s = ca.SX.sym("s", ns, nodes)
        p, h, x0 = ca.SX.sym("p", np_, nodes + 1), ca.SX.sym("h", nodes), ca.SX.sym("x0", nx)
        cost: Any = 0.5 * ca.sumsqr(problem.terminal_residual(x[:, nodes], p[:, nodes]))
        equalities: list[Any] = [(x[:, 0] - x0) / problem.x_scale]
        inequalities: list[Any] = []
        slack_of = list(problem.slack_of)
        for k in range(nodes):
            cost += 0.5 * ca.sumsqr(problem.residual(x[:, k], u[:, k], p[:, k]))
            equalities.append((x[:, k + 1] - problem.dynamics(x[:, k], u[:, k], p[:, k], h[k])) / problem.x_scale)
            u_next = u[:, k + 1] if k + 1 < nodes else ca.SX.zeros(nu)
            inequalities.append(problem.inequality(x[:, k + 1], u_next, p[:, k + 1]) - s[slack_of, k])
            cost += ca.dot(problem.slack_linear, s[:, k]) + 0.5 * ca.dot(problem.slack_quadratic, s[:, k] ** 2)
        g = ca.vertcat(*equalities, *inequalities)
        w = ca.veccat(x, u, s)
        ipopt = {"print_level": 0, "sb": "yes", "tol": tolerance, "mu_strategy": "adaptive"}
        self._equal = (nodes + 1) * nx
        self._size_g = int(g.numel())
        self._options: dict[str, Any] = ipopt
        self._nlp = {"x": w, "f": cost, "g": g, "p": ca.veccat(p, h, x0)}
        self._solvers: dict[int, Any] = {}
        free = np.full(nx, np.inf)
        self._lower = np.concatenate([-free, np.tile(problem.x_lower, nodes), np.tile(problem.u_lower, nodes), np.zeros(ns * nodes)])
        self._upper = np.concatenate([free, np.tile(problem.x_upper, nodes), np.tile(problem.u_upper, nodes), np.full(ns * nodes, np.inf)])

    @held_interrupts()
    def solve(self, x0: Array, p: Array, steps: Array, guess: StageGuess, iterations: int = 300) -> Outcome:
        """As `OsqpEngine.solve`; `iterations` caps IPOPT's own."""
        nodes, problem = self.nodes, self.problem
        nx, nu, ns = problem.nx, problem.nu, problem.ns
        if iterations not in self._solvers:
            options: dict[str, Any] = {"print_time": False, "error_on_fail": False}
            options["ipopt"] = {**self._options, "max_iter": iterations}
            self._solvers[iterations] = ca.nlpsol("lane_nlp", "ipopt", self._nlp, options)
        solver = self._solvers[iterations]
        start = np.concatenate([guess.x.ravel(), guess.u.ravel(), guess.s[1:].ravel()])
        lower_g = np.concatenate([np.zeros(self._equal), np.full(self._size_g - self._equal, -np.inf)])
        out = solver(
            x0=start,
            p=np.concatenate([p.ravel(), steps, x0]),
            lbx=self._lower,
            ubx=self._upper,
            lbg=lower_g,
            ubg=np.zeros(self._size_g),
        )
        stats = solver.stats()
        w = np.asarray(out["x"], dtype=np.float64).ravel()
        x = w[: (nodes + 1) * nx].reshape(nodes + 1, nx)
        u = w[(nodes + 1) * nx : (nodes + 1) * nx + nodes * nu].reshape(nodes, nu)
        s = np.vstack([np.zeros((1, ns)), w[(nodes + 1) * nx + nodes * nu :].reshape(nodes, ns)])
        ending = IPOPT_ENDINGS.get(str(stats["return_status"]), Ending.FAILED)
        objective = float(out["f"])
        if np.all(np.isfinite(w)):  # IPOPT moves bounds out by 1e-8, which pays at the slacks' penalties: count the least slacks instead
            s = self.linearisation.slacks(x, u, p)
            objective = self.linearisation.objective(x, u, s, p)
        else:
            ending = Ending.NOT_FINITE
        return Outcome(
            ending=ending,
            x=x,
            u=u,
            s=s,
            objective=objective,
            iterations=int(stats["iter_count"]),
            message=str(stats["return_status"]),
        )
