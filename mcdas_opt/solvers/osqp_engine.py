"""Real-time iteration on OSQP: Gauss-Newton SQP in absolute, scaled variables, warm-started in primal and dual.

Sources: Diehl, Bock, Schloeder, SIAM J. Control Optim. 43 (2005) 1714 (real-time iteration); Stellato et al., Math. Prog. Comp. 12
(2020) 637 (OSQP). What OSQP returns is read only after its status and finiteness: an infeasible problem comes back with an x.
"""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_matrix, csc_matrix

from mcdas_opt.domain.declared_types import require_types
from mcdas_opt.domain.rules import Array, positive, require_every
from mcdas_opt.solvers.held_interrupts import held_interrupts
from mcdas_opt.solvers.linearisation import Linearisation, Linearised
from mcdas_opt.solvers.outcome import Ending, Outcome
from mcdas_opt.solvers.stage_problem import StageGuess, StageProblem

_UNBOUNDED = 1e20
_STEP_TOLERANCE = 1e-3  # of the scaled variables
_RHO = 0.1  # penalty that a solve begins with
Index = NDArray[np.int64]


@dataclass(frozen=True, slots=True, kw_only=True)
class OsqpSettings:
    """Tolerances are relative to the scaled variables; every limit is counted, none is a clock."""

    tolerance: float = 1e-4
    qp_iterations: int = 300

    def __post_init__(self) -> None:
        require_types(self)
        require_every(self, positive)


