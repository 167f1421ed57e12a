"""From arrays of measured values to violations of rules, one a rule and trajectory."""

from __future__ import annotations

import numpy as np

from mcdas_opt.domain.rules import Array
from mcdas_opt.domain.verdict import Violation, ViolationKind


class Findings:
    """What has been found against each of several trajectories; values are (trajectories, m), their times (m,)."""

    def __init__(self, count: int) -> None:
        self.of: list[list[Violation]] = [[] for _ in range(count)]

    def add(self, which: int, kind: ViolationKind, t_s: float, value: float, limit: float, unit: str, body: str = "") -> None:
        self.of[which].append(Violation(kind=kind, t_s=float(t_s), value=float(value), limit=float(limit), unit=unit, body=body))

    def above(self, kind: ViolationKind, t_s: Array, value: Array, limit: float, allowed: float, unit: str) -> None:
        """The worst value where one exceeds `allowed` (the limit with its tolerance), or is none."""
        if value.max() <= allowed:
            return
        for which in np.flatnonzero(~(value.max(axis=-1) <= allowed)).tolist():
            worst = int(value[which].argmax())
            self.add(which, kind, t_s[worst], value[which, worst], limit, unit)

    def below(self, kind: ViolationKind, t_s: Array, value: Array, limit: float, allowed: float, unit: str) -> None:
        """The worst value where one is less than `allowed`, or is none."""
        if value.min() >= allowed:
            return
        for which in np.flatnonzero(~(value.min(axis=-1) >= allowed)).tolist():
            worst = int(value[which].argmin())
            self.add(which, kind, t_s[worst], value[which, worst], limit, unit)
