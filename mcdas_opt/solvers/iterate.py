"""Where an interior point stands: the arrays that a kernel works on, one row a node."""

from __future__ import annotations

from typing import Protocol

import numpy as np

from mcdas_opt.solvers.barrier_stage import BarrierStage
from mcdas_opt.solvers.newton_loop import LoopEnd, LoopRule, Progress


class Iterate:
    """States and inputs z (N + 1, nz), slacks s (N + 1, ns), t and multiplier (N + 1, nc); parameters p and step lengths beside them.

    `least` (N + 1, ns) are the slacks that the rows need at z.
    """

    def __init__(self, stage: BarrierStage, nodes: int) -> None:
        n = nodes + 1
        self.z, self.s, self.least = np.zeros((n, stage.nz)), np.zeros((n, stage.ns)), np.zeros((n, stage.ns))
        self.t, self.multiplier = np.ones((n, stage.nc)), np.zeros((n, stage.nc))
        self.p, self.steps = np.zeros((n, stage.np)), np.zeros(n)

    @property
    def multipliers(self) -> int:
        """How many numbers a warm start holds besides z: s, t and multiplier of every node."""
        return self.s.size + 2 * self.t.size


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
