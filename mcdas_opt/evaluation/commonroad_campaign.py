"""CommonRoad scenarios driven by planners side by side: how each drive ends, what of it is whose doing, and a picture of each loss."""

from __future__ import annotations

import csv
import re
import tarfile
import tempfile
import warnings
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from io import StringIO
from itertools import pairwise
from pathlib import Path
from statistics import median
from typing import Any

from mcdas_opt.domain.vocabulary import Alert, Mode
from mcdas_opt.errors import InputError, McdasError, reading
from mcdas_opt.evaluation import provenance
from mcdas_opt.evaluation.hindsight import last_chance, would_have_braked
from mcdas_opt.evaluation.results_folder import JOURNAL, open_folder
from mcdas_opt.evaluation.running.executor import Executor
from mcdas_opt.evaluation.running.journal import Journal, write_whole
from mcdas_opt.evaluation.running.messages import Ended, Task
from mcdas_opt.evaluation.statistics import Pairs, Share
from mcdas_opt.evaluation.table import markdown_table
from mcdas_opt.simulation.record import Outcome, Simulation

SUITE = "commonroad"
ROWS, TABLE, PICTURES = "rows.csv", "table.md", "pictures"
REFUSED, SAFE, FAILED, OFF_THE_MAP = "refused", "safe", "failed", "off the map"
NOT_DRIVEN = (REFUSED, FAILED)
REACHED = "reached"
RECORDING, NOT_SHOWN, OURS = "recording", "not shown", "ours"
_ENDS = (SAFE, "struck in front", "struck at the side", "struck from behind", "left_road", OFF_THE_MAP, REFUSED, FAILED)
_COLUMNS = (
    *("scenario", "planner", "kind", "end", "blame", "chance_s", "duration_s", "of_s", "goal", "cycles", "fallback", "unavoidable"),
    *("neighbours", "left_out", "most_lateral_mps2", "most_braking_mps2", "most_jerk_mps3", "evasions", "warned"),
    *("p50_ms", "p99_ms", "why"),
)
_HARSH_MPS2 = 4.0  # across: twice what is comfortable in a bend
_STOOD_S, _STANDING_MPS = 1.0, 0.5
_BRAKED_S, _BRAKED_MPS2 = 2.0, 4.0  # who follows keeps clear of a host that brakes by less

Record = dict[str, Any]
Progress = Callable[[str, int, int], None]


@contextmanager
def scenario_files(data: Path) -> Iterator[list[Path]]:
    """The scenarios (XML) behind a folder, an archive or a single file, in the names' order. Raises `InputError` where there is none."""
    with tempfile.TemporaryDirectory() as folder:
        if data.is_dir():
            archives = sorted(path for path in data.rglob("*") if path.name.lower().endswith((".tar.xz", ".tar.gz")))
            found = _scenarios(data)
        else:
            archives, found = ([], [data]) if data.suffix.lower() == ".xml" else ([data], [])
        for one in archives:
            try:
                with reading(one), tarfile.open(one) as archive:  # each on its own: two may hold a file of one name
                    archive.extractall(Path(folder) / (one.relative_to(data) if data.is_dir() else one.name), filter="data")
            except tarfile.TarError as error:
                raise InputError(one, "", None, f"is no archive that can be read: {error}") from None
        found += _scenarios(Path(folder))
        if not found:
            raise InputError(data, "", None, "holds no CommonRoad scenario (*.xml, or an archive *.tar.xz of them)")
        yield sorted(found, key=lambda path: (path.stem, path.parts[::-1]))


def _scenarios(folder: Path) -> list[Path]:
    return [path for path in folder.rglob("*") if path.suffix.lower() == ".xml" and path.is_file()]


def scenario_names(paths: Sequence[Path]) -> list[str]:
    """What each file's rows are called: its stem; of files of one stem, as much of their paths as tells them apart."""
    alike: dict[str, list[tuple[str, ...]]] = {}
    for path in paths:
        alike.setdefault(path.stem, []).append(path.parts)
    return [path.stem if len(alike[path.stem]) == 1 else _apart(path.parts, alike[path.stem]) for path in paths]


