"""`mcdas-opt verify`: the judge on anybody's trajectory."""

from __future__ import annotations

import functools
from pathlib import Path
from typing import Annotated

import typer

from mcdas_opt.cli import completion
from mcdas_opt.cli.log import hint
from mcdas_opt.cli.screen import JsonOption, console, emit, facts_table, number, print_violations
from mcdas_opt.errors import InputError


def verify(
    scene: Annotated[
        str, typer.Argument(metavar="SCENE|SITUATION.json", help="What the trajectory is driven in.", autocompletion=completion.scenes)
    ],
    trajectory: Annotated[Path, typer.Argument(metavar="TRAJECTORY", help="CSV, or JSON (a trajectory, a plan, a simulation).")],
    prediction: Annotated[
        str | None, typer.Option("--prediction", help="scene or constant-velocity; default the file's own, else the scene's script.")
    ] = None,
    as_json: JsonOption = False,
) -> None:
    """The judge alone, on anybody's trajectory, in traffic or in a parking case.

    Example: mcdas-opt plan cut-in --json > plan.json; mcdas-opt verify cut-in plan.json
    """
    from mcdas_opt.parking.case_file import is_parking_case

    if is_parking_case(scene):
        if prediction is not None:
            raise InputError("--prediction", "", prediction, "not read by a parking case: nobody moves there")
        _judge_parking(scene, trajectory, as_json)
        return
    from mcdas_opt.catalogue.trajectories import load_trajectory
    from mcdas_opt.domain.document import SCHEMA_VERSION, to_document
    from mcdas_opt.domain.situation import Situation
    from mcdas_opt.simulation.judging import foresee, target_of
    from mcdas_opt.simulation.judging import verify as judged

    target, vehicle = target_of(scene)
    read = load_trajectory(trajectory)
    wanted = read.prediction if prediction is None else prediction
    verdict = judged(read.trajectory, target, wanted, vehicle=vehicle, relies_on=read.relies_on)
    name = foresee(read.trajectory, target, wanted).name
    if as_json:
        emit({"schema_version": SCHEMA_VERSION, "verdict": to_document(verdict), "prediction": name})
        return
    screen = console()
    rows: list[tuple[str, object]] = [("verdict", "passed" if verdict.passed else "failed"), ("prediction", name)]
    if read.relies_on is not None and isinstance(target, Situation):
        rows.append(("expected to brake", read.relies_on))
    screen.print(facts_table(f"{trajectory} in {scene}", rows))
    print_violations(screen, verdict)


@functools.wraps(verify)
def judge(scene: str, trajectory: Path, prediction: str | None = None, as_json: bool = False) -> None:
    verify(scene, trajectory, prediction, as_json)
    hint("judge is now called verify")  # last: of bad input nothing but the error is said


def _judge_parking(name: str, file: Path, as_json: bool) -> None:
    from mcdas_opt.domain.document import SCHEMA_VERSION, to_document
    from mcdas_opt.parking.case_file import load_parking_case
    from mcdas_opt.parking.trajectory_file import load_parking_trajectory
    from mcdas_opt.verification.parking_judge import judge_parking

    case = load_parking_case(name)
    driven = load_parking_trajectory(file).moved(-case.origin_m[0], -case.origin_m[1])
    found = judge_parking(case, driven)
    if as_json:
        measured = {"min_clearance_m": found.min_clearance_m, "duration_s": driven.duration_s, "gear_changes": driven.gear_changes}
        emit({"schema_version": SCHEMA_VERSION, "verdict": to_document(found.verdict), **measured})
        return
    screen = console()
    rows: list[tuple[str, object]] = [
        ("verdict", "passed" if found.verdict.passed else "failed"),
        ("duration", number(driven.duration_s, "s")),
        ("gear changes", driven.gear_changes),
        ("least clearance", number(found.min_clearance_m, "m", 3)),
    ]
    screen.print(facts_table(f"{file} in {name}", rows))
    print_violations(screen, found.verdict)
