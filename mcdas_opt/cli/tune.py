"""`mcdas-opt tune`: the sigmoid's a, b, y_max, designed; or a study in traffic, its tables within 80 columns."""

from __future__ import annotations

import re
from collections.abc import Iterator
from contextlib import contextmanager
from inspect import signature
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from mcdas_opt.cli import completion, options, speeds
from mcdas_opt.cli.progress import progress_bar
from mcdas_opt.cli.screen import JsonOption, console, emit, facts_table, headed_table, leaving, number
from mcdas_opt.cli.streams import said_before_it_is_written
from mcdas_opt.errors import ParameterError

if TYPE_CHECKING:
    from rich.table import Table

    from mcdas_opt.tuning.design import Design
    from mcdas_opt.tuning.study_options import StudyOptions
    from mcdas_opt.tuning.tune_in_traffic import StudyReport


_BOUNDS = "LOW HIGH"
_OTHERWISE = {"length_max_m": "length", "settling_error": "settling", "initial_heading_jump": "heading_jump"}
_OF_STUDY = ("trials", "storage", "search", "seed", "train", "held_out", "workers", "scheduler")
_OF_BOTH = ("speed", "out", "scenes", "as_json")
_UNIT = re.compile("_(mps[23]?|rad|per_m|m)$")


def tune(
    context: typer.Context,
    speed: speeds.Speed = 60.0 / 3.6,
    offset: Annotated[float, typer.Option("--offset", help="Front vehicle's offset d_front - d_host, left positive [m].")] = 0.0,
    objective: Annotated[str, typer.Option("--objective", help="shortest, clearance or jerk.")] = "shortest",
    side: Annotated[str, typer.Option("--side", help="left or right.")] = "left",
    lateral_acceleration: Annotated[float, typer.Option("--lateral-acceleration", help="Limit [m/s^2].")] = 4.0,
    lateral_jerk: Annotated[float, typer.Option("--lateral-jerk", help="Limit [m/s^3].")] = 20.0,
    friction: Annotated[float, typer.Option("--friction", help="Friction of the road.")] = 0.9,
    length: Annotated[float | None, typer.Option("--length", help="The path must settle within this length [m].")] = None,
    settling: Annotated[float, typer.Option("--settling", help="Limit of the error against the lane centre [m].")] = 0.01,
    heading_jump: Annotated[float, typer.Option("--heading-jump", help="Limit of the jump at the start [rad].")] = 0.015,
    clearance: Annotated[float, typer.Option("--clearance", help="Least clearance to whoever is passed [m].")] = 0.25,
    front_gap: Annotated[float | None, typer.Option("--front-gap", help="Bumper to bumper to the vehicle ahead [m].")] = None,
    front_speed: speeds.FrontSpeed = None,
    rear_gap: Annotated[float | None, typer.Option("--rear-gap", help="Bumper to bumper to the vehicle behind [m].")] = None,
    rear_speed: speeds.RearSpeed = None,
    a_bounds: Annotated[tuple[float, float] | None, typer.Option("--a-bounds", metavar=_BOUNDS, help="Of a [1/m].")] = None,
    b_bounds: Annotated[tuple[float, float] | None, typer.Option("--b-bounds", metavar=_BOUNDS, help="Of b.")] = None,
    y_max_bounds: Annotated[tuple[float, float] | None, typer.Option("--y-max-bounds", metavar=_BOUNDS, help="Of y_max [m].")] = None,
    speed_bounds: speeds.SpeedBounds = None,
    lane_width: Annotated[float, typer.Option("--lane-width", help="To the centre of the next lane [m].")] = 3.7,
    vehicle: Annotated[str, typer.Option("--vehicle", help="A shipped vehicle or a file.", autocompletion=completion.vehicles)] = "sedan",
    out: Annotated[Path | None, typer.Option("--out", help="Writes FILE's stem as .toml (for `plan --params`) and as .png.")] = None,
    scenes: Annotated[
        str | None, typer.Option("--scenes", help="Tune the MPC in this suite's traffic instead.", autocompletion=completion.suites)
    ] = None,
    trials: Annotated[int, typer.Option("--trials", help="Of the study, those already in its file included.")] = 30,
    storage: Annotated[Path | None, typer.Option("--storage", help="The study's file (SQLite); several workers may share it.")] = None,
    search: Annotated[str, typer.Option("--search", help="tpe, nsga2, de, cma-es or random.")] = "tpe",
    seed: Annotated[int, typer.Option("--seed", help="Of the search.")] = 0,
    train: Annotated[int, typer.Option("--train", help="Avoidable scenes to train on.")] = 12,
    held_out: Annotated[int, typer.Option("--held-out", help="Scenes to validate on, and as many to test.")] = 8,
    workers: Annotated[int, typer.Option("--workers", help="Processes that drive.")] = 1,
    scheduler: options.Scheduler = None,
    as_json: JsonOption = False,
) -> None:
    """The best sigmoid for a speed, with what binds it; with --scenes, the MPC's numbers tuned in traffic.

    Example: mcdas-opt tune --speed 16.7 --objective jerk --out best.toml
    """
    if scenes is not None:
        from mcdas_opt.evaluation.families import suite_file
        from mcdas_opt.tuning.study_options import StudyOptions

        of_design = signature(tune).parameters.keys() - {*_OF_STUDY, *_OF_BOTH}
        options.unread(context, of_design, "a study in traffic (--scenes)")
        options.only_one_sort_of_workers(context, scheduler)
        suite_file(scenes)
        with named_as_written(scenes="train"):
            study = StudyOptions(
                method=search, seed=seed, scenes=train, held_out=held_out, workers=workers, scheduler=scheduler, speed_mps=speed
            )
        if storage is None:
            raise ParameterError("--scenes", scenes, "a study needs a file to live in: --storage FILE")
        with named_as_written():
            _study(scenes, trials, storage, study, out, as_json)
        return
    options.unread(context, _OF_STUDY, "a design, only by a study in traffic: --scenes SUITE")
    if speed_bounds is not None:
        options.unread(context, ("speed",), "--speed-bounds, within which it is chosen")
    from mcdas_opt.catalogue.vehicles import load_vehicle
    from mcdas_opt.domain.vocabulary import Side
    from mcdas_opt.tuning.design import check_out, design, write_design
    from mcdas_opt.tuning.request import DesignRequest

    if side not in ("left", "right"):
        raise ParameterError("--side", side, "must be left or right")
    chosen: dict[str, Any] = {
        "a_bounds_per_m": a_bounds,
        "b_bounds": b_bounds,
        "y_max_bounds_m": y_max_bounds,
        "speed_bounds_mps": None if speed_bounds is None else (speeds.speed(speed_bounds[0]), speeds.speed(speed_bounds[1])),
    }
    if out is not None:
        check_out(out)
    with named_as_written():
        request = DesignRequest(
            speed_mps=speed,
            offset_m=offset,
            objective=objective,
            lateral_acceleration_mps2=lateral_acceleration,
            lateral_jerk_mps3=lateral_jerk,
            friction=friction,
            side=Side(side),
            length_max_m=length,
            settling_m=settling,
            heading_jump_rad=heading_jump,
            clearance_m=clearance,
            front_gap_m=front_gap,
            front_speed_mps=front_speed,
            rear_gap_m=rear_gap,
            rear_speed_mps=rear_speed,
            lane_width_m=lane_width,
            vehicle=load_vehicle(vehicle),
            **{name: value for name, value in chosen.items() if value is not None},
        )
        if objective == "clearance":
            options.unread(context, ("clearance",), "--objective clearance, which makes it as large as it can")
        if request.front is None and request.rear is None:
            options.unread(context, ("clearance",), "a design that passes nobody: --front-gap or --rear-gap says whom")
        with progress_bar("design"):
            found = design(request)
    with said_before_it_is_written():
        if as_json:
            emit(found.to_dict())
        else:
            _print(found)
    if out is not None:
        written = write_design(found, out)
        if not as_json:
            console().print(f"written: {', '.join(map(str, written))}")


