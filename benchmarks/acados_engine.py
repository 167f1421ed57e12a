"""acados on the same stage functions, for the race: SQP in C, each quadratic program by HPIPM, generated and compiled when it is built.

Source: Verschueren et al., Math. Prog. Comp. 14 (2022) 147. Slacks that several rows share are inputs of their own, because acados' own
belong to one row each; the last node is one stage more, told apart by a parameter, because inputs end before the terminal node. The cost's
Hessian is Gauss-Newton's. HPIPM's mode and the tolerance are the fastest of those that gave the same answers (on eight evasions).

Written against the wheel `comma-deps-acados`, which overwrites casadi: install it into a folder of its own,
`pip install --no-deps --target FOLDER comma-deps-acados`, and set ACADOS_SOURCE_DIR=FOLDER/acados/install.
"""

from __future__ import annotations

import contextlib
import ctypes
import importlib
import importlib.util
import io
import os
import sys
import tempfile
from pathlib import Path
from typing import Any

import casadi as ca
import numpy as np

from mcdas_opt.domain.rules import Array
from mcdas_opt.solvers.linearisation import Linearisation
from mcdas_opt.solvers.outcome import Ending, Outcome
from mcdas_opt.solvers.stage_problem import StageGuess, StageProblem

_FAR = 1e6  # acados' bounds have two sides: the other one
_ENDINGS = {0: Ending.CONVERGED, 1: Ending.NOT_FINITE, 2: Ending.LIMIT}


class AcadosEngine:
    """Raises ImportError where acados is not installed, RuntimeError where it cannot generate or compile."""

    def __init__(self, problem: StageProblem, nodes: int, iterations: int = 50, tolerance: float = 1e-4, curved: bool = False) -> None:
        """`curved` adds the rows' curvature to the Hessian, as the package's interior point does, and projects it to be positive."""
        template = _template()
        self.problem, self.nodes = problem, nodes
        self.seconds: list[float] = []  # acados' own time of each solve
        self._linearisation = Linearisation(problem, nodes)
        ocp = template.AcadosOcp()
        ocp.model = _model(template.AcadosModel(), problem)
        ocp.parameter_values = np.zeros(len(problem.parameters) + 3)
        ocp.dims.N = nodes + 1
        ocp.cost.cost_type = "EXTERNAL"
        limits, options = ocp.constraints, ocp.solver_options
        limits.x0 = np.zeros(problem.nx)
        limits.idxbx = np.flatnonzero(np.isfinite(problem.x_lower) | np.isfinite(problem.x_upper))
        limits.lbx, limits.ubx = (np.clip(b, -_FAR, _FAR)[limits.idxbx] for b in (problem.x_lower, problem.x_upper))
        limits.idxbu = np.arange(problem.nu + problem.ns)
        limits.lbu = np.concatenate([problem.u_lower, np.zeros(problem.ns)])
        limits.ubu = np.concatenate([problem.u_upper, np.full(problem.ns, _FAR)])
        limits.lh, limits.uh = np.full(problem.ng, -_FAR), np.zeros(problem.ng)
        options.integrator_type, options.nlp_solver_type, options.hessian_approx = "DISCRETE", "SQP", "GAUSS_NEWTON"
        if curved:  # the cost's part stays the one that the model gives
            options.hessian_approx, options.exact_hess_dyn, options.regularize_method = "EXACT", 0, "PROJECT"
        options.qp_solver, options.hpipm_mode = "PARTIAL_CONDENSING_HPIPM", "SPEED"
        options.qp_solver_warm_start, options.qp_solver_iter_max = 1, 100
        options.tf, options.time_steps = float(nodes + 1), np.ones(nodes + 1)  # the map knows its step: these only weigh the cost
        options.nlp_solver_max_iter, options.print_level = iterations, 0
        for kind in ("stat", "eq", "ineq", "comp"):
            setattr(options, f"nlp_solver_tol_{kind}", tolerance)
            setattr(options, f"qp_solver_tol_{kind}", 0.1 * tolerance)  # at the same one the steps may end just above it, for ever
        options.ext_fun_compile_flags = "-O3 -march=native"
        self._solver = _built(template, ocp)
        self.reset()

    def reset(self) -> None:
        self._solver.reset()
        for k in range(self.nodes + 2):  # this version's own reset reads past its zeros when it clears multipliers
            for field in ("lam", "t"):
                self._solver.set(k, field, np.zeros(len(self._solver.get(k, field))))

    def solve(self, x0: Array, p: Array, steps: Array, guess: StageGuess, iterations: int = 0) -> Outcome:
        """As the engines of the package; its own iteration limit."""
        nodes, nu, solver = self.nodes, self.problem.nu, self._solver
        stages = np.zeros((nodes + 2, p.shape[1] + 3))  # p, step length, first, last
        stages[: nodes + 1, :-3], stages[-1, :-3] = p, p[-1]
        stages[:nodes, -3], stages[nodes:, -3] = steps, steps[-1]
        stages[0, -2], stages[nodes:, -1] = 1.0, 1.0
        inputs = np.hstack([np.vstack([guess.u, np.zeros((1, nu))]), guess.s])
        for k in range(nodes + 2):
            solver.set(k, "p", stages[k])
            solver.set(k, "x", guess.x[min(k, nodes)])
            if k <= nodes:
                solver.set(k, "u", inputs[k])
        solver.set(0, "lbx", x0)
        solver.set(0, "ubx", x0)
        status = solver.solve()
        self.seconds.append(float(solver.get_stats("time_tot")[0]))
        x = np.array([solver.get(k, "x") for k in range(nodes + 1)])
        u = np.array([solver.get(k, "u")[:nu] for k in range(nodes)])
        ending = _ENDINGS.get(status, Ending.FAILED)
        if ending in (Ending.FAILED, Ending.NOT_FINITE):
            self.reset()  # its memory is not worth a warm start
        if not (np.isfinite(x).all() and np.isfinite(u).all()):
            return Outcome(ending=Ending.NOT_FINITE, x=guess.x, u=guess.u, s=guess.s, message=f"acados status {status}")
        s = self._linearisation.slacks(x, u, p)
        return Outcome(
            ending=ending,
            x=x,
            u=u,
            s=s,
            objective=self._linearisation.objective(x, u, s, p),
            iterations=int(solver.get_stats("sqp_iter")[0]),
            message=f"acados status {status}",
        )


