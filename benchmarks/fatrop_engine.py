"""fatrop on the same stage functions (through CasADi), for the race: a structure-exploiting interior point in C++.

Source: Vanroye et al., IROS 2023. Variables and constraints are ordered stage by stage, as its structure detection wants them.
"""

from __future__ import annotations

from typing import Any

import casadi as ca
import numpy as np

from mcdas_opt.domain.rules import Array
from mcdas_opt.solvers.linearisation import Linearisation
from mcdas_opt.solvers.outcome import Ending, Outcome
from mcdas_opt.solvers.stage_problem import StageGuess, StageProblem


class FatropEngine:
    """Raises RuntimeError where CasADi has no fatrop."""

    def __init__(self, problem: StageProblem, nodes: int, tolerance: float = 1e-8) -> None:
        if not ca.has_nlpsol("fatrop"):
            raise RuntimeError("this CasADi has no fatrop")
        self.problem, self.nodes = problem, nodes
        self._linearisation = Linearisation(problem, nodes)
        nx, nu, ns = problem.nx, problem.nu, problem.ns
        x = [ca.SX.sym(f"x{k}", nx) for k in range(nodes + 1)]
        u = [ca.SX.sym(f"u{k}", nu) for k in range(nodes)]
        s = [ca.SX.sym(f"s{k}", ns) for k in range(nodes + 1)]
        p, h, x0 = ca.SX.sym("p", len(problem.parameters), nodes + 1), ca.SX.sym("h", nodes), ca.SX.sym("x0", nx)
        w: list[Any] = []
        g: list[Any] = []
        equal: list[bool] = []
        lower: list[Array] = []
        upper: list[Array] = []
        cost: Any = 0.5 * ca.sumsqr(problem.terminal_residual(x[nodes], p[:, nodes]))
        free = np.full(nx, np.inf)
        for k in range(nodes + 1):
            w.append(x[k])
            lower.append(problem.x_lower if k else -free)
            upper.append(problem.x_upper if k else free)
            if k < nodes:
                w.append(u[k])
                lower.append(problem.u_lower)
                upper.append(problem.u_upper)
                g.append(x[k + 1] - problem.dynamics(x[k], u[k], p[:, k], h[k]))
                equal += [True] * nx
                cost += 0.5 * ca.sumsqr(problem.residual(x[k], u[k], p[:, k]))
            if k == 0:
                g.append(x[0] - x0)
                equal += [True] * nx
                continue
            w.append(s[k])
            lower.append(np.zeros(ns))
            upper.append(np.full(ns, np.inf))
            g.append(problem.inequality(x[k], u[k] if k < nodes else ca.SX.zeros(nu), p[:, k]) - s[k][list(problem.slack_of)])
            equal += [False] * problem.ng
            cost += ca.dot(problem.slack_linear, s[k]) + 0.5 * ca.dot(problem.slack_quadratic, s[k] ** 2)
        options = {
            "structure_detection": "auto",
            "equality": equal,
            "print_time": False,
            "error_on_fail": False,
            "fatrop": {"print_level": 0, "tol": tolerance},
        }
        nlp = {"x": ca.vertcat(*w), "f": cost, "g": ca.vertcat(*g), "p": ca.veccat(p, h, x0)}
        self._solver = ca.nlpsol("lane_fatrop", "fatrop", nlp, options)
        self._bounds = {
            "lbx": np.concatenate(lower),
            "ubx": np.concatenate(upper),
            "lbg": np.where(equal, 0.0, -np.inf),
            "ubg": np.zeros(len(equal)),
        }

    def solve(self, x0: Array, p: Array, steps: Array, guess: StageGuess, iterations: int = 0) -> Outcome:
        """As the engines of the package; its own iteration limit."""
        nodes, nx, nu = self.nodes, self.problem.nx, self.problem.nu
        parts = [guess.x[0], guess.u[0]]
        for k in range(1, nodes + 1):
            parts += [guess.x[k], *([guess.u[k]] if k < nodes else []), guess.s[k]]
        out = self._solver(x0=np.concatenate(parts), p=np.concatenate([p.ravel(), steps, x0]), **self._bounds)
        stats = self._solver.stats()
        w = np.append(np.asarray(out["x"], dtype=np.float64).ravel(), np.zeros(0))
        x, u = np.empty((nodes + 1, nx)), np.empty((nodes, nu))
        at = 0
        for k in range(nodes + 1):
            x[k] = w[at : at + nx]
            at += nx
            if k < nodes:
                u[k] = w[at : at + nu]
                at += nu
            if k:
                at += self.problem.ns
        s = self._linearisation.slacks(x, u, p)
        objective = self._linearisation.objective(x, u, s, p)
        ending = Ending.CONVERGED if stats["success"] else Ending.FAILED
        return Outcome(ending=ending, x=x, u=u, s=s, objective=objective, iterations=int(stats.get("iter_count", 0)))
