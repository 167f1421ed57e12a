"""The time grid as data."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from mcdas_opt.domain.rules import Array, floats
from mcdas_opt.errors import ParameterError

_MOST_STEPS, _SHORTEST_S = 1000, 1e-3


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class TimeGrid:
    """Step lengths [s] of a horizon, not necessarily even; at most 0.1 s each (the contract's sampling)."""

    steps_s: Array = field(default_factory=lambda: np.full(40, 0.1))
    times_s: Array = field(init=False, repr=False)
    """(N + 1,), from 0. Rounded to a nanosecond, so that 0.1 s steps print as such."""

    def __post_init__(self) -> None:
        steps = floats("steps_s", self.steps_s, "must be at least two positive steps", "s")
        if steps.ndim != 1 or steps.size < 2 or not np.all(np.isfinite(steps)) or steps.min() <= 0.0:
            raise ParameterError("steps_s", self.steps_s, "must be at least two positive steps", "s")
        if steps.max() > 0.1 + 1e-9:
            raise ParameterError("steps_s", float(steps.max()), "no step may exceed 0.1 s", "s")
        if not TimeGrid.holds(steps):
            rule = f"must be at most {_MOST_STEPS} steps, none of them under {_SHORTEST_S:g}"
            raise ParameterError("steps_s", f"{steps.size} steps, the shortest {steps.min():g}", rule, "s")
        steps.setflags(write=False)
        object.__setattr__(self, "steps_s", steps)
        times = np.round(np.concatenate([[0.0], np.cumsum(steps)]), 9)
        times.setflags(write=False)
        object.__setattr__(self, "times_s", times)

    def __eq__(self, other: object) -> bool:
        """Every step the same, to the bit."""
        return isinstance(other, TimeGrid) and self.steps_s.tobytes() == other.steps_s.tobytes()

    def __hash__(self) -> int:
        return hash(self.steps_s.tobytes())

    @staticmethod
    def holds(steps_s: Array) -> bool:
        """Whether there are not too many steps for a grid, nor too short ones."""
        return steps_s.size <= _MOST_STEPS and float(steps_s.min()) >= _SHORTEST_S

    @property
    def nodes(self) -> int:
        """Number of steps N; there are N + 1 times."""
        return int(self.steps_s.size)
