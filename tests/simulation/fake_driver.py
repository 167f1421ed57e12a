"""Planners that do as they are told."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.measurement import Scan
from mcdas_opt.domain.plan import Plan
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.trajectory import Trajectory
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.domain.verdict import Verdict, Violation, ViolationKind
from mcdas_opt.domain.vocabulary import Mode, Status
from mcdas_opt.simulation.driver import Driver
from mcdas_opt.simulation.kinematic_plant import KinematicPlant

FAILED = Verdict(violations=(Violation(kind=ViolationKind.FRICTION, t_s=0.0, value=9.0, limit=8.0, unit="m/s^2"),))


def plan_of(host: HostState, inputs: Sequence[tuple[float, float]], **how: Any) -> Plan:
    """A plan of 0.1 s pieces of (jerk, steering rate) from `host`, as the bicycle drives it on a straight road."""
    car = KinematicPlant(Vehicle(), Road(friction=1.5), host)
    states = [host.to_vector()]
    for jerk, rate in inputs:
        for _ in range(10):
            car.step(jerk, rate)
        states.append(car.state.to_vector())
    t = np.round(0.1 * np.arange(len(states)), 9)
    trajectory = Trajectory.from_states(t, np.array(states), np.array(inputs))
    return Plan(**{"planner": "fake", "mode": Mode.HOLD, "verdict": Verdict(), "prediction": "none", "trajectory": trajectory, **how})


class FakeDriver(Driver):
    """Replans every cycle: `inputs(host, now)` names the (jerk, steering rate) of the next second."""

    name = "fake"
    tracker = None

    def __init__(self, inputs: Any = lambda host, now: (0.0, 0.0), verdicts: Any = None, statuses: Any = None, modes: Any = None) -> None:
        self.inputs, self.verdicts, self.statuses, self.modes = inputs, verdicts, statuses, modes
        self.heard: list[tuple[float, tuple[Scan, ...]]] = []
        self.asked: list[dict[str, Any]] = []

    def step(self, measurements: Sequence[Scan], host: HostState, now: float, **asked: Any) -> Plan:
        self.heard.append((now, tuple(measurements)))
        self.asked.append({"host": host, **asked})
        how: dict[str, Any] = {"time_s": now}
        if self.verdicts:
            how["verdict"] = self.verdicts(now)
        if self.statuses:
            how["status"] = self.statuses(now)
        if self.modes:
            how["mode"] = self.modes(now)
        return plan_of(host, [self.inputs(host, now)] * 10, **how)


def braking(share: float = 1.0) -> Any:
    """Inputs that brake at `share` of 8 m/s^2 to a standstill."""

    def inputs(host: HostState, now: float) -> tuple[float, float]:
        if host.speed_mps <= 0.0:
            return 0.0, 0.0
        return float(np.clip((-8.0 * share - host.acceleration_mps2) / 0.1, -40.0, 20.0)), 0.0

    return inputs


__all__ = ["FAILED", "FakeDriver", "Mode", "Status", "braking", "plan_of"]
