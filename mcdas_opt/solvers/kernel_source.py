"""The C text of a family's stage functions, which the compiled kernel includes: sizes, penalties, functions."""

from __future__ import annotations

from collections.abc import Iterable

from mcdas_opt.native.binding import defined
from mcdas_opt.solvers.c_text import Arguments, c_function
from mcdas_opt.solvers.interpreted_kernel import CORRECTION
from mcdas_opt.solvers.stage_functions import family_functions
from mcdas_opt.solvers.stage_problem import ProblemFamily

LANES = 8  # stages of a block: the widest vectors
_LOOPS = ("evaluate", "gradient", "steps", "cold", "warm", "measure")  # over blocks; the sweeps go stage by stage
_STAGE = {
    "evaluate": Arguments(constants=(9,)),
    "cold": Arguments(values=(4, 5), constants=(7,)),
    "warm": Arguments(values=(7, 8), constants=(9,)),
    "measure": Arguments(constants=(6,)),
}
_ROW = {
    "evaluate": Arguments(constants=(7,), repeated=((2, 3, 4), (1, 2)), sums={0: 6}),
    "gradient": Arguments(repeated=((0, 1, 2), ()), sums={0: 3}),
    "steps": Arguments(repeated=((0, 1, 2, 3), (1, 2)), sums={0: 7}),
    "least": Arguments(constants=(3,), repeated=((1,), ()), sums={0: 2}),
    "cold": Arguments(values=(4, 5), constants=(6,), repeated=((1,), (0, 1))),
    "warm": Arguments(values=(6, 7), constants=(8,), repeated=((2, 3, 4), (0, 1))),
}


def stage_text(family: ProblemFamily) -> str:
    """The text. Raises `c_text.UnsupportedOperationError` when a stage function uses what has no C text."""
    stage, f, row = family_functions(family)
    sizes = {
        "LANES": LANES,
        "NX": stage.nx,
        "NU": stage.nu,
        "NZ": stage.nz,
        "NS": stage.ns,
        "NC": stage.nc,
        "NP": stage.np,
        "NROWS": stage.ng,
        "NINNER": stage.inner,
        "NNUMBERS": family.sizes + len(stage.bounds),
        "ND": f.evaluate.size1_out(0),
        "NVALUE": f.terminal.size1_out(0),
        "NFEEDBACK": f.backward.size1_out(1),
        "NMEMORY": f.backward.size1_out(2),
        "NROWP": family.row_parameters,
        "NROWDATA": row.evaluate.size1_out(1),
        "NSUMS": row.evaluate.size1_out(0),
        "NYSUMS": row.gradient.size1_out(0),
        "CORRECTION": CORRECTION,
    }
    parts = [
        f"/* Generated: the stage functions of every {family.problem.name} problem. */",
        defined(sizes) + f"static const double PRICE_LINEAR[] = {_vector(family.problem.slack_linear)};",
        f"static const double PRICE_QUADRATIC[] = {_vector(family.problem.slack_quadratic)};",
    ]
    for name, function in zip(f._fields, f, strict=True):
        parts.append(c_function(function, loop=name in _LOOPS, arguments=_STAGE.get(name, Arguments())))
    for name, function in zip(row._fields, row, strict=True):
        parts.append(c_function(function, loop=True, arguments=_ROW[name]))
    return "\n".join(parts)


def _vector(values: Iterable[float]) -> str:
    return "{" + ", ".join([*(repr(float(v)) for v in values), "0.0"]) + "}"  # never empty
