"""Laws that track plans, side by side: on every plant, with steering delays, known and unknown, with noise and with a push.

    python benchmarks/tracking.py --workers 2                                  # all: some ten minutes of two cores
    python benchmarks/tracking.py --plants dynamic --delays 0,0.1 --quick      # a look: twenty seconds

Plans are lane changes by 3.5 m at constant speed: one sine of steering, of half and of 85 % of the grip, begun on the plan and 0.2 m
beside it. The delay stands in the vehicle's file, and states are predicted to the moment at which commands take effect; "not known": the
plant has it, the loop does not know. Noise is that of the host's production sensors. The push is one to the left, by PUSH_MPS2 over PUSH_S
in the middle of the plan. Errors are those of the body centre across the plan, of all drives of a row together, from half a
second on. Chatter is the mean change of the commanded steering rate from step to step.
"""

from __future__ import annotations

import argparse
import math
import multiprocessing
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import product
from typing import NamedTuple

import numpy as np

from mcdas_opt.actuation.grip_monitor import GripMonitor
from mcdas_opt.catalogue.vehicles import load_vehicle
from mcdas_opt.domain.actuator_response import ActuatorResponse
from mcdas_opt.domain.chassis import Chassis
from mcdas_opt.domain.host import HostState, SlidingState
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.rules import Array
from mcdas_opt.domain.trajectory import Trajectory
from mcdas_opt.domain.vehicle import GRAVITY_MPS2, Vehicle
from mcdas_opt.simulation.actuators import Applied
from mcdas_opt.simulation.car import Car, PlantError
from mcdas_opt.simulation.controller import make_controller
from mcdas_opt.simulation.idm import STEP_S
from mcdas_opt.simulation.kinematic_plant import KinematicPlant
from mcdas_opt.simulation.motion_sensors import MeasuredHost, motion_sensors
from mcdas_opt.simulation.plant import make_plant

OFFSET_M = 3.5
PUSH_MPS2, PUSH_S, PUSHED_AT_S = 1.5, 0.3, 0.8
SPUN_RAD = 0.35
SETTLING_S = 0.5


class Task(NamedTuple):
    speed_mps: float
    friction: float
    share: float
    beside_m: float


@dataclass(frozen=True, kw_only=True)
class Setting:
    plant: str
    law: str
    delay_s: float
    known: bool
    disturbed: str  # "", "noise" or "push"


class Pushed:
    """A plant that is pushed aside for a while: what sensors feel, and no command explains."""

    def __init__(self, vehicle: Vehicle, road: Road, state: HostState, *, plant: str, at_s: float) -> None:
        self._make = partial(make_plant, plant, vehicle, road)
        self._inner, self._steps, self._from = self._make(state), 0, round(at_s / STEP_S)

    @property
    def state(self) -> HostState:
        return self._inner.state

    def step(self, jerk_mps3: float, steering_rate_radps: float) -> Applied:
        applied = self._inner.step(jerk_mps3, steering_rate_radps)
        self._steps += 1
        if not self._from <= self._steps < self._from + round(PUSH_S / STEP_S):
            return applied
        state, faster = self._inner.state, PUSH_MPS2 * STEP_S
        if isinstance(state, SlidingState):
            self._inner = self._make(replace(state, lateral_speed_mps=state.lateral_speed_mps + faster))
        else:
            self._inner = self._make(replace(state, heading_rad=state.heading_rad + faster / state.speed_mps))
        return replace(applied, lateral_acceleration_mps2=applied.lateral_acceleration_mps2 + PUSH_MPS2)


def lane_change(car: Vehicle, task: Task, *, slips: bool) -> Trajectory:
    """The no-slip car (about the zero-sideslip point, for one that slips), through one sine of steering and on for 1.5 s."""
    point = Chassis.of(car).zero_sideslip_point_m(task.speed_mps) if slips else 0.0
    lateral = task.share * task.friction * GRAVITY_MPS2
    period = 0.1 * round(10.0 * math.sqrt(2.0 * math.pi * OFFSET_M / lateral))
    lateral = 2.0 * math.pi * OFFSET_M / period**2
    plant = KinematicPlant(replace(car, zero_sideslip_point_m=point), Road(friction=5.0), HostState(speed_mps=task.speed_mps))
    states, inputs = [plant.state.to_vector()], []
    for k in range(round(10.0 * (period + 1.5))):
        t = 0.1 * (k + 1)
        bend = lateral / task.speed_mps**2 * math.sin(2.0 * math.pi * t / period) if t < period else 0.0
        rate = (math.atan(car.wheelbase_m * bend) - plant.state.steering_rad) / 0.1
        inputs.append((0.0, rate))
        for _ in range(10):
            plant.step(0.0, rate)
        states.append(plant.state.to_vector())
    return Trajectory.from_states(0.1 * np.arange(len(states)), np.array(states), np.array(inputs))


