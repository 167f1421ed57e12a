"""Where the tuner may look: ranges of the adjustable numbers, and the unit cube they are drawn from."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from mcdas_opt.domain.declared_types import require_types
from mcdas_opt.domain.rules import Array, finite
from mcdas_opt.errors import ParameterError, nearest
from mcdas_opt.planning.adjustable import defaults


@dataclass(frozen=True, slots=True, kw_only=True)
class Range:
    """One adjustable number between `low` and `high`; `log`: its logarithm is drawn evenly."""

    name: str
    low: float
    high: float
    log: bool = False

    def __post_init__(self) -> None:
        require_types(self)
        known = defaults()
        if self.name not in known:
            raise ParameterError("search space", self.name, f"is not adjustable; {nearest(self.name, known)}")
        if not finite("low", self.low) < finite("high", self.high):
            raise ParameterError(self.name, (self.low, self.high), "bounds are in the wrong order: low, then high")
        if self.log and self.low <= 0.0:
            raise ParameterError(self.name, self.low, "a logarithmic range begins above 0")

    def at(self, share: float) -> float:
        """The value at a share of the range, 0 to 1."""
        if self.log:
            return math.exp(math.log(self.low) + share * math.log(self.high / self.low))
        return self.low + share * (self.high - self.low)

    def share(self, value: float) -> float:
        """The inverse of `at`."""
        if self.log:
            return math.log(value / self.low) / math.log(self.high / self.low)
        return (value - self.low) / (self.high - self.low)


SPACE = (
    Range(name="sigmoid.lateral_acceleration_mps2", low=2.5, high=6.0),
    Range(name="sigmoid.lateral_friction_share", low=0.45, high=0.8),
    Range(name="sigmoid.b", low=15.0, high=150.0, log=True),
    Range(name="stage.clearance_along_m", low=0.2, high=1.5),
    Range(name="stage.clearance_across_m", low=0.1, high=0.5),
    Range(name="selector.hysteresis", low=1.05, high=1.8),
    Range(name="selector.hold_s", low=0.1, high=1.0),
    Range(name="cost.persistence", low=0.3, high=0.95),
    Range(name="cost.nearness", low=2.0, high=15.0, log=True),
    Range(name="weight.path_deviation", low=0.5, high=8.0, log=True),
    Range(name="weight.delta_rate", low=1.0, high=25.0, log=True),
    Range(name="weight.jerk", low=0.002, high=0.05, log=True),
)


def values_at(space: Sequence[Range], shares: Array) -> dict[str, float]:
    """Names to values at a point of the unit cube."""
    return {part.name: part.at(float(share)) for part, share in zip(space, shares, strict=True)}


def shares_of(space: Sequence[Range], values: Mapping[str, float]) -> Array:
    """The point of the unit cube, clipped to it."""
    return np.clip([part.share(values[part.name]) for part in space], 0.0, 1.0)


def default_values(space: Sequence[Range]) -> dict[str, float]:
    known = defaults()
    return {part.name: min(max(known[part.name], part.low), part.high) for part in space}
