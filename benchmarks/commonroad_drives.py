"""How a planner ends in CommonRoad scenarios: refused, safe, struck in front, at the side or from behind, or off the road.

    pip install 'mcdas-opt[commonroad]'
    python benchmarks/commonroad_drives.py scenarios.tar.xz --out drives.csv        # a folder or single XML files do too

One row a scenario, written as soon as it is driven. A loss has the reason of the last plan in it, a refusal the rule that was broken.
Recorded traffic does not react to the host: some losses are hits from behind by somebody who would have braked.
"""

from __future__ import annotations

import argparse
import csv
import re
import tarfile
import tempfile
import warnings
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager
from multiprocessing import get_context
from pathlib import Path

from mcdas_opt.errors import InputError
from mcdas_opt.interop.commonroad.scenario import read_scenario
from mcdas_opt.simulation.loop import simulate
from mcdas_opt.simulation.record import Outcome, Simulation

COLUMNS = ("scenario", "kind", "end", "duration_s", "of_s", "cycles", "fallback", "unavoidable", "neighbours", "p50_ms", "goal", "why")


def kind_of(text: str) -> str:
    """Urban or highway, from the scenario's own tags."""
    tags = re.search(r"<scenarioTags>(.*?)</scenarioTags>", text, re.S)
    words = set(re.findall(r"<(\w+)", tags[1]) if tags else " ".join(re.findall(r'\btags="([^"]*)"', text[:4000])).split())
    return next((name for name in ("highway", "interstate", "urban", "rural") if name in words), "other")


def end_of(drive: Simulation) -> str:
    """The outcome; of a collision also the face of the host that was struck."""
    if drive.outcome is not Outcome.COLLISION:
        return drive.outcome.value
    struck = next(other for other in drive.neighbours if other.name == drive.collided_with)
    car, last = drive.scene.vehicle, drive.trajectory
    ahead_m = float(struck.s_m[-1] - last.s_m[-1])
    if abs(ahead_m) < 0.5 * (car.length_m + struck.length_m) - 0.5:
        return "struck at the side"
    return "struck in front" if ahead_m > 0.0 else "struck from behind"


def row(path: Path, planner: str) -> dict[str, object]:
    warnings.simplefilter("ignore")  # the reader's
    found: dict[str, object] = {"scenario": path.stem, "kind": kind_of(path.read_text("utf-8"))}
    try:
        read = read_scenario(path)
    except InputError as error:
        return found | {"end": "refused", "why": f"{error.key}: {error.rule}"}
    scene = read.scene
    drive = simulate(scene, planner)
    end = end_of(drive)
    last_m = float(drive.trajectory.s_m[-1])
    if end == "safe" and drive.destination != "reached" and read.map_end_s_m is not None and last_m > read.map_end_s_m:
        end = "off the map"
    return found | {
        "end": end,
        "duration_s": round(drive.duration_s, 2),
        "of_s": scene.duration_s,
        "cycles": drive.plans,
        "fallback": drive.fallbacks,
        "unavoidable": drive.unavoidable,
        "neighbours": len(scene.neighbour),
        "p50_ms": round(drive.cycle_ms.p50, 1),
        "goal": f"off: {read.goal_is_off}" if read.goal_is_off else drive.destination,
        "why": "" if end == "safe" else f"{drive.cycles[-1].plan.status.value}: {drive.cycles[-1].plan.reason}",
    }


@contextmanager
def files(given: list[Path]) -> Iterator[list[Path]]:
    """The XML files behind archives, folders and names, in the names' order."""
    with tempfile.TemporaryDirectory() as folder:
        found: list[Path] = []
        for one in given:
            if one.is_dir():
                found += one.rglob("*.xml")
            elif one.suffix == ".xml":
                found.append(one)
            else:
                with tarfile.open(one) as archive:
                    archive.extractall(folder, filter="data")
        yield sorted([*found, *Path(folder).rglob("*.xml")], key=lambda path: path.stem)


def table(rows: list[dict[str, object]]) -> list[str]:
    kinds = sorted({str(one["kind"]) for one in rows})
    ends = ["safe", "struck in front", "struck at the side", "struck from behind", "left_road", "off the map", "refused"]
    lines = ["| | " + " | ".join([*ends, "all"]) + " |", "|---" * (len(ends) + 2) + "|"]
    for kind in [*kinds, "all"]:
        chosen = [one for one in rows if kind in ("all", one["kind"])]
        counts = Counter(str(one["end"]) for one in chosen)
        lines.append(f"| {kind} | " + " | ".join(str(counts[end]) for end in ends) + f" | {len(chosen)} |")
    cycles, fallback, unavoidable = (sum(int(str(one.get(key, 0))) for one in rows) for key in ("cycles", "fallback", "unavoidable"))
    driven = [one for one in rows if one["end"] != "refused"]
    goals = Counter(str(one.get("goal", "")).split(":")[0] or "none asked" for one in driven)
    lines += ["", f"goals of {len(driven)} driven: " + ", ".join(f"{count} {name}" for name, count in goals.most_common())]
    return [*lines, "", f"{cycles} cycles: {fallback} fallback, {unavoidable} unavoidable"]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scenarios", nargs="+", type=Path)
    parser.add_argument("--planner", default="mpc")
    parser.add_argument("--out", type=Path, default=Path("commonroad_drives.csv"))
    parser.add_argument("--workers", type=int, default=1)
    arguments = parser.parse_args()
    rows: list[dict[str, object]] = []
    with files(arguments.scenarios) as paths, arguments.out.open("w", newline="", encoding="utf-8") as out:
        writer = csv.DictWriter(out, COLUMNS, restval="")
        writer.writeheader()
        with get_context("spawn").Pool(arguments.workers, maxtasksperchild=20) as pool:
            for one in (job.get() for job in [pool.apply_async(row, (path, arguments.planner)) for path in paths]):
                rows.append(one)
                writer.writerow(one)
                out.flush()
    print("\n".join(table(rows)))


if __name__ == "__main__":
    main()