@contextmanager
def named_as_written(**written: str) -> Iterator[None]:
    """Names in a `ParameterError` the option that the value was written behind; `written`: options that are called otherwise here."""
    try:
        yield
    except ParameterError as error:
        name = error.name.replace(" ", "_")
        option = (_OTHERWISE | written).get(name) or _UNIT.sub("", name)
        is_derived = name == "friction" and error.unit  # the acceleration that it allows
        if option not in signature(tune).parameters or is_derived:
            raise
        raise ParameterError(f"--{option.replace('_', '-')}", error.value, error.rule, error.unit) from None


def _study(suite: str, trials: int, storage: Path, options: StudyOptions, out: Path | None, as_json: bool) -> None:
    """A study in traffic: progress on stderr, then what was found."""
    from mcdas_opt.tuning.tune_in_traffic import tune_in_traffic

    with leaving(f"trials so far are in {storage}: the same command goes on"), progress_bar("trials") as advance:
        found = tune_in_traffic(suite, trials, storage, options, out=out, progress=advance)
    if as_json:
        emit(found.to_dict())
        return
    print_study(found, storage)
    if out is not None:
        console().print(
            f"drawn: {out.with_suffix('.png')}" + (f"; values: {out.with_suffix('.toml')}" if found.accepted else "; no values")
        )


