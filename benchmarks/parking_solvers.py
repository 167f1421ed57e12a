"""The parking program by IPOPT (as the package does) and by fatrop (stage by stage, through CasADi): setting up, iterations, CPU seconds.

    python benchmarks/parking_solvers.py [--ratio 1.3]

fatrop (Vanroye et al., IROS 2023) wants stages x+ = F(x, u): the interval length becomes a state, changes of speed, of steering and, where
a segment ends, of that length become inputs, and so do the checks' lines. What is fixed becomes an equation.
"""

from __future__ import annotations

import argparse
import time
from typing import Any

import casadi as ca
import numpy as np

from mcdas_opt.catalogue.parking_cases import slot_case
from mcdas_opt.domain.rules import Array
from mcdas_opt.ocp import parking as program_module
from mcdas_opt.ocp.parking_blocks import INTERVAL_LOW, STATE, WEIGHTS, check, check_rows, check_unknowns, interval
from mcdas_opt.ocp.parking_records import ParkingCosts, ParkingPhysics, ParkingProgram, ParkingSolution
from mcdas_opt.planning.parking import exchange as loop
from mcdas_opt.planning.parking.park import ParkSettings, park

FORM = "half-planes"


def by_fatrop(
    program: ParkingProgram, physics: ParkingPhysics, costs: ParkingCosts, iterations: int
) -> tuple[float, float, ParkingSolution]:
    """(seconds of setting up, seconds of solving, solution)."""
    begin = time.process_time()
    n, checks = len(program.segments), program.checks
    own, own_low, own_high, numbers = check_unknowns(FORM, checks, program.nodes[checks.intervals, 2], clearance_cost=False)
    own, own_low, own_high = own[:, :2], own_low[:, :2], own_high[:, :2]
    common = ca.DM([*physics, *(getattr(costs, name) for name in WEIGHTS)])
    least, most = check_rows(FORM)
    w: list[Any] = []
    g: list[Any] = []
    guess: list[Array] = []
    lower: list[Array] = []
    upper: list[Array] = []
    low: list[float] = []
    high: list[float] = []
    equal: list[bool] = []
    cost: Any = 0.0

    def unknown(name: str, first: Array, least: Array, most: Array) -> Any:
        symbol = ca.SX.sym(name, len(first))
        w.append(symbol)
        guess.append(first)
        lower.append(least)
        upper.append(most)
        return symbol

    def rows(value: Any, least: Array, most: Array) -> None:
        g.append(value)
        low.extend(least.tolist())
        high.extend(most.tolist())
        equal.extend((least == most).tolist())

    h = program.steps[program.segments]
    z_low, z_high = program.nodes_low, program.nodes_high
    fixed = z_low == z_high
    states, inputs = [], []
    for k in range(n + 1):
        i = min(k, n - 1)
        s = int(program.segments[i])
        bound = [
            np.append(np.where(fixed[k], open_, edge), length)
            for open_, edge, length in ((-np.inf, z_low[k], program.steps_low[s]), (np.inf, z_high[k], program.steps_high[s]))
        ]
        states.append(unknown(f"x{k}", np.append(program.nodes[k], h[i]), bound[0], bound[1]))
        if k < n:
            mine = np.flatnonzero(checks.intervals == k)
            jump = k + 1 < n and program.segments[k + 1] != s
            first = np.concatenate([program.nodes[k + 1, 3:] - program.nodes[k, 3:], [h[k + 1] - h[k]] if jump else [], own[mine].ravel()])
            free = np.full(2 + int(jump), np.inf)
            inputs.append(
                (
                    unknown(f"u{k}", first, np.concatenate([-free, own_low[mine].ravel()]), np.concatenate([free, own_high[mine].ravel()])),
                    jump,
                    mine,
                )
            )
    for k in range(n + 1):
        x = states[k]
        if k < n:
            u, jump, mine = inputs[k]
            after = ca.vertcat(states[k + 1][:3], x[3] + u[0], x[4] + u[1])
            value, part = interval().value(ca.vertcat(x[:STATE], after, x[5]), ca.SX(0, 1), common)
            cost += part
            rows(value[:3], np.zeros(3), np.zeros(3))
            rows(ca.vertcat(states[k + 1][3:5] - after[3:], states[k + 1][5] - x[5] - (u[2] if jump else 0.0)), np.zeros(3), np.zeros(3))
            rows(value[3:], INTERVAL_LOW[3:], np.zeros(4))
            for place, c in enumerate(mine):
                line = u[2 + int(jump) + 2 * place :][:2]
                inside = checks.fractions[c] != 0.0
                moved = ca.vertcat(x[:STATE], _driven(x, u, physics), x[5]) if inside else x[:3]
                data = np.append(numbers[c], checks.fractions[c]) if inside else numbers[c]
                value, _ = check(FORM, bool(inside)).value(ca.vertcat(moved, line, 0.0), data, common)
                rows(value, least, most)
        if fixed[k].any():
            at = np.flatnonzero(fixed[k])
            rows(x[at.tolist()], z_low[k, at], z_low[k, at])
    nlp = {"x": ca.vertcat(*w), "f": cost, "g": ca.vertcat(*g)}
    options = {
        "structure_detection": "auto",
        "equality": equal,
        "print_time": False,
        "error_on_fail": False,
        "fatrop": {"print_level": 0, "tol": 1e-5, "max_iter": iterations, "mu_init": 1e-2},
    }
    solver = ca.nlpsol("parking_fatrop", "fatrop", nlp, options)
    ready = time.process_time()
    answer = solver(x0=np.concatenate(guess), lbx=np.concatenate(lower), ubx=np.concatenate(upper), lbg=np.array(low), ubg=np.array(high))
    done = time.process_time()
    value = np.asarray(answer["g"]).ravel()
    violation = float(np.max(np.maximum(np.array(low) - value, value - np.array(high)), initial=0.0))
    stats = solver.stats()
    found = ca.Function("states", [nlp["x"]], [ca.horzcat(*states)])(answer["x"])
    nodes = np.asarray(found).T
    steps = nodes[:-1, 5]
    return (
        ready - begin,
        done - ready,
        ParkingSolution(
            nodes[:, :5],
            steps,
            float(steps.sum()),
            violation,
            int(stats.get("iter_count", 0)),
            str(stats.get("return_status", "")),
            "fatrop",
        ),
    )


