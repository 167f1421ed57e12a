"""A designed sigmoid: the three numbers of eq 20-23, and what they were designed for."""

from __future__ import annotations

import math
from dataclasses import dataclass

from mcdas_opt.domain.rules import finite, positive, require, word
from mcdas_opt.domain.vocabulary import Side
from mcdas_opt.errors import ParameterError


@dataclass(frozen=True, slots=True, kw_only=True)
class SigmoidDesign:
    """d(x) = reach (S(x) - S(0)) / (S(X) - S(0)) to `side`, S(x) = 1 / (1 + b exp(a x)), X = -2 ln(b) / a.

    `offset_m` = d_front - d_host, left positive: the left path reaches y_max + offset, the right one y_max - offset (eq 22-23).
    """

    a_per_m: float
    b: float
    y_max_m: float
    offset_m: float = 0.0
    side: Side = Side.LEFT

    def __post_init__(self) -> None:
        if finite("a_per_m", self.a_per_m, "1/m") >= 0.0:
            raise ParameterError("a_per_m", self.a_per_m, "must be less than 0", "1/m")
        if finite("b", self.b) <= 1.0:
            raise ParameterError("b", self.b, "must be greater than 1")
        require(self, finite, "y_max_m", "offset_m")
        object.__setattr__(self, "side", word("side", self.side, Side))
        if self.side is Side.NONE:
            raise ParameterError("side", self.side.value, "must be left or right")
        positive("y_max_m plus the offset towards the side", self.reach_m, "m")

    @property
    def reach_m(self) -> float:
        """How far to the side the path ends [m], positive."""
        return self.y_max_m + self.side.sign * self.offset_m

    @property
    def end_m(self) -> float:
        """Where the path ends, X [m]."""
        return -2.0 * math.log(self.b) / self.a_per_m
