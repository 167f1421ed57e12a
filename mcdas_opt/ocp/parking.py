"""The parking problem as a nonlinear program: one block per interval, everything else a parameter or a bound.

Unknown are the nodes (x, y, heading, speed, steering), the length of every interval, and a separating line for every collision check
(Boyd and Vandenberghe 2004, section 8.2; the half-plane form). Speed and steering are linear over an interval, so that the roll-out
of the solution is the solution. Gears, standstill, fixed ends and unused checks are bounds: one solver serves every case of its size.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Any, NamedTuple

import casadi as ca
import numpy as np

from mcdas_opt.domain.rules import Array

CORNERS = 4  # of the body, and of an obstacle as far as a check sees it
_STATE = 5
_CHECK = 1 + 2 * CORNERS  # parameters: fraction of the interval, vertices
_COSTS = ("time", "path", "steering", "smooth")
_COMMON = 7 + len(_COSTS)  # wheelbase, body, acceleration, steering rate, clearance, weights


@dataclass(frozen=True, slots=True, kw_only=True)
class ParkingCosts:
    """Weights of the named costs: seconds per second, per metre, per rad^2 s of steering, per rad^2 of its changes."""

    time: float = 1.0
    path: float = 0.02
    steering: float = 0.01
    smooth: float = 0.02


class ParkingPhysics(NamedTuple):
    """What the equations need of the car and of the limits."""

    wheelbase_m: float
    rear_m: float
    front_m: float
    half_width_m: float
    acceleration_mps2: float
    steering_rate_radps: float
    clearance_m: float


@dataclass(slots=True, kw_only=True)
class ParkingProgram:
    """Numbers of one program: a guess, bounds, and collision checks; n intervals, c checks in each."""

    nodes: Array  # (n + 1, 5) guess
    nodes_low: Array
    nodes_high: Array
    steps: Array  # (n,) guess of the interval lengths [s]
    steps_low: Array
    steps_high: Array
    step_change: Array  # (n - 1,) how much neighbours may differ [s]; infinite where a segment ends
    lines: Array  # (n, c, 2) guess: angle of the normal from obstacle to car, offset
    fractions: Array  # (n, c) where in the interval the check stands
    vertices: Array  # (n, c, 4, 2)
    used: Array  # (n, c) bool


@dataclass(frozen=True, slots=True)
class ParkingSolution:
    """What the solver left; `violation` is measured here, not taken from its word."""

    nodes: Array
    steps: Array
    lines: Array
    duration_s: float
    violation: float
    iterations: int
    status: str


def _interval(checks: int) -> Any:
    """The rows and the cost of one interval as a CasADi function of (z_k, z_k+1, h, lines, checks, common)."""
    z, after, h = ca.SX.sym("z", _STATE), ca.SX.sym("after", _STATE), ca.SX.sym("h")
    lines, data, common = ca.SX.sym("lines", 2 * checks), ca.SX.sym("data", _CHECK * checks), ca.SX.sym("common", _COMMON)
    wheelbase, rear, front, half, acceleration, rate, clearance = (common[i] for i in range(7))
    dv, dd = after[3] - z[3], after[4] - z[4]
    # Written with differences instead of rates, so that an interval may shrink to nothing.
    half_way = [z[3] + 0.5 * dv, z[4] + 0.5 * dd]

    def advance(fraction: Any) -> list[Any]:
        step = fraction * h
        v_mid, d_mid = z[3] + 0.5 * fraction * dv, z[4] + 0.5 * fraction * dd
        v_end, d_end = z[3] + fraction * dv, z[4] + fraction * dd
        turn = [v * ca.tan(d) / wheelbase for v, d in ((z[3], z[4]), (v_mid, d_mid), (v_end, d_end))]
        psi_mid_a = z[2] + 0.5 * step * turn[0]
        psi_mid_b = z[2] + 0.5 * step * turn[1]
        psi_end = z[2] + step * turn[1]
        x = z[0] + step / 6.0 * (z[3] * ca.cos(z[2]) + 2.0 * v_mid * (ca.cos(psi_mid_a) + ca.cos(psi_mid_b)) + v_end * ca.cos(psi_end))
        y = z[1] + step / 6.0 * (z[3] * ca.sin(z[2]) + 2.0 * v_mid * (ca.sin(psi_mid_a) + ca.sin(psi_mid_b)) + v_end * ca.sin(psi_end))
        return [x, y, z[2] + step / 6.0 * (turn[0] + 4.0 * turn[1] + turn[2])]

    rows = [after[i] - p for i, p in enumerate(advance(1.0))]
    rows += [dv - acceleration * h, -dv - acceleration * h, dd - rate * h, -dd - rate * h]
    for c in range(checks):
        fraction = data[_CHECK * c]
        x, y, psi = advance(fraction)
        angle, offset = lines[2 * c], lines[2 * c + 1]
        nx, ny = ca.cos(angle), ca.sin(angle)
        ahead, left = ca.cos(angle - psi), ca.sin(angle - psi)
        centre = nx * x + ny * y - offset - clearance
        rows += [centre + ahead * px + left * py for px in (front, rear) for py in (half, -half)]
        rows += [offset - nx * data[_CHECK * c + 1 + 2 * j] - ny * data[_CHECK * c + 2 + 2 * j] for j in range(CORNERS)]
    time, path, steering, smooth = (common[7 + i] for i in range(len(_COSTS)))
    cost = time * h + path * h * half_way[0] ** 2 / (ca.fabs(half_way[0]) + 0.05) + steering * h * half_way[1] ** 2 + smooth * dd**2
    return ca.Function("interval", [z, after, h, lines, data, common], [ca.vertcat(*rows), cost])


@lru_cache(maxsize=24)
def parking_solver(intervals: int, checks: int, max_iterations: int) -> Any:
    """The solver of one size; building it costs more than using it, so it is kept."""
    n = intervals
    nodes, steps = ca.MX.sym("nodes", _STATE, n + 1), ca.MX.sym("steps", 1, n)
    lines = ca.MX.sym("lines", 2 * checks, n)
    data, common = ca.MX.sym("data", _CHECK * checks, n), ca.MX.sym("common", _COMMON)
    rows, costs = _interval(checks).map(n)(nodes[:, :-1], nodes[:, 1:], steps, lines, data, ca.repmat(common, 1, n))
    problem = {
        "x": ca.veccat(nodes, steps, lines),
        "p": ca.veccat(data, common),
        "f": ca.sum2(costs),
        "g": ca.veccat(rows, steps[1:] - steps[:-1]),
    }
    options = {
        "print_time": False,
        "error_on_fail": False,
        "ipopt.print_level": 0,
        "ipopt.sb": "yes",
        "ipopt.max_iter": max_iterations,
        "ipopt.tol": 1e-6,
        "ipopt.constr_viol_tol": 1e-6,
        "ipopt.acceptable_tol": 1e-4,
        "ipopt.acceptable_constr_viol_tol": 1e-6,
        "ipopt.acceptable_iter": 5,
        "ipopt.mu_init": 1e-2,
        "ipopt.bound_push": 1e-3,
        "ipopt.bound_frac": 1e-3,
        "ipopt.linear_solver": "mumps",
        "ipopt.max_cpu_time": 1e6,
    }
    return ca.nlpsol("parking", "ipopt", problem, options)


def solve_parking(program: ParkingProgram, physics: ParkingPhysics, costs: ParkingCosts, max_iterations: int = 150) -> ParkingSolution:
    """Solve one program from its guess. The status is the solver's, the violation is not."""
    n, checks = program.used.shape
    solver = parking_solver(n, checks, max_iterations)
    unlimited = np.inf
    pose_rows = np.zeros((n, 3))
    rate_rows = np.full((n, 4), -unlimited)
    used = np.repeat(program.used[:, :, None], 2 * CORNERS, axis=2).reshape(n, -1)
    low = np.hstack([pose_rows, rate_rows, np.where(used, 0.0, -unlimited)])
    high = np.hstack([pose_rows, np.zeros((n, 4)), np.full(used.shape, unlimited)])
    line_used = np.repeat(program.used[:, :, None], 2, axis=2)
    lines_low = np.where(line_used, program.lines + [-1.2, -unlimited], program.lines)
    lines_high = np.where(line_used, program.lines + [1.2, unlimited], program.lines)
    data = np.concatenate([program.fractions[:, :, None], program.vertices.reshape(n, checks, -1)], axis=2)
    weights = [getattr(costs, name) for name in _COSTS]
    answer = solver(
        x0=_stacked(program.nodes, program.steps, program.lines),
        lbx=_stacked(program.nodes_low, program.steps_low, lines_low),
        ubx=_stacked(program.nodes_high, program.steps_high, lines_high),
        p=np.concatenate([data.ravel(), [*physics, *weights]]),
        lbg=np.concatenate([low.ravel(), -program.step_change]),
        ubg=np.concatenate([high.ravel(), program.step_change]),
    )
    stats = solver.stats()
    x = np.asarray(answer["x"]).ravel()
    g = np.asarray(answer["g"]).ravel()
    bounds_low, bounds_high = np.concatenate([low.ravel(), -program.step_change]), np.concatenate([high.ravel(), program.step_change])
    violation = float(np.max(np.maximum(bounds_low - g, g - bounds_high), initial=0.0)) if np.all(np.isfinite(x)) else np.inf
    nodes = x[: _STATE * (n + 1)].reshape(n + 1, _STATE)
    steps = x[_STATE * (n + 1) : _STATE * (n + 1) + n]
    return ParkingSolution(
        nodes,
        steps,
        x[_STATE * (n + 1) + n :].reshape(n, checks, 2),
        float(steps.sum()),
        violation,
        int(stats.get("iter_count", 0)),
        str(stats.get("return_status", "")),
    )


def _stacked(nodes: Array, steps: Array, lines: Array) -> Array:
    return np.concatenate([nodes.ravel(), steps.ravel(), lines.ravel()])