def _driven(x: Any, u: Any, physics: ParkingPhysics) -> Any:
    """Node after the interval as far as checks inside it need it: speed and steering; the pose there plays no part."""
    return ca.vertcat(x[:3], x[3] + u[0], x[4] + u[1])


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--ratio", type=float, default=1.3)
    parser.add_argument("--rounds", type=int, default=4)
    arguments = parser.parse_args()
    met: list[tuple[Any, ...]] = []
    plain = program_module.solve_parking

    def kept(program: ParkingProgram, *rest: Any, **named: Any) -> ParkingSolution:
        begin = time.process_time()
        solution = plain(program, *rest, **named)
        met.append((program, rest, named, time.process_time() - begin, solution))
        return solution

    loop.solve_parking = kept
    park(slot_case(4.5 * arguments.ratio), settings=ParkSettings(guesses=("search",), starts=1, polish_up_to=0, left_out=0))
    for number, (program, rest, named, _, _) in enumerate(met[: arguments.rounds], start=1):
        program_module._solver.cache_clear()
        begin = time.process_time()
        plain(program, *rest, **named)
        both = time.process_time() - begin
        begin = time.process_time()
        again = plain(program, *rest, **named)
        seconds = time.process_time() - begin
        print(f"round {number}: {len(program.segments)} intervals, {len(program.checks.angles)} checks")
        print(
            f"  ipopt: set up {max(both - seconds, 0.0):.3f} s, {seconds:.3f} s, {again.iterations} iterations, "
            f"{again.duration_s:.3f} s of driving, {again.status}"
        )
        try:
            ready, seconds, found = by_fatrop(program, rest[0], rest[1], rest[2])
        except RuntimeError as error:
            print(f"  fatrop: {str(error).splitlines()[-1][:160]}")
            continue
        print(
            f"  fatrop: set up {ready:.3f} s, {seconds:.3f} s, {found.iterations} iterations, {found.duration_s:.3f} s of driving, "
            f"violation {found.violation:.1e}, {found.status}"
        )


if __name__ == "__main__":
    main()
