"""The parking problem as a nonlinear program: one block per interval, everything else a parameter or a bound.

Unknown are the nodes (x, y, heading, speed, steering), the length of every interval, and a separating line for every collision check
(Boyd and Vandenberghe 2004, section 8.2; the half-plane form). Speed and steering are linear over an interval, so that the roll-out
of the solution is the solution. Gears, standstill, fixed ends and unused checks are bounds: one solver serves every case of its size.
"""

from __future__ import annotations

from dataclasses import dataclass, fields
from functools import lru_cache
from typing import Any, NamedTuple

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from mcdas_opt.domain.rules import Array

Rows = NDArray[np.int64]
CORNERS = 4  # of the body, and of an obstacle as far as a check sees it
_STATE = 5
_LINE_TURN_RAD = 1.2  # how far a separating line may turn in one solution
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
class Checks:
    """m collision checks: in which interval, where in it, against which four vertices, with which line to begin."""

    intervals: Rows  # (m,)
    fractions: Array  # (m,) 0: at the interval's first node
    vertices: Array  # (m, 4, 2)
    angles: Array  # (m,) of the normal from obstacle to car
    offsets: Array  # (m,)

    def only(self, rows: NDArray[np.bool_]) -> Checks:
        return Checks(**{f.name: getattr(self, f.name)[rows] for f in fields(self)})


@dataclass(slots=True, kw_only=True)
class ParkingProgram:
    """Numbers of one program over n intervals: a guess, bounds, and collision checks."""

    nodes: Array  # (n + 1, 5) guess
    nodes_low: Array
    nodes_high: Array
    steps: Array  # (n,) guess of the interval lengths [s]
    steps_low: Array
    steps_high: Array
    step_change: Array  # (n - 1,) how much neighbours may differ [s]; infinite where a segment ends
    checks: Checks


@dataclass(frozen=True, slots=True)
class ParkingSolution:
    """What the solver left; `violation` is measured here, not taken from its word."""

    nodes: Array
    steps: Array
    duration_s: float
    violation: float
    iterations: int
    status: str


def _advance(z: Any, after: Any, h: Any, fraction: Any, wheelbase: Any) -> list[Any]:
    """Pose after a fraction of an interval, by the classical Runge-Kutta step of the bicycle.

    Written with differences of speed and steering instead of rates, so that an interval may shrink to nothing.
    """
    step = fraction * h
    v = [z[3] + share * fraction * (after[3] - z[3]) for share in (0.0, 0.5, 1.0)]
    turn = [v[i] * ca.tan(z[4] + share * fraction * (after[4] - z[4])) / wheelbase for i, share in enumerate((0.0, 0.5, 1.0))]
    heading = [z[2], z[2] + 0.5 * step * turn[0], z[2] + 0.5 * step * turn[1], z[2] + step * turn[1]]
    along = [v[0], 2.0 * v[1], 2.0 * v[1], v[2]]
    x = z[0] + step / 6.0 * sum(w * ca.cos(psi) for w, psi in zip(along, heading, strict=True))
    y = z[1] + step / 6.0 * sum(w * ca.sin(psi) for w, psi in zip(along, heading, strict=True))
    return [x, y, z[2] + step / 6.0 * (turn[0] + 4.0 * turn[1] + turn[2])]


@lru_cache(maxsize=1)
def _interval() -> Any:
    """(z_k, z_k+1, h, common) -> equations, rates, cost of one interval."""
    z, after, h, common = ca.SX.sym("z", _STATE), ca.SX.sym("after", _STATE), ca.SX.sym("h"), ca.SX.sym("common", _COMMON)
    wheelbase, acceleration, rate = common[0], common[4], common[5]
    dv, dd = after[3] - z[3], after[4] - z[4]
    rows = [after[i] - p for i, p in enumerate(_advance(z, after, h, 1.0, wheelbase))]
    rows += [dv - acceleration * h, -dv - acceleration * h, dd - rate * h, -dd - rate * h]
    time, path, steering, smooth = (common[7 + i] for i in range(len(_COSTS)))
    v, delta = 0.5 * (z[3] + after[3]), 0.5 * (z[4] + after[4])
    cost = time * h + path * h * v**2 / (ca.fabs(v) + 0.05) + steering * h * delta**2 + smooth * dd**2
    return ca.Function("interval", [z, after, h, common], [ca.vertcat(*rows), cost])


def _check_rows(pose: list[Any], line: Any, data: Any, common: Any) -> Any:
    """Body corners beyond the line by the clearance, obstacle vertices on its other side: all at least 0."""
    _, rear, front, half, _, _, clearance = (common[i] for i in range(7))
    angle, offset = line[0], line[1]
    nx, ny = ca.cos(angle), ca.sin(angle)
    ahead, left = ca.cos(angle - pose[2]), ca.sin(angle - pose[2])
    centre = nx * pose[0] + ny * pose[1] - offset - clearance
    rows = [centre + ahead * px + left * py for px in (front, rear) for py in (half, -half)]
    rows += [offset - nx * data[2 * j] - ny * data[2 * j + 1] for j in range(CORNERS)]
    return ca.vertcat(*rows)


@lru_cache(maxsize=1)
def _node_check() -> Any:
    z, line, data, common = ca.SX.sym("z", _STATE), ca.SX.sym("line", 2), ca.SX.sym("data", 2 * CORNERS), ca.SX.sym("common", _COMMON)
    return ca.Function("node_check", [z, line, data, common], [_check_rows([z[0], z[1], z[2]], line, data, common)])


