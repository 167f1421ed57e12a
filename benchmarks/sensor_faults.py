"""What doubtful tracks cost: faults of sensors and of the host's own measurements, planted one at a time and together.

    python benchmarks/sensor_faults.py --scenes 200 --seed 71 --workers 2 --out faults.csv        # a minute of one core for 12 scenes
    python benchmarks/sensor_faults.py --quick

Scenes of a suite whose scripts can be labelled are driven by `mpc` with the same seed under each condition. `safe on A` counts those that
the oracle finds avoidable; `lost` and `won` pair them with the clean run. `not of its cycle` counts cycles whose plan is the remainder of
the previous one; `doubts` counts cycles with at least one. The sides' ideal sensors of a suite have lost scans and duplicates too.
"""

from __future__ import annotations

import argparse
import csv
import multiprocessing
import os
from functools import partial
from math import radians
from pathlib import Path

from mcdas_opt.domain.vocabulary import Status
from mcdas_opt.evaluation.labels import Kind, label_scene, wants_label
from mcdas_opt.evaluation.statistics import Share
from mcdas_opt.evaluation.suites import expand
from mcdas_opt.planning.rungs.previous_plan import NAME as REMAINDER
from mcdas_opt.simulation.loop import simulate
from mcdas_opt.simulation.sensor_faults import SensorFaults

CONDITIONS: dict[str, SensorFaults | None] = {
    "clean": None,
    "duplicates": SensorFaults(duplicates=0.3),
    "ghosts": SensorFaults(ghosts=0.3),
    "false alarms": SensorFaults(false_alarms_per_scan=0.5),
    "splits": SensorFaults(reflections=4),
    "missed 10 %": SensorFaults(missed=0.1),
    "lost scans 10 %": SensorFaults(dropouts=0.1),
    "lost scans 30 %": SensorFaults(dropouts=0.3),
    "lost scans 50 %": SensorFaults(dropouts=0.5),
    "misaligned": SensorFaults(yaw_rad=radians(0.5), aside_m=0.3),
    "host errors": SensorFaults(host_speed_share=0.01, host_yaw_rate_radps=0.003),
    "all together": SensorFaults(
        reflections=4, duplicates=0.1, ghosts=0.1, false_alarms_per_scan=0.2, missed=0.05, dropouts=0.1, yaw_rad=radians(0.5), aside_m=0.3,
        host_speed_share=0.01, host_yaw_rate_radps=0.003,
    ),
}  # fmt: skip
COLUMNS = ("scene", "label", "condition", "outcome", "cycles", "fallback", "unavoidable", "remainder", "doubts", "unverified")
Row = dict[str, object]


def rows_of(index: int, *, suite: str, scenes: int, seed: int, conditions: tuple[str, ...]) -> list[Row]:
    """One scene under every condition; none where it cannot be labelled."""
    case = expand(suite, scenes, seed).cases[index]
    if not wants_label(case):
        return []
    label, found = label_scene(case.scene).kind, []
    for name in conditions:
        drive = simulate(case.scene, faults=CONDITIONS[name])
        plans = [cycle.plan for cycle in drive.cycles]
        found.append(
            {
                "scene": case.scene.name,
                "label": label.value,
                "condition": name,
                "outcome": drive.outcome.value,
                "cycles": len(plans),
                "fallback": drive.fallbacks,
                "unavoidable": drive.unavoidable,
                "remainder": sum(plan.status is Status.FALLBACK and plan.reason.startswith(REMAINDER) for plan in plans),
                "doubts": sum(bool(plan.doubts) for plan in plans),
                "unverified": drive.unverified_plans,
            }
        )
    return found


def table(rows: list[Row], conditions: tuple[str, ...]) -> list[str]:
    clean = {row["scene"]: row["outcome"] == "safe" for row in rows if row["condition"] == "clean"}
    lines = ["| condition | safe on A | | lost | won | cycles | fallback | unavoidable | not of its cycle | doubts |", "|---" * 10 + "|"]
    for name in conditions:
        mine = [row for row in rows if row["condition"] == name]
        avoidable = [row for row in mine if row["label"] == Kind.A.value]
        safe = {row["scene"]: row["outcome"] == "safe" for row in avoidable}
        share = Share(k=sum(safe.values()), n=len(safe))
        low, high = share.interval
        lost, won = (sum(clean[scene] is not was and is_safe is was for scene, is_safe in safe.items()) for was in (False, True))
        sums = [sum(int(str(row[key])) for row in mine) for key in ("cycles", "fallback", "unavoidable", "remainder", "doubts")]
        cells = [f"{share.k}/{share.n}", f"{100 * low:.0f} to {100 * high:.0f} %", str(lost), str(won), *map(str, sums)]
        lines.append(f"| {name} | " + " | ".join(cells) + " |")
    return lines


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("suite", nargs="?", default="mid-vehicle")
    parser.add_argument("--scenes", type=int, default=200)
    parser.add_argument("--seed", type=int, default=71)
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--conditions", nargs="+", choices=list(CONDITIONS), default=list(CONDITIONS))
    parser.add_argument("--out", type=Path, help="every drive as a row (CSV), written scene by scene")
    parser.add_argument("--quick", action="store_true", help="six scenes, four conditions")
    arguments = parser.parse_args()
    scenes = 6 if arguments.quick else arguments.scenes
    conditions = tuple(dict.fromkeys(["clean", *(["splits", "ghosts", "all together"] if arguments.quick else arguments.conditions)]))
    task = partial(rows_of, suite=arguments.suite, scenes=scenes, seed=arguments.seed, conditions=conditions)
    rows: list[Row] = []
    with (
        multiprocessing.get_context("spawn").Pool(arguments.workers) as pool,
        (arguments.out or Path(os.devnull)).open("w", newline="") as out,
    ):
        writer = csv.DictWriter(out, COLUMNS)
        writer.writeheader()
        for found in pool.imap(task, range(scenes)):
            rows += found
            writer.writerows(found)
            out.flush()
    print(f"{arguments.suite}, {scenes} scenes, seed {arguments.seed}\n")
    print("\n".join(table(rows, conditions)))


if __name__ == "__main__":
    main()
