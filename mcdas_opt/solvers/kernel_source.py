"""The C text of the compiled kernel: sizes and generated stage functions, which stand before the kernel itself."""

from __future__ import annotations

from collections.abc import Iterable

from mcdas_opt.native.binding import defined
from mcdas_opt.native.build import text_of
from mcdas_opt.native.kernels import INTERIOR_POINT
from mcdas_opt.solvers.barrier_stage import BarrierStage
from mcdas_opt.solvers.c_text import c_function
from mcdas_opt.solvers.stage_functions import StageFunctions

BUILDS = INTERIOR_POINT.builds
PORTABLE = BUILDS[-1:]

_LANES = 8  # stages are padded to a whole number of the widest vectors
_LOOPS = ("evaluate", "gradient", "steps", "cold", "warm", "measure")  # over all stages; the sweeps go stage by stage
_SHARED = {"cold": (4, 5), "warm": (7, 8)}  # inputs mu and least


def kernel_source(stage: BarrierStage, f: StageFunctions, nodes: int, correction: float) -> str:
    """The kernel behind its `stage_text`: one text that is complete."""
    return stage_text(stage, f, nodes, correction) + "".join(map(text_of, INTERIOR_POINT.texts))


def stage_text(stage: BarrierStage, f: StageFunctions, nodes: int, correction: float) -> str:
    """What stands before the kernel. Raises `c_text.UnsupportedOperationError` when a stage function uses what has no C text."""
    sizes = {
        "NODES": nodes,
        "LD": -(-(nodes + 1) // _LANES) * _LANES,
        "NX": stage.nx,
        "NU": stage.nu,
        "NZ": stage.nz,
        "NS": stage.ns,
        "NC": stage.nc,
        "NP": stage.np,
        "NINNER": stage.inner,
        "ND": f.evaluate.size1_out(0),
        "NVALUE": f.terminal.size1_out(0),
        "NFEEDBACK": f.backward.size1_out(1),
        "NMEMORY": f.backward.size1_out(2),
    }
    numbers = {"NACTIVE": float(stage.over(nodes)[2]), "CORRECTION": correction}
    parts = [text_of("stage_functions.h"), defined({**sizes, **numbers})]
    parts += [
        f"static const double PRICE_LINEAR[] = {_vector(stage.problem.slack_linear)};",
        f"static const double PRICE_QUADRATIC[] = {_vector(stage.problem.slack_quadratic)};",
    ]
    for name, function in zip(f._fields, f, strict=True):
        parts.append(c_function(function, loop=name in _LOOPS, shared=_SHARED.get(name, ())))
    return "\n".join(parts)


def _vector(values: Iterable[float]) -> str:
    return "{" + ", ".join([*(repr(float(v)) for v in values), "0.0"]) + "}"  # never empty
