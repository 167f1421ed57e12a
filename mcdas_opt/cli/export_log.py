"""`mcdas-opt export-log`: a drive for others' viewers."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from mcdas_opt.cli import options
from mcdas_opt.cli.progress import progress_bar
from mcdas_opt.cli.screen import JsonOption, PlannerOption, SceneArgument, console, emit
from mcdas_opt.errors import InputError


def export_log(
    scene: SceneArgument,
    out: Annotated[Path, typer.Argument(metavar="FILE", help="drive.mcap for Foxglove, or drive.rrd for Rerun.")],
    planner: PlannerOption = "mpc",
    plant: options.Plant = "kinematic",
    seed: options.NoiseSeed = None,
    show: Annotated[bool, typer.Option("--show", help="Open the .rrd in Rerun's viewer, its analytics disabled.")] = False,
    as_json: JsonOption = False,
) -> None:
    """Drives a scene and writes the drive as a log for another viewer: bodies, tracks, plans and their reasons over time.

    Example: mcdas-opt export-log sandwich-60-40 drive.mcap
    """
    from mcdas_opt.catalogue.scenes import load_scene
    from mcdas_opt.domain.document import SCHEMA_VERSION
    from mcdas_opt.interop.logs.mcap_log import write_mcap
    from mcdas_opt.interop.logs.rerun_log import show as open_viewer
    from mcdas_opt.interop.logs.rerun_log import write_rrd
    from mcdas_opt.simulation.loop import simulate

    writers = {".mcap": write_mcap, ".rrd": write_rrd}
    if out.suffix not in writers:
        raise InputError(out, "suffix", out.suffix, "must be .mcap (Foxglove) or .rrd (Rerun)")
    if show and out.suffix != ".rrd":
        raise InputError("--show", "", None, "belongs to an .rrd")
    if not out.parent.is_dir():
        raise InputError(out, "", None, "cannot be written: no such folder")
    with progress_bar("drive") as progress:
        drive = simulate(load_scene(scene), planner, plant, seed, progress=progress)
    writers[out.suffix](drive, out)
    if show:
        open_viewer(out)
    if as_json:
        emit({"schema_version": SCHEMA_VERSION, "file": str(out), "bytes": out.stat().st_size, "outcome": drive.outcome.value})
        return
    console().print(f"written: {out} ({out.stat().st_size} bytes, {drive.outcome.value} after {drive.duration_s:.2f} s)")
