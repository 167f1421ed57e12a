"""`mcdas-opt export-c`: the MPC step as C99."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from mcdas_opt.cli.progress import progress_bar
from mcdas_opt.cli.screen import JsonOption, console, emit, facts_table


def export_c(
    folder: Annotated[Path, typer.Argument(metavar="DIR", help="Where the files go; made if absent.")],
    scene: Annotated[
        str, typer.Option("--scene", help="Whose vehicle the code is for, and whose drive it is checked on.")
    ] = "sandwich-60-40",
    steps: Annotated[int, typer.Option("--steps", help="Solves to compare with Python's (the recording takes 15 kB each).")] = 1000,
    neighbours: Annotated[int, typer.Option("--neighbours", help="How many vehicles the problem has obstacle slots for.")] = 4,
    compiler: Annotated[str | None, typer.Option("--compiler", help="Default $CC, cc, gcc or clang, whichever there is.")] = None,
    flags: Annotated[str, typer.Option("--flags", help="For the compiler, beside -std=c99.")] = "-O3 -Wall -Wextra",
    arithmetic: Annotated[
        str, typer.Option("--arithmetic", help="Python's side: portable (what plain flags make of the C), or native (as it flies here).")
    ] = "portable",
    as_json: JsonOption = False,
) -> None:
    """The MPC step as C99 that takes no memory: written, compiled, and held against Python on a scene's own solves.

    Example: mcdas-opt export-c mpc_c --scene cut-in --neighbours 2
    """
    from mcdas_opt.catalogue.scenes import load_scene
    from mcdas_opt.interop.c_export.export import export_c as run
    from mcdas_opt.interop.c_export.recording import one_arithmetic

    chosen = one_arithmetic(arithmetic)
    with progress_bar("generate and check"):
        done = run(folder, load_scene(scene), steps=steps, neighbours=neighbours, compiler=compiler, flags=flags, arithmetic=chosen)
    if as_json:
        emit(done.to_dict())
        return
    compared = "not compared: there is no C compiler"
    if done.max_error is not None:
        compared = f"at most {done.max_error:.1e} apart in a state or an input"
        compared += f"; {done.apart} of {done.steps} by more than 1e-6" if done.apart else ""
    rows: list[tuple[str, object]] = [
        ("files", ", ".join(done.checksums)),
        ("solves", f"{done.steps} of {scene}, {done.warm_steps} of them warm"),
        ("compiler", f"{done.compiler} -std=c99 {done.flags}" if done.compiler else "none found"),
        (f"against Python's {done.python_solver}", compared),
    ]
    for side, times in done.timing_us.items():
        if times is not None:
            rows.append((f"a solve in {side}", f"p50 {times['p50']:.0f} us, p99 {times['p99']:.0f} us, max {times['max']:.0f} us"))
    screen = console()
    screen.print(facts_table(f"{done.folder}: {done.neighbours} neighbours", rows))
    if done.warnings:
        screen.print(done.warnings)
