"""The observer of sideslip and friction against the truth: errors, false alarms of friction in ordinary driving, time to notice ice.

    python benchmarks/sideslip.py --hours 20 --workers 2
    python benchmarks/sideslip.py --plants dynamic --hours 0.02 --quick        # a look: some twenty seconds

Errors: one sine of steering a 1.5 s, to 40 and 80 % of the grip and beyond it, at 15 to 30 m/s, on friction 0.3 and 0.9, with friction
believed right and 1.5 times as much. "Within 2 sd" is the share of instants whose error is within two of the observer's own standard
deviations; friction counts where the monitor takes it for a sample. Ordinary driving: steering for at most 3 m/s^2 across (or 0.35 of the
grip), pedals for at most 2.5 m/s^2 (or 0.3), friction believed right; an alarm is each time at which plans are no longer made with the
belief. Ice: friction 0.2 and 0.3 where 0.9 is believed, brakes (5 m/s^2) or wheels (3 m/s^2 across, or 6) asked for more; noticed once
plans are made with at most 1.25 of what there is.
"""

from __future__ import annotations

import argparse
import math
import multiprocessing
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from itertools import product
from typing import NamedTuple

import numpy as np

from mcdas_opt.actuation.grip_monitor import INFORMED_SD, GripMonitor
from mcdas_opt.catalogue.vehicles import load_vehicle
from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.rules import Array
from mcdas_opt.domain.vehicle import GRAVITY_MPS2, Vehicle
from mcdas_opt.evaluation.statistics import Share
from mcdas_opt.simulation.idm import STEP_S
from mcdas_opt.simulation.motion_sensors import MeasuredHost, motion_sensors
from mcdas_opt.simulation.plant import make_plant

PIECE_S = 36.0  # of ordinary driving, each with its own speed, road and wishes
NOTICED = 1.25
LONGEST_S = 4.0  # on ice
STEERING_LAG_S, PEDAL_LAG_S = 0.02, 0.1


class Instant(NamedTuple):
    sideslip_rad: float
    estimate_rad: float
    sd_rad: float
    friction: float
    friction_sd: float
    planned_with: float


Wish = Callable[[float, HostState], tuple[float, float]]  # (lateral acceleration of the no-slip path, acceleration) wanted at a time


def driven(
    plant: str, sensors: str, car: Vehicle, *, friction: float, believed: float, speed: float, wish: Wish, seed: int, extra_rad: float = 0.0
) -> Iterator[Instant]:
    """Goes on until nobody asks; `extra_rad` is steered beyond the no-slip path, as its share of the most that is wanted."""
    vehicle = make_plant(plant, car, Road(friction=friction), HostState(speed_mps=speed))
    host = MeasuredHost(car, vehicle.state, motion_sensors(sensors), friction=believed, seed=seed)
    monitor = GripMonitor(vehicle=car, believed=believed)
    k = 0
    while True:
        state = vehicle.state
        across, along = wish(k * STEP_S, state)
        wheels = math.atan(car.wheelbase_m * across / max(state.speed_mps, 3.0) ** 2)
        wheels += extra_rad * across / (friction * GRAVITY_MPS2)
        jerk = (along - state.acceleration_mps2) / PEDAL_LAG_S
        monitor.note(host.state, along if jerk < -1.0 else 0.0, host.slip, host.measured_if_slips)
        host.look(vehicle.state, vehicle.step(jerk, (wheels - state.steering_rad) / STEERING_LAG_S))
        true, told, v = vehicle.state, host.slip, max(vehicle.state.speed_mps, 1.0)
        assert told is not None, plant
        yield Instant(
            math.atan2(true.turning(car.wheelbase_m)[0], v),
            math.atan2(told.lateral_speed_mps, v),
            told.lateral_speed_sd_mps / v,
            told.friction,
            told.friction_sd,
            monitor.friction,
        )
        k += 1


def weaving(share: float, friction: float) -> Wish:
    most = share * friction * GRAVITY_MPS2
    return lambda t, state: (most * math.sin(2.0 * math.pi * t / 1.5), 0.0)


def errors(plant: str, sensors: str, car: Vehicle, quick: bool) -> str:
    slip, within, felt = [], [], []
    tasks = list(product((15.0, 22.0, 30.0), (0.3, 0.9), (0.4, 0.8, 1.2), (1.0, 1.5)))[:: 4 if quick else 1]
    for n, (speed, friction, share, times) in enumerate(tasks):
        run = driven(
            plant, sensors, car, friction=friction, believed=times * friction, speed=speed, wish=weaving(share, friction), seed=n,
            extra_rad=0.05 if share > 1.0 else 0.0,
        )  # fmt: skip
        rows = np.array([next(run) for _ in range(300)])
        off = np.abs(rows[:, 0] - rows[:, 1])
        slip.append(off)
        within.append(off < 2.0 * rows[:, 2])
        felt.append(rows[rows[:, 4] <= INFORMED_SD, 3] / friction)
    p50, p99, most = np.percentile(np.concatenate(slip), [50, 99, 100])
    ratio = np.concatenate(felt)
    low, middle, high = np.percentile(ratio, [5, 50, 95]) if ratio.size else (math.nan,) * 3
    inside = 100.0 * np.concatenate(within).mean()
    return f"{p50:>8.4f} {p99:>8.4f} {most:>8.4f} {inside:>8.0f} % {low:>8.2f} {middle:>6.2f} {high:>6.2f} ({ratio.size} instants)"


