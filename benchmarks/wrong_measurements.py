"""A car that radar reports in every scan, under faults of clock, host and radar: is it met, and did the road count as watched?

    python benchmarks/wrong_measurements.py             # a minute and a half of one core
    python benchmarks/wrong_measurements.py clock-twice heading-flips
    python benchmarks/wrong_measurements.py --recorded FOLDER [fault ...]  # range rates of radar_tracks.csv there, beside host.csv

The host drives at 20 m/s, and asks for it. The car ahead is 10 m/s slower, 75 m away, or stands 120 m away. 20 s in closed loop, the
host as the plan's acceleration says. `unknown` counts the cycles, but for the first, in which the front was covered and nobody known.
"""

from __future__ import annotations

import argparse
import csv
import math
import random
import tempfile
import warnings
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

from mcdas_opt import HostState, Mounting, Planner, RadarDetection, Scan
from mcdas_opt.domain.vocabulary import Sector
from mcdas_opt.errors import MeasurementWarning
from mcdas_opt.interop.replay import replay
from mcdas_opt.interop.replay_record import Summary

CYCLE_S, CYCLES = 0.1, 200
PLACE = Mounting(x_m=2.25)


@dataclass(frozen=True, kw_only=True)
class Fault:
    """What is wrong; by default nothing."""

    clock: Callable[[int, random.Random], float] = lambda k, _: CYCLE_S * k
    place: Callable[[float], float] = lambda s_m: s_m
    rate: Callable[[float], float] = lambda rate_mps: rate_mps
    yaw_rad: float = 0.0  # of the mounting, as it is said
    heading: Callable[[int, random.Random], float] = lambda _k, _random: 0.0
    every: int = 1  # of so many scans one arrives
    period_s: float = CYCLE_S
    blind_twin: bool = False  # a second sensor of the same name, 0.5 m beside, sees nobody
    clutter: int = 0  # further returns of a scan, anywhere


def runs(rate: float) -> Callable[[int, random.Random], float]:
    return lambda k, _: 100.0 + rate * CYCLE_S * k


def noisy(centre: float, sd: float) -> Callable[[int, random.Random], float]:
    return lambda _, drawn: centre + drawn.gauss(0.0, sd)


FAULTS = {
    "none": Fault(),
    "place-never-set": Fault(place=lambda _: 0.0),
    "clock-twice": Fault(clock=runs(2.0)),
    "clock-thrice": Fault(clock=runs(3.0)),
    "clock-five-times": Fault(clock=runs(5.0)),
    "clock-half": Fault(clock=runs(0.5)),
    "clock-back": Fault(clock=runs(-0.4)),
    "clock-stands-2ms": Fault(clock=noisy(100.0, 0.002)),
    "clock-stands-4ms": Fault(clock=noisy(100.0, 0.004)),
    "clock-stands-10ms": Fault(clock=noisy(100.0, 0.010)),
    "rate-zero": Fault(rate=lambda _: 0.0),
    "rate-sign": Fault(rate=lambda rate_mps: -rate_mps),
    "rate-kmh": Fault(rate=lambda rate_mps: 3.6 * rate_mps),
    "rate-2-too-high": Fault(rate=lambda rate_mps: rate_mps + 2.0),
    "rate-3-too-high": Fault(rate=lambda rate_mps: rate_mps + 3.0),
    "rate-5-too-high": Fault(rate=lambda rate_mps: rate_mps + 5.0),
    "rate-7-too-high": Fault(rate=lambda rate_mps: rate_mps + 7.0),
    "yaw-pi": Fault(yaw_rad=math.pi),
    "period-0.5s": Fault(every=5, period_s=0.5),
    "period-said-50s": Fault(every=15, period_s=50.0),
    "one-scan-in-5": Fault(every=5),
    "one-scan-in-8": Fault(every=8),
    "one-scan-in-10": Fault(every=10),
    "two-of-one-name": Fault(blind_twin=True),
    "heading-flips": Fault(heading=lambda k, _: math.pi * (k % 2)),
    "heading-noise-0.1": Fault(heading=noisy(0.0, 0.1)),
    "heading-noise-0.3": Fault(heading=noisy(0.0, 0.3)),
    "clutter-5": Fault(clutter=5),
    "clutter-400": Fault(clutter=400),
}


