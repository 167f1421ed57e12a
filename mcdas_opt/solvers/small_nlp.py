"""A small dense nonlinear program with multipliers, by IPOPT from exact derivatives; judged by residuals, not by the solver's word."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import casadi as ca
import numpy as np

from mcdas_opt.domain.rules import Array
from mcdas_opt.solvers.outcome import IPOPT_ENDINGS, Ending

_ITERATIONS = 200
_TOLERANCE = 1e-9
_SOUND = 1e-6  # largest violation of a row or bound that is still called kept


@dataclass(frozen=True, slots=True, kw_only=True)
class SmallAnswer:
    """`ending` CONVERGED only where every row and bound holds to 1e-6, measured here.

    `row_multipliers` >= 0 say by how much f falls per unit that a row is relaxed; `bound_multipliers` are negative at lower bounds.
    """

    ending: Ending
    x: Array
    row_multipliers: Array
    bound_multipliers: Array
    evaluations: int
    message: str


class SmallSolver:
    """Minimise f(x, p) subject to g(x, p) <= 0 and bounds; x, p, f, g in CasADi SX, rows of order one. Built once for every p."""

    def __init__(self, x: Any, p: Any, f: Any, g: Any) -> None:
        options: dict[str, Any] = {"print_time": False, "error_on_fail": False}
        options["ipopt"] = {"print_level": 0, "sb": "yes", "tol": _TOLERANCE, "max_iter": _ITERATIONS, "bound_relax_factor": 0.0}
        self._solver = ca.nlpsol("small", "ipopt", {"x": x, "p": p, "f": f, "g": ca.cse(g)}, options)
        self._rows = int(g.numel())

    def solve(self, p: Array, lower: Array, upper: Array, start: Array) -> SmallAnswer:
        """One solve from `start`, clipped into the bounds."""
        out = self._solver(
            x0=np.clip(start, lower, upper),
            p=p,
            lbx=lower,
            ubx=upper,
            lbg=np.full(self._rows, -np.inf),
            ubg=np.zeros(self._rows),
        )
        stats = self._solver.stats()
        x = np.asarray(out["x"], dtype=np.float64).ravel()
        ending = IPOPT_ENDINGS.get(str(stats["return_status"]), Ending.FAILED)
        violation = np.inf
        if np.all(np.isfinite(x)):
            g = np.asarray(out["g"], dtype=np.float64).ravel()
            over = np.concatenate([g, lower - x, x - upper])
            violation = float(max(over.max(), 0.0)) if np.all(np.isfinite(g)) else np.inf
        if ending is Ending.CONVERGED and not violation < _SOUND:
            ending = Ending.FAILED
        return SmallAnswer(
            ending=ending,
            x=x,
            row_multipliers=np.maximum(np.asarray(out["lam_g"], dtype=np.float64).ravel(), 0.0),
            bound_multipliers=np.asarray(out["lam_x"], dtype=np.float64).ravel(),
            evaluations=int(stats["n_call_nlp_f"]),
            message=str(stats["return_status"]),
        )
