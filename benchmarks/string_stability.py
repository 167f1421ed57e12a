"""A platoon of five hosts behind one leader: do swings of speed shrink from car to car?

    python benchmarks/string_stability.py [--cars 5] [--speed 25] [--planner mpc] [--quick] [--recorded FOLDER] [--out FILE.png]

One lane; every car is planned for by a planner of its own, is where its plan says a cycle later, and sees the one ahead as a track with
its exact place, speed and acceleration (`--noise`: as a radar's tracker knows them). The leader's speed swings around `--speed` by 1 m/s
(less where that would take more than 1 m/s^2) at 0.02 to 0.5 Hz; the amplitude of each car is fitted at that frequency once it has
settled. String stable: no car swings more than the one ahead, up to 1 %, in speed.

`--recorded` is a folder of recordings t, veh1_x, veh1_y, veh1_v, ...: the hosts follow the speed of vehicle 1, and beside them stands how
the recorded drivers behind it did. There the measure is the swing between 0.02 and 0.5 Hz (root of the power, less the trend and under a
Hann window: what the recording begins and ends with counts little), the same band by band, and the least and greatest speed. A swing
under 0.01 m/s is none.
"""

from __future__ import annotations

import argparse
import csv
import multiprocessing
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import pairwise
from pathlib import Path

import numpy as np

from mcdas_opt import Planner
from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.rules import Array
from mcdas_opt.domain.settings import HeadwaySettings, Settings, WarningSettings
from mcdas_opt.domain.situation import Situation
from mcdas_opt.domain.track import Coverage, Track

CYCLE_S = 0.1
FREQUENCIES_HZ = (0.02, 0.03, 0.05, 0.07, 0.1, 0.15, 0.2, 0.3, 0.4, 0.5)
QUICK_HZ = (0.03, 0.07, 0.15, 0.4)
BANDS_HZ = (0.02, 0.04, 0.07, 0.12, 0.25, 0.5)
NONE_MPS = 0.01  # a smaller swing is none
SWING_MPS, SWING_MPS2 = 1.0, 1.0
NOISE_M, NOISE_MPS, NOISE_MPS2 = 0.1, 0.1, 0.3  # of a track
TOLERANCE = 1.01
PERIODS, SETTLED = 3, 1  # periods driven, and of these not looked at


@dataclass(frozen=True, slots=True, kw_only=True)
class Platoon:
    """Speeds (cars + 1, n) [m/s], the leader's first, at times (n,) [s]; the least gap of each host [m]; cycles that were not planned."""

    t_s: Array
    speed_mps: Array
    least_gap_m: Array
    fallbacks: int


def drive(leader_mps: Array, *, cars: int = 5, planner: str = "mpc", noise: bool = False, wanted: float = 1.3, seed: int = 0) -> Platoon:
    """`cars` hosts behind a leader with these speeds, one a cycle; each begins at the time gap that it keeps."""
    settings = Settings(warning=WarningSettings(escapes=False))
    planners = [Planner(method=planner, settings=settings) for _ in range(cars)]
    rng, headway, first = np.random.default_rng(seed), HeadwaySettings(), float(leader_mps[0])
    length, road = planners[0].vehicle.length_m, Road(speed_limit_mps=60.0)
    apart = length + headway.standstill_m + headway.time_gap_s * first
    hosts = [HostState(s_m=-apart * (i + 1), speed_mps=first) for i in range(cars)]
    desired = max(wanted * float(leader_mps.max()), 5.0)
    place, least, fallbacks = 0.0, np.full(cars, np.inf), 0
    found = np.empty((cars + 1, leader_mps.size))
    for k, v in enumerate(leader_mps.tolist()):
        found[:, k] = [v, *(host.speed_mps for host in hosts)]
        a = 0.0 if k == 0 else (v - float(leader_mps[k - 1])) / CYCLE_S
        ahead, moved = (place, v, a), []
        for i, (one, host) in enumerate(zip(planners, hosts, strict=True)):
            least[i] = min(least[i], ahead[0] - host.s_m - length)
            track = _track(ahead, rng if noise else None, length)
            asked = Situation(
                time_s=round(k * CYCLE_S, 9), host=host, coverage=Coverage(), tracks=(track,), road=road, desired_speed_mps=desired
            )
            plan = one.plan(asked)
            fallbacks += plan.status.value != "planned"
            ahead = (host.s_m, host.speed_mps, host.acceleration_mps2)
            moved.append(HostState.from_vector(plan.trajectory.states[int(np.searchsorted(plan.trajectory.t_s, CYCLE_S - 1e-9))]))
        hosts, place = moved, place + v * CYCLE_S
    return Platoon(t_s=CYCLE_S * np.arange(leader_mps.size), speed_mps=found, least_gap_m=least, fallbacks=fallbacks)


