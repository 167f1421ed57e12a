"""The parking problem as a nonlinear program: one block per interval and per collision check, everything else a parameter or a bound.

Unknown are the nodes (x, y, heading, speed, steering), the interval length of every segment, and a certificate for every collision check.
Speed and steering are linear over an interval, so that the roll-out of the solution is the solution. Gears, standstill and fixed ends
are bounds: one solver serves every program of its structure.
"""

from __future__ import annotations

from functools import lru_cache
from threading import get_ident
from typing import Any

import casadi as ca
import numpy as np

from mcdas_opt.domain.rules import Array
from mcdas_opt.parking.cost import ParkingCosts
from mcdas_opt.parking.program.block_derivatives import Copies, nlp_of
from mcdas_opt.parking.program.equations import COMMON, EXTRA, INTERVAL_LOW, STATE, check, check_rows, check_unknowns, interval
from mcdas_opt.parking.program.records import ParkingPhysics, ParkingProgram, ParkingSolution
from mcdas_opt.solvers.held_interrupts import held_interrupts


@lru_cache(maxsize=48)
@held_interrupts()
def _solver(
    form: str,
    segments: tuple[int, ...],
    at_nodes: tuple[int, ...],
    inside: tuple[int, ...],
    iterations: int,
    warm: bool,
    tolerance: float,
    thread: int,
) -> Any:
    """The solver of one structure, with the numbers of the case as parameters; each thread has its own, to ask how it ended."""
    del thread
    n, own = len(segments), EXTRA[form]
    k, first, last = np.arange(n), np.array(at_nodes, dtype=np.int64), np.array(inside, dtype=np.int64)
    steps = STATE * (n + 1) + np.array(segments, dtype=np.int64)
    begin = int(steps.max()) + 1
    certificates = begin + own * np.arange(len(first) + len(last))[:, None] + np.arange(own)

    def driven(at: Any) -> Any:
        return np.column_stack([STATE * at[:, None] + np.arange(2 * STATE), steps[at]])

    poses = STATE * first[:, None] + np.arange(3)
    copies = [
        Copies(interval(), driven(k)),
        Copies(check(form, False), np.column_stack([poses, certificates[: len(first)]])),
        Copies(check(form, True), np.column_stack([driven(last), certificates[len(first) :]])),
    ]
    problem, derivatives = nlp_of(copies, begin + own * (len(first) + len(last)), COMMON)
    options: Any = {
        **derivatives,
        "print_time": False,
        "error_on_fail": False,
        "ipopt.print_level": 0,
        "ipopt.sb": "yes",
        "ipopt.max_iter": iterations,
        "ipopt.tol": tolerance,
        "ipopt.constr_viol_tol": 1e-7,
        "ipopt.acceptable_iter": 0,  # "acceptable" stops on the flat side of a time-optimal valley: 15.4 s instead of 15.1 s
        "ipopt.mu_init": 1e-3 if warm else 1e-2,
        "ipopt.bound_push": 1e-4 if warm else 1e-3,
        "ipopt.bound_frac": 1e-4 if warm else 1e-3,
        "ipopt.min_refinement_steps": 0,  # one less solution with the factors: a tenth of the computing, the same iterates to 1e-8
        "ipopt.linear_solver": "mumps",
        "ipopt.max_cpu_time": 1e6,
    }
    return ca.nlpsol("parking", "ipopt", problem, options)


def solve_parking(
    program: ParkingProgram,
    physics: ParkingPhysics,
    costs: ParkingCosts,
    max_iterations: int = 150,
    warm: bool = False,
    form: str = "half-planes",
    tolerance: float = 1e-5,
) -> ParkingSolution:
    """Solve one program from its guess. The status is the solver's, the violation is measured here."""
    n, segments = len(program.segments), len(program.steps)
    checks = program.checks.only(np.argsort(program.checks.fractions != 0.0, kind="stable"))
    inside = checks.fractions != 0.0
    where, count, m = checks.intervals.tolist(), int((~inside).sum()), len(inside)
    solver = _solver(
        form, tuple(program.segments.tolist()), tuple(where[:count]), tuple(where[count:]), max_iterations, warm, tolerance, get_ident()
    )
    headings = program.nodes[checks.intervals, 2]
    own, own_low, own_high, numbers = check_unknowns(form, checks, headings, costs.clearance > 0.0)
    least, most = check_rows(form)
    low = np.concatenate([np.tile(INTERVAL_LOW, n), np.tile(least, m)])
    high = np.concatenate([np.zeros(INTERVAL_LOW.size * n), np.tile(most, m)])
    inner = np.column_stack([numbers[count:], checks.fractions[count:]])
    with held_interrupts():
        answer = solver(
            x0=_stacked(program.nodes, program.steps, own),
            lbx=_stacked(program.nodes_low, program.steps_low, own_low),
            ubx=_stacked(program.nodes_high, program.steps_high, own_high),
            p=np.concatenate([numbers[:count].ravel(), inner.ravel(), [*physics, *costs.of_the_program]]),
            lbg=low,
            ubg=high,
        )
    stats = solver.stats()
    x, g = np.asarray(answer["x"]).ravel(), np.asarray(answer["g"]).ravel()
    sound = bool(np.all(np.isfinite(x)) and np.all(np.isfinite(g)))
    violation = float(np.max(np.maximum(low - g, g - high), initial=0.0)) if sound else np.inf
    nodes = x[: STATE * (n + 1)].reshape(n + 1, STATE)
    steps = x[STATE * (n + 1) : STATE * (n + 1) + segments][program.segments]
    iterations, status = int(stats.get("iter_count", 0)), str(stats.get("return_status", ""))
    return ParkingSolution(nodes, steps, violation, iterations, status)


def _stacked(nodes: Array, steps: Array, certificates: Array) -> Array:
    return np.concatenate([nodes.ravel(), steps.ravel(), certificates.ravel()])
