"""Records what the planner answers, and compares two records: the net under a change that must leave every plan the same.

    python benchmarks/same_plans.py scenes FOLDER [--count 150]
    python benchmarks/same_plans.py record OUT.jsonl [--situations 10000] [--drives 300] [--parking 40] [--scenes FOLDER] [--workers 2]
                                                     [--every N] [--part K/N]
    python benchmarks/same_plans.py compare A.jsonl B.jsonl [--plans-only] [--common] [--show 5]

`scenes` writes scenes of every suite as files, to be driven by both sides. `record` asks: random situations and short sequences of every
family (`random_traffic.py`), the planner and the baselines; drives through the scenes on both plants; parking cases. Stopped at any
moment, the same command goes on where it was. It runs on any version of the package that Python finds first: to record other code, call
this file by its path with PYTHONPATH set to that code. The environment decides the form: `MCDAS_OPT_COMPILE=0` records the interpreted
one; with `--every 20` it asks about one item in twenty.

`compare` prints for each group and field how many of n are equal, and the first that differ; it exits with 1 if any does. Fields of words
(reasons, refusals, names of violations) stand apart from those of plans: `--plans-only` leaves them out. With `--common` items that only
one record holds are no difference.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import multiprocessing
import sys
import tempfile
import time
import zlib
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
from random_traffic import BASELINES, KINDS, Episode, ask, episodes  # beside this file, which is run by its path

import mcdas_opt
from mcdas_opt import Planner, load_parking_case, load_scene, park, simulate

PLANTS = ("kinematic", "dynamic")
PARKERS = ("nlp", "search", "closed-form", "closed-form-corrected", "two-arc")
COLUMNS = ("t_s", "s_m", "d_m", "heading_rad", "speed_mps", "acceleration_mps2", "steering_rad", "steering_rate_radps", "jerk_mps3")
WORDS = ("reason", "verdict words", "refusals", "closed by", "prediction", "solver", "keys", "notes")
_SHIPPED_CASES = ("parallel", "parallel-tight", "perpendicular", "diagonal", "leaving")

Fields = dict[str, Any]
Item = tuple[str, str, Any]  # key, kind of question, what to ask


def digest(value: Any) -> str:
    """16 hexadecimal digits of an array's bytes, of floats to the last bit, of texts."""
    found = hashlib.blake2b(digest_size=8)
    found.update(value.tobytes() if isinstance(value, np.ndarray) else repr(value).encode())
    return found.hexdigest()


def fields_of(plan: Any) -> Fields:
    """Of a plan, each on its own: words, numbers and bytes."""
    document = plan.to_dict()
    drive = plan.trajectory
    tried = document["candidates"]
    violations = document["verdict"]["violations"]
    ways = {name: way for name, way in (document.get("escapes") or {}).items() if isinstance(way, dict)}
    return {
        "trajectory": digest(np.array([getattr(drive, name) for name in COLUMNS])),
        "end": [float(drive.t_s[-1]), float(drive.s_m[-1]), float(drive.d_m[-1]), float(drive.speed_mps[-1])],
        "status": str(plan.status),
        "mode": str(plan.mode),
        "side": str(plan.side),
        "chosen": plan.chosen,
        "alert": [document["alert"], document["warning"], document["literal_mode"]],
        "candidates": digest([one["name"] for one in tried]),
        "costs": digest([one["cost"] for one in tried]),
        "passed": digest([one["passed"] for one in tried]),
        "refusals": digest([one["refusal"] for one in tried]),
        "iterations": plan.iterations,
        "time to react": digest([[name, *(way[key] for key in sorted(way) if key != "closed_by")] for name, way in ways.items()]),
        "closed by": digest([way["closed_by"] for way in ways.values()]),
        "safe end": digest(document["safe_end"]),
        "verdict": digest([document["verdict"]["passed"], *([one["t_s"], one["value"], one["limit"]] for one in violations)]),
        "verdict words": digest([[one["name"], one["unit"]] for one in violations]),
        "reason": digest(plan.reason),
        "prediction": plan.prediction,
        "solver": plan.solver,
        "keys": digest(sorted(document)),
    }


