"""Drives planners through a family of scenes, labelled by the oracle, and counts.

    python benchmarks/closed_loop_suite.py sandwich --scenes 60 --seed 1 --planners mpc,closed-form-corrected --out /tmp/rows.csv

A scene is A (avoidable: the library holds a way out, starting 0.2 s after onset, safe whether the rear car brakes later or not),
C (only by knowing that it will) or U (unknown: the library holds none). Rows are one scene and planner each.
"""

from __future__ import annotations

import argparse
import contextlib
import csv
import multiprocessing
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from scipy.stats import beta

from mcdas_opt.evaluation.families import load_family
from mcdas_opt.evaluation.oracle import Avoidable, label
from mcdas_opt.simulation.loop import simulate
from mcdas_opt.simulation.record import Simulation

CLASSES = {Avoidable.YES: "A", Avoidable.BY_KNOWING: "C", Avoidable.UNKNOWN: "U"}
COLUMNS = (
    "family",
    "seed",
    "index",
    "class",
    "onset_s",
    "friction",
    "host_mps",
    "front_gap_m",
    "rear_gap_m",
    "planner",
    "outcome",
    "collided_with",
    "ended_s",
    "impact_mps",
    "modes",
    "plans",
    "fallbacks",
    "unavoidable",
    "unverified",
    "exception",
    "p50_ms",
    "p99_ms",
    "first_reason",
)


def interval(k: int, n: int, level: float = 0.95) -> tuple[float, float]:
    """Clopper and Pearson's interval (1934) of a share."""
    tail = 0.5 * (1.0 - level)
    low = float(beta.ppf(tail, k, n - k + 1)) if k > 0 else 0.0
    high = float(beta.ppf(1.0 - tail, k + 1, n - k)) if k < n else 1.0
    return low, high


def share(k: int, n: int) -> str:
    if n == 0:
        return "0/0"
    low, high = interval(k, n)
    return f"{k}/{n} = {100 * k / n:.1f} % [{100 * low:.1f}, {100 * high:.1f}]"


def rows_of(task: tuple[str, int, int, tuple[str, ...], str, str]) -> list[dict[str, Any]]:
    """Every planner through one scene, if it is of a wanted class."""
    name, seed, index, planners, plant, wanted = task
    scene = load_family(name).scene(index, seed)
    scripted = all(part.behaviour == "scripted" for part in scene.neighbour)
    verdict = label(scene) if scripted else None
    if verdict is not None and CLASSES[verdict.avoidable] not in wanted:
        return []
    places = {part.name: part.s_m or 0.0 for part in scene.neighbour}
    length = scene.vehicle.length_m
    fixed = {
        "family": name,
        "seed": seed,
        "index": index,
        "class": CLASSES[verdict.avoidable] if verdict else "-",
        "onset_s": round(verdict.onset_s, 2) if verdict else "",
        "friction": scene.road.friction,
        "host_mps": round(scene.host.speed_mps, 1),
        "front_gap_m": round(places["front"] - length, 1) if "front" in places else "",
        "rear_gap_m": round(-places["rear"] - length, 1) if "rear" in places else "",
    }
    rows = []
    for planner in planners:
        row: dict[str, Any] = fixed | {"planner": planner, "exception": ""}
        try:
            row |= _figures(simulate(scene, planner=planner, plant=plant))
        except Exception as error:  # counted, not hidden: the row tells it
            row |= {"outcome": "exception", "exception": f"{type(error).__name__}: {error}"}
        rows.append(row)
    return rows


def _figures(run: Simulation) -> dict[str, Any]:
    emergency = [cycle.plan for cycle in run.cycles if cycle.plan.status.value != "planned"]
    return {
        "outcome": run.outcome.value,
        "collided_with": run.collided_with or "",
        "ended_s": round(run.duration_s, 2),
        "impact_mps": round(run.impact_speed_mps, 1),
        "modes": " ".join(f"{t:g}:{mode}" for t, mode in run.modes),
        "plans": run.plans,
        "fallbacks": run.fallbacks,
        "unavoidable": run.unavoidable,
        "unverified": run.unverified_plans,
        "p50_ms": round(run.cycle_ms.p50, 2),
        "p99_ms": round(run.cycle_ms.p99, 2),
        "first_reason": emergency[0].reason if emergency else "",
    }


def report(rows: Sequence[dict[str, Any]], planners: Sequence[str]) -> list[str]:
    """The table, a line each."""
    lines = []
    for planner in planners:
        mine = [row for row in rows if row["planner"] == planner]
        for kind in sorted({row["class"] for row in mine}):
            of_kind = [row for row in mine if row["class"] == kind]
            safe = sum(row["outcome"] == "safe" for row in of_kind)
            lines.append(f"{planner:>22}  class {kind}: safe {share(safe, len(of_kind))}")
        unverified = sum(row.get("unverified") or 0 for row in mine)
        plans = sum(row.get("plans") or 0 for row in mine)
        thrown = sum(bool(row["exception"]) for row in mine)
        lines.append(f"{planner:>22}  unverified plans {unverified} of {plans}, exceptions {share(thrown, len(mine))}")
    return lines


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("family", nargs="?", default="sandwich", help="a shipped family or a path")
    parser.add_argument("--scenes", type=int, default=20)
    parser.add_argument("--first", type=int, default=0, help="index of the first scene")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--planners", default="mpc,closed-form-corrected,closed-form")
    parser.add_argument("--plant", default="kinematic")
    parser.add_argument("--classes", default="ACU", help="only scenes of these classes are driven")
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--out", type=Path, help="CSV of the rows")
    arguments = parser.parse_args()
    planners = tuple(arguments.planners.split(","))
    indices = range(arguments.first, arguments.first + arguments.scenes)
    tasks = [(arguments.family, arguments.seed, i, planners, arguments.plant, arguments.classes) for i in indices]
    started = time.perf_counter()
    rows: list[dict[str, Any]] = []
    with contextlib.ExitStack() as stack:
        table = None
        if arguments.out is not None:
            file = stack.enter_context(arguments.out.open("w", newline="", encoding="utf-8", buffering=1))
            table = csv.DictWriter(file, fieldnames=COLUMNS, restval="")
            table.writeheader()
        pool = stack.enter_context(multiprocessing.get_context("spawn").Pool(arguments.workers))
        for found in pool.imap(rows_of, tasks):
            rows += found
            if table is not None:
                table.writerows(found)
    for line in report(rows, planners):
        print(line)
    print(f"{arguments.scenes} scenes of {arguments.family}, seed {arguments.seed}: {time.perf_counter() - started:.0f} s")
    for row in rows:
        if row["class"] == "A" and row["outcome"] != "safe" and row["planner"] == planners[0]:
            where = f"{row['outcome']} {row.get('collided_with', '')} at {row.get('ended_s', '')} s"
            print(f"  lost: --seed {row['seed']} --first {row['index']}: {where}, {row.get('impact_mps', '')} m/s; {row.get('modes', '')}")


if __name__ == "__main__":
    main()