@lru_cache(maxsize=1)
def _inner_check() -> Any:
    z, after, h, fraction = ca.SX.sym("z", _STATE), ca.SX.sym("after", _STATE), ca.SX.sym("h"), ca.SX.sym("fraction")
    line, data, common = ca.SX.sym("line", 2), ca.SX.sym("data", 2 * CORNERS), ca.SX.sym("common", _COMMON)
    rows = _check_rows(_advance(z, after, h, fraction, common[0]), line, data, common)
    return ca.Function("inner_check", [z, after, h, fraction, line, data, common], [rows])


@lru_cache(maxsize=48)
def _solver(intervals: int, at_nodes: tuple[int, ...], inside: tuple[int, ...], max_iterations: int, warm: bool) -> Any:
    """The solver of one structure, with the numbers of the case as parameters. Mapped blocks make it cheap to build."""
    n, m = intervals, len(at_nodes) + len(inside)
    nodes, steps, lines = ca.MX.sym("nodes", _STATE, n + 1), ca.MX.sym("steps", 1, n), ca.MX.sym("lines", 2, m)
    data, fractions, common = ca.MX.sym("data", 2 * CORNERS, m), ca.MX.sym("fractions", 1, m), ca.MX.sym("common", _COMMON)
    rows, costs = _interval().map(n)(nodes[:, :-1], nodes[:, 1:], steps, ca.repmat(common, 1, n))
    blocks = [ca.vec(rows), ca.vec(steps[1:] - steps[:-1])]
    first = len(at_nodes)
    if at_nodes:
        here = nodes[:, list(at_nodes)]
        blocks.append(ca.vec(_node_check().map(first)(here, lines[:, :first], data[:, :first], ca.repmat(common, 1, first))))
    if inside:
        at = list(inside)
        here, then, h = nodes[:, at], nodes[:, [k + 1 for k in at]], steps[:, at]
        arguments = (here, then, h, fractions[:, first:], lines[:, first:], data[:, first:], ca.repmat(common, 1, len(at)))
        blocks.append(ca.vec(_inner_check().map(len(at))(*arguments)))
    problem = {
        "x": ca.veccat(nodes, steps, lines),
        "p": ca.veccat(data, fractions, common),
        "f": ca.sum2(costs),
        "g": ca.vertcat(*blocks),
    }
    options: Any = {
        "print_time": False,
        "error_on_fail": False,
        "ipopt.print_level": 0,
        "ipopt.sb": "yes",
        "ipopt.max_iter": max_iterations,
        "ipopt.tol": 1e-5,
        "ipopt.constr_viol_tol": 1e-7,
        "ipopt.acceptable_iter": 0,  # "acceptable" stops on the flat side of a time-optimal valley: 15.4 s instead of 15.1 s
        "ipopt.mu_init": 1e-3 if warm else 1e-2,
        "ipopt.bound_push": 1e-4 if warm else 1e-3,
        "ipopt.bound_frac": 1e-4 if warm else 1e-3,
        "ipopt.linear_solver": "mumps",
        "ipopt.max_cpu_time": 1e6,
    }
    return ca.nlpsol("parking", "ipopt", problem, options)


def solve_parking(
    program: ParkingProgram, physics: ParkingPhysics, costs: ParkingCosts, max_iterations: int = 150, warm: bool = False
) -> ParkingSolution:
    """Solve one program from its guess. The status is the solver's, the violation is measured here."""
    n = len(program.steps)
    checks = program.checks
    at_nodes, inside = checks.fractions == 0.0, checks.fractions != 0.0
    checks = Checks(
        **{f.name: np.concatenate([getattr(checks, f.name)[at_nodes], getattr(checks, f.name)[inside]]) for f in fields(checks)}
    )
    count = int(at_nodes.sum())
    where = checks.intervals.tolist()
    solver = _solver(n, tuple(where[:count]), tuple(where[count:]), max_iterations, warm)
    m = len(where)
    low = np.concatenate([np.tile([0.0] * 3 + [-np.inf] * 4, n), -program.step_change, np.zeros(2 * CORNERS * m)])
    high = np.concatenate([np.zeros(7 * n), program.step_change, np.full(2 * CORNERS * m, np.inf)])
    lines = np.column_stack([checks.angles, checks.offsets])
    room = np.array([_LINE_TURN_RAD, np.inf])
    weights = [getattr(costs, name) for name in _COSTS]
    answer = solver(
        x0=_stacked(program.nodes, program.steps, lines),
        lbx=_stacked(program.nodes_low, program.steps_low, lines - room),
        ubx=_stacked(program.nodes_high, program.steps_high, lines + room),
        p=np.concatenate([checks.vertices.ravel(), checks.fractions, [*physics, *weights]]),
        lbg=low,
        ubg=high,
    )
    stats = solver.stats()
    x, g = np.asarray(answer["x"]).ravel(), np.asarray(answer["g"]).ravel()
    sound = bool(np.all(np.isfinite(x)) and np.all(np.isfinite(g)))
    violation = float(np.max(np.maximum(low - g, g - high), initial=0.0)) if sound else np.inf
    nodes = x[: _STATE * (n + 1)].reshape(n + 1, _STATE)
    steps = x[_STATE * (n + 1) : _STATE * (n + 1) + n]
    return ParkingSolution(
        nodes, steps, float(steps.sum()), violation, int(stats.get("iter_count", 0)), str(stats.get("return_status", ""))
    )


def _stacked(nodes: Array, steps: Array, lines: Array) -> Array:
    return np.concatenate([nodes.ravel(), steps.ravel(), lines.ravel()])
