"""The commands: read, call one public function, print. Heavy packages load inside the command that needs them.

Exit 0: done (a refused plan or a collision is a result). 2: bad input, one message that names file, key, value and rule. 1: our fault.
With --json stdout holds one JSON document and nothing else; progress and tables go to stderr or are left out.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from mcdas_opt.errors import InputError, McdasError

if TYPE_CHECKING:
    from rich.console import Console
    from rich.table import Table

    from mcdas_opt.domain.verdict import Verdict

app = typer.Typer(
    name="mcdas-opt",
    help="Planner for the car in the middle: front and rear vehicles as constraints, every plan judged before it leaves.",
    no_args_is_help=True,
    add_completion=True,
    pretty_exceptions_enable=False,
    rich_markup_mode="rich",
)

SceneArgument = Annotated[str, typer.Argument(metavar="SCENE", help="A scene file (TOML), or the name of a shipped scene.")]
JsonOption = Annotated[bool, typer.Option("--json", help="Print one JSON document on stdout, nothing else.")]
PlannerOption = Annotated[str, typer.Option("--planner", help="mpc, closed-form, closed-form-corrected, or a registered method.")]


_INTERRUPTED = 130


def main() -> None:
    """Entry point: turns our own errors into one line on stderr and the exit code of the contract."""
    try:
        code = app(standalone_mode=False)  # an interrupt comes back as the exit code 130
    except McdasError as error:
        print(f"mcdas-opt: {error}", file=sys.stderr)  # noqa: T201
        sys.exit(2)
    except typer.Exit as stop:
        sys.exit(stop.exit_code)
    except typer.Abort:
        sys.exit(_INTERRUPTED)
    except Exception as error:
        show = getattr(error, "show", None)  # click's usage errors show themselves
        if show is not None:
            show()
            sys.exit(2)
        raise
    if isinstance(code, int) and code:
        if code == _INTERRUPTED:
            print("mcdas-opt: interrupted; what was not yet written is lost", file=sys.stderr)  # noqa: T201
        sys.exit(code)


def emit(document: dict[str, Any]) -> None:
    """One JSON document on stdout; refuses NaN rather than printing it."""
    sys.stdout.write(json.dumps(document, allow_nan=False) + "\n")


def console() -> Console:
    from rich.console import Console

    return Console(highlight=False)


def facts_table(title: str, rows: list[tuple[str, object]]) -> Table:
    """Two columns, name and value."""
    from rich.table import Table

    table = Table(title=title, show_header=False, title_justify="left")
    table.add_column(style="bold")
    table.add_column()
    for name, value in rows:
        table.add_row(name, str(value))
    return table


def number(value: float | None, unit: str = "", digits: int = 2) -> str:
    """A value for a table; a dash where there is none."""
    return "-" if value is None else f"{value:.{digits}f} {unit}".rstrip()


@app.callback(invoke_without_command=True)
def _root(version: Annotated[bool, typer.Option("--version", help="Print the version and exit.")] = False) -> None:
    if version:
        from mcdas_opt import __version__

        typer.echo(f"mcdas-opt {__version__}")
        raise typer.Exit


@app.command()
def plan(
    scene: Annotated[str, typer.Argument(metavar="SCENE|SITUATION.json", help="A scene, or a saved situation (JSON).")],
    planner: PlannerOption = "mpc",
    out: Annotated[Path | None, typer.Option("--out", help="Save the situation that was planned, as JSON.")] = None,
    as_json: JsonOption = False,
) -> None:
    """One plan at t = 0, judged."""
    from mcdas_opt.simulation.first_situation import plan_once, situation_of

    situation, vehicle = situation_of(scene)
    if out is not None:
        _write(out, situation.to_json())
    answer = plan_once(situation, vehicle, planner)
    if as_json:
        emit(answer.to_dict())
        return
    screen = console()
    rows: list[tuple[str, object]] = [
        ("mode", f"{answer.mode} {answer.side if answer.side != 'none' else ''}".strip()),
        ("status", answer.status),
        ("warning", "yes" if answer.warning else "no"),
        ("reason", answer.reason),
        ("verdict", answer.verdict.reason),
        ("prediction", answer.prediction),
        ("Table 1, literally", answer.literal_mode or "no mode"),
        ("time", f"{answer.timing_ms.total:.1f} ms ({answer.iterations} solver iterations)"),
    ]
    screen.print(facts_table(f"{planner}: {scene}", rows))
    from rich.table import Table

    table = Table(title="candidates", title_justify="left")
    for heading in ("way", "cost", "passed", "refusal"):
        table.add_column(heading)
    for candidate in answer.candidates:
        table.add_row(candidate.name, number(candidate.cost), "yes" if candidate.passed else "no", candidate.refusal)
    screen.print(table)


@app.command()
def simulate(
    scene: SceneArgument,
    planner: PlannerOption = "mpc",
    plant: Annotated[str, typer.Option("--plant", help="The car that is driven: kinematic, or dynamic (with tyres).")] = "kinematic",
    seed: Annotated[int | None, typer.Option("--seed", min=0, help="Of the measurement noise; default the scene's.")] = None,
    out: Annotated[Path | None, typer.Option("--out", help="Draw the drive: an animation (.gif) or a sheet of moments (.png).")] = None,
    as_json: JsonOption = False,
) -> None:
    """The closed loop: sensors, tracker, planner, plant and traffic until the scene's end, a collision, or the road's edge."""
    from mcdas_opt.catalogue.scenes import load_scene
    from mcdas_opt.simulation.loop import simulate as run

    if out is not None:
        from mcdas_opt.plotting.animation import check_suffix

        check_suffix(out)
    with _progress("drive") as progress:
        drive = run(load_scene(scene), planner, plant, seed, progress=progress)
    if out is not None:
        from mcdas_opt.plotting.animation import save

        try:
            save(drive, out)
        except OSError as error:
            raise InputError(out, "", None, f"cannot be written: {error.strerror}") from None
    if as_json:
        emit(drive.to_dict())
        return
    ended = f"{drive.outcome} after {drive.duration_s:.2f} s"
    if drive.collided_with is not None:
        ended += f", with {drive.collided_with} at {drive.impact_speed_mps:.1f} m/s"
    others = [f"{count} {word}" for count, word in ((drive.fallbacks, "fallback"), (drive.unavoidable, "unavoidable")) if count]
    rows: list[tuple[str, object]] = [
        ("outcome", ended),
        ("modes", ", ".join(f"{t:.1f} s {mode}" for t, mode in drive.modes)),
        ("lane change", "completed" if drive.lane_change_completed else "none completed"),
        ("least clearance", number(drive.min_clearance_m, "m")),
        ("least time to collision", f"front {number(drive.min_ttc_front_s, 's')}, rear {number(drive.min_ttc_rear_s, 's')}"),
        ("largest lateral acceleration", f"{drive.max_lateral_acceleration_mps2:.2f} m/s^2"),
        ("largest jerk", f"{drive.max_jerk_mps3:.1f} m/s^3"),
        ("largest steering rate", f"{drive.max_steering_rate_radps:.3f} rad/s"),
        ("plans", ", ".join([str(drive.plans), *others])),
        ("unverified plans", drive.unverified_plans),
        ("cycle", f"p50 {drive.cycle_ms.p50:.1f} ms, p99 {drive.cycle_ms.p99:.1f} ms, max {drive.cycle_ms.max:.1f} ms"),
        ("seed", drive.seed),
    ]
    screen = console()
    screen.print(facts_table(f"{planner}: {scene}", rows))
    if out is not None:
        screen.print(f"drawn: {out}")


@app.command()
def judge(
    scene: Annotated[str, typer.Argument(metavar="SCENE|SITUATION.json", help="What the trajectory is driven in.")],
    trajectory: Annotated[Path, typer.Argument(metavar="TRAJECTORY", help="CSV, or JSON (a trajectory, a plan, a simulation).")],
    prediction: Annotated[
        str | None, typer.Option("--prediction", help="scene or constant-velocity; default the file's own, else the scene's script.")
    ] = None,
    as_json: JsonOption = False,
) -> None:
    """The judge alone, on anybody's trajectory, in traffic or in a parking case."""
    from mcdas_opt.catalogue.parking_cases import is_parking_case

    if is_parking_case(scene):
        _judge_parking(scene, trajectory, as_json)
        return
    from mcdas_opt.catalogue.trajectories import load_trajectory
    from mcdas_opt.domain.document import SCHEMA_VERSION, to_document
    from mcdas_opt.simulation.judging import foresee, target_of, verify

    target, vehicle = target_of(scene)
    read = load_trajectory(trajectory)
    wanted = read.prediction if prediction is None else prediction
    verdict = verify(read.trajectory, target, wanted, vehicle=vehicle)
    name = foresee(read.trajectory, target, wanted).name
    if as_json:
        emit({"schema_version": SCHEMA_VERSION, "verdict": to_document(verdict), "prediction": name})
        return
    screen = console()
    rows: list[tuple[str, object]] = [("verdict", "passed" if verdict.passed else "failed"), ("prediction", name)]
    screen.print(facts_table(f"{trajectory} in {scene}", rows))
    _print_violations(screen, verdict)