def _apart(path: tuple[str, ...], others: Sequence[tuple[str, ...]]) -> str:
    """The least of the path's end, its folder at least, that no other path ends in."""
    ends = (path[-n:] for n in range(2, len(path)) if [one[-n:] for one in others].count(path[-n:]) == 1)
    return "/".join(next(ends, path))


def run(
    paths: Sequence[Path],
    planners: Sequence[str],
    folder: Path,
    executor: Executor,
    *,
    plant: str = "kinematic",
    limit_s: float,
    resume: bool,
    progress: Progress,
) -> tuple[Record, ...]:
    """The rows, by scenario and planner, each written as it comes. Raises `InputError` for a folder of another run."""
    scenarios = scenario_names(paths)
    manifest = {"suite": SUITE, "scenarios": scenarios, "planners": list(planners), "plant": plant}
    open_folder(folder, manifest | {"versions": provenance.versions(), "commit": provenance.commit()})
    with Journal(folder / JOURNAL) as journal:
        if journal.records and not resume:
            raise InputError(folder, "", None, "holds rows of this very run: add --resume to go on, or name another --out")
        there = {(row["scenario"], row["planner"]) for row in journal.records}
        named = list(zip(scenarios, paths, strict=True))
        wanted = [(name, path, planner) for name, path in named for planner in planners if (name, planner) not in there]
        tasks = [Task(driven, (name, path, planner, folder / PICTURES, plant), limit_s) for name, path, planner in wanted]
        for done, (number, answer) in enumerate(executor.run(tasks), start=1 + len(there)):
            name, _, planner = wanted[number]
            failed = {"scenario": name, "planner": planner, "kind": "", "end": FAILED, "why": answer.reason}
            journal.append(answer.value if answer.ended is Ended.RETURNED else failed)
            progress("drives", done, len(paths) * len(planners))
        found = {(row["scenario"], row["planner"]): row for row in journal.records}
    rows = shown_by_others([found[name, planner] for name in scenarios for planner in planners])
    text = StringIO()
    writer = csv.DictWriter(text, _COLUMNS, restval="", lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    write_whole(folder / ROWS, text.getvalue())
    return rows


def driven(name: str, path: Path, planner: str, pictures: Path, plant: str = "kinematic") -> Record:
    """One scenario as a row; a loss has the reason of the last plan in it and a picture, a refusal the rule that was broken."""
    from mcdas_opt.interop.commonroad.scenario import read_scenario
    from mcdas_opt.interop.commonroad.solution import goal_reached_s
    from mcdas_opt.simulation.loop import simulate

    warnings.simplefilter("ignore")  # the reader's
    row: Record = {"scenario": name, "planner": planner, "kind": kind_of(path.read_text("utf-8", "replace"))}
    try:
        read = read_scenario(path)
    except InputError as error:
        return row | {"end": REFUSED, "why": f"{error.key}: {error.rule}" if error.key else error.rule}
    try:
        drive = simulate(read.scene, planner, plant)
    except McdasError as error:
        return row | {"end": FAILED, "why": str(error)}
    end, last_m = end_of(drive), float(drive.trajectory.s_m[-1])
    is_there = goal_reached_s(read, drive.trajectory) is not None
    if end == SAFE and not is_there and read.map_end_s_m is not None and last_m > read.map_end_s_m:
        end = OFF_THE_MAP
    if end != SAFE:
        _draw(drive, pictures / f"{name.replace('/', '-')}-{planner}.png")
    last = drive.cycles[-1].plan
    blame, chance_s = ("", None) if end == SAFE else (OURS, None) if end == OFF_THE_MAP else blame_of(drive)
    return row | {
        "end": end,
        "blame": blame,
        "chance_s": chance_s,
        "duration_s": round(drive.duration_s, 2),
        "of_s": round(read.scene.duration_s, 2),
        "goal": REACHED if is_there else why_missed(read.goal_is_off, drive),
        "cycles": drive.plans,
        "fallback": drive.fallbacks,
        "unavoidable": drive.unavoidable,
        "neighbours": len(read.scene.neighbour),
        "left_out": len(read.left_out),
        "most_lateral_mps2": round(drive.max_lateral_acceleration_mps2, 2),
        "most_braking_mps2": round(max(-float(drive.trajectory.acceleration_mps2.min()), 0.0), 2),
        "most_jerk_mps3": round(drive.max_jerk_mps3, 1),
        "evasions": _evasions(drive),
        "warned": sum(cycle.plan.alert is not Alert.NONE for cycle in drive.cycles),
        "p50_ms": round(drive.cycle_ms.p50, 1),
        "p99_ms": round(drive.cycle_ms.p99, 1),
        "why": "" if end == SAFE else f"{last.status.value}: {last.reason}",
    }


def _evasions(drive: Simulation) -> int:
    """How often it began to steer out."""
    evades = [False, *(cycle.plan.mode is Mode.EVADE for cycle in drive.cycles)]
    return sum(now and not before for before, now in pairwise(evades))


def why_missed(off: str, drive: Simulation) -> str:
    """Why a goal was not reached that CommonRoad judges."""
    if off:
        return f"off: {off}"
    return drive.destination if drive.destination != REACHED else "ahead: but for what CommonRoad asks besides"


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


def blame_of(drive: Simulation) -> tuple[str, float | None]:
    """Whose doing a loss is, others not reacting, and how long before it [s] something could still have been done, where that was ours.

    `recording`: somebody drove into a host that stood, into one from behind that did not brake hard, or from behind though an attentive
    driver would have braked in time. `not shown`: nothing that is looked at would have gone well, knowing what everybody did
    (`hindsight.py`), which proves nothing. `ours`: everything else.
    """
    if drive.outcome is Outcome.COLLISION:
        t, v, a = drive.trajectory.t_s, drive.trajectory.speed_mps, drive.trajectory.acceleration_mps2
        stood = bool((v[t >= t[-1] - _STOOD_S] < _STANDING_MPS).all()) and t[-1] >= _STOOD_S
        eased = bool((a[t >= t[-1] - _BRAKED_S] > -_BRAKED_MPS2).all())
        from_behind = end_of(drive) == "struck from behind"
        if stood or (from_behind and (eased or would_have_braked(drive))):
            return RECORDING, None
    chance = last_chance(drive)
    return (NOT_SHOWN, None) if chance is None else (OURS, round(chance.before_s, 2))


def shown_by_others(rows: Sequence[Record]) -> tuple[Record, ...]:
    """The rows; where another planner drove the scenario safely, something could be done from the start on."""
    safe = {row["scenario"] for row in rows if row["end"] == SAFE}
    return tuple(
        row | {"blame": OURS, "chance_s": row["duration_s"]} if row.get("blame") == NOT_SHOWN and row["scenario"] in safe else row
        for row in rows
    )


def summarise(rows: Sequence[Record], planners: Sequence[str]) -> Record:
    """By planner: ends by kind, lost by blame, goals, cycles; and the first planner's losses against each other one's, paired."""
    found: Record = {}
    for planner in planners:
        mine = [row for row in rows if row["planner"] == planner]
        drives = [row for row in mine if row["end"] not in NOT_DRIVEN]
        lost = [row for row in drives if row["end"] != SAFE]
        cycles = sum(row["cycles"] for row in drives)
        goals = [row["goal"].partition(":")[0] for row in drives if row["goal"]]
        found[planner] = {
            "scenarios": len(mine),
            "ends": {
                kind: dict(Counter(row["end"] for row in mine if row["kind"] == kind)) for kind in sorted({row["kind"] for row in mine})
            },
            "refused": _share(sum(row["end"] == REFUSED for row in mine), len(mine)),
            "lost": _share(len(lost), len(drives)),
            "lost_urban": _share(*_counted(drives, urban=True)),
            "lost_elsewhere": _share(*_counted(drives, urban=False)),
            "blame": dict(Counter(row["blame"] for row in lost)),
            "goals": dict(Counter(goals)),
            "goal_reached": _share(goals.count(REACHED), len(goals)),
            "fallback_or_unavoidable": _share(sum(row["fallback"] + row["unavoidable"] for row in drives), cycles),
            "evasions": sum(row.get("evasions", 0) for row in drives),
            "warned": _share(sum(row.get("warned", 0) for row in drives), cycles),
            "harsh": _share(sum(row["most_lateral_mps2"] > _HARSH_MPS2 for row in drives), len(drives)),
            "p50_ms": _middle([row["p50_ms"] for row in drives]),
            "most_lateral_mps2": _middle([row["most_lateral_mps2"] for row in drives]),
            "most_braking_mps2": _middle([row["most_braking_mps2"] for row in drives]),
        }
    first = {row["scenario"]: row["end"] != SAFE for row in rows if row["planner"] == planners[0] and row["end"] not in NOT_DRIVEN}
    for planner in planners[1:]:
        other = {row["scenario"]: row["end"] != SAFE for row in rows if row["planner"] == planner and row["end"] not in NOT_DRIVEN}
        both = [(lost, other[name]) for name, lost in first.items() if name in other]
        found[planner][f"paired_with_{planners[0]}"] = Pairs(
            first=planners[0],
            second=planner,
            n=len(both),
            only_first=sum(ours and not theirs for ours, theirs in both),
            only_second=sum(theirs and not ours for ours, theirs in both),
        ).to_dict()
    return found


def lines(summary: Record) -> list[tuple[str, list[str]]]:
    """(what, a cell for each planner) of the summary."""
    of = list(summary.values())

    def shares(key: str) -> list[str]:
        return [f"{one[key]['k']}/{one[key]['n']}" for one in of]

    table = [("refused", shares("refused")), ("lost, urban", shares("lost_urban")), ("lost elsewhere", shares("lost_elsewhere"))]
    for end in _ENDS[1:6]:
        table.append((end, [str(sum(kind.get(end, 0) for kind in one["ends"].values())) for one in of]))
    for title, blame in (("the recording's doing", RECORDING), ("no way out shown", NOT_SHOWN), ("ours", OURS)):
        table.append((f"of the lost, {title}", [str(one["blame"].get(blame, 0)) for one in of]))
    table += [("goal reached", shares("goal_reached")), ("fallback or unavoidable cycles", shares("fallback_or_unavoidable"))]
    table += [("evasions begun", [str(one["evasions"]) for one in of]), ("warned cycles", shares("warned"))]
    table.append((f"drives with over {_HARSH_MPS2:g} m/s^2 across", shares("harsh")))
    table.append(("failed", [str(sum(kind.get(FAILED, 0) for kind in one["ends"].values())) for one in of]))
    for title, key in (
        ("most lateral acceleration, median [m/s^2]", "most_lateral_mps2"),
        ("most braking, median [m/s^2]", "most_braking_mps2"),
        ("cycle p50, median [ms]", "p50_ms"),
    ):
        table.append((title, ["-" if one[key] is None else f"{one[key]:.1f}" for one in of]))
    return table


def markdown(summary: Record) -> str:
    """The summary's table."""
    return markdown_table(["", *summary], lines(summary))


def _share(k: int, n: int) -> Record:
    return Share(k=k, n=n).to_dict()


def _counted(drives: Sequence[Record], *, urban: bool) -> tuple[int, int]:
    of = [row for row in drives if (row["kind"] == "urban") is urban]
    return sum(row["end"] != SAFE for row in of), len(of)


def _middle(values: Sequence[float]) -> float | None:
    return median(values) if values else None


def _draw(drive: Simulation, path: Path) -> None:
    from mcdas_opt.plotting.animation import sheet
    from mcdas_opt.plotting.style import save_png

    path.parent.mkdir(parents=True, exist_ok=True)
    save_png(sheet(drive), path)