def _track(ahead: tuple[float, float, float], rng: np.random.Generator | None, length_m: float) -> Track:
    s, v, a = ahead
    covariance = np.zeros((4, 4))
    if rng is not None:
        off = rng.normal(size=3)
        s, v, a = s + NOISE_M * off[0], max(v + NOISE_MPS * off[1], 0.0), a + NOISE_MPS2 * off[2]
        covariance = np.diag([NOISE_M**2, NOISE_MPS**2, 0.01, 0.01])
    sd = NOISE_MPS2
    return Track(
        id="ahead",
        s_m=s,
        d_m=0.0,
        speed_s_mps=v,
        covariance=covariance,
        length_m=length_m,
        age_s=9.0,
        acceleration_s_mps2=a,
        acceleration_s_sd_mps2=sd,
    )


def amplitudes(platoon: Platoon, frequency_hz: float) -> Array:
    """(cars + 1,): of the swing at that frequency, by least squares over what has settled [m/s]."""
    late = platoon.t_s >= SETTLED / frequency_hz
    t = platoon.t_s[late]
    basis = np.stack([np.sin(2 * np.pi * frequency_hz * t), np.cos(2 * np.pi * frequency_hz * t), np.ones_like(t), t], axis=1)
    fitted, *_ = np.linalg.lstsq(basis, platoon.speed_mps[:, late].T, rcond=None)
    return np.asarray(np.hypot(fitted[0], fitted[1]))


def swinging(frequency_hz: float, *, speed_mps: float, cars: int, planner: str, noise: bool) -> tuple[float, Array, Platoon]:
    """(frequency, amplitudes, platoon) behind a leader that swings."""
    swing = min(SWING_MPS, SWING_MPS2 / (2 * np.pi * frequency_hz))
    t = np.arange(0.0, PERIODS / frequency_hz, CYCLE_S) if frequency_hz < 0.2 else np.arange(0.0, 25.0, CYCLE_S)
    platoon = drive(speed_mps + swing * np.sin(2 * np.pi * frequency_hz * t), cars=cars, planner=planner, noise=noise)
    return frequency_hz, amplitudes(platoon, frequency_hz), platoon


def recorded(file: Path, *, planner: str, noise: bool) -> tuple[str, Array, Platoon]:
    """(name, speeds (5, n) of the recorded drivers, our platoon in place of those behind the first)."""
    with file.open(newline="") as rows:
        table = list(csv.DictReader(rows))
    t = np.array([float(row["t"]) for row in table])
    speeds = np.array([[float(row[f"veh{i}_v"]) for row in table] for i in range(1, 6)])
    moving = np.flatnonzero(speeds.min(axis=0) > 3.0)  # from where all drive until the first stands
    span = slice(int(moving[0]), int(moving[-1]) + 1)
    even = np.arange(t[span][0], t[span][-1], CYCLE_S)
    speeds = np.array([np.interp(even, t, row) for row in speeds])
    return file.stem, speeds, drive(speeds[0], planner=planner, noise=noise)