def _raised(error: Exception) -> Fields:
    return {"raised": f"{type(error).__name__}: {error}"[:200]}


# --- what is asked ---------------------------------------------------------------------------------------------------------------------


def items(situations: int, drives: int, cases: int, scenes: Path | None) -> Iterator[Item]:
    """Everything that is asked, in a fixed order."""
    for family in KINDS:
        for one in episodes(family, -(-situations // len(KINDS))) if situations else ():
            yield f"situations {one.name}", "episode", one
    found = sorted(str(path) for path in scenes.glob("*.toml")) if scenes is not None else []
    for k in range(drives if found else 0):
        path, plant = found[k // 2 % len(found)], PLANTS[k % 2]
        method = BASELINES[k // 12 % len(BASELINES)] if k // 2 % 6 == 5 else "mpc"
        yield f"drives {Path(path).stem.rsplit('-', 2)[0]}/{Path(path).stem}, {plant}, {method}, {k}", "drive", (path, plant, method)
    for k, (name, text, parker) in enumerate(parking_cases(cases)):
        yield f"parking {parker}/{k} {name}", "parking", (name, text, parker)


def parking_cases(count: int) -> Iterator[tuple[str, str | None, str]]:
    """(name, the file's text or None for a shipped case, planner): shipped cases, slots of every length, random starts, leaving."""
    r = np.random.default_rng(7)
    for k in range(count):
        parker = PARKERS[k % len(PARKERS)] if k % 2 else PARKERS[0]
        if k < len(_SHIPPED_CASES):
            yield _SHIPPED_CASES[k], None, parker
            continue
        length, depth, street = 4.5 * r.uniform(1.15, 2.2), r.uniform(2.0, 2.4), r.uniform(3.8, 6.0)
        slot = f"[slot]\nlength_m = {length!r}\ndepth_m = {depth!r}\nstreet_m = {street!r}\n"
        x, y, psi = r.uniform(-2.0, length + 4.0), r.uniform(1.2, street - 1.2), r.uniform(-0.3, 0.3)
        ends = f"[start]\nx_m = {x!r}\ny_m = {y!r}\nheading_rad = {psi!r}\n" if k % 3 else ""
        yield f"slot {length:.2f} m", slot + ends, parker


# --- answers ---------------------------------------------------------------------------------------------------------------------------


def _episode(key: str, one: Episode) -> Iterator[tuple[str, Fields]]:
    try:
        planner = Planner(vehicle=one.vehicle, method=one.method)  # new, so that no answer depends on what was asked before
        for cycle, (_, plan) in enumerate(ask(one, planner)):
            yield f"{key}.{cycle}", fields_of(plan)
    except Exception as error:
        yield f"{key}.raised", _raised(error)


def _drive(key: str, asked: tuple[str, str, str]) -> Iterator[tuple[str, Fields]]:
    path, plant, method = asked
    try:
        drive = simulate(load_scene(path), planner=method, plant=plant)
    except Exception as error:
        yield key, _raised(error)
        return
    document = drive.to_dict()
    plans = [fields_of(cycle.plan) for cycle in drive.cycles]
    columns = np.array([document["trajectory"][name] for name in COLUMNS])
    numbers = ("impact_speed_mps", "min_clearance_m", "min_ttc_front_s", "min_ttc_rear_s", "max_lateral_acceleration_mps2", "max_jerk_mps3")
    yield (
        key,
        {
            "trajectory": digest(columns),
            "outcome": [document["outcome"], document["collided_with"], document["duration_s"], document["lane_change_completed"]],
            "modes": digest(document["modes"]),
            "figures": digest([document[name] for name in numbers]),
            "counts": [document[name] for name in ("plans", "fallbacks", "unavoidable", "unverified_plans")],
            "keys": digest(sorted(document)),
            **{f"plans' {name}": digest([plan[name] for plan in plans]) for name in plans[0]},
        },
    )


def _parking(key: str, asked: tuple[str, str | None, str]) -> Iterator[tuple[str, Fields]]:
    name, text, parker = asked
    try:
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder) / "case.toml"
            if text is not None:
                file.write_text(text)
            answer = park(load_parking_case(name if text is None else file), planner=parker)
    except Exception as error:
        yield key, {"raised": type(error).__name__}  # its message may name the temporary file
        return
    document = answer.to_dict()
    drive = document["trajectory"] or {}
    violations = document["verdict"]["violations"]
    tried = document["attempts"]
    yield (
        key,
        {
            "trajectory": digest(drive),
            "status": document["status"],
            "figures": [document[name] for name in ("duration_s", "path_m", "gear_changes", "min_clearance_m")],
            "work": [document["nodes"], document["iterations"]],
            "attempts": digest([[one["name"], one["duration_s"], one["gear_changes"], one["passed"]] for one in tried]),
            "verdict": digest([document["verdict"]["passed"], *([one["t_s"], one["value"], one["limit"]] for one in violations)]),
            "verdict words": digest([[one["name"], one["unit"]] for one in violations]),
            "reason": digest(document["reason"]),
            "notes": digest([document["notes"], *(one["note"] for one in tried)]),
            "keys": digest(sorted(document)),
        },
    )


_ANSWERS: dict[str, Callable[[str, Any], Iterator[tuple[str, Fields]]]] = {"episode": _episode, "drive": _drive, "parking": _parking}


def _answer(item: Item) -> tuple[str, float, list[tuple[str, Fields]]]:
    """The item's key, seconds of processor, and what was answered."""
    key, kind, asked = item
    started = time.process_time()
    found = list(_ANSWERS[kind](key, asked))
    return key, time.process_time() - started, found


# --- records ---------------------------------------------------------------------------------------------------------------------------


def record(out: Path, asked: list[Item], workers: int) -> None:
    """Appends a line for each item as it is done; items that the file holds are not asked again."""
    source = str(Path(mcdas_opt.__file__).parent)
    done = {line["item"] for line in _lines(out)} if out.is_file() else set()
    left = [item for item in asked if item[0] not in done]
    print(f"{source}: {len(asked)} items, {len(asked) - len(left)} of them already in {out}", file=sys.stderr)
    spent: dict[str, float] = {}
    counts: dict[str, int] = {}
    started = time.time()
    with out.open("a") as file, multiprocessing.get_context("spawn").Pool(workers) as pool:
        for n, (key, seconds, found) in enumerate(pool.imap_unordered(_answer, left, chunksize=1), start=1):
            file.write(json.dumps({"item": key, "answers": dict(found)}) + "\n")
            file.flush()
            group = key.split()[0]
            spent[group] = spent.get(group, 0.0) + seconds
            counts[group] = counts.get(group, 0) + len(found)
            if n % 500 == 0:
                print(f"... {n} of {len(left)} items, {time.time() - started:.0f} s", file=sys.stderr, flush=True)
    for group, seconds in spent.items():
        print(f"{group}: {counts[group]} answers, {seconds:.0f} s of processor, {1e3 * seconds / counts[group]:.1f} ms each")


def _lines(path: Path) -> Iterator[dict[str, Any]]:
    """What the record holds; a last line that was cut off is left out."""
    with path.open() as file:
        for line in file:
            if line.endswith("\n"):
                yield json.loads(line)


def compare(a: Path, b: Path, *, plans_only: bool, common: bool, show: int) -> bool:
    """Prints k of n equal for each group and field, then the first that differ. True when all are."""
    ours, theirs = ({key: fields for line in _lines(path) for key, fields in line["answers"].items()} for path in (a, b))
    both = [key for key in ours if key in theirs]
    alone = {path.name: [key for key in one if key not in other] for path, one, other in ((a, ours, theirs), (b, theirs, ours))}
    groups: dict[str, dict[str, list[str]]] = {}
    sizes: dict[tuple[str, str], int] = {}
    same_items: dict[str, list[int]] = {}
    for key in sorted(both):
        group = key.split("/")[0]
        mine, other = ours[key], theirs[key]
        names = [name for name in dict.fromkeys([*mine, *other]) if not (plans_only and _is_words(name))]
        differing = [name for name in names if mine.get(name) != other.get(name)]
        for name in names:
            sizes[group, name] = sizes.get((group, name), 0) + 1
        for name in differing:
            groups.setdefault(group, {}).setdefault(name, []).append(key)
        kept = same_items.setdefault(group, [0, 0])
        kept[0] += not differing
        kept[1] += 1
    width = max((len(group) for group in same_items), default=0)
    for group, (k, n) in same_items.items():
        print(f"{group:<{width}}  {k} of {n} equal")
        for name, keys in groups.get(group, {}).items():
            n_field = sizes[group, name]
            print(f"{'':<{width}}    {name}{' (words)' if _is_words(name) else ''}: {n_field - len(keys)} of {n_field}; first: {keys[0]}")
    differing_items = list(dict.fromkeys(key for fields in groups.values() for keys in fields.values() for key in keys))
    for key in differing_items[:show]:
        print(f"\n{key}")
        for name in dict.fromkeys([*ours[key], *theirs[key]]):
            if ours[key].get(name) != theirs[key].get(name):
                print(f"    {name}: {ours[key].get(name)} | {theirs[key].get(name)}")
    for name, keys in alone.items():
        if keys:
            print(f"only in {name}: {len(keys)} answers, as {keys[0]}")
    equal, total = (sum(column) for column in zip(*same_items.values(), strict=True)) if same_items else (0, 0)
    print(f"\nall together: {equal} of {total} equal")
    return equal == total > 0 and (common or not any(alone.values()))


def _is_words(name: str) -> bool:
    return name.removeprefix("plans' ") in WORDS


def write_scenes(folder: Path, count: int) -> None:
    """`count` scenes of every suite that needs no recordings, each as one TOML file, half as long as they are."""
    from mcdas_opt.catalogue.scene_file import scene_file
    from mcdas_opt.evaluation.families import shipped_suites
    from mcdas_opt.evaluation.suites import expand

    folder.mkdir(parents=True, exist_ok=True)
    suites = [name for name in shipped_suites() if name != "recorded"]
    for suite in suites:
        for k, case in enumerate(expand(suite, scenes=-(-count // len(suites)), seed=11).cases):
            text = scene_file(case.scene.model_copy(update={"duration_s": min(case.scene.duration_s, 5.0)}))
            (folder / f"{suite}-{k:03d}-x.toml").write_text(text)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    commands = parser.add_subparsers(dest="command", required=True)
    scenes = commands.add_parser("scenes")
    scenes.add_argument("folder", type=Path)
    scenes.add_argument("--count", type=int, default=150)
    recording = commands.add_parser("record")
    recording.add_argument("out", type=Path)
    recording.add_argument("--situations", type=int, default=10_000, help="plans of random situations and sequences")
    recording.add_argument("--drives", type=int, default=300)
    recording.add_argument("--parking", type=int, default=40)
    recording.add_argument("--scenes", type=Path, metavar="FOLDER", help="what `scenes` wrote; without it nothing is driven")
    recording.add_argument("--workers", type=int, default=2)
    recording.add_argument("--every", type=int, default=1, metavar="N", help="ask about one item in N, always the same ones")
    recording.add_argument("--part", default="1/1", metavar="K/N", help="the Kth of N parts of the items")
    comparing = commands.add_parser("compare")
    comparing.add_argument("a", type=Path)
    comparing.add_argument("b", type=Path)
    comparing.add_argument("--plans-only", action="store_true", help="leave words out")
    comparing.add_argument("--common", action="store_true", help="only what both records hold")
    comparing.add_argument("--show", type=int, default=5)
    given = parser.parse_args()
    if given.command == "scenes":
        write_scenes(given.folder, given.count)
        return 0
    if given.command == "compare":
        return 0 if compare(given.a, given.b, plans_only=given.plans_only, common=given.common, show=given.show) else 1
    k, n = (int(part) for part in given.part.split("/"))
    wanted = items(given.situations, given.drives, given.parking, given.scenes)
    asked = [item for item in wanted if zlib.crc32(item[0].encode()) % given.every == 0][k - 1 :: n]
    record(given.out, asked, given.workers)
    return 0


if __name__ == "__main__":
    sys.exit(main())
