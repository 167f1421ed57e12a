"""Following, and then the leader brakes: does the host hit it, and how far behind was it?

    python benchmarks/following.py --drives 200 --seed 7 --workers 2 [--planner mpc]

One lane. The host begins 1 to 3 s behind a leader of 3 to 40 m/s, wants to drive 5 to 40 % faster (at most 48 m/s), and follows for 20
to 30 s; then the leader brakes to a stop by 3 to 9 m/s^2, never beyond its grip. Friction 0.3 to 0.9, known to the host; measurements
exact or a radar's, 0, 0.1 or 0.2 s late. Counted are contacts; the time gap before the braking, its least after that (while the host
drives over 3 m/s), and the least distance left.
"""

from __future__ import annotations

import argparse
import multiprocessing
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from mcdas_opt.catalogue.scenes import Scene
from mcdas_opt.cli.progress import progress_bar
from mcdas_opt.domain.vehicle import GRAVITY_MPS2
from mcdas_opt.evaluation.statistics import Share
from mcdas_opt.simulation.loop import simulate
from mcdas_opt.simulation.record import Outcome

AFTER_S = 4.0  # driven on for, once the leader stands
FROM_MPS = 3.0  # a time gap below this speed says nothing
LATENCIES_S = (0.0, 0.1, 0.2)


@dataclass(frozen=True, slots=True, kw_only=True)
class Following:
    """One drive: what it was, and what came of it."""

    index: int
    sensor: str
    latency_s: float
    friction: float
    speed_mps: float
    braking_mps2: float
    contact: bool
    impact_mps: float
    before_s: float
    least_s: float
    left_m: float
    fallbacks: int
    plans: int


def scene(index: int, seed: int) -> tuple[Scene, float, float]:
    """(scene, when the leader brakes [s], by how much [m/s^2])"""
    rng = np.random.default_rng([seed, index])
    speed, friction = float(rng.uniform(3.0, 40.0)), float(rng.uniform(0.3, 0.9))
    wanted, gap = min(speed * float(rng.uniform(1.05, 1.4)), 48.0), max(speed * float(rng.uniform(1.0, 3.0)), 4.0)
    brakes, hard = round(float(rng.uniform(20.0, 30.0)), 1), min(float(rng.uniform(3.0, 9.0)), friction * GRAVITY_MPS2)
    document = {
        "name": f"following-{index}",
        "duration_s": brakes + speed / hard + AFTER_S,
        "seed": index,
        "road": {"friction": friction, "speed_limit_mps": 60.0},
        "host": {"speed_mps": speed, "desired_speed_mps": wanted},
        "neighbour": [
            {
                "name": "leader",
                "s_m": gap + 4.6,
                "speed_mps": speed,
                "motion": [{"start_s": brakes, "acceleration_mps2": -hard, "until_speed_mps": 0.0}],
            }
        ],
        "sensors": {"front": "delphi_esr" if index % 2 else "ideal", "latency_s": LATENCIES_S[index // 2 % len(LATENCIES_S)]},
    }
    return Scene.model_validate(document), brakes, hard


def driven(index: int, *, seed: int, planner: str) -> Following:
    """One drive of the campaign."""
    drawn, brakes_s, hard = scene(index, seed)
    drive = simulate(drawn, planner)
    leader, host = drive.neighbours[0], drive.trajectory
    n = min(len(host), len(leader.s_m))
    gap = leader.s_m[:n] - host.s_m[:n] - 0.5 * (leader.length_m + drawn.vehicle.length_m)
    speed, after = host.speed_mps[:n], host.t_s[:n] >= brakes_s
    time_gap = gap / np.maximum(speed, FROM_MPS)
    moving = after & (speed > FROM_MPS)
    return Following(
        index=index,
        sensor=drawn.sensors.front,
        latency_s=drawn.sensors.latency_s,
        friction=drawn.road.friction,
        speed_mps=float(leader.speed_mps[0]),
        braking_mps2=hard,
        contact=drive.outcome is not Outcome.SAFE,
        impact_mps=drive.impact_speed_mps,
        before_s=float(time_gap[~after][-1]),
        least_s=float(time_gap[moving].min(initial=np.inf)),
        left_m=float(gap[after].min(initial=np.inf)),
        fallbacks=drive.fallbacks + drive.unavoidable,
        plans=drive.plans,
    )


def told(name: str, drives: Sequence[Following]) -> str:
    """One line of the table."""
    contacts = Share(k=sum(one.contact for one in drives), n=len(drives))
    low, high = contacts.interval
    before, least = np.array([one.before_s for one in drives]), np.array([one.least_s for one in drives])
    return (
        f"{name:24s} contacts {contacts.k} of {contacts.n} [{100 * low:.1f}, {100 * high:.1f} %]; before {np.median(before):.2f} s"
        f" (least {before.min():.2f}); least after: median {np.median(least):.2f}, least {least.min():.2f} s;"
        f" least distance {min(one.left_m for one in drives):.2f} m"
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--drives", type=int, default=200)
    parser.add_argument("--seed", type=int, default=7)
    parser.add_argument("--workers", type=int, default=1)
    parser.add_argument("--planner", default="mpc")
    args = parser.parse_args()
    drives: list[Following] = []
    with multiprocessing.get_context("spawn").Pool(args.workers) as pool, progress_bar("drives") as progress:
        for one in pool.imap(partial(driven, seed=args.seed, planner=args.planner), range(args.drives)):
            drives.append(one)
            progress(len(drives), args.drives)
    print(told("all", drives))
    for sensor in ("ideal", "delphi_esr"):
        for latency in LATENCIES_S:
            some = [one for one in drives if (one.sensor, one.latency_s) == (sensor, latency)]
            if some:
                print(told(f"{sensor}, {latency:g} s late", some))
    share = sum(one.fallbacks for one in drives) / sum(one.plans for one in drives)
    print(f"cycles answered by the fallback: {100 * share:.2f} %")
    for one in drives:
        if one.contact:
            print(one)


if __name__ == "__main__":
    main()
