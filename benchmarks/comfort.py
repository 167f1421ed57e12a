"""ISO 15622 (full speed range adaptive cruise control) over ordinary driving, by speed: how long is a drive beyond its limits, and by what?

    python benchmarks/comfort.py [--suite ordinary] [--scenes 20] [--seed 7] [--planners mpc,acc,idm-mobil] [--workers 1]

Limits: above 20 m/s an acceleration of 2.0, braking of 3.5 m/s^2 and jerk of 2.5 m/s^3; below 5 m/s 4.0, 5.0 and 5.0; linear in between.
Acceleration and braking are means over 2 s, jerk (of braking) over 1 s. Told for each band: the time driven there, the share of it beyond
each limit, and the greatest excess (negative: what is left to the limit).
"""

from __future__ import annotations

import argparse
import multiprocessing
from functools import partial

import numpy as np

from mcdas_opt.catalogue.scenes import Scene
from mcdas_opt.domain.rules import Array
from mcdas_opt.evaluation.suites import expand
from mcdas_opt.simulation.loop import simulate
from mcdas_opt.simulation.ordinary import ISO_TOLERANCE, beyond_iso, instants_of

BANDS_MPS = ((0.0, 5.0), (5.0, 20.0), (20.0, np.inf))
PARTS = (("acceleration", "m/s^2"), ("braking", "m/s^2"), ("jerk", "m/s^3"))


def measured(scene: Scene, planner: str) -> Array:
    """(4, n): speed [m/s] and the three excesses of `beyond_iso`, every 0.1 s."""
    instants = instants_of(simulate(scene, planner))
    t, v, a = np.array([(one.time_s, one.speed_mps, one.acceleration_mps2) for one in instants]).T
    return np.vstack([v, beyond_iso(t, v, a)])


def told(name: str, table: Array) -> list[str]:
    """A line a band."""
    lines = []
    for low, high in BANDS_MPS:
        mine = table[1:, (table[0] >= low) & (table[0] < high)]
        if mine.size:
            parts = (
                f"{part} {100 * np.mean(row > ISO_TOLERANCE):6.2f} % ({row.max():+.2f} {unit} at most)"
                for (part, unit), row in zip(PARTS, mine, strict=True)
            )
            lines.append(f"{name:<12} {low:>4.0f} to {high:<4.0f} m/s  {0.1 * mine.shape[1]:>8.1f} s  beyond: {', '.join(parts)}")
    return lines


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--suite", default="ordinary")
    parser.add_argument("--scenes", type=int, default=20)
    parser.add_argument("--seed", type=int, default=7)
    parser.add_argument("--planners", default="mpc,acc,idm-mobil")
    parser.add_argument("--workers", type=int, default=1)
    args = parser.parse_args()
    scenes = [case.scene for case in expand(args.suite, args.scenes, args.seed).cases]
    with multiprocessing.get_context("spawn").Pool(args.workers) as pool:
        for planner in args.planners.split(","):
            tables = pool.map(partial(measured, planner=planner), scenes, chunksize=1)
            print("\n".join(told(planner, np.hstack(tables))), flush=True)


if __name__ == "__main__":
    main()