class OsqpEngine:
    """Solves a `StageProblem` over a fixed number of steps. One engine belongs to one planner and one thread."""

    def __init__(self, problem: StageProblem, nodes: int, settings: OsqpSettings | None = None) -> None:
        self.problem, self.nodes = problem, nodes
        self.settings = settings or OsqpSettings()
        self.linearisation = Linearisation(problem, nodes)
        self._pattern = _Pattern(problem, nodes)
        self._solver: Any = None

    @held_interrupts()
    def solve(self, x0: Array, p: Array, steps: Array, guess: StageGuess, iterations: int) -> Outcome:
        """At most `iterations` SQP steps from `guess`, for the measured x0 (nx,), parameters p (N + 1, np), step lengths (N,)."""
        pattern = self._pattern
        x, u, s = guess.x.copy(), guess.u.copy(), guess.s.copy()
        x[0] = x0
        y = guess.multipliers if guess.multipliers.size == pattern.rows else np.zeros(pattern.rows)
        inner = 0
        if self._solver is not None:  # what the step size adapted to in another problem must not colour this one
            self._solver.update_settings(rho=_RHO)
        ending, message = Ending.LIMIT, ""
        done = 0
        for done in range(1, iterations + 1):
            lin = self.linearisation.at(x, u, p, steps)
            qp = pattern.assemble(lin, x, u, x0)
            if not all(np.all(np.isfinite(part)) for part in (qp.p_data, qp.q, qp.a_data)):
                return self._failed(Ending.NOT_FINITE, x, u, s, done, inner, "the linearisation is not finite")
            if not np.all(qp.lower <= qp.upper):  # a bound that is, or a row beyond what counts as no bound: OSQP prints that it refuses it
                return self._failed(Ending.INFEASIBLE, x, u, s, done, inner, "bounds contradict each other, or numbers are out of range")
            try:
                result = self._qp(qp, pattern.pack(x, u, s), y)
            except (ValueError, RuntimeError, ArithmeticError) as error:
                self._solver = None
                return self._failed(Ending.FAILED, x, u, s, done, inner, str(error))
            inner += int(result.info.iter)
            status = int(result.info.status_val)
            z = np.asarray(result.x, dtype=np.float64)
            if status not in (1, 2, 7):  # solved, solved inaccurate, iteration limit
                self._solver = None
                ended = Ending.INFEASIBLE if status in (3, 4, 5, 6) else Ending.FAILED
                return self._failed(ended, x, u, s, done, inner, f"OSQP: {result.info.status}")
            if not (np.all(np.isfinite(z)) and np.all(np.isfinite(result.y))):
                self._solver = None
                return self._failed(Ending.NOT_FINITE, x, u, s, done, inner, "OSQP returned a point that is not finite")
            y = np.asarray(result.y, dtype=np.float64).copy()
            x_new, u_new, s_new = pattern.unpack(z)
            step = max(float(np.abs((x_new - x) / self.problem.x_scale).max()), float(np.abs((u_new - u) / self.problem.u_scale).max()))
            x, u, s = x_new, u_new, s_new
            x[0] = x0
            if step < _STEP_TOLERANCE * 10.0 and status == 1:
                ending = Ending.CONVERGED
                break
            message = f"last step {step:.2g}"
        s = self.linearisation.slacks(x, u, p)  # the least that the point needs, not OSQP's within tolerance
        objective = self.linearisation.objective(x, u, s, p)
        return Outcome(
            ending=ending, x=x, u=u, s=s, multipliers=y, objective=objective, iterations=done, inner_iterations=inner, message=message
        )

    def shifted(self, outcome: Outcome, nodes: int = 1) -> StageGuess:
        """The warm start for so many steps later: everything moved on by as many nodes, the last node held."""
        return self._pattern.shifted(outcome, nodes)

    def reset(self) -> None:
        """Throws the workspace away: the next solve is set up anew."""
        self._solver = None

    def _failed(self, ending: Ending, x: Array, u: Array, s: Array, done: int, inner: int, message: str) -> Outcome:
        return Outcome(ending=ending, x=x, u=u, s=s, iterations=done, inner_iterations=inner, message=message)

    @staticmethod
    def load() -> None:
        """OSQP's own modules, before a solve needs them: they take a fiftieth of a second."""
        import osqp  # noqa: F401

    def _qp(self, qp: _Qp, z: Array, y: Array) -> Any:
        import osqp

        try:
            if self._solver is None:
                with warnings.catch_warnings():
                    warnings.simplefilter("ignore")
                    self._solver = osqp.OSQP()
                    self._solver.setup(
                        self._pattern.p_matrix(qp.p_data),
                        qp.q,
                        self._pattern.a_matrix(qp.a_data),
                        qp.lower,
                        qp.upper,
                        verbose=False,
                        eps_abs=self.settings.tolerance,
                        eps_rel=self.settings.tolerance,
                        max_iter=self.settings.qp_iterations,
                        rho=_RHO,
                        check_termination=10,
                        adaptive_rho_interval=25,
                        adaptive_rho_tolerance=2.0,
                        polishing=False,
                    )
            else:
                self._solver.update(Px=qp.p_data, Ax=qp.a_data, q=qp.q, l=qp.lower, u=qp.upper)
            self._solver.warm_start(x=z, y=y)
            return self._solver.solve(raise_error=False)
        except osqp.OSQPException as error:  # its base is Exception
            raise RuntimeError(f"OSQP refuses the problem: error {error}") from error


@dataclass(frozen=True, slots=True)
class _Qp:
    p_data: Array
    q: Array
    a_data: Array
    lower: Array
    upper: Array