def tracked(setting: Setting, task: Task, vehicle: str) -> tuple[Array, float, float]:
    """(errors across the plan [m], largest sideslip [rad], chatter [rad/s])."""
    car = replace(load_vehicle(vehicle), actuators=ActuatorResponse(steering_delay_s=setting.delay_s))
    road = Road(friction=task.friction, lanes_left=2, lanes_right=2)
    plant = partial(Pushed, plant=setting.plant, at_s=PUSHED_AT_S) if setting.disturbed == "push" else setting.plant
    driven = Car(plant, car, road, HostState(speed_mps=task.speed_mps, d_m=task.beside_m))
    plan = lane_change(car, task, slips=driven.slips)
    monitor = GripMonitor(vehicle=car, believed=task.friction)
    controller = make_controller(setting.law, car, turned=driven.slips, grip=monitor)
    sensors = motion_sensors("production" if setting.disturbed == "noise" else "ideal")
    host = MeasuredHost(car, driven.state, sensors, friction=task.friction, seed=1)
    late = round(driven.delay_s / STEP_S) if setting.known else 0
    errors, slip, rates = [], 0.0, [0.0]
    for k in range(round(float(plan.t_s[-1]) / STEP_S) + late):
        state = driven.state
        now = max(k - late, 0) * STEP_S
        s, d, psi = (float(np.interp(now, plan.t_s, plan.states[:, i])) for i in range(3))
        if now >= SETTLING_S:
            errors.append(abs((state.d_m - d) * math.cos(psi) - (state.s_m - task.speed_mps * late * STEP_S - s) * math.sin(psi)))
        slip = max(slip, abs(math.atan2(state.turning(car.wheelbase_m)[0], max(state.speed_mps, 1.0))))
        monitor.note(host.state, 0.0, host.slip, host.measured_if_slips)
        seen = driven.ahead(host.state, task.friction) if setting.known else host.state
        along = task.speed_mps * late * STEP_S  # the plan begins where the first command takes effect
        jerk, rate = controller.command(plan, k * STEP_S, replace(seen, s_m=seen.s_m - along))
        rates.append(rate)
        try:
            applied = driven.step(jerk, rate)
        except PlantError:  # it turned about
            slip = math.pi
            break
        host.look(driven.state, applied)
    return np.array(errors), slip, float(np.abs(np.diff(rates)).mean())


def measured(setting: Setting, tasks: Sequence[Task], vehicle: str) -> str:
    found = [tracked(setting, task, vehicle) for task in tasks]
    errors = np.concatenate([row[0] for row in found])
    p50, p99, most = np.percentile(errors, [50, 99, 100])
    known = "" if setting.delay_s == 0.0 else "known" if setting.known else "not known"
    spun, chatter = sum(row[1] > SPUN_RAD for row in found), np.mean([row[2] for row in found])
    head = f"{setting.plant:>10} {setting.law:>18} {1e3 * setting.delay_s:>5.0f} ms {known:>9} {setting.disturbed:>5}"
    return f"{head} {p50:>7.3f} {p99:>7.3f} {most:>7.3f} {spun:>5} of {len(found)} {chatter:>8.4f}"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--plants", default="kinematic,dynamic,std,multi-body")
    parser.add_argument("--laws", default="stanley,mpc-single-track,lqr-inverse-tyre,lqr-errors")
    parser.add_argument("--disturbed", default="no,noise,push")
    parser.add_argument("--delays", default="0,0.05,0.1", help="[s]")
    parser.add_argument("--vehicle", default="bmw_320i")
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--quick", action="store_true", help="a third of the plans")
    arguments = parser.parse_args()
    tasks = [Task(*row) for row in product((15.0, 22.0, 30.0), (0.4, 0.9), (0.5, 0.85), (0.0, 0.2))][:: 3 if arguments.quick else 1]
    delays = [(float(text), known) for text in arguments.delays.split(",") for known in ((True, False) if float(text) > 0.0 else (True,))]
    settings = [
        Setting(plant=plant, law=law, delay_s=delay, known=known, disturbed="" if disturbed == "no" else disturbed)
        for plant in arguments.plants.split(",")
        for delay, known in delays
        for disturbed in arguments.disturbed.split(",")
        for law in arguments.laws.split(",")
        if known or disturbed == "no"
    ]
    print(f"{arguments.vehicle}: {len(tasks)} lane changes; errors across the plan [m], drives that spin, chatter [rad/s]")
    print(f"{'plant':>10} {'law':>18} {'delay':>8} {'':>15} {'p50':>7} {'p99':>7} {'max':>7} {'spun':>11} {'chatter':>7}")
    with multiprocessing.get_context("spawn").Pool(arguments.workers) as pool:
        for line in pool.imap(partial(measured, tasks=tasks, vehicle=arguments.vehicle), settings):
            print(line, flush=True)


if __name__ == "__main__":
    main()
