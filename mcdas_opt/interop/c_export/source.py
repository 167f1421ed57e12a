"""The exported files as text: generated header and solver, the shipped replay program, and the recording in bytes."""

from __future__ import annotations

import struct
from collections.abc import Sequence
from importlib import resources

import numpy as np

from mcdas_opt import __version__
from mcdas_opt.domain.rules import Array
from mcdas_opt.interop.c_export.meanings import meaning
from mcdas_opt.interop.c_export.recording import ENDINGS, SLOTS, Recording
from mcdas_opt.native.binding import defined
from mcdas_opt.native.build import flags_of, text_of
from mcdas_opt.native.library import NoLibraryError, level_of, load
from mcdas_opt.solvers.barrier_stage import BarrierStage
from mcdas_opt.solvers.interior_point import ITERATIONS, LEAST_COLD, LEAST_WARM, MU_COLD, RULE
from mcdas_opt.solvers.stage_problem import StageProblem

KERNEL = "interior_point.c"
MAGIC = 20261.5  # a recording begins with it: another byte order reads something else
_UNBOUNDED = 1e300  # a bound that does not bind


def _makefile() -> str:
    return f"""\
ifeq ($(origin CC),default)
CC = gcc
endif
CFLAGS ?= -O3 -Wall -Wextra
# as mcdas-opt's own kernel of this processor is built on x86-64 with glibc: its instructions, sines of whole vectors at once
VECTORS ?= {native_flags()}

replay: replay.c mcdas_mpc.c mcdas_mpc.h
\t$(CC) -std=c99 $(CFLAGS) -o $@ replay.c mcdas_mpc.c -lm

replay-vectors: replay.c mcdas_mpc.c mcdas_mpc.h
\t$(CC) -std=c99 -o $@ replay.c mcdas_mpc.c $(VECTORS)

check: replay
\t./replay replay.bin

check-vectors: replay-vectors
\t./replay-vectors replay.bin

clean:
\trm -f replay replay-vectors

.PHONY: check check-vectors clean
"""


def native_flags() -> str:
    """For a compiler: those of the kernel that this processor runs."""
    try:
        level = level_of(load())
    except NoLibraryError:
        level = ""
    return flags_of(KERNEL, level)


def header(recording: Recording) -> str:
    """`mcdas_mpc.h`."""
    problem, sizes = recording.transcribed.problem, _sizes(recording)
    lines = [f"#define MCDAS_{name} {size}" for name, size in sizes.items()]
    lines += [f"#define MCDAS_SLOTS {SLOTS} /* of a recording */", f"#define MCDAS_MAGIC {MAGIC!r}"]
    parts = {
        "title": f"Written by mcdas-opt {__version__}: the lane problem for {recording.transcribed.slots} neighbours",
        "sizes": "\n".join(lines),
        "states": _enum("X", problem.states),
        "inputs": _enum("U", problem.inputs),
        "parameters": _enum("P", problem.parameters, [meaning(name) for name in problem.parameters]),
    }
    text = _shipped("mcdas_mpc.h.in")
    for name, part in parts.items():
        text = text.replace(f"@{name}@", part)
    return text


def solver(recording: Recording) -> str:
    """`mcdas_mpc.c`: the stage functions, the kernel, and the step around them."""
    problem, nodes = recording.transcribed.problem, recording.transcribed.nodes
    member = problem.member
    if member is None:
        raise LookupError(f"there are no stage functions of this {problem.name} problem")
    numbers = {"MU_COLD": MU_COLD, "LEAST_COLD": LEAST_COLD, "LEAST_WARM": LEAST_WARM}
    sizes = {"NODES": nodes, "BODIES": member.times, "COLUMNS": len(problem.parameters), "FIRST_OF_BODY": member.first_of_row}
    return "\n".join(
        [
            f"/* Written by mcdas-opt {__version__}. */",
            "#include <stddef.h>",
            "#include <stdint.h>",
            text_of(KERNEL),
            '#include "mcdas_mpc.h"',
            defined(sizes),
            f"static const double VEHICLE[] = {_vector(member.numbers)};",
            f"static const whole COLUMN[] = {{{', '.join(map(str, member.columns))}}};",
            f"static const double FIXED[] = {_vector(member.fixed)};",
            *(f"#define {name} {value!r}" for name, value in numbers.items()),
            f"static const Rule RULE = {{{', '.join(repr(float(value)) for value in RULE)}}};",
            f"static const double X_LOWER[] = {_vector(problem.x_lower)};",
            f"static const double X_UPPER[] = {_vector(problem.x_upper)};",
            _shipped("mpc_step.c"),
        ]
    )


def replay_bytes(recording: Recording) -> bytes:
    """`replay.bin`, as `replay.c` reads it: little-endian doubles and 32-bit integers."""
    problem, nodes = recording.transcribed.problem, recording.transcribed.nodes
    parts = [struct.pack("<d6i", MAGIC, nodes, problem.nx, problem.nu, len(problem.parameters), SLOTS, 0), _raw(recording.steps_s)]
    for step in recording.steps:
        outcome = step.outcome
        parts.append(struct.pack("<5i", step.slot, step.warm, step.cap, ENDINGS.index(outcome.ending), outcome.iterations))
        parts += [_raw(step.x0), _raw(step.p)]
        if not step.warm:
            parts += [_raw(step.guess_x), _raw(step.guess_u)]
        parts += [_raw(outcome.x), _raw(outcome.u)]
    return b"".join(parts)


def files(recording: Recording) -> dict[str, bytes]:
    """Every file of an export by its name."""
    texts = {"mcdas_mpc.h": header(recording), "mcdas_mpc.c": solver(recording), "replay.c": _shipped("replay.c"), "Makefile": _makefile()}
    return {**{name: text.encode() for name, text in texts.items()}, "replay.bin": replay_bytes(recording)}


def _sizes(recording: Recording) -> dict[str, int]:
    problem: StageProblem = recording.transcribed.problem
    stage = BarrierStage(problem)
    sizes = {"NODES": recording.transcribed.nodes, "NX": stage.nx, "NU": stage.nu, "NS": stage.ns, "NC": stage.nc, "NP": stage.np}
    return {**sizes, "ITERATIONS": ITERATIONS}


def _enum(kind: str, names: Sequence[str], meanings: Sequence[str] = ()) -> str:
    entries = [f"    MCDAS_{kind}_{name.upper()}," for name in names]
    entries = [f"{entry} /* {said} */" for entry, said in zip(entries, meanings, strict=True)] if meanings else entries
    return "\n".join(["enum {", *entries, "};"])


def _vector(values: Array) -> str:
    return "{" + ", ".join(repr(float(v)) for v in np.clip(values, -_UNBOUNDED, _UNBOUNDED)) + "}"


def _raw(values: Array) -> bytes:
    return np.ascontiguousarray(values, dtype="<f8").tobytes()


def _shipped(name: str) -> str:
    return resources.files("mcdas_opt.interop.c_export").joinpath(name).read_text("utf-8")
