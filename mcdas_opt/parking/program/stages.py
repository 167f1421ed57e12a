"""The parking program stage by stage, for fatrop: the same equations, the same guess, the same bounds as `parking/program/nlp.py`.

fatrop (Vanroye, Sathya, De Schutter and Decré, IROS 2023) wants stages x+ = F(x, u): the interval length becomes a state; changes of speed,
of steering and, where a segment ends, of that length become inputs, and so do the checks' lines. What is fixed becomes an equation.
"""

from __future__ import annotations

from typing import Any

import casadi as ca
import numpy as np

from mcdas_opt.domain.rules import Array
from mcdas_opt.parking.cost import ParkingCosts
from mcdas_opt.parking.program.equations import EXTRA, INTERVAL_LOW, STATE, check, check_rows, check_unknowns, interval
from mcdas_opt.parking.program.records import ParkingPhysics, ParkingProgram, ParkingSolution
from mcdas_opt.solvers.held_interrupts import held_interrupts

_FORM = "half-planes"


class Stages:
    """One program as fatrop reads it. Only half-planes, and no clearance cost, which would take one unknown a check more."""

    def __init__(self, program: ParkingProgram, physics: ParkingPhysics, costs: ParkingCosts, iterations: int, warm: bool = False) -> None:
        self.unknowns: list[Any] = []
        self.rows: list[Any] = []
        self.guess: list[Array] = []
        self.bounds: tuple[list[Array], list[Array]] = ([], [])
        self.limits: tuple[list[Array], list[Array]] = ([], [])
        self.states: list[Any] = []
        self.cost: Any = 0.0
        self.common = ca.DM([*physics, *costs.of_the_program])
        self._pose(program)
        problem = {"x": ca.vertcat(*self.unknowns), "f": self.cost, "g": ca.vertcat(*self.rows)}
        low, high = (np.concatenate(side) for side in self.limits)
        options: Any = {
            "structure_detection": "auto",
            "equality": (low == high).tolist(),
            "print_time": False,
            "error_on_fail": False,
            "fatrop": {"print_level": 0, "tol": 1e-5, "max_iter": iterations, "mu_init": 1e-3 if warm else 1e-2},
        }
        self.solver: Any = ca.nlpsol("parking_stages", "fatrop", problem, options)
        self.found: Any = ca.Function("states", [problem["x"]], [ca.horzcat(*self.states)])

    def solve(self) -> ParkingSolution:
        low, high = (np.concatenate(side) for side in self.limits)
        lbx, ubx = (np.concatenate(side) for side in self.bounds)
        with held_interrupts():
            answer = self.solver(x0=np.concatenate(self.guess), lbx=lbx, ubx=ubx, lbg=low, ubg=high)
        g, x = np.asarray(answer["g"]).ravel(), np.asarray(answer["x"]).ravel()
        sound = bool(np.all(np.isfinite(g)) and np.all(np.isfinite(x)))
        lacking = np.concatenate([low - g, g - high, lbx - x, x - ubx])
        violation = float(np.max(lacking, initial=0.0)) if sound else np.inf
        nodes = np.asarray(self.found(answer["x"])).T
        steps, stats = nodes[:-1, STATE], self.solver.stats()
        iterations, status = int(stats.get("iter_count", 0)), str(stats.get("return_status", ""))
        return ParkingSolution(nodes[:, :STATE], steps, violation, iterations, status)

    def _unknown(self, name: str, guess: Array, low: Array, high: Array) -> Any:
        symbol = ca.SX.sym(name, len(guess))
        self.unknowns.append(symbol)
        self.guess.append(guess)
        for side, edge in zip(self.bounds, (low, high), strict=True):
            side.append(edge)
        return symbol

    def _rows(self, value: Any, low: Array, high: Array) -> None:
        self.rows.append(value)
        for side, edge in zip(self.limits, (low, high), strict=True):
            side.append(edge)

    def _pose(self, program: ParkingProgram) -> None:
        n, checks = len(program.segments), program.checks
        own, own_low, own_high, numbers = check_unknowns(_FORM, checks, program.nodes[checks.intervals, 2], clearance_cost=False)
        each = EXTRA[_FORM] - 1
        h, fixed = program.steps[program.segments], program.nodes_low == program.nodes_high
        inputs: list[tuple[Any, bool, Any]] = []
        for k in range(n + 1):
            i = min(k, n - 1)
            s = int(program.segments[i])
            low = np.append(np.where(fixed[k], -np.inf, program.nodes_low[k]), program.steps_low[s])
            high = np.append(np.where(fixed[k], np.inf, program.nodes_high[k]), program.steps_high[s])
            self.states.append(self._unknown(f"x{k}", np.append(program.nodes[k], h[i]), low, high))
            if k < n:
                mine = np.flatnonzero(checks.intervals == k)
                jump = k + 1 < n and bool(program.segments[k + 1] != s)
                change = program.nodes[k + 1, 3:] - program.nodes[k, 3:]
                first = np.concatenate([change, [h[k + 1] - h[k]] if jump else [], own[mine, :each].ravel()])
                free = np.full(2 + int(jump), np.inf)
                low, high = (np.concatenate([sign * free, edge[mine, :each].ravel()]) for sign, edge in ((-1.0, own_low), (1.0, own_high)))
                inputs.append((self._unknown(f"u{k}", first, low, high), jump, mine))
        least, most = check_rows(_FORM)
        for k, x in enumerate(self.states):
            if k < n:
                u, jump, mine = inputs[k]
                driven = ca.vertcat(self.states[k + 1][:3], x[3:STATE] + u[:2])
                value, part = interval().value(ca.vertcat(x[:STATE], driven, x[STATE]), ca.SX(0, 1), self.common)
                self.cost += part
                self._rows(value[:3], np.zeros(3), np.zeros(3))
                length = self.states[k + 1][STATE] - x[STATE] - (u[2] if jump else 0.0)
                self._rows(ca.vertcat(self.states[k + 1][3:STATE] - driven[3:], length), np.zeros(3), np.zeros(3))
                self._rows(value[3:], INTERVAL_LOW[3:], np.zeros(4))
                for place, c in enumerate(mine):
                    line = u[2 + int(jump) + each * place :][:each]
                    inside = bool(checks.fractions[c] != 0.0)
                    after = ca.vertcat(x[:3], x[3:STATE] + u[:2])  # the pose there plays no part on the path to a place inside
                    moved = ca.vertcat(x[:STATE], after, x[STATE]) if inside else x[:3]
                    data = np.append(numbers[c], checks.fractions[c]) if inside else numbers[c]
                    value, _ = check(_FORM, inside).value(ca.vertcat(moved, line, 0.0), data, self.common)
                    self._rows(value, least, most)
            if fixed[k].any():
                at = np.flatnonzero(fixed[k])
                self._rows(x[at.tolist()], program.nodes_low[k, at], program.nodes_low[k, at])