def _print(found: Design) -> None:
    screen = console()
    rows: list[tuple[str, object]] = [
        ("a", f"{found.a_per_m:.5f} 1/m"),
        ("b", number(found.b, "", 3)),
        ("y_max", f"{found.y_max_m:.4f} m (offset {found.offset_m:g} m, to the {found.side})"),
        ("length", f"{found.length_m:.2f} m, {found.duration_s:.2f} s (path ends at {found.end_m:.2f} m)"),
        ("objective", f"{found.objective}: {found.value:.4g} {found.unit}"),
        *(("active", words) for words in found.active),
        ("method", f"{found.method}, {found.evaluations} evaluations"),
    ]
    screen.print(facts_table(f"sigmoid at {3.6 * found.speed_mps:.0f} km/h", rows))
    table = headed_table("constraints", "name", "value", "", "limit", "unit", "multiplier")
    for row in found.constraints:
        sense = ">=" if row.sense == "at least" else "<="
        multiplier = f"{row.multiplier:.4g} {found.unit} per {row.unit}" if row.binds else "-"
        table.add_row(row.name, f"{row.value:.4g}", sense, f"{row.limit:.4g}", row.unit, multiplier)
    screen.print(table)


def print_study(found: StudyReport, storage: Path) -> None:
    screen = console()
    rows: list[tuple[str, object]] = [
        ("study", f"{found.method}: {found.evaluations} trials, {found.pruned} pruned, in {storage}"),
        ("chosen", f"trial {found.choice.trial.number} of a front of {len(found.choice.front)}"),
        *(("why", reason) for reason in found.reasons),
        ("verdict", found.reason),
    ]
    screen.print(facts_table(f"tuned on {found.spec.suite}", rows))
    are_tuned = found.values != found.defaults
    if not are_tuned:
        screen.print("The best trial is the defaults: there are no other values to set beside them.")
    screen.print(_scenes_apart(found, are_tuned))
    screen.print(_values(found, are_tuned))
    _say_gain(found, are_tuned)


def _say_gain(found: StudyReport, are_tuned: bool) -> None:
    """The last words: whether it helped, on scenes that were not used."""
    screen, gain = console(), found.gain
    collided = [("defaults", gain.defaults), *([("tuned", gain.tuned)] if are_tuned else [])]
    told = ", ".join(f"{who} {one.k} of {one.n} [{100.0 * one.interval[0]:.0f}, {100.0 * one.interval[1]:.0f}] %" for who, one in collided)
    screen.print(f"Test scenes, not tuned on, that collided, with 95 % intervals: {told}.")
    if are_tuned:
        screen.print(f"Their scores, tuned less defaults, scene by scene: {gain.score_difference:+.3g} in the mean.")
    screen.print(f"The tuned values are {gain.verdict}." if are_tuned else "Tuning changed nothing.")


def _scenes_apart(found: StudyReport, are_tuned: bool) -> Table:
    table = headed_table("scenes apart", "set", "values", "collided", "lateral", "jerk", "beside", "score")
    sets = found.guarded.sets
    seeds = ", ".join(f"{one.name} {one.seed}" for one in sets)
    table.caption = (
        "collided: of the scenes of the set; the rest are means over them. lateral: peak lateral acceleration [m/s^2]; jerk: peak "
        f"[m/s^3]; beside: driven beside a lane's middle [m]; score: the less the better. Seeds: {seeds}."
    )
    table.caption_justify = "left"
    for one in sets:
        for who, cost in (("defaults", one.default), ("tuned", one.tuned))[: 1 + are_tuned]:
            hits = f"{round(cost.collisions * cost.drives)}/{cost.drives}"
            figures = (f"{cost.peak_lateral_mps2:.2f}", f"{cost.peak_jerk_mps3:.1f}", f"{cost.manoeuvre_m:.1f}", f"{cost.score:.2f}")
            table.add_row(one.name, who, hits, *figures)
    return _uncut(table)


def _values(found: StudyReport, are_tuned: bool) -> Table:
    table = headed_table("values", "name", "default", *(["tuned"] if are_tuned else []), "importance")
    for name, value in found.values.items():
        tuned = [f"{value:.4g}"] if are_tuned else []
        table.add_row(name, f"{found.defaults[name]:.4g}", *tuned, number(found.importance.get(name), "", 3))
    return _uncut(table)


def _uncut(table: Table) -> Table:
    for column in table.columns:
        column.no_wrap = True
    return table
