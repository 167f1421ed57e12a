"""A suite driven by every planner: labels first and frozen, then rows as they come, then the table in its fixed order."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from mcdas_opt.errors import InputError, ParameterError
from mcdas_opt.evaluation import provenance
from mcdas_opt.evaluation.case import Case
from mcdas_opt.evaluation.labels import REACTIONS_S, ROOM_M, label_chunk, wants_label
from mcdas_opt.evaluation.results_folder import JOURNAL, LABELLING, LABELS, frozen_labels, open_folder
from mcdas_opt.evaluation.row import Driven, Row, drive, head
from mcdas_opt.evaluation.running.executor import Executor
from mcdas_opt.evaluation.running.journal import Journal, StoppedError, write_whole
from mcdas_opt.evaluation.running.messages import Answer, Ended, Task
from mcdas_opt.evaluation.suites import Suite
from mcdas_opt.simulation.plant import plant_factory

SCHEMA_VERSION = 1
LIMIT_S = 300.0
_LABELS_AT_ONCE = 8
_LABEL_LIMIT_S = 1800.0

Progress = Callable[[str, int, int], None]
Record = dict[str, Any]


@dataclass(frozen=True, slots=True, kw_only=True)
class Results:
    """The finished table: `rows` in the order of scenes and planners, each with its labels; what was timed row by row beside it."""

    manifest: Record
    rows: tuple[Record, ...]
    cycles_ms: tuple[tuple[float, ...], ...]
    took_s: tuple[float, ...]

    @property
    def rows_hash(self) -> str:
        """Of every row; timings are not in them."""
        return provenance.digest(self.rows)


def manifest_of(suite: Suite, planners: Sequence[str], plant: str, limit_s: float) -> Record:
    return {
        "schema_version": SCHEMA_VERSION,
        "suite": suite.name,
        "suite_hash": suite.hash,
        "seed": suite.seed,
        "scenes": len(suite.cases),
        "planners": list(planners),
        "plant": plant,
        "reactions_s": list(REACTIONS_S),
        "room_m": ROOM_M,
        "limit_s": limit_s,
        "versions": provenance.versions(),
        "commit": provenance.commit(),
    }


def check_planners(planners: Sequence[str]) -> None:
    """Raises `ParameterError` with the known ones for a name that is not registered and no "module:Class", that cannot be built, or that
    stands twice."""
    from mcdas_opt.planning.method import METHODS, check_method

    known = METHODS.known()
    for name in planners:
        if ":" not in name and name not in known:
            raise ParameterError("planners", name, "is not a known planner; known: " + ", ".join(known))
        check_method(name)
        if list(planners).count(name) > 1:
            raise ParameterError("planners", name, "stands twice")
    if not planners:
        raise ParameterError("planners", "", "names nobody; known: " + ", ".join(known))


def run(
    suite: Suite,
    planners: Sequence[str],
    folder: Path,
    executor: Executor,
    *,
    plant: str = "kinematic",
    limit_s: float = LIMIT_S,
    resume: bool = False,
    progress: Progress = lambda stage, done, of: None,
) -> Results:
    """Labels and drives what is not yet in `folder`, and returns the whole table.

    Raises `InputError` for a folder of something else or a full disk, `ParameterError` for an unknown planner or plant.
    """
    check_planners(planners)
    plant_factory(plant)
    manifest = manifest_of(suite, planners, plant, limit_s)
    if open_folder(folder, manifest) and not resume:
        raise InputError(folder, "", None, "holds results of this very run: add --resume to go on, or name another --out")
    labels, labels_hash = _labels(suite, folder, executor, progress)
    with Journal(folder / JOURNAL) as journal:
        _drive(suite.cases, planners, plant, limit_s, journal, executor, progress)
        records = {(record["row"]["index"], record["row"]["planner"]): record for record in journal.records}
    ordered = [records[case.index, planner] for case in suite.cases for planner in planners]
    rows = tuple({**record["row"], **labels[record["row"]["index"]]} for record in ordered)
    manifest["labels_hash"] = labels_hash
    cycles = tuple(tuple(record["cycles_ms"]) for record in ordered)
    return Results(manifest=manifest, rows=rows, cycles_ms=cycles, took_s=tuple(record["took_s"] for record in ordered))


def _labels(suite: Suite, folder: Path, executor: Executor, progress: Progress) -> tuple[dict[int, Record], str]:
    """By case index: a label for each reaction time, one with room, the onset; and their hash. Frozen in a file before anybody drives."""
    frozen = frozen_labels(folder, suite.hash)
    if frozen is None:
        with Journal(folder / LABELLING) as journal:
            _label(suite.cases, journal, executor, progress)
            found = {(record["index"], record["reaction_s"]): record for record in journal.records}
        labels = []
        for case in (case for case in suite.cases if wants_label(case)):
            first, late = (found[case.index, rho] for rho in REACTIONS_S)
            labels.append([case.index, first["label"], late["label"], first["with_room"], first["onset_s"]])
        frozen = {
            "suite_hash": suite.hash,
            "labels_hash": provenance.digest(labels),
            "reactions_s": list(REACTIONS_S),
            "room_m": ROOM_M,
            "labels": labels,
        }
        write_whole(folder / LABELS, json.dumps(frozen) + "\n")
    table = {case.index: _unlabelled() for case in suite.cases}
    for index, letter, late, roomy, onset in frozen["labels"]:
        table[index] = {"label": letter, "label_late": late, "label_with_room": roomy, "onset_s": onset}
    return table, str(frozen["labels_hash"])


def _unlabelled() -> Record:
    return {"label": "-", "label_late": "-", "label_with_room": "-", "onset_s": None}


def _label(cases: Sequence[Case], journal: Journal, executor: Executor, progress: Progress) -> None:
    there = {(record["index"], record["reaction_s"]) for record in journal.records}
    wanted = [(case, rho) for rho in REACTIONS_S for case in cases if wants_label(case) and (case.index, rho) not in there]
    chunks: list[tuple[list[Case], float]] = []
    for rho in REACTIONS_S:
        mine = [case for case, reaction in wanted if reaction == rho]
        chunks += [(mine[k : k + _LABELS_AT_ONCE], rho) for k in range(0, len(mine), _LABELS_AT_ONCE)]
    tasks = [Task(label_chunk, ([case.scene for case in part], rho), _LABEL_LIMIT_S) for part, rho in chunks]
    done, of = len(there), len(there) + len(wanted)
    if of:
        progress("labels", done, of)
    for number, answer in executor.run(tasks):
        if answer.ended is not Ended.RETURNED:
            raise StoppedError(f"the oracle failed on scenes {[case.scene.name for case in chunks[number][0]]}: {answer.reason}")
        part, rho = chunks[number]
        for case, found in zip(part, answer.value, strict=True):
            journal.append({"index": case.index, "reaction_s": rho, **found})
        done += len(part)
        progress("labels", done, of)


def _drive(
    cases: Sequence[Case], planners: Sequence[str], plant: str, limit_s: float, journal: Journal, executor: Executor, progress: Progress
) -> None:
    there = {(record["row"]["index"], record["row"]["planner"]) for record in journal.records}
    wanted = [(case, planner) for case in cases for planner in planners if (case.index, planner) not in there]
    tasks = [Task(drive, (case, planner, plant), limit_s) for case, planner in wanted]
    progress("drives", len(there), len(there) + len(wanted))
    for done, (number, answer) in enumerate(executor.run(tasks), start=1 + len(there)):
        driven = _driven(*wanted[number], plant, answer)
        journal.append({"row": driven.row.to_dict(), "cycles_ms": driven.cycles_ms, "took_s": driven.took_s})
        progress("drives", done, len(there) + len(wanted))


def _driven(case: Case, planner: str, plant: str, answer: Answer) -> Driven:
    if answer.ended is Ended.RETURNED and isinstance(answer.value, Driven):
        return answer.value
    return Driven(row=Row(**head(case, planner, plant), ended=answer.ended.value, error=answer.reason))
