"""`mcdas-opt replay`: recorded sensor data through the pipeline."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from mcdas_opt.cli import completion, options
from mcdas_opt.cli.progress import progress_bar
from mcdas_opt.cli.screen import JsonOption, PlannerOption, check_picture, check_spared, console, emit, facts_table, headed_table, number
from mcdas_opt.cli.streams import said_before_it_is_written

if TYPE_CHECKING:
    from mcdas_opt.interop.replay_record import Summary
    from mcdas_opt.interop.truth import Comparison

SUFFIXES = (".html", ".png", ".svg", ".pdf", ".json", ".csv", ".parquet")


def replay(
    context: typer.Context,
    log: Annotated[str, typer.Argument(metavar="LOG", help="A recording, or the name of a shipped one (front_and_rear).")],
    log_format: Annotated[
        str | None,
        typer.Option(
            "--format", help="esr-candump, radar-csv, mdf4, mcap, rosbag2; default: by its name.", autocompletion=completion.formats
        ),
    ] = None,
    dbc: options.Dbc = None,
    rear: Annotated[Path | None, typer.Option("--rear", help="The rear radar's log, where it is a file of its own.")] = None,
    host: Annotated[str | None, typer.Option("--host", help="The host's speed: a CSV of t_s, speed_mps.")] = None,
    road: options.Road = None,
    columns: Annotated[
        str | None, typer.Option("--columns", help="A target list's channels: time_s=t,x_m=0.01*dx_cm,y_m=-right ...")
    ] = None,
    truth: Annotated[str | None, typer.Option("--truth", help="Compare with a truth file: t, front_range, front_azimuth_deg ...")] = None,
    planner: PlannerOption = "mpc",
    planning: Annotated[bool, typer.Option("--plan/--no-plan", help="Plan every cycle, or only track and assess.")] = True,
    out: Annotated[
        Path | None,
        typer.Option("--out", help="Page that plays (.html), picture (.png), .json, .csv or .parquet."),
    ] = None,
    as_json: JsonOption = False,
) -> None:
    """Recorded sensor data through tracker, situation and planner.

    Example: mcdas-opt replay esr.log --host speed.csv
    """
    from mcdas_opt.interop.replay import replay as run
    from mcdas_opt.interop.target_list import Columns
    from mcdas_opt.interop.truth import compare

    if not planning:
        options.unread(context, ("planner",), "--no-plan")
    if out is not None:
        check_picture(out, *(SUFFIXES if truth is None else (".png",)))
    check_spared(out, log, rear, host, truth, dbc, road)
    scene = None
    if road is not None:
        from mcdas_opt.catalogue.scenes import load_scene

        scene = load_scene(road)
    mapping = None if columns is None else Columns.parse(columns)
    with progress_bar("replay") as progress:
        done = run(
            log, log_format, dbc=dbc, rear=rear, host=host, road=scene, columns=mapping, planner=planner, plan=planning, progress=progress
        )  # fmt: skip
    comparison = None if truth is None else compare(done, truth)
    with said_before_it_is_written():
        if as_json:
            emit({**done.to_dict(), "truth": None if comparison is None else comparison.to_dict()})
        else:
            _print(done.summary, comparison, log)
    if out is not None:
        if comparison is None:
            done.save(out)
        else:
            from mcdas_opt.plotting.export import save_figure
            from mcdas_opt.plotting.replay import draw_against_truth

            save_figure(draw_against_truth(comparison.sectors), out)
        if not as_json:
            console().print(f"written: {out}")


def _print(summary: Summary, comparison: Comparison | None, log: str) -> None:
    screen = console()
    bad = ", ".join(f"{entry['count']} {kind} (first in line {entry['first_line']})" for kind, entry in summary.bad.items())
    left_out = {**summary.gated, **{k: v for k, v in summary.tracker.items() if v and k not in ("scans", "associated", "initiated")}}
    rows: list[tuple[str, object]] = [
        *((f"{sector} radar", where) for sector, where in summary.radars.items()),
        ("cycles", f"{summary.cycles}, {summary.span()}"),
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
        title = "against the truth: root mean squares in m, m and m/s over n instants"
        table = headed_table(title, "sector", "of", "along", "across", "rate", "n", "breaks", "covered")
        for sector, found in comparison.sectors.items():
            for name, errors in (("tracks", found.tracked), ("raw", found.raw)):
                roots = (errors.along_rmse_m, errors.across_rmse_m, errors.range_rate_rmse_mps)
                shown = [*(number(root, digits=3) for root in roots), str(errors.samples)]
                last = [str(found.breaks), f"{100.0 * found.covered:.1f} %"] if name == "tracks" else ["", ""]
                table.add_row(sector.value, name, *shown, *last)
        screen.print(table)
