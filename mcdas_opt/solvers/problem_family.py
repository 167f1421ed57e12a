"""Problems that differ in numbers alone, and in how often they have one soft row: they share their compiled stage functions."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from mcdas_opt.solvers.stage_problem import StageProblem


@dataclass(frozen=True, slots=True, kw_only=True)
class ProblemFamily:
    """What the members share. `problem` is the one without the repeated row; its last `sizes` parameters are numbers of the member, the
    same at all nodes, as are the finite bounds. `row(x, sizes, own parameters) -> g` is relaxed by the slack `row_slack`."""

    problem: StageProblem
    sizes: int
    row: Any
    row_parameters: int
    row_slack: int
