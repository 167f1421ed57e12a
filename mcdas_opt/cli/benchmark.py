"""`mcdas-opt benchmark`: planners side by side on a suite of scenes."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from mcdas_opt.cli import completion, options
from mcdas_opt.cli.log import complain, hint
from mcdas_opt.cli.progress import stages
from mcdas_opt.cli.screen import JsonOption, console, emit, leaving

if TYPE_CHECKING:
    from mcdas_opt.evaluation.running.executor import Executor

_ABREAST = 3  # planners in one table
_ROWS = (
    ("lost on A", "lost_on_A"),
    ("lost on A with room", "lost_on_A_with_room"),
    ("collisions on A", "collisions_on_A"),
    ("lost", "lost"),
    ("collisions", "collisions"),
    ("hit from behind", "rear_hits"),
    ("left the road", "road_departures"),
    ("false interventions", "false_interventions"),
    ("time gap < 0.8 s, own doing", "short_headways"),
    ("beyond ISO 15622", "beyond_iso"),
    ("followers who brake hard", "followers_braked"),
    ("ordinary again at the end", "ordinary_again"),
    ("plans by the fallback", "fallback_plans"),
    ("unverified plans", "unverified_plans"),
    ("failures", "failures"),
)


def benchmark(
    context: typer.Context,
    suite: Annotated[
        str,
        typer.Argument(
            metavar="SUITE",
            help="A suite file (TOML), the name of a shipped suite, or commonroad (with --data).",
            autocompletion=completion.suites,
        ),
    ],
    planners: Annotated[
        str, typer.Option("--planners", help="Names, with commas between.", autocompletion=completion.planner_lists)
    ] = "mpc,closed-form,closed-form-corrected",
    scenes: Annotated[int | None, typer.Option("--scenes", min=1, help="How many; default what the suite says.")] = None,
    seed: Annotated[int | None, typer.Option("--seed", min=0, help="Of the scenes; default the suite's.")] = None,
    out: Annotated[Path | None, typer.Option("--out", help="Folder for the results; default benchmark-SUITE-SEED.")] = None,
    workers: Annotated[int, typer.Option("--workers", min=1, help="Processes on this machine, a thread each.")] = 2,
    scheduler: options.Scheduler = None,
    data: Annotated[
        Path | None, typer.Option("--data", help="Folder of recordings, for suites that read them; of CommonRoad scenarios.")
    ] = None,
    resume: options.Resume = False,
    plant: options.Plant = "kinematic",
    limit: Annotated[float, typer.Option("--limit", min=1.0, help="Seconds for one drive; what takes longer is marked.")] = 300.0,
    as_json: JsonOption = False,
) -> None:
    """Every planner on the same scenes: labels by the oracle, a row for each drive, statistics and a report.

    Example: mcdas-opt benchmark sandwich --planners mpc,closed-form --scenes 40 --out results
    """
    from mcdas_opt.evaluation.benchmark import run
    from mcdas_opt.evaluation.publish import publish
    from mcdas_opt.evaluation.running.executor import working
    from mcdas_opt.evaluation.running.journal import StoppedError
    from mcdas_opt.evaluation.suites import expand
    from mcdas_opt.evaluation.summary import contradictions

    options.only_one_sort_of_workers(context, scheduler)
    names = [name.strip() for name in planners.split(",") if name.strip()]
    if suite == "commonroad":
        options.unread(context, ("seed",), "commonroad: its scenarios are not drawn")
        with working(workers, scheduler) as executor:
            _commonroad(names, data, out, scenes, executor, plant, limit, resume=resume, as_json=as_json)
        return
    chosen = expand(suite, scenes, seed, data)
    folder = out if out is not None else Path(f"benchmark-{chosen.name}-{chosen.seed}")
    kept = f"rows so far are in {folder}: the same command with --resume goes on"
    try:
        with working(workers, scheduler) as executor, leaving(kept), stages() as progress:
            results = run(chosen, names, folder, executor, plant=plant, limit_s=limit, resume=resume, progress=progress)
            done = publish(chosen, results, folder, executor, progress)
    except StoppedError as error:
        complain(str(error))
        raise typer.Exit(1) from None
    if as_json:
        emit(done.document)
    else:
        _show(done.document)
    for line in _failed(names, results.rows):
        hint(line)
    wrong = contradictions(results.rows)
    if wrong:
        told = ", ".join(f"{row['scene']} ({row['planner']})" for row in wrong[:5])
        complain(f"the oracle calls {len(wrong)} safe drives unavoidable: {told}")
        raise typer.Exit(1)


def _commonroad(
    planners: list[str],
    data: Path | None,
    out: Path | None,
    scenes: int | None,
    executor: Executor,
    plant: str,
    limit_s: float,
    *,
    resume: bool,
    as_json: bool,
) -> None:
    """CommonRoad scenarios: rows, a table, and a picture of each loss. Exit code 2 where every one was refused."""
    from mcdas_opt.errors import InputError
    from mcdas_opt.evaluation import commonroad_campaign as campaign
    from mcdas_opt.evaluation.benchmark import check_planners
    from mcdas_opt.evaluation.running.journal import write_whole
    from mcdas_opt.interop.commonroad.library import require
    from mcdas_opt.simulation.plant import plant_factory

    check_planners(planners)
    plant_factory(plant)
    require()
    if data is None:
        raise InputError("--data", "", None, "names no folder: commonroad reads the scenarios (*.xml) in it")
    folder = out if out is not None else Path("benchmark-commonroad")
    kept = f"rows so far are in {folder}: the same command with --resume goes on"
    with leaving(kept), campaign.scenario_files(data) as found, stages() as progress:
        rows = campaign.run(found[:scenes], planners, folder, executor, plant=plant, limit_s=limit_s, resume=resume, progress=progress)
    summary = campaign.summarise(rows, planners)
    write_whole(folder / campaign.TABLE, campaign.markdown(summary))
    pictures = sorted(str(path) for path in (folder / campaign.PICTURES).glob("*.png"))
    if as_json:
        told = {"schema_version": 1, "suite": campaign.SUITE, "plant": plant, "rows": str(folder / campaign.ROWS)}
        emit(told | {"summary": summary, "pictures": pictures})
    else:
        _show_scenarios(rows, summary, planners, folder, len(pictures))
    if all(row["end"] == campaign.REFUSED for row in rows):
        complain(f"every scenario was refused, the first, {rows[0]['scenario']}: {rows[0]['why']}")
        raise typer.Exit(2)


def _show_scenarios(rows: Sequence[dict[str, Any]], summary: dict[str, Any], planners: Sequence[str], folder: Path, pictures: int) -> None:
    from mcdas_opt.cli.screen import headed_table
    from mcdas_opt.evaluation import commonroad_campaign as campaign

    driven = len({row["scenario"] for row in rows})
    table = headed_table(f"CommonRoad, {driven} scenario{'s' if driven > 1 else ''}", "", *planners)
    for title, cells in campaign.lines(summary):
        table.add_row(title, *cells)
    console().print(table)
    for said in dict.fromkeys(f"{row['scenario']}: {row['end']}: {row['why']}" for row in rows if row["end"] in campaign.NOT_DRIVEN):
        console().print(said, soft_wrap=True, markup=False)
    console().print(f"rows, table and {pictures} pictures of losses: {folder}", soft_wrap=True)


def _show(document: dict[str, Any]) -> None:
    """A table for each kind of traffic, planners side by side, a few at a time so that it fits."""
    from rich import box
    from rich.table import Table

    screen = console()
    summary: dict[str, Any] = document["summary"]
    planners = list(summary)
    kinds = [key for key in summary[planners[0]] if key != "cycle_ms"]
    for kind in kinds:
        shown = [(title, key) for title, key in _ROWS if any(summary[planner][kind][key]["n"] for planner in planners)]
        for few in (planners[k : k + _ABREAST] for k in range(0, len(planners), _ABREAST)):
            title = f"{document['suite']}, {kind} traffic, {summary[planners[0]][kind]['scenes']} scenes; k/n [95 % interval in %]"
            table = Table(title=title, title_justify="left", box=box.SIMPLE, pad_edge=False)
            for heading in ("", *few):
                table.add_column(heading, justify="right" if heading else "left", overflow="fold")
            for title, key in shown:
                table.add_row(title, *(_share(summary[planner][kind][key]) for planner in few))
            if kind == kinds[-1]:
                table.add_row("cycle p50 / p99 [ms]", *(_cycle(summary[planner]["cycle_ms"]) for planner in few))
            screen.print(table)
    screen.print(f"rows: {document['rows']} (hash {document['rows_hash'][:12]}), report: {document['report']}", soft_wrap=True)


def _failed(planners: Sequence[str], rows: Sequence[Mapping[str, Any]]) -> Iterator[str]:
    """Of each planner that raised, took too long or died: in how many drives, and why in the first."""
    for planner in planners:
        mine = [row for row in rows if row["planner"] == planner]
        reasons = [row["error"] for row in mine if row["error"]]
        if reasons:
            yield f"{planner} failed in {len(reasons)} of {len(mine)} drives, in the first: {reasons[0]}"


def _share(found: dict[str, Any]) -> str:
    if not found["n"]:
        return "-"
    return f"{found['k']}/{found['n']} [{100.0 * found['low']:.1f}, {100.0 * found['high']:.1f}]"


def _cycle(found: dict[str, Any]) -> str:
    return "-" if found["p50"] is None else f"{found['p50']:.1f} / {found['p99']:.1f}"
