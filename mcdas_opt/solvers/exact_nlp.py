"""A stage problem solved to its exact optimum, and what that optimum's derivatives are: by parameters, through the active constraints.

With L = f + lam'g and the rows and bounds that hold with a multiplier kept as equalities, the optimum moves with a parameter p as
[L_ww A'; A 0] [dw; dlam] = -[L_wp; g_p] dp (Fiacco 1983); the optimal cost changes by L_p alone. All derivatives are CasADi's, exact.
"""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from typing import Any

import casadi as ca
import numpy as np
from scipy.sparse import bmat, csc_matrix
from scipy.sparse.linalg import MatrixRankWarning, spsolve

from mcdas_opt.domain.rules import Array
from mcdas_opt.solvers.ipopt_engine import IpoptEngine
from mcdas_opt.solvers.outcome import Ending
from mcdas_opt.solvers.stage_problem import StageProblem

_TOLERANCE = 1e-10
_ITERATIONS = 300
_ENDINGS = {"Solve_Succeeded": Ending.CONVERGED, "Solved_To_Acceptable_Level": Ending.CONVERGED}


@dataclass(frozen=True, slots=True, kw_only=True)
class ExactSolution:
    """A solved problem: unknowns w = (x, u, s), multipliers, and the parameters (N + 1, np) it was solved for; usable when converged."""

    ending: Ending
    w: Array
    bound_multipliers: Array
    row_multipliers: Array
    parameters: Array  # (p, h, x0) in one vector
    objective: float


class ExactNlp(IpoptEngine):
    """IPOPT to 1e-10 on the whole horizon."""

    def __init__(self, problem: StageProblem, nodes: int) -> None:
        super().__init__(problem, nodes, tolerance=_TOLERANCE)
        w, p, f, g = (self._nlp[key] for key in ("x", "p", "f", "g"))
        lam = ca.SX.sym("lam", self._size_g)
        lagrangian = f + ca.dot(lam, g)
        slope = ca.gradient(lagrangian, w)
        self._derivatives = ca.Function(
            "derivatives",
            [w, p, lam],
            [ca.hessian(lagrangian, w)[0], ca.jacobian(g, w), ca.jacobian(slope, p), ca.jacobian(g, p), g],
        )
        self._cost_slope = ca.Function("cost_slope", [w, p, lam], [ca.gradient(lagrangian, p)])
        options: Any = {
            "print_time": False,
            "error_on_fail": False,
            "ipopt": {**self._options, "max_iter": _ITERATIONS, "bound_relax_factor": 0.0},
        }
        self._exact = ca.nlpsol("exact", "ipopt", self._nlp, options)
        self.w, self.p = w, p

    def exact_from(self, parameters: Array, start: Array) -> ExactSolution:
        """The optimum for the parameters (p (N + 1, np), steps (N,), x0 (nx,), in one vector), from a start (x, u, s in one vector)."""
        lower = np.concatenate([np.zeros(self._equal), np.full(self._size_g - self._equal, -np.inf)])
        out = self._exact(x0=start, p=parameters, lbx=self._lower, ubx=self._upper, lbg=lower, ubg=np.zeros(self._size_g))
        w = np.asarray(out["x"], dtype=np.float64).ravel()
        ending = _ENDINGS.get(str(self._exact.stats()["return_status"]), Ending.FAILED)
        return ExactSolution(
            ending=ending if np.all(np.isfinite(w)) else Ending.NOT_FINITE,
            w=w,
            bound_multipliers=np.asarray(out["lam_x"], dtype=np.float64).ravel(),
            row_multipliers=np.asarray(out["lam_g"], dtype=np.float64).ravel(),
            parameters=parameters,
            objective=float(out["f"]),
        )

    def cost_gradient(self, at: ExactSolution) -> Array:
        """Of the optimal cost by (p, h, x0): the Lagrangian's own slope, no system is solved (Danskin)."""
        return np.asarray(self._cost_slope(at.w, at.parameters, at.row_multipliers), dtype=np.float64).ravel()

    def gradient(self, at: ExactSolution, by_w: Array, by_p: Array) -> Array:
        """Of any measure m(w(p), p) by (p, h, x0), from its partial slopes: one adjoint solve."""
        hessian, rows, mixed, rows_p, g = (_sparse(part) for part in self._derivatives(at.w, at.parameters, at.row_multipliers))
        left = np.asarray(g.todense()).ravel()
        held_rows = np.ones(self._size_g, dtype=bool)
        held_rows[self._equal :] = at.row_multipliers[self._equal :] > -left[self._equal :]
        room = np.minimum(at.w - self._lower, self._upper - at.w)
        free = ~(np.abs(at.bound_multipliers) > room)
        active = rows[held_rows][:, free]
        system = bmat([[hessian[free][:, free], active.T], [active, None]], format="csc")
        right = np.concatenate([by_w[free], np.zeros(active.shape[0])])
        with warnings.catch_warnings():
            warnings.simplefilter("error", MatrixRankWarning)
            adjoint = np.asarray(spsolve(system, right), dtype=np.float64)
        moved = np.asarray(mixed[free].T @ adjoint[: int(free.sum())]).ravel()
        bent = np.asarray(rows_p[held_rows].T @ adjoint[int(free.sum()) :]).ravel()
        return np.asarray(by_p - moved - bent)


def _sparse(matrix: Any) -> csc_matrix:
    """A CasADi matrix as scipy's, without a detour through a dense one."""
    columns, rows = matrix.sparsity().get_ccs()
    return csc_matrix((np.asarray(matrix.nonzeros(), dtype=np.float64), np.asarray(rows), np.asarray(columns)), shape=matrix.shape)