def _judge_parking(name: str, file: Path, as_json: bool) -> None:
    from mcdas_opt.catalogue.parking_cases import load_parking_case
    from mcdas_opt.catalogue.parking_trajectories import load_parking_trajectory
    from mcdas_opt.domain.document import SCHEMA_VERSION, to_document
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
    _print_violations(screen, found.verdict)


def _print_violations(screen: Console, verdict: Verdict) -> None:
    if not verdict.violations:
        return
    from rich.table import Table

    table = Table(title="violations", title_justify="left")
    for heading in ("rule", "at", "value", "limit", "unit"):
        table.add_column(heading)
    for found in verdict.violations:
        table.add_row(found.name, f"{found.t_s:.2f} s", f"{found.value:.4g}", f"{found.limit:.4g}", found.unit)
    screen.print(table)


@app.command()
def park(
    case: Annotated[str, typer.Argument(metavar="CASE", help="A case (TOML), a TPCAP CSV, or the name of a shipped case.")],
    planner: Annotated[str, typer.Option("--planner", help="nlp, search, closed-form, closed-form-corrected, two-arc.")] = "nlp",
    vehicle: Annotated[str | None, typer.Option("--vehicle", help="Instead of the case's vehicle.")] = None,
    clearance: Annotated[float | None, typer.Option("--clearance", min=0.0, help="Instead of the case's clearance [m].")] = None,
    budget: Annotated[float | None, typer.Option("--budget", min=0.0, help="Stop improving after so many seconds (an extra cap).")] = None,
    out: Annotated[Path | None, typer.Option("--out", help="Draw it: a sheet (.png) or an animation (.gif).")] = None,
    as_json: JsonOption = False,
) -> None:
    """One parking plan, judged."""
    from mcdas_opt.catalogue.parking_cases import load_parking_case
    from mcdas_opt.planning.parking.park import ParkSettings
    from mcdas_opt.planning.parking.park import park as run

    if out is not None:
        from mcdas_opt.plotting.animation import check_suffix

        check_suffix(out)
    problem = load_parking_case(case, vehicle=vehicle, clearance_m=clearance)
    answer = run(problem, planner, settings=ParkSettings(time_budget_s=budget))
    if out is not None and answer.trajectory is not None:
        from mcdas_opt.plotting.parking import save as draw

        try:
            draw(problem, answer, out)
        except OSError as error:
            raise InputError(out, "", None, f"cannot be written: {error.strerror}") from None
    if as_json:
        emit(answer.to_dict())
        return
    screen, timing = console(), answer.timing_ms
    rows: list[tuple[str, object]] = [
        ("status", answer.status),
        ("reason", answer.reason),
        ("verdict", answer.verdict.reason),
        ("duration", number(answer.duration_s, "s")),
        ("path", number(answer.path_m, "m")),
        ("gear changes", "-" if answer.gear_changes is None else answer.gear_changes),
        ("least clearance", number(answer.min_clearance_m, "m", 3)),
        ("time", f"{timing['total'] / 1e3:.2f} s, first answer after {timing['first'] / 1e3:.2f} s"),
        *(("note", note) for note in answer.notes),
    ]
    screen.print(facts_table(f"{planner}: {case}", rows))
    from rich.table import Table

    table = Table(title="attempts", title_justify="left")
    for heading in ("way", "duration", "gear changes", "sound", "note"):
        table.add_column(heading)
    for attempt in answer.attempts:
        table.add_row(
            attempt.name, number(attempt.duration_s, "s"), str(attempt.gear_changes), "yes" if attempt.passed else "no", attempt.note
        )
    screen.print(table)
    if out is not None:
        screen.print(f"drawn: {out}" if answer.trajectory is not None else "nothing to draw")