def _model(model: Any, problem: StageProblem) -> Any:
    nx, nu, ns, count = problem.nx, problem.nu, problem.ns, len(problem.parameters)
    x, v, q = ca.SX.sym("x", nx), ca.SX.sym("v", nu + ns), ca.SX.sym("q", count + 3)
    u, s, p = v[:nu], v[nu:], q[:count]
    h, first, last = q[count], q[count + 1], q[count + 2]
    model.name, model.x, model.u, model.p = "lane", x, v, q
    model.disc_dyn_expr = last * x + (1.0 - last) * problem.dynamics(x, u, p, h)
    running, terminal = problem.residual(x, u, p), ca.vertcat(problem.terminal_residual(x, p), u)
    price = ca.dot(problem.slack_linear, s) + 0.5 * ca.dot(problem.slack_quadratic, s**2)
    model.cost_expr_ext_cost = 0.5 * ((1.0 - last) * ca.sumsqr(running) + last * ca.sumsqr(terminal)) + price
    order = ca.vertcat(v, x)
    jr, jt = (ca.jacobian(r, order) for r in (running, terminal))
    of_slacks = ca.diagcat(ca.SX(nu, nu), ca.diag(ca.SX(problem.slack_quadratic)), ca.SX(nx, nx))
    model.cost_expr_ext_cost_custom_hess = (1.0 - last) * ca.mtimes(jr.T, jr) + last * ca.mtimes(jt.T, jt) + of_slacks
    model.con_h_expr = (1.0 - first) * problem.inequality(x, (1.0 - last) * u, p) - s[list(problem.slack_of)]
    return model


def _template() -> Any:
    """acados' Python package, with its libraries loaded and told where the rest of it is."""
    home = _home()
    renderer = home / "bin" / "t_renderer"
    if not os.access(renderer, os.X_OK):
        raise RuntimeError(f"acados' template renderer is missing: {renderer}")
    os.environ["ACADOS_SOURCE_DIR"], os.environ["TERA_PATH"] = str(home), str(renderer)
    os.environ["ACADOS_PYTHON_INTERFACE_PATH"] = str(home.parent / "acados_template")
    if str(home.parent) not in sys.path:
        sys.path.append(str(home.parent))
    for name in ("blasfeo", "hpipm", "qpOASES_e", "acados"):  # they do not know where their neighbours lie
        library = next((home / "lib").glob(f"lib{name}.*"), None)
        if library is None:
            raise RuntimeError(f"acados has no library {name} in {home / 'lib'}")
        ctypes.CDLL(str(library), mode=ctypes.RTLD_GLOBAL)
    return importlib.import_module("acados_template")


def _home() -> Path:
    if told := os.environ.get("ACADOS_SOURCE_DIR"):
        home = Path(told)
    else:
        spec = importlib.util.find_spec("acados")
        if spec is None or not spec.submodule_search_locations:
            raise ImportError("acados is not installed, or ACADOS_SOURCE_DIR not set")
        home = Path(next(iter(spec.submodule_search_locations))) / "install"
    if not (home.parent / "acados_template").is_dir():
        raise ImportError(f"no acados_template beside {home}")
    return home.resolve()


def _built(template: Any, ocp: Any) -> Any:
    """Generated and compiled in a folder that is gone once the library is loaded."""
    said = io.StringIO()
    with tempfile.TemporaryDirectory() as folder, contextlib.chdir(folder), contextlib.redirect_stdout(said):
        ocp.code_export_directory = str(Path(folder) / "code")
        try:
            return template.AcadosOcpSolver(ocp, json_file=str(Path(folder) / "ocp.json"), verbose=False)
        except Exception as error:  # acados raises bare ones
            raise RuntimeError(f"acados: {error}; {said.getvalue()[-300:]}") from error