def ordinary(random: np.random.Generator, friction: float, speed: float) -> Wish:
    """Sums of slow sines, scaled to what a driver asks for; the speed is kept between two thirds and four thirds."""
    across = min(3.0, 0.35 * friction * GRAVITY_MPS2) * random.uniform(0.2, 1.0)
    along = min(2.5, 0.3 * friction * GRAVITY_MPS2) * random.uniform(0.2, 1.0)
    periods, phases = random.uniform(2.5, 15.0, (2, 3)), random.uniform(0.0, 2.0 * math.pi, (2, 3))

    def wish(t: float, state: HostState) -> tuple[float, float]:
        left, ahead = np.sin(2.0 * math.pi * t / periods + phases).mean(axis=1)
        back = 0.3 * min(max(speed - state.speed_mps, -speed / 3.0), speed / 3.0)
        return across * float(left), min(max(along * float(ahead) + back, -along), min(along, 1.5))

    return wish


def alarms(piece: int, *, plant: str, sensors: str, car: Vehicle, seed: int) -> int:
    random = np.random.default_rng([seed, piece])
    friction, speed = float(random.choice([0.9, 0.9, 0.6, 0.3])), float(random.uniform(8.0, 35.0))
    wish = ordinary(random, friction, speed)
    run = driven(plant, sensors, car, friction=friction, believed=friction, speed=speed, wish=wish, seed=piece)
    lower = [next(run).planned_with < friction for _ in range(round(PIECE_S / STEP_S))]
    return sum(now and not before for before, now in zip([False, *lower], lower, strict=False))


def ice(plant: str, sensors: str, car: Vehicle, quick: bool) -> tuple[Array, int]:
    """(times until it is noticed [s], how many never were)."""
    wishes: list[Wish] = [lambda t, state: (0.0, -5.0), lambda t, state: (3.0, 0.0), lambda t, state: (6.0, 0.0)]
    found, never = [], 0
    for n, (speed, friction, wish) in enumerate(list(product((15.0, 25.0), (0.2, 0.3), wishes))[:: 3 if quick else 1]):
        run = driven(plant, sensors, car, friction=friction, believed=0.9, speed=speed, wish=wish, seed=n, extra_rad=0.02)
        noticed = next((k for k in range(round(LONGEST_S / STEP_S)) if next(run).planned_with <= NOTICED * friction), None)
        if noticed is None:
            never += 1
        else:
            found.append(noticed * STEP_S)
    return np.array(found), never


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--plants", default="dynamic,std,multi-body")
    parser.add_argument("--sensors", default="ideal,production")
    parser.add_argument("--vehicle", default="bmw_320i")
    parser.add_argument("--hours", type=float, default=1.0, help="of ordinary driving, on each plant, with the last of the sensors")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--workers", type=int, default=1)
    parser.add_argument("--quick", action="store_true", help="a quarter of the swerves, a third of the ice")
    arguments = parser.parse_args()
    car, plants, sensors = load_vehicle(arguments.vehicle), arguments.plants.split(","), arguments.sensors.split(",")
    report_errors(plants, sensors, car, arguments.quick)
    pieces = max(round(3600.0 * arguments.hours / PIECE_S), 1)
    with multiprocessing.get_context("spawn").Pool(arguments.workers) as pool:
        for plant in plants:
            task = partial(alarms, plant=plant, sensors=sensors[-1], car=car, seed=arguments.seed)
            counts = pool.map(task, range(pieces), chunksize=1)
            share = Share(k=sum(count > 0 for count in counts), n=pieces)
            hours = pieces * PIECE_S / 3600.0
            print(f"{plant:>12}: {sum(counts)} false alarms in {hours:.2f} h of ordinary driving, in {share.k} of {share.n} pieces", end="")
            print(f" (at most {100.0 * share.interval[1]:.1f} %)", flush=True)
    for plant in plants:
        times, never = ice(plant, sensors[-1], car, arguments.quick)
        p50, most = np.percentile(times, [50, 100]) if times.size else (math.nan, math.nan)
        print(f"{plant:>12}: ice noticed in {times.size} of {times.size + never}, after {p50:.2f} s (median), {most:.2f} s at most")


def report_errors(plants: Sequence[str], sensors: Sequence[str], car: Vehicle, quick: bool) -> None:
    print("error of sideslip [rad]: p50, p99, largest, within 2 sd; friction of the observer over the true one: p5, p50, p95")
    for plant, kind in product(plants, sensors):
        print(f"{plant:>12} {kind:>11} {errors(plant, kind, car, quick)}", flush=True)


if __name__ == "__main__":
    main()