def swing_in_band(speed_mps: Array, low_hz: float = FREQUENCIES_HZ[0], high_hz: float = FREQUENCIES_HZ[-1]) -> Array:
    """(rows,): root of the power from one frequency to another, of rows of speeds [m/s], one a cycle, each less a parabola: a trend over
    the whole recording is slower than any of these frequencies, and would count in the lowest."""
    n = speed_mps.shape[-1]
    window, along = np.hanning(n), np.vander(np.linspace(-1.0, 1.0, n), 3)
    trend = along @ np.linalg.lstsq(along, speed_mps.T, rcond=None)[0]
    spectrum = np.abs(np.fft.rfft((speed_mps - trend.T) * window)) ** 2
    f = np.fft.rfftfreq(n, CYCLE_S)
    band = (f >= low_hz) & (f <= high_hz)
    return np.asarray(np.sqrt(2.0 * spectrum[:, band].sum(axis=-1) / (n * (window**2).sum())))


def by_band(name: str, speed_mps: Array) -> None:
    """Prints how rows of speeds swing in each band, and the greatest ratio of neighbours where that is a swing."""
    for low, high in pairwise(BANDS_HZ):
        swings = swing_in_band(speed_mps, low, high)
        ratios = np.where(swings[1:] > NONE_MPS, swings[1:] / swings[:-1], 0.0)
        told = " ".join(f"{one:.3f}" for one in swings)
        print(f"{name} {low:4.2f} to {high:4.2f} Hz: swings [m/s] {told}; greatest ratio {ratios.max():.3f}")


def _map(function: Callable[..., object], over: Sequence[object], workers: int) -> list[object]:
    if workers == 1:
        return [function(one) for one in over]
    with multiprocessing.get_context("spawn").Pool(workers) as pool:
        return list(pool.imap(function, over))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--cars", type=int, default=5)
    parser.add_argument("--speed", type=float, default=25.0)
    parser.add_argument("--planner", default="mpc")
    parser.add_argument("--noise", action="store_true")
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--recorded", type=Path)
    parser.add_argument("--workers", type=int, default=1)
    parser.add_argument("--out", type=Path)
    args = parser.parse_args()
    if args.recorded is not None:
        files = sorted(args.recorded.glob("*.csv"))
        if not files:
            parser.error(f"--recorded {args.recorded}: no .csv file there")
        for name, drivers, ours in _map(
            partial(recorded, planner=args.planner, noise=args.noise), files[: 1 if args.quick else None], args.workers
        ):
            for who, speeds in (("recorded drivers", drivers), ("hosts", ours.speed_mps)):
                told = ", ".join(
                    f"{one:.2f} ({v.min():.1f} to {v.max():.1f})" for one, v in zip(swing_in_band(speeds), speeds, strict=True)
                )
                print(f"{name} {who}: swing of speed [m/s] (least to greatest) {told}")
            by_band(f"{name} hosts", ours.speed_mps)
            print(f"{name} hosts: least gap {ours.least_gap_m.min():.1f} m; cycles by the fallback {ours.fallbacks}")
        return
    run = partial(swinging, speed_mps=args.speed, cars=args.cars, planner=args.planner, noise=args.noise)
    found = _map(run, QUICK_HZ if args.quick else FREQUENCIES_HZ, args.workers)
    stable = 0
    for frequency, swings, platoon in found:
        ratios = swings[1:] / swings[:-1]
        stable += bool(ratios.max() <= TOLERANCE)
        told = " ".join(f"{one:.3f}" for one in swings)
        print(f"{frequency:5.2f} Hz: swings [m/s] {told}; greatest ratio {ratios.max():.3f}; least gap {platoon.least_gap_m.min():.1f} m")
    print(f"string stable at {stable} of {len(found)} frequencies; cycles by the fallback {sum(one[2].fallbacks for one in found)}")
    if args.out is not None:
        _draw(found, args.out)


def _draw(found: Sequence[tuple[float, Array, Platoon]], file: Path) -> None:
    from matplotlib.figure import Figure

    figure = Figure(figsize=(7.0, 4.0), layout="constrained")
    axes = figure.add_subplot(xscale="log", xlabel="frequency [Hz]", ylabel="swing of speed over the leader's")
    for car in range(1, found[0][1].size):
        axes.plot([f for f, _, _ in found], [swings[car] / swings[0] for _, swings, _ in found], marker="o", label=f"car {car}")
    axes.axhline(1.0, color="0.5", linewidth=0.8)
    axes.legend()
    figure.savefig(file, dpi=120)


if __name__ == "__main__":
    main()
