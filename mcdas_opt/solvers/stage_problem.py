"""An optimal control problem as its stage functions: what every engine takes, whatever method it runs."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mcdas_opt.domain.rules import Array


@dataclass(frozen=True, slots=True, kw_only=True)
class Member:
    """A problem as a member of a `ProblemFamily`: its numbers (sizes, then the finite bounds in the order of `BarrierStage.bounds`), how
    often it has the row, and where the family's parameters stand among its own: `columns`, -1 for one that is `fixed`; the row's own ones
    one instance after the other from `first_of_row` on."""

    numbers: Array
    times: int
    columns: NDArray[np.int64]
    fixed: Array
    first_of_row: int


@dataclass(frozen=True, slots=True, kw_only=True)
class StageProblem:
    """Minimise sum_k 1/2 |r_k|^2 + z1's_k + 1/2 s_k'Z2 s_k subject to the dynamics, soft rows g <= s, and bounds.

    With x (nx), u (nu), p (np) and step length h of a stage, the CasADi functions are
    `dynamics(x, u, p, h) -> x_next`, `residual(x, u, p) -> r` (weights inside), `terminal_residual(x, p) -> r`,
    `inequality(x, u, p) -> g`; row i of g is relaxed by slack `slack_of[i]` >= 0. Rows hold at the nodes 1..N (u = 0 at N); x bounds
    too, u bounds at 0..N-1. Scales bring every variable to order one.
    """

    name: str
    dynamics: Any
    residual: Any
    terminal_residual: Any
    inequality: Any
    slack_of: tuple[int, ...]
    slack_linear: Array
    slack_quadratic: Array
    x_lower: Array
    x_upper: Array
    u_lower: Array
    u_upper: Array
    x_scale: Array
    u_scale: Array
    s_scale: Array
    states: tuple[str, ...]
    inputs: tuple[str, ...]
    parameters: tuple[str, ...]
    rows: tuple[str, ...]
    slacks: tuple[str, ...]
    member: Member | None = None  # of a family that has compiled stage functions

    @property
    def nx(self) -> int:
        return len(self.states)

    @property
    def nu(self) -> int:
        return len(self.inputs)

    @property
    def ns(self) -> int:
        return len(self.slacks)

    @property
    def ng(self) -> int:
        return len(self.rows)


@dataclass(frozen=True, slots=True, kw_only=True)
class StageGuess:
    """Where an engine starts: states (N + 1, nx), inputs (N, nu), slacks (N + 1, ns), and multipliers in the engine's own order."""

    x: Array
    u: Array
    s: Array
    multipliers: Array = field(default_factory=lambda: np.zeros(0))


@dataclass(frozen=True, slots=True, kw_only=True)
class ProblemFamily:
    """What the members share. `problem` is the one without the repeated row; its last `sizes` parameters are numbers of the member, the
    same at all nodes, as are the finite bounds. `row(x, sizes, own parameters) -> g` is relaxed by the slack `row_slack`."""

    problem: StageProblem
    sizes: int
    row: Any
    row_parameters: int
    row_slack: int
