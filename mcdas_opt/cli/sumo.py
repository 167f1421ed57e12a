"""`mcdas-opt sumo`: SUMO traffic with our planner at the wheel of one vehicle, and with SUMO's own driver in the same seeds."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from mcdas_opt.cli import options
from mcdas_opt.cli.progress import progress_bar
from mcdas_opt.cli.screen import JsonOption, PlannerOption, console, emit, headed_table, leaving
from mcdas_opt.cli.speeds import DesiredSpeed
from mcdas_opt.errors import InputError

_MOST_SEEDS, _DIGITS = 100_000, 10


def sumo(
    config: Annotated[str, typer.Argument(metavar="CONFIG", help="A .sumocfg, or the name of a shipped one (motorway, bends, town).")],
    ego: Annotated[str, typer.Option("--ego", help="Id of the vehicle to drive; it must be in the configuration.")] = "ego",
    seeds: Annotated[str, typer.Option("--seeds", help="SUMO's seeds: 0-40, or 3, or 1,5,9.")] = "0-4",
    planner: PlannerOption = "mpc",
    against: Annotated[str, typer.Option("--against", help="Others on the same seeds; sumo is SUMO's driver.")] = "sumo",
    desired: DesiredSpeed = None,
    look: Annotated[str, typer.Option("--look", help="How far ahead and behind others are seen [m].")] = "150,100",
    out: Annotated[Path | None, typer.Option("--out", help="Folder for rows, table and pictures; default sumo-CONFIG.")] = None,
    workers: Annotated[int, typer.Option("--workers", min=1, help="Processes on this machine.")] = 1,
    resume: options.Resume = False,
    as_json: JsonOption = False,
) -> None:
    """Drives one vehicle of a SUMO configuration, seed by seed, and compares with SUMO's own driver in the same traffic.

    Example: mcdas-opt sumo motorway --seeds 0-9 --against sumo --out motorway
    """
    from mcdas_opt.evaluation.benchmark import check_planners
    from mcdas_opt.evaluation.running.executor import working
    from mcdas_opt.evaluation.running.journal import write_whole
    from mcdas_opt.evaluation.sumo_campaign import TABLE, lines, markdown, run, summarise
    from mcdas_opt.interop.sumo.connection import require_libsumo
    from mcdas_opt.interop.sumo.driver import SUMO
    from mcdas_opt.interop.sumo.episode import EpisodeSettings, sumo_config

    require_libsumo()
    drivers = [planner, *(name.strip() for name in against.split(",") if name.strip())]
    check_planners([name for name in drivers if name != SUMO] or [planner])
    ahead, behind = _numbers("--look", look, 2)
    settings = EpisodeSettings(config=sumo_config(config), ego=ego, desired_mps=desired, look_m=(ahead, behind))
    chosen, folder = seeds_of(seeds), out if out is not None else Path(f"sumo-{Path(config).stem}")
    kept = f"rows so far are in {folder}: the same command with --resume goes on"
    with working(workers) as executor, leaving(kept), progress_bar("episodes") as progress:
        rows = run(settings, chosen, drivers, folder, executor, resume=resume, progress=progress)
    summary = summarise(rows, drivers)
    title = f"{settings.config.stem}: {ego}, {len(chosen)} seeds"
    write_whole(folder / TABLE, markdown(title, summary))
    pictures = [str(folder / "pictures" / name) for row in rows for name in row["pictures"]]
    if as_json:
        emit({"schema_version": 1, "config": str(settings.config), "ego": ego, "seeds": chosen, "summary": summary, "rows": list(rows)})
        return
    table = headed_table(title, "", *drivers)
    for name, cells in lines(summary):
        table.add_row(name, *cells)
    console().print(table)
    console().print(f"rows, table and {len(pictures)} pictures of contacts and near misses: {folder}", soft_wrap=True)


def seeds_of(text: str) -> list[int]:
    """The seeds of `0-40`, `3` or `1,5,9`. Raises `InputError` for anything else."""
    rule = "must be whole numbers: 0-40, 3, or 1,5,9"
    found: list[int] = []
    for part in text.split(","):
        first, dash, last = part.strip().partition("-")
        last = last if dash else first
        if not (first.isdecimal() and last.isdecimal()):
            raise InputError("--seeds", "", text, rule)
        if max(len(first), len(last)) > _DIGITS:
            raise InputError("--seeds", "", text, f"must have at most {_DIGITS} digits each")
        if int(last) < int(first):
            raise InputError("--seeds", "", text, rule)
        if len(found) + int(last) - int(first) >= _MOST_SEEDS:
            raise InputError("--seeds", "", text, f"must be at most {_MOST_SEEDS} seeds")
        found += range(int(first), int(last) + 1)
    known: set[int] = set()
    for seed in found:
        if seed in known:
            raise InputError("--seeds", "", text, f"names {seed} twice")
        known.add(seed)
    return found


def _numbers(option: str, text: str, count: int) -> list[float]:
    try:
        found = [float(part) for part in text.split(",")]
    except ValueError:
        found = []
    if len(found) != count:
        raise InputError(option, "", text, f"must be {count} numbers with commas between")
    return found
