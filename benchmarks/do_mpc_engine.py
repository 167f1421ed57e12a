"""do-mpc on the same stage functions, for the race: IPOPT behind a modelling layer, as its users have it.

Source: Fiedler et al., Control Engineering Practice 140 (2023). Slacks are inputs of their own; the last node is one stage more, told apart
by a parameter, because do-mpc's terminal cost takes no time-varying ones.
"""

from __future__ import annotations

import warnings

import casadi as ca
import numpy as np

from mcdas_opt.domain.rules import Array
from mcdas_opt.solvers.linearisation import Linearisation
from mcdas_opt.solvers.outcome import Ending, Outcome
from mcdas_opt.solvers.stage_problem import StageGuess, StageProblem


class DoMpcEngine:
    """Raises ImportError where do-mpc is not installed."""

    def __init__(self, problem: StageProblem, nodes: int, step_s: float = 0.1, tolerance: float = 1e-8) -> None:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            import do_mpc

        self.problem, self.nodes = problem, nodes
        self._linearisation = Linearisation(problem, nodes)
        nx, nu, ns = problem.nx, problem.nu, problem.ns
        model = do_mpc.model.Model("discrete", "SX")
        x, u, s = model.set_variable("_x", "x", (nx, 1)), model.set_variable("_u", "u", (nu, 1)), model.set_variable("_u", "s", (ns, 1))
        p = model.set_variable("_tvp", "p", (len(problem.parameters), 1))
        last, first = model.set_variable("_tvp", "last"), model.set_variable("_tvp", "first")
        model.set_rhs("x", last * x + (1.0 - last) * problem.dynamics(x, u, p, step_s))
        model.setup()
        mpc = do_mpc.controller.MPC(model)
        mpc.settings.n_horizon, mpc.settings.t_step, mpc.settings.store_full_solution = nodes + 1, step_s, False
        mpc.settings.nlpsol_opts = {"print_time": False, "ipopt": {"print_level": 0, "sb": "yes", "tol": tolerance}}
        x, u, s, p = model.x["x"], model.u["u"], model.u["s"], model.tvp["p"]
        last, first = model.tvp["last"], model.tvp["first"]
        running, terminal = (0.5 * ca.sumsqr(r) for r in (problem.residual(x, u, p), problem.terminal_residual(x, p)))
        price = ca.dot(problem.slack_linear, s) + 0.5 * ca.dot(problem.slack_quadratic, s**2)
        mpc.set_objective(lterm=(1.0 - last) * running + last * (terminal + 0.5 * ca.sumsqr(u)) + price, mterm=ca.SX(0.0))
        mpc.set_rterm(u=0.0, s=0.0)
        rows = problem.inequality(x, (1.0 - last) * u, p)
        mpc.set_nl_cons("rows", (1.0 - first) * rows - s[list(problem.slack_of)], ub=0.0)
        mpc.bounds["lower", "_x", "x"], mpc.bounds["upper", "_x", "x"] = problem.x_lower, problem.x_upper
        mpc.bounds["lower", "_u", "u"], mpc.bounds["upper", "_u", "u"] = problem.u_lower, problem.u_upper
        mpc.bounds["lower", "_u", "s"] = np.zeros(ns)
        self._told = mpc.get_tvp_template()
        for k in range(nodes + 2):
            self._told["_tvp", k, "last"], self._told["_tvp", k, "first"] = float(k >= nodes), float(k == 0)
        mpc.set_tvp_fun(lambda _: self._told)
        mpc.setup()
        self._mpc = mpc

    def solve(self, x0: Array, p: Array, steps: Array, guess: StageGuess, iterations: int = 0) -> Outcome:
        """As the engines of the package; its own iteration limit, steps of the length it was built with."""
        mpc, nodes = self._mpc, self.nodes
        for k in range(nodes + 2):
            self._told["_tvp", k, "p"] = p[min(k, nodes)]
        mpc.t0, mpc.x0 = 0.0, x0
        mpc.set_initial_guess()
        for k in range(nodes + 2):
            mpc.opt_x_num["_x", k, 0, -1] = guess.x[min(k, nodes)] / mpc._x_scaling.cat.full().ravel()
        for k in range(nodes + 1):
            mpc.opt_x_num["_u", k, 0] = np.concatenate([guess.u[k] if k < nodes else np.zeros(self.problem.nu), guess.s[k]])
        mpc.make_step(x0[:, None])
        stats = mpc.solver_stats
        x = np.array([np.asarray(mpc.opt_x_num["_x", k, 0, -1]).ravel() for k in range(nodes + 1)])
        u = np.array([np.asarray(mpc.opt_x_num["_u", k, 0]).ravel()[: self.problem.nu] for k in range(nodes)])
        s = self._linearisation.slacks(x, u, p)
        ending = Ending.CONVERGED if stats["success"] else Ending.FAILED
        objective = self._linearisation.objective(x, u, s, p)
        return Outcome(ending=ending, x=x, u=u, s=s, objective=objective, iterations=int(stats["iter_count"]))