def _write(path: Path, text: str) -> None:
    try:
        path.write_text(text, encoding="utf-8")
    except OSError as error:
        raise InputError(path, "", None, f"cannot be written: {error.strerror}") from None


@app.command()
def replay(
    log: Annotated[str, typer.Argument(metavar="LOG", help="A recording, or the name of a shipped one (front_and_rear).")],
    log_format: Annotated[str, typer.Option("--format", help="esr-candump (Delphi ESR on CAN) or radar-csv (a front radar's track list).")],
    dbc: Annotated[Path | None, typer.Option("--dbc", help="The DBC to decode by; default the shipped minimal one.")] = None,
    rear: Annotated[Path | None, typer.Option("--rear", help="The rear radar's log, where it is a file of its own.")] = None,
    host: Annotated[str | None, typer.Option("--host", help="The host's speed: a CSV of t_s, speed_mps.")] = None,
    road: Annotated[str | None, typer.Option("--road", help="A scene whose road and vehicle to drive; default one straight lane.")] = None,
    columns: Annotated[
        str | None, typer.Option("--columns", help="radar-csv: time_s=t,x_m=dx,y_m=-right ... (a minus turns the sign).")
    ] = None,
    truth: Annotated[str | None, typer.Option("--truth", help="Compare with a truth file: t, front_range, front_azimuth_deg ...")] = None,
    planner: PlannerOption = "mpc",
    planning: Annotated[bool, typer.Option("--plan/--no-plan", help="Plan every cycle, or only track and assess.")] = True,
    out: Annotated[Path | None, typer.Option("--out", help="Draw the tracks (against the truth, if given) into a PNG.")] = None,
    as_json: JsonOption = False,
) -> None:
    """Recorded sensor data through tracker, situation and planner."""
    from mcdas_opt.interop.radar_csv import Columns
    from mcdas_opt.interop.replay import replay as run
    from mcdas_opt.interop.truth import compare

    if out is not None and not out.parent.is_dir():
        raise InputError(out, "", None, "cannot be written: no such folder")
    scene = None
    if road is not None:
        from mcdas_opt.catalogue.scenes import load_scene

        scene = load_scene(road)
    mapping = None if columns is None else Columns.parse(columns)
    with _progress("replay") as progress:
        done = run(
            log, log_format, dbc=dbc, rear=rear, host=host, road=scene, columns=mapping, planner=planner, plan=planning, progress=progress
        )  # fmt: skip
    comparison = None if truth is None else compare(done, truth)
    if out is not None:
        from mcdas_opt.plotting.replay import draw_against_truth, draw_tracks
        from mcdas_opt.plotting.style import save_png

        figure = draw_tracks(done.cycles) if comparison is None else draw_against_truth(comparison.sectors)
        try:
            save_png(figure, out)
        except OSError as error:
            raise InputError(out, "", None, f"cannot be written: {error.strerror}") from None
    if as_json:
        emit({**done.to_dict(), "truth": None if comparison is None else comparison.to_dict()})
        return
    screen, summary = console(), done.summary
    bad = ", ".join(f"{entry['count']} {kind} (first in line {entry['first_line']})" for kind, entry in summary.bad.items())
    left_out = {**summary.gated, **{k: v for k, v in summary.tracker.items() if v and k not in ("scans", "associated", "initiated")}}
    rows: list[tuple[str, object]] = [
        ("cycles", f"{summary.cycles}, {summary.start_s:g} s to {summary.end_s:g} s"),
        ("frames", f"{summary.frames_good} good, {summary.frames_bad} bad, {summary.frames_other} other"),
        ("bad", bad or "-"),
        ("scans, detections", f"{summary.scans}, {summary.detections}"),
        ("gated", ", ".join(f"{count} {kind}" for kind, count in left_out.items()) or "-"),
        ("tracks", f"{summary.tracks_started} started, {summary.tracks_ended} ended, longest {summary.longest_track_s:.1f} s"),
        ("covered", ", ".join(f"{sector} {100.0 * share:.0f} %" for sector, share in summary.covered.items())),
        ("modes", ", ".join(f"{mode} {count}" for mode, count in summary.modes.items())),
        ("plans", ", ".join(f"{count} {status}" for status, count in summary.statuses.items()) or "none asked for"),
        ("unverified plans", summary.unverified_plans),
        ("cycle", f"p50 {summary.cycle_ms.p50:.1f} ms, p99 {summary.cycle_ms.p99:.1f} ms, max {summary.cycle_ms.max:.1f} ms"),
    ]
    screen.print(facts_table(f"replay: {log}", rows))
    if comparison is not None:
        from rich.table import Table

        table = Table(title="against the truth: root mean squares in m, m and m/s over n instants", title_justify="left")
        for heading in ("sector", "of", "along", "across", "rate", "n", "breaks", "covered"):
            table.add_column(heading)
        for sector, found in comparison.sectors.items():
            for name, errors in (("tracks", found.tracked), ("raw", found.raw)):
                roots = (errors.along_rmse_m, errors.across_rmse_m, errors.range_rate_rmse_mps)
                shown = [*(number(root, digits=3) for root in roots), str(errors.samples)]
                last = [str(found.breaks), f"{100.0 * found.covered:.1f} %"] if name == "tracks" else ["", ""]
                table.add_row(sector.value, name, *shown, *last)
        screen.print(table)
    if out is not None:
        screen.print(f"drawn: {out}")


