"""piqp on the linearised problems of the OSQP engine, for the race: a proximal interior point for sparse quadratic programs.

Source: Schwan, Jiang, Kuhn, Jones, CDC 2023. Each step's quadratic program is solved to the end; there is no warm start.
"""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
from scipy.sparse import csc_matrix

from mcdas_opt.domain.rules import Array
from mcdas_opt.solvers.osqp_engine import OsqpEngine
from mcdas_opt.solvers.stage_problem import StageProblem

_FAR = 1e12  # bounds beyond it are none: piqp wants infinity said as such


class PiqpEngine(OsqpEngine):
    """Raises ImportError where piqp is not installed."""

    def __init__(self, problem: StageProblem, nodes: int) -> None:
        import piqp

        super().__init__(problem, nodes)
        self._make, self._optimum = piqp.SparseSolver, piqp.PIQP_SOLVED
        self._piqp: Any = None
        pattern = self._pattern
        self._equal = np.concatenate([pattern.r_initial, pattern.r_dynamics.ravel(), pattern.r_u_last])
        self._other = np.setdiff1d(np.arange(pattern.rows), self._equal)
        self._bounded = False

    def reset(self) -> None:
        super().reset()
        self._piqp = None

    def _qp(self, qp: Any, z: Array, y: Array) -> Any:
        """What OSQP would say: status 1 solved, 2 not quite."""
        pattern = self._pattern
        if not self._bounded:  # piqp wants rows without any bound left out
            self._other = self._other[(qp.lower[self._other] > -_FAR) | (qp.upper[self._other] < _FAR)]
            self._bounded = True
        p = pattern.p_matrix(qp.p_data)
        rows = pattern.a_matrix(qp.a_data).tocsr()
        equal, other = (csc_matrix(rows[index]) for index in (self._equal, self._other))
        lower, upper = qp.lower[self._other], qp.upper[self._other]
        data: dict[str, Any] = {
            "P": p,
            "c": qp.q,
            "A": equal,
            "b": qp.lower[self._equal],
            "G": other,
            "h_l": np.where(lower < -_FAR, -np.inf, lower),
            "h_u": np.where(upper > _FAR, np.inf, upper),
        }
        if self._piqp is None:
            self._piqp = self._make()
            self._piqp.setup(**data)
        else:
            self._piqp.update(**data)
        solved = self._piqp.solve() == self._optimum
        result = self._piqp.result
        info = SimpleNamespace(iter=result.info.iter, status_val=1 if solved else 2, status=str(result.info.status))
        return SimpleNamespace(x=np.array(result.x), y=np.zeros(pattern.rows), info=info)
