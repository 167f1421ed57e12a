"""Where an interior point stands: the arrays that a kernel works on, one row a node."""

from __future__ import annotations

from typing import Protocol

import numpy as np

from mcdas_opt.solvers.barrier_stage import BarrierStage
from mcdas_opt.solvers.newton_loop import LoopEnd, LoopRule, Progress


class Iterate:
    """States and inputs z (N + 1, nz), slacks s (N + 1, ns), t and multiplier (N + 1, nc); parameters p and step lengths beside them.

    `least` (N + 1, ns) are the slacks that the rows need at z. What a warm start holds besides z lies in one vector, `multipliers`: all of
    s, then t, then multiplier, which are views into it.
    """

    def __init__(self, stage: BarrierStage, nodes: int) -> None:
        n, ns, nc = nodes + 1, stage.ns, stage.nc
        self.z, self.least = np.zeros((n, stage.nz)), np.zeros((n, ns))
        self.multipliers = np.zeros(n * (ns + 2 * nc))
        s, t, multiplier = np.split(self.multipliers, (n * ns, n * (ns + nc)))
        self.s, self.t, self.multiplier = s.reshape(n, ns), t.reshape(n, nc), multiplier.reshape(n, nc)
        self.t[:] = 1.0
        self.p, self.steps = np.zeros((n, stage.np)), np.zeros(n)


class Kernel(Protocol):
    """Moves an `Iterate`; see `InterpretedKernel` for what each method does, `newton_loop` for `loop`."""

    @property
    def kind(self) -> str: ...
    @property
    def iterate(self) -> Iterate: ...
    def cold(self, mu: float, least: float) -> bool: ...
    def warm(self, mu: float, least: float) -> bool: ...
    def newton(self, *, corrected: bool, mu: float, boundary: float, longest: float) -> Progress: ...
    def measure(self) -> tuple[float, float]: ...
    def loop(self, *, warm: bool, iterations: int, rule: LoopRule) -> LoopEnd: ...
