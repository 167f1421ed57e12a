"""The exported files as text: generated header and solver, the shipped replay program, and the recording in bytes."""

from __future__ import annotations

import re
import struct
from collections.abc import Sequence
from importlib import resources

import numpy as np

from mcdas_opt import __version__
from mcdas_opt.domain.rules import Array
from mcdas_opt.interop.c_export.recording import ENDINGS, SLOTS, Recording
from mcdas_opt.native.binding import defined
from mcdas_opt.native.build import flags_of, text_of
from mcdas_opt.native.library import NoLibraryError, level_of, load
from mcdas_opt.solvers.barrier_stage import BarrierStage
from mcdas_opt.solvers.interior_point import ITERATIONS, LEAST_COLD, LEAST_WARM, MU_COLD, RULE
from mcdas_opt.solvers.stage_problem import StageProblem

MEANINGS = {
    "kappa": "the road's curvature at kappa_s, left positive [1/m]",
    "kappa_slope": "its change along the road [1/m^2]",
    "kappa_nose": "its mean from kappa_s to the nose, half a car further on, as it bends the road there [1/m]",
    "kappa_tail": "the same to the tail [1/m]",
    "kappa_s": "where along the road these hold: the s that is guessed for the node [m]",
    "ref_start_s": "s where the path to follow begins to steer out [m]",
    "ref_start_d": "d of that path before [m]",
    "ref_amplitude": "how far it goes aside, left positive [m]",
    "ref_a": "steepness of its sigmoid, less than 0 [1/m]",
    "ref_b": "the sigmoid's b, greater than 1: where along it the middle lies [-]",
    "ref_bend": "height of a hump on top of the amplitude, left positive [m]",
    "ref_bend_s": "s of the hump's middle [m]",
    "ref_bend_width": "the hump's width [m]",
    "speed_ref": "speed to drive towards [m/s]",
    "grip": "most that tyres give, along and across together [m/s^2]",
    "braking_unloads": "load that the braked axle loses per deceleration [s^2/m]",
    "brakes_by_load": "1: braking is shared between the axles by load; 0: by braking_pull [-]",
    "braking_pull": "braking force of the axle over its share of the mass, per deceleration of the car [-]",
    "driving_unloads": "load that the driven axle loses per acceleration [s^2/m]",
    "driving_pull": "force of the driven axle over its share of the mass, per acceleration of the car [-]",
    "left_edge": "d of the road's left edge [m], at edge_s where the edges slope",
    "right_edge": "d of the road's right edge [m], at edge_s where the edges slope",
    "left_slope": "change of the left edge's d along the road [-]",
    "right_slope": "change of the right edge's d along the road [-]",
    "edge_s": "s where both edges are as given [m]",
    "road_end": "s that the front bumper stays short of; far away without [m]",
    "front_bumper": "s of the rear bumper of the vehicle ahead; far away without [m]",
    "front_speed": "speed of the vehicle ahead [m/s]",
    "rear_bumper": "s of the front bumper of the vehicle behind; far behind without [m]",
    "rear_speed": "speed of the vehicle behind [m/s]",
    "standstill": "gap to keep at rest, ahead and behind [m]",
    "time_gap": "gap to keep ahead besides, per speed [s]",
    "most_acceleration": "acceleration that is comfortable [m/s^2]",
    "most_braking": "deceleration that is comfortable, greater than 0 [m/s^2]",
    "most_jerk": "jerk that is comfortable, either way [m/s^3]",
    "weight_path_deviation": "cost of being off the path [1/m^2]",
    "weight_heading_deviation": "cost of not heading along it [1/rad^2]",
    "weight_speed_deviation": "cost of another speed than speed_ref [s^2/m^2]",
    "weight_a": "cost of acceleration [s^4/m^2]",
    "weight_jerk": "cost of jerk [s^6/m^2]",
    "weight_delta_rate": "cost of the steering rate [s^2/rad^2]",
    "weight_lateral_acceleration": "cost of lateral acceleration [s^4/m^2]",
    "steering_rate_share": "share of the steering rate's limit that may be used [-]",
    "centre": "body centre ahead of the point that moves along the car's axis [m]",
    "body_s": "s of a neighbour's body centre [m]",
    "body_d": "d of a neighbour's body centre [m]",
    "body_along": "half its length, and the room kept around it [m]",
    "body_across": "half its width, and the room kept around it [m]",
}
KERNEL = "interior_point.c"
MAGIC = 20261.5  # a recording begins with it: another byte order reads something else
_UNBOUNDED = 1e300  # a bound that does not bind


def meaning(parameter: str) -> str:
    """What it means, and its unit. Raises `KeyError` for a parameter that nobody described."""
    return MEANINGS[re.sub(r"^body\d+_", "body_", parameter)]


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
    makefile = _shipped("Makefile.in").replace("@NATIVE_FLAGS@", native_flags())
    texts = {"mcdas_mpc.h": header(recording), "mcdas_mpc.c": solver(recording), "replay.c": _shipped("replay.c"), "Makefile": makefile}
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