class _Pattern:
    """The fixed sparsity of the QP: where each block of the linearisation goes. A node's variables are [x, u, s]."""

    def __init__(self, problem: StageProblem, nodes: int) -> None:
        self.problem, self.nodes = problem, nodes
        nx, nu, ns, ng = problem.nx, problem.nu, problem.ns, problem.ng
        nz, nv = nx + nu, nx + nu + ns
        self.size = (nodes + 1) * nv
        base = np.arange(nodes + 1) * nv
        self.ix = base[:, None] + np.arange(nx)
        self.iu = base[:-1, None] + nx + np.arange(nu)
        self.iu_last = base[-1] + nx + np.arange(nu)
        self.is_ = base[:, None] + nz + np.arange(ns)
        scale = np.ones(self.size)
        scale[self.ix], scale[self.iu], scale[self.iu_last] = problem.x_scale, problem.u_scale, problem.u_scale
        scale[self.is_] = problem.s_scale
        self.scale = scale
        self.iz = base[:, None] + np.arange(nz)
        # Hessian: dense upper triangle of each (x, u) block, diagonal slacks, a whisper of regularisation on the last node's idle input
        upper = np.triu_indices(nz)
        self._upper = upper
        rows = [self.iz[:, upper[0]].ravel(), self.is_.ravel()]
        columns = [self.iz[:, upper[1]].ravel(), self.is_.ravel()]
        self._p_order = _CscOrder(np.concatenate(rows), np.concatenate(columns), (self.size, self.size))
        self._p_scale = scale[np.concatenate(rows)] * scale[np.concatenate(columns)]
        # constraints: x_0; dynamics; soft rows at 1..N; bounds on x at 1..N, on u at 0..N-1 and u_N = 0; slacks >= 0
        r = 0
        a_rows: list[Index] = []
        a_columns: list[Index] = []

        def block(row_index: Any, column_index: Any) -> None:
            a_rows.append(np.broadcast_to(row_index, np.broadcast_shapes(np.shape(row_index), np.shape(column_index))).ravel())
            a_columns.append(np.broadcast_to(column_index, np.broadcast_shapes(np.shape(row_index), np.shape(column_index))).ravel())

        self.r_initial = np.arange(nx)
        block(self.r_initial, self.ix[0])
        r += nx
        self.r_dynamics = r + np.arange(nodes * nx).reshape(nodes, nx)
        block(self.r_dynamics[:, :, None], self.iz[:-1, None, :])  # -[A B]
        block(self.r_dynamics, self.ix[1:])  # +1
        r += nodes * nx
        self.r_rows = r + np.arange(nodes * ng).reshape(nodes, ng)
        block(self.r_rows[:, :, None], self.iz[1:, None, :])
        block(self.r_rows, self.is_[1:][:, list(problem.slack_of)])
        r += nodes * ng
        self.r_x = r + np.arange(nodes * nx).reshape(nodes, nx)
        block(self.r_x, self.ix[1:])
        r += nodes * nx
        self.r_u = r + np.arange(nodes * nu).reshape(nodes, nu)
        block(self.r_u, self.iu)
        r += nodes * nu
        self.r_u_last = r + np.arange(nu)
        block(self.r_u_last, self.iu_last)
        r += nu
        self.r_s = r + np.arange((nodes + 1) * ns).reshape(nodes + 1, ns)
        block(self.r_s, self.is_)
        r += (nodes + 1) * ns
        self.rows = r
        rows_all, columns_all = np.concatenate(a_rows), np.concatenate(a_columns)
        self._a_order = _CscOrder(rows_all, columns_all, (r, self.size))
        self._a_scale = scale[columns_all]
        self._row_scale = np.ones(r)
        self._row_scale[self.r_initial] = 1.0 / problem.x_scale
        self._row_scale[self.r_dynamics] = 1.0 / problem.x_scale
        self._row_scale[self.r_x] = 1.0 / problem.x_scale
        self._row_scale[self.r_u] = 1.0 / problem.u_scale
        self._row_scale[self.r_u_last] = 1.0 / problem.u_scale
        self._row_scale[self.r_s] = 1.0 / problem.s_scale
        self._row_scale[self.r_rows] = 1.0 / problem.s_scale[list(problem.slack_of)]
        self._a_scale = self._a_scale * self._row_scale[rows_all]

        lower, upper_bound = np.full(r, -_UNBOUNDED), np.full(r, _UNBOUNDED)
        lower[self.r_x], upper_bound[self.r_x] = problem.x_lower, problem.x_upper
        lower[self.r_u], upper_bound[self.r_u] = problem.u_lower, problem.u_upper
        lower[self.r_u_last] = upper_bound[self.r_u_last] = 0.0
        lower[self.r_s] = 0.0
        self._lower, self._upper_bound = lower, upper_bound

        old = np.arange(self.size)
        self._shift = old.copy()
        for index in (self.ix, self.iu, self.is_):
            self._shift[index[:-1]] = old[index[1:]]
        row = np.arange(r)
        self._row_shift = row.copy()
        for index in (self.r_dynamics, self.r_rows, self.r_x, self.r_u, self.r_s):
            self._row_shift[index[:-1]] = row[index[1:]]

    def p_matrix(self, data: Array) -> csc_matrix:
        return self._p_order.matrix(data)

    def a_matrix(self, data: Array) -> csc_matrix:
        return self._a_order.matrix(data)

    def assemble(self, lin: Linearised, x: Array, u: Array, x0: Array) -> _Qp:
        problem, n = self.problem, self.nodes
        u_all = np.vstack([u, np.zeros((1, problem.nu))])
        z = np.hstack([x, u_all])
        hessian = lin.hessian.copy()
        idle = np.arange(problem.nx, problem.nx + problem.nu)
        hessian[-1, idle, idle] += 1e-6
        diagonal = np.broadcast_to(problem.slack_quadratic, (n + 1, problem.ns))
        p_values = np.concatenate([hessian[:, self._upper[0], self._upper[1]].ravel(), diagonal.ravel()])
        q = np.zeros(self.size)
        q[self.iz] = lin.gradient - np.einsum("kij,kj->ki", hessian, z)
        q[self.is_] = problem.slack_linear
        ones_x = np.ones(n * problem.nx)
        a_values = np.concatenate(
            [
                np.ones(problem.nx),
                -lin.ab[:-1].ravel(),
                ones_x,
                lin.jg[1:].ravel(),
                np.full(n * problem.ng, -1.0),
                ones_x,
                np.ones(n * problem.nu + problem.nu + (n + 1) * problem.ns),
            ]
        )
        lower, upper = self._lower.copy(), self._upper_bound.copy()
        lower[self.r_initial] = upper[self.r_initial] = x0
        affine = lin.f[:-1] - np.einsum("kij,kj->ki", lin.ab[:-1], z[:-1])
        lower[self.r_dynamics] = upper[self.r_dynamics] = affine
        upper[self.r_rows] = np.einsum("kij,kj->ki", lin.jg[1:], z[1:]) - lin.g[1:]
        lower *= self._row_scale
        upper *= self._row_scale
        return _Qp(
            p_data=self._p_order.data(p_values * self._p_scale),
            q=q * self.scale,
            a_data=self._a_order.data(a_values * self._a_scale),
            lower=np.maximum(lower, -_UNBOUNDED),
            upper=np.minimum(upper, _UNBOUNDED),
        )

    def pack(self, x: Array, u: Array, s: Array) -> Array:
        z = np.zeros(self.size)
        z[self.ix], z[self.iu], z[self.is_] = x, u, s
        return z / self.scale

    def unpack(self, z: Array) -> tuple[Array, Array, Array]:
        full = z * self.scale
        return full[self.ix], full[self.iu], full[self.is_]

    def shifted(self, outcome: Outcome, nodes: int) -> StageGuess:
        z = self.pack(outcome.x, outcome.u, outcome.s)
        y = outcome.multipliers if outcome.multipliers.size == self.rows else np.zeros(self.rows)
        for _ in range(nodes):
            z, y = z[self._shift], y[self._row_shift]
            z[self.iu[-1]] = 0.0
        x, u, s = self.unpack(z)
        return StageGuess(x=x, u=u, s=s, multipliers=y)


class _CscOrder:
    """Where entry i of a coordinate list lands in CSC data."""

    def __init__(self, rows: Index, columns: Index, shape: tuple[int, int]) -> None:
        tagged = coo_matrix((np.arange(1, rows.size + 1, dtype=np.float64), (rows, columns)), shape=shape).tocsc()
        tagged.sort_indices()
        self._order = tagged.data.astype(np.int64) - 1
        self._indices, self._indptr, self._shape = tagged.indices.copy(), tagged.indptr.copy(), shape
        assert self._order.size == rows.size, "an entry stands twice"

    def data(self, values: Array) -> Array:
        return values[self._order]

    def matrix(self, data: Array) -> csc_matrix:
        return csc_matrix((data.copy(), self._indices, self._indptr), shape=self._shape)
