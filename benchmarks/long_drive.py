"""A day at the wheel in one process, by two clocks at once: from t = 0, and from the Unix time 1.7e9 s. Do they decide the same?

    python -m benchmarks.long_drive [--hours 24] [--cycle 0.1] [--seed 1]

Two ESRs tell once a cycle, with noise, of a car ahead that changes its speed for ever and of one behind; the host drives what is planned by
the first clock, on a road that bends this way and that. Both planners hear the same scans, each with its own clock's time. Told every
quarter of an hour: cycles whose decisions differ (status, mode, side, candidate, warning, alert), the largest difference of the planned
places, resident memory and descriptors; at the end their slopes, as `endurance` has them.
"""

from __future__ import annotations

import argparse
import math
import os
from collections import Counter
from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from benchmarks.endurance import sample, slope
from mcdas_opt import HostState, Mounting, Plan, Planner, RadarDetection, Road, Scan, Sector, Settings

_LATENCY_S, _UNIX_S = 0.02, 1.7e9
_PLACE_M = 2.3  # of the radars, before and behind the body's centre
_TOLD_S = 900.0


class _Traffic:
    """A car ahead at 15 to 25 m/s, a minute and a half a swing, and one behind at its distance, both sensed."""

    def __init__(self, seed: int, cycle_s: float) -> None:
        self._r, self._cycle_s, self.front_m, self.rear_m = np.random.default_rng(seed), cycle_s, 50.0, -45.0

    def move(self, t_s: float, host: HostState) -> None:
        swing = math.sin(2.0 * math.pi * t_s / 90.0)
        self.front_m += self._cycle_s * (20.0 + 5.0 * swing)
        self.rear_m += self._cycle_s * max(host.speed_mps + 0.2 * (host.s_m - 45.0 - self.rear_m), 0.0)
        if not 20.0 < self.front_m - host.s_m < 120.0:  # somebody else now
            self.front_m = host.s_m + 60.0

    def scans(self, t_s: float, host: HostState, closing_mps: float) -> tuple[Scan, ...]:
        found = []
        for sector, place_m, rate_mps in ((Sector.FRONT, self.front_m, closing_mps), (Sector.REAR, self.rear_m, 0.0)):
            ahead = 1.0 if sector is Sector.FRONT else -1.0
            point = RadarDetection(
                range_m=max(abs(place_m - host.s_m) - _PLACE_M - 2.25 + 0.1 * float(self._r.normal()), 0.5),
                azimuth_rad=0.002 * float(self._r.normal()),
                range_rate_mps=rate_mps + 0.05 * float(self._r.normal()),
            )
            mounting = Mounting(x_m=ahead * _PLACE_M, yaw_rad=0.0 if sector is Sector.FRONT else math.pi)
            found.append(Scan(sensor=sector.value, sector=sector, t_s=t_s - _LATENCY_S, mounting=mounting, radar=(point,)))
        return tuple(found)


def decided(plan: Plan) -> tuple[object, ...]:
    return plan.status, plan.mode, plan.side, plan.chosen, plan.warning, plan.alert, plan.verdict.passed


def places_apart_m(plan: Plan, other: Plan) -> float:
    """Along the road, as long as both plans last."""
    shorter = min(len(plan.trajectory), len(other.trajectory))
    return float(np.abs(plan.trajectory.s_m[:shorter] - other.trajectory.s_m[:shorter]).max())


def _next(plan: Plan, cycle_s: float) -> HostState:
    driven = plan.trajectory
    names = ("s_m", "d_m", "heading_rad", "speed_mps", "acceleration_mps2", "steering_rad")
    return HostState(**{name: float(np.interp(cycle_s, driven.t_s, column)) for name, column in driven.columns().items() if name in names})


def driven(cycles: int, seed: int, cycle_s: float = 0.1) -> Iterator[tuple[Plan, Plan, HostState]]:
    """In each cycle the plans by both clocks, and where the host is after it."""
    bends = tuple((500.0 * k, 0.0008 * math.sin(0.7 * k)) for k in range(-2, round(cycles * cycle_s * 25.0 / 500.0) + 10))
    road = Road(lanes_left=1, lanes_right=1, curvature=bends)
    traffic, host = _Traffic(seed, cycle_s), HostState(speed_mps=20.0)
    settings = Settings(cycle_s=cycle_s)
    planners = {zero_s: Planner(road=road, settings=settings) for zero_s in (0.0, _UNIX_S)}
    before_m = traffic.front_m
    for k in range(cycles):
        t_s = round(k * cycle_s, 9)
        traffic.move(t_s, host)
        speed_mps, before_m = (traffic.front_m - before_m) / cycle_s, traffic.front_m
        scans = traffic.scans(0.0, host, min(max(speed_mps, 0.0), 40.0) - host.speed_mps)
        first, other = (
            planner.step([replace(scan, t_s=zero_s + t_s + scan.t_s) for scan in scans], host, zero_s + t_s)
            for zero_s, planner in planners.items()
        )
        host = _next(first, cycle_s)
        yield first, other, host


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--hours", type=float, default=24.0)
    parser.add_argument("--cycle", type=float, default=0.1, help="s")
    parser.add_argument("--seed", type=int, default=1)
    asked = parser.parse_args()
    statuses, different, apart_m, samples = Counter[str](), 0, 0.0, []
    cycles, told = round(3600.0 * asked.hours / asked.cycle), round(_TOLD_S / asked.cycle)
    for k, (first, other, host) in enumerate(driven(cycles, asked.seed, asked.cycle)):
        statuses[first.status.value] += 1
        different += decided(first) != decided(other)
        apart_m = max(apart_m, places_apart_m(first, other))
        if (k + 1) % (told // 15) == 0:
            samples.append((*sample(k + 1)[:2], float(len(os.listdir("/proc/self/fd")))))
        if (k + 1) % told == 0 or k + 1 == cycles:
            print(
                f"{(k + 1) * asked.cycle / 3600.0:.2f} h, {k + 1} cycles, s = {host.s_m / 1000.0:.1f} km: {dict(statuses)}; decisions that "
                f"differ {different}, places by at most {apart_m:.2g} m; {samples[-1][1]:.0f} KiB, {samples[-1][2]:.0f} descriptors",
                flush=True,
            )
    table = np.array(samples[len(samples) // 5 :])
    if len(table) >= 20:
        for name, column in zip(("resident [KiB]", "descriptors"), table[:, 1:].T, strict=True):
            mean, half = slope(table[:, 0], column)
            print(f"{name}: {mean:+.3f} +- {half:.3f} per 1,000 cycles")


if __name__ == "__main__":
    main()
