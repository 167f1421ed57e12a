"""The C text of the compiled kernel: sizes, generated stage functions, and the kernel itself."""

from __future__ import annotations

from collections.abc import Iterable
from importlib import resources

from mcdas_opt.native.compile_cache import HEAD as HEAD
from mcdas_opt.solvers.barrier_stage import BarrierStage
from mcdas_opt.solvers.c_text import c_function
from mcdas_opt.solvers.stage_functions import StageFunctions

# best first. Measured on AVX-512, a plain iteration with three neighbours: 14 us, 37 us, 45 us. Portable is what the last one is.
_FAST = "-O2 -ftree-vectorize -march=native -fno-math-errno -fno-trapping-math"
BUILDS = (f"{_FAST} -fno-builtin-sin -fno-builtin-cos -DVECTOR_MATH -lmvec -lm", f"{_FAST} -lm", "-O2 -lm")
PORTABLE = BUILDS[-1:]

_LANES = 8  # stages are padded to a whole number of the widest vectors
_VECTORISED = ("sin", "cos", "tan", "atan", "exp", "log", "tanh")  # of glibc's libmvec, version 2.35
_LOOPS = ("evaluate", "gradient", "steps", "cold", "warm", "measure")  # over all stages; the sweeps go stage by stage
_SHARED = {"cold": (4, 5), "warm": (7, 8)}  # inputs mu and least


def kernel_source(stage: BarrierStage, f: StageFunctions, nodes: int, correction: float) -> str:
    """Raises `c_text.UnsupportedOperationError` when a stage function uses what has no C text."""
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
    parts = [HEAD, "#ifdef VECTOR_MATH /* declared pure and for vectors, so that loops over stages call libmvec */"]
    parts += [f'double {name}(double) __attribute__((simd("notinbranch"), const));' for name in _VECTORISED]
    parts += ["#endif", *(f"#define {name} {size}" for name, size in sizes.items()), *(f"#define {n} {v!r}" for n, v in numbers.items())]
    parts += [
        f"static const double PRICE_LINEAR[] = {_vector(stage.problem.slack_linear)};",
        f"static const double PRICE_QUADRATIC[] = {_vector(stage.problem.slack_quadratic)};",
    ]
    for name, function in zip(f._fields, f, strict=True):
        parts.append(c_function(function, loop=name in _LOOPS, shared=_SHARED.get(name, ())))
    parts.append(resources.files("mcdas_opt.solvers").joinpath("interior_point_kernel.c").read_text("utf-8"))
    return "\n".join(parts)


def _vector(values: Iterable[float]) -> str:
    return "{" + ", ".join([*(repr(float(v)) for v in values), "0.0"]) + "}"  # never empty