def drive(fault: Fault, car_mps: float, gap_m: float) -> tuple[float | None, int, int]:
    """The speed of the contact, if there is one, in how many cycles the car was known, and in how many it was not and seemed watched."""
    planner, drawn = Planner(), random.Random(0)
    s_m, speed_mps, acceleration_mps2, known, unknown = 0.0, 20.0, 0.0, 0, 0
    for k in range(CYCLES):
        now = fault.clock(k, drawn)
        car = RadarDetection(range_m=gap_m, azimuth_rad=0.0, range_rate_mps=fault.rate(car_mps - speed_mps))
        places = [(drawn.uniform(1.0, 170.0), drawn.uniform(-0.17, 0.17), drawn.uniform(-30.0, 10.0)) for _ in range(fault.clutter)]
        others = [RadarDetection(range_m=r, azimuth_rad=phi, range_rate_mps=rate) for r, phi, rate in places]
        place = replace(PLACE, yaw_rad=fault.yaw_rad)
        scans = [Scan(sensor="r", sector=Sector.FRONT, t_s=now, mounting=place, radar=(car, *others), period_s=fault.period_s)]
        if fault.blind_twin:
            beside = Mounting(x_m=PLACE.x_m, y_m=0.5)
            scans.insert(0, Scan(sensor="r", sector=Sector.FRONT, t_s=now, mounting=beside, period_s=fault.period_s))
        host = HostState(
            s_m=fault.place(s_m), speed_mps=speed_mps, heading_rad=fault.heading(k, drawn), acceleration_mps2=acceleration_mps2
        )
        plan = planner.step([] if k % fault.every else scans, host, now, desired_speed_mps=20.0)
        known += bool(plan.situation.tracks)
        unknown += k > 0 and plan.situation.coverage.front and not plan.situation.tracks
        acceleration_mps2 = plan.command_at(0.5 * CYCLE_S).acceleration_mps2
        after_mps = max(speed_mps + acceleration_mps2 * CYCLE_S, 0.0)
        way_m, speed_mps = 0.5 * (speed_mps + after_mps) * CYCLE_S, after_mps
        s_m, gap_m = s_m + way_m, gap_m - way_m + car_mps * CYCLE_S
        if gap_m <= 0.0:
            return speed_mps - car_mps, known, unknown
    return None, known, unknown


def recorded(folder: Path, fault: Fault) -> Summary:
    """A recorded list of targets, with range rates that are wrong, tracked."""
    with tempfile.TemporaryDirectory() as made, (folder / "radar_tracks.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
        with (Path(made) / "radar.csv").open("w", newline="") as copy:
            writer = csv.DictWriter(copy, rows[0])
            writer.writeheader()
            writer.writerows(row | {"range_rate_mps": fault.rate(float(row["range_rate_mps"]))} for row in rows)
        return replay(Path(made) / "radar.csv", "radar-csv", host=folder / "host.csv", plan=False).summary


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("faults", nargs="*", metavar="fault", help="of: " + ", ".join(FAULTS))
    parser.add_argument("--recorded", type=Path, metavar="FOLDER", help="track a recording, with these faults of its range rates")
    arguments = parser.parse_args()
    if not set(arguments.faults) <= FAULTS.keys():
        parser.error("no such fault: " + ", ".join(sorted(set(arguments.faults) - FAULTS.keys())))
    warnings.simplefilter("ignore", MeasurementWarning)
    if arguments.recorded is not None:
        print("| fault | found wrong | unfollowed | front covered | tracks begun |\n" + "|---" * 5 + "|")
        for name in arguments.faults or [name for name in FAULTS if name == "none" or name.endswith("too-high")]:
            found = recorded(arguments.recorded, FAULTS[name])
            counted = [str(found.tracker[counter]) for counter in ("range_rates", "unfollowed")]
            print(f"| {name} | " + " | ".join([*counted, f"{found.covered['front']:.3f}", str(found.tracks_started)]) + " |", flush=True)
        return
    print("| fault | car ahead: contact [m/s] | known | unknown | standing: contact [m/s] | known | unknown |\n" + "|---" * 7 + "|")
    for name in arguments.faults or FAULTS:
        cells = []
        for car_mps, gap_m in ((10.0, 75.0), (0.0, 120.0)):
            contact_mps, known, unknown = drive(FAULTS[name], car_mps, gap_m)
            cells += ["none" if contact_mps is None else f"{contact_mps:.1f}", str(known), str(unknown)]
        print(f"| {name} | " + " | ".join(cells) + " |", flush=True)


if __name__ == "__main__":
    main()
