"""The MPC step as C99 in a folder: written, compiled, and compared with Python on a scene's own sequence of solves."""

from __future__ import annotations

import hashlib
import json
import shutil
import subprocess
import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from mcdas_opt.catalogue.scenes import Scene
from mcdas_opt.domain.document import SCHEMA_VERSION, to_document
from mcdas_opt.errors import InputError, McdasError, ParameterError, writing
from mcdas_opt.interop.c_export.recording import Arithmetic, Recording, record
from mcdas_opt.interop.c_export.source import files
from mcdas_opt.native import build

FLAGS = "-O3 -Wall -Wextra"
_TIMEOUT_S = 300.0
_MOST_STEPS, _MOST_NEIGHBOURS = 20_000, 16


@dataclass(frozen=True, slots=True, kw_only=True)
class Export:
    """What was written, and how the C code compares with Python. Without a compiler, `max_error` and the C side's times are None.

    `max_error`: largest difference of a state or an input, in its own SI unit, of all solves; `apart`: how many differ by more than
    1e-6; `mismatches`: how many ended otherwise, or took another number of iterations. With the same arithmetic on both sides (portable
    Python against plain flags, native Python against its own) they are 0. With different ones they differ where a solve hardly converges:
    there the last digit of a sine decides. `timing_us`: of a solve, on both sides, measured beside each other on this machine.
    """

    folder: str
    files: tuple[str, ...]
    checksums: dict[str, str]
    steps: int
    warm_steps: int
    neighbours: int
    compiler: str | None
    flags: str
    warnings: str
    max_error: float | None
    apart: int | None
    mismatches: int | None
    timing_us: dict[str, dict[str, float] | None]
    python_solver: str

    def to_dict(self) -> dict[str, Any]:
        return {"schema_version": SCHEMA_VERSION, **to_document(self)}


class ExportError(McdasError):
    """The exported C code does not compile or does not run here; says what the compiler or the program said."""


def export_c(
    folder: str | Path,
    scene: Scene,
    *,
    steps: int = 1000,
    neighbours: int = 4,
    compiler: str | None = None,
    flags: str = FLAGS,
    arithmetic: Arithmetic = "portable",
) -> Export:
    """Writes the solver for scenes like `scene` into `folder` (made if absent), and checks it on the first `steps` solves of its drive.

    `compiler`: a program's name or path; None takes $CC, cc, gcc or clang, whichever there is; it is given -std=c99 and `flags`.
    `arithmetic`: how the Python side is built: "portable", which is what plain flags make of the C code, or "native", as it flies.
    Raises `ParameterError` for a number out of range or a compiler that there is not, `InputError` where the folder cannot be written
    or the scene asks for no solve, `ExportError` where what was written does not compile or run.
    """
    for name, value, most in (("steps", steps, _MOST_STEPS), ("neighbours", neighbours, _MOST_NEIGHBOURS)):
        if not 1 <= value <= most:
            raise ParameterError(name, value, f"must lie in [1, {most}]")
    program = _compiler(compiler)
    folder = Path(folder)
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(folder, "", None, f"cannot be made a folder: {error.strerror}") from None
    recording = record(scene, steps, neighbours, arithmetic)
    if not recording.steps:
        raise InputError(scene.file, "", None, "asks the MPC for no solve, so that there is nothing to compare")
    written = files(recording)
    for name, content in written.items():
        with writing(folder / name):
            (folder / name).write_bytes(content)
    said: dict[str, Any] = {}
    warnings = ""
    if program is not None:
        said, warnings = run_replay(folder, program, flags)
    return Export(
        folder=str(folder),
        files=tuple(str(folder / name) for name in written),
        checksums={name: hashlib.sha256(content).hexdigest() for name, content in written.items()},
        steps=len(recording.steps),
        warm_steps=sum(step.warm for step in recording.steps),
        neighbours=neighbours,
        compiler=program,
        flags=flags,
        warnings=warnings,
        max_error=said.get("max_error"),
        apart=said.get("apart"),
        mismatches=said.get("mismatches"),
        timing_us={"c": said.get("timing_us"), "python": _timing(recording)},
        python_solver=recording.solver,
    )


def run_replay(folder: Path, compiler: str, flags: str = FLAGS) -> tuple[dict[str, Any], str]:
    """Compiles an export outside its folder, replays its recording: what the program printed, and what the compiler said."""
    with tempfile.TemporaryDirectory() as name:
        program = Path(name) / "replay"
        sources = [str(folder / "replay.c"), str(folder / "mcdas_mpc.c")]
        options = flags.split()
        libraries = [option for option in options if option.startswith("-l")]
        switches = [option for option in options if option not in libraries]
        built = _run([compiler, "-std=c99", *switches, "-o", str(program), *sources, *libraries, "-lm"])
        done = _run([str(program), str(folder / "replay.bin")])
    document: dict[str, Any] = json.loads(done.stdout)
    return document, built.stderr.strip()


def _run(command: list[str]) -> subprocess.CompletedProcess[str]:
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=_TIMEOUT_S, check=False)
    except (OSError, subprocess.SubprocessError) as error:
        raise ExportError(f"{Path(command[0]).name}: {error}") from error
    if done.returncode != 0:
        raise ExportError(f"{Path(command[0]).name} failed: {done.stderr.strip() or f'exit {done.returncode}'}")
    return done


def _compiler(name: str | None) -> str | None:
    if name is not None:
        found = shutil.which(name)
        if found is None:
            raise ParameterError("compiler", name, "is no program that can be found")
        return found
    try:
        return build.compiler()
    except build.BuildError:
        return None


def _timing(recording: Recording) -> dict[str, float]:
    took = recording.took_us
    p50, p99 = (float(q) for q in np.percentile(took, [50, 99]))
    return {"mean": float(took.mean()), "p50": p50, "p99": p99, "max": float(took.max())}