@app.command()
def reproduce(
    out: Annotated[Path, typer.Option("--out", help="Folder for Figures 7-12 (PNG); made if absent.")] = Path("reproduction"),
    as_json: JsonOption = False,
) -> None:
    """Every table and figure of the paper: published against computed, and the reading under which they agree."""
    from mcdas_opt.evaluation.reproduction import reproduce as run

    done = run(out)
    if as_json:
        emit(done.to_dict())
        return
    from rich import box
    from rich.table import Table

    table = Table(title="the paper, published against computed", title_justify="left", box=box.SIMPLE, pad_edge=False)
    table.add_column("item", overflow="fold")
    for heading in ("published", "computed"):
        table.add_column(heading, justify="right", min_width=11, max_width=12)
    table.add_column("unit", no_wrap=True)
    table.add_column("note", justify="right", no_wrap=True)
    readings = list(dict.fromkeys(row.reading for row in done.rows))
    for row in done.rows:
        values = [f"{v:.7f}".rstrip("0").rstrip(".") if isinstance(v, float) else v or "-" for v in (row.published, row.computed)]
        table.add_row(row.item, *values, row.unit, str(1 + readings.index(row.reading)))
    screen = console()
    screen.print(table)
    notes = Table.grid(padding=(0, 2))
    for note, reading in enumerate(readings, start=1):
        notes.add_row(str(note), reading)
    screen.print(notes)
    for figure in done.figures:
        screen.print(f"drawn: {figure}")


@contextmanager
def _progress(title: str) -> Iterator[Callable[[int, int], None]]:
    """A bar on stderr where that is a terminal: call what this yields with (done, of)."""
    from rich.console import Console
    from rich.progress import Progress

    with Progress(console=Console(stderr=True), transient=True, disable=not sys.stderr.isatty()) as bar:
        task = bar.add_task(title, total=None)
        yield lambda done, of: bar.update(task, completed=done, total=of)
