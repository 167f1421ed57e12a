"""How a solve ended: read the ending and finiteness before x."""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import StrEnum

import numpy as np

from mcdas_opt.domain.rules import Array, all_finite


class Ending(StrEnum):
    """`CONVERGED`: the step fell under tolerance. `LIMIT`: the iteration cap ended it with a finite point. The rest have no point."""

    CONVERGED = "converged"
    LIMIT = "iteration limit"
    INFEASIBLE = "infeasible"
    NOT_FINITE = "not finite"
    FAILED = "failed"


@dataclass(frozen=True, slots=True, kw_only=True)
class Outcome:
    """`x` (N + 1, nx), `u` (N, nu), `s` (N + 1, ns) may be read only when `usable`."""

    ending: Ending
    x: Array
    u: Array
    s: Array
    multipliers: Array = field(default_factory=lambda: np.zeros(0))
    objective: float = float("nan")
    iterations: int = 0
    inner_iterations: int = 0
    message: str = ""

    @property
    def usable(self) -> bool:
        if self.ending is not Ending.CONVERGED and self.ending is not Ending.LIMIT:
            return False
        return all_finite(self.x) and all_finite(self.u) and all_finite(self.s)
