"""How a plan of the lane problem changes with what it was posed with: the sigmoid's a, b, y_max and offset, and the weights.

Cost: the optimal objective. Clearance: the least of the neighbour rows over the horizon [m], negative inside a body's margin. Merit: a
smooth cost of the plan itself, by the measure of `planning.candidates.cost`, whatever weights it was made with.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import casadi as ca
import numpy as np

from mcdas_opt.domain.rules import Array
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.dynamics.bicycle import lateral_acceleration
from mcdas_opt.ocp.lane_mpc import LaneProblem, default_weights
from mcdas_opt.solvers.exact_nlp import ExactNlp, ExactSolution
from mcdas_opt.solvers.outcome import Ending
from mcdas_opt.solvers.stage_problem import StageGuess

SIGMOID = {"a": "ref_a", "b": "ref_b", "y_max": "ref_amplitude", "off": "ref_bend"}
KNOBS = (*SIGMOID, *default_weights())
# the merit per second of plan: per (m/s^2)^2, (m/s^3)^2, (rad/s)^2, m^2 off the target, and per exp(-clearance / scale)
_ACCELERATION, _LATERAL_ACCELERATION, _JERK, _STEERING_RATE, _OFF_TARGET = 0.04, 0.08, 0.001, 2.0, 0.1
_NEARNESS, _NEARNESS_SCALE_M = 6.0, 0.7


@dataclass(frozen=True, slots=True, kw_only=True)
class Measured:
    """A plan's measures, and their gradients by `KNOBS` where they were asked for."""

    converged: bool
    cost: float
    clearance_m: float
    merit: float
    cost_by: dict[str, float]
    clearance_by: dict[str, float]
    merit_by: dict[str, float]
    solution: ExactSolution


class PlanSensitivity:
    """The lane problem with free weights over `nodes` steps, its exact optimum and its gradients. Not shared between threads."""

    def __init__(self, vehicle: Vehicle, neighbours: int, nodes: int) -> None:
        self.lane = LaneProblem(vehicle=vehicle, neighbours=neighbours, free_weights=True)
        self.problem = self.lane.stage_problem()
        self.nodes = nodes
        self.nlp = ExactNlp(self.problem, nodes)
        self.names = self.problem.parameters
        near, merit = self._expressions()
        w, p = self.nlp.w, self.nlp.p
        self._near = ca.Function("near", [w, p], [near])
        self._merit = ca.Function("merit", [w, p], [merit, ca.gradient(merit, w), ca.gradient(merit, p)])
        which = ca.SX.sym("which", near.numel())
        picked = ca.dot(which, near)
        self._near_slope = ca.Function("near_slope", [w, p, which], [ca.gradient(picked, w), ca.gradient(picked, p)])

    def _expressions(self) -> tuple[Any, Any]:
        """Clearance rows (nodes x neighbours) and the merit, in the unknowns and parameters of the whole horizon."""
        problem, n = self.problem, self.nodes
        nx, nu, np_ = problem.nx, problem.nu, len(problem.parameters)
        x = ca.reshape(self.nlp.w[: nx * (n + 1)], nx, n + 1)
        u = ca.reshape(self.nlp.w[nx * (n + 1) : nx * (n + 1) + nu * n], nu, n)
        p = ca.reshape(self.nlp.p[: np_ * (n + 1)], np_, n + 1)
        h = self.nlp.p[np_ * (n + 1) : np_ * (n + 1) + n]
        bodies = [i for i, row in enumerate(problem.rows) if row.startswith("neighbour")]
        start_d, amplitude = (self.names.index(name) for name in ("ref_start_d", "ref_amplitude"))
        near, merit = [], ca.SX(0.0)
        for k in range(1, n + 1):
            last = u[:, k] if k < n else ca.SX.zeros(nu)
            rows = -problem.inequality(x[:, k], last, p[:, k])[bodies]
            near.append(rows)
            lateral = lateral_acceleration(x[3, k], x[5, k], self.lane.vehicle.wheelbase_m, ca)
            rate = _ACCELERATION * x[4, k] ** 2 + _LATERAL_ACCELERATION * lateral**2
            rate += _OFF_TARGET * (x[1, k] - p[start_d, 0] - p[amplitude, 0]) ** 2
            rate += _JERK * u[0, k - 1] ** 2 + _STEERING_RATE * u[1, k - 1] ** 2
            rate += _NEARNESS * ca.sum1(ca.exp(-rows / _NEARNESS_SCALE_M))
            merit += h[k - 1] * rate
        return ca.vertcat(*near), merit

    def pack(self, x0: Array, p: Array, steps: Array) -> Array:
        """(p, h, x0) in one vector; p (N + 1, np)."""
        return np.concatenate([p.ravel(), steps, x0])

    def with_knob(self, parameters: Array, knob: str, value: float) -> Array:
        """The same problem with one knob at another value, at every node."""
        changed = parameters.copy()
        changed[self._places(knob)] = value
        return changed

    def knob(self, parameters: Array, knob: str) -> float:
        return float(parameters[self._places(knob)[0]])

    def _places(self, knob: str) -> Sequence[int]:
        column, width = self.names.index(SIGMOID.get(knob, knob)), len(self.names)
        return [k * width + column for k in range(self.nodes + 1)]

    def measured(self, parameters: Array, start: Array | StageGuess, *, gradients: bool) -> Measured:
        """One solve; with `gradients` two adjoint solves of the same matrix on top."""
        if isinstance(start, StageGuess):
            start = np.concatenate([start.x.ravel(), start.u.ravel(), start.s[1:].ravel()])
        at = self.nlp.exact_from(parameters, start)
        near = np.asarray(self._near(at.w, parameters), dtype=np.float64).ravel()
        merit, by_w, by_p = (np.asarray(part, dtype=np.float64).ravel() for part in self._merit(at.w, parameters))
        converged = at.ending is Ending.CONVERGED
        cost_by, clearance_by, merit_by = {}, {}, {}
        if gradients and converged:
            cost_by = self._by_knobs(self.nlp.cost_gradient(at))
            merit_by = self._by_knobs(self.nlp.gradient(at, by_w, by_p))
            which = np.zeros(near.size)
            which[int(np.argmin(near))] = 1.0
            slopes = (np.asarray(part, dtype=np.float64).ravel() for part in self._near_slope(at.w, parameters, which))
            clearance_by = self._by_knobs(self.nlp.gradient(at, *slopes))
        return Measured(
            converged=converged,
            cost=at.objective,
            clearance_m=float(near.min()),
            merit=float(merit[0]),
            cost_by=cost_by,
            clearance_by=clearance_by,
            merit_by=merit_by,
            solution=at,
        )

    def _by_knobs(self, gradient: Array) -> dict[str, float]:
        return {knob: float(gradient[self._places(knob)].sum()) for knob in KNOBS}
