"""Shares with exact intervals, exact comparison of pairs, and quantiles that say when there is nothing to say."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from mcdas_opt.domain.declared_types import require_types
from mcdas_opt.errors import ParameterError

LEVEL = 0.95


@dataclass(frozen=True, slots=True, kw_only=True)
class Share:
    """k of n, with the interval of Clopper and Pearson (Biometrika 26, 1934) at level 0.95."""

    k: int
    n: int

    def __post_init__(self) -> None:
        require_types(self)
        if not 0 <= self.k <= self.n:
            raise ParameterError("k", self.k, f"must lie in [0, {self.n}]")

    @property
    def rate(self) -> float | None:
        return self.k / self.n if self.n else None

    @property
    def interval(self) -> tuple[float, float]:
        from scipy.special import betaincinv  # scipy.stats, which has it by name, takes a second to import

        tail = 0.5 * (1.0 - LEVEL)
        low = float(betaincinv(self.k, self.n - self.k + 1, tail)) if self.k > 0 else 0.0
        high = float(betaincinv(self.k + 1, self.n - self.k, 1.0 - tail)) if self.k < self.n else 1.0
        return low, high

    def to_dict(self) -> dict[str, Any]:
        return {"k": self.k, "n": self.n, "rate": self.rate, "low": self.interval[0], "high": self.interval[1], "level": LEVEL}


@dataclass(frozen=True, slots=True, kw_only=True)
class Pairs:
    """The same scenes by two planners: how often only the first and only the second lost, and whether that may be chance."""

    first: str
    second: str
    n: int
    only_first: int
    only_second: int

    @property
    def p(self) -> float:
        """Two-sided exact McNemar test: binomial with one half over the pairs that differ (McNemar, Psychometrika 12, 1947)."""
        from scipy.special import bdtr

        differing = self.only_first + self.only_second
        return min(1.0, 2.0 * float(bdtr(min(self.only_first, self.only_second), differing, 0.5))) if differing else 1.0

    def to_dict(self) -> dict[str, Any]:
        counts = {"first": self.first, "second": self.second, "n": self.n, "only_first": self.only_first, "only_second": self.only_second}
        return {**counts, "p": self.p}


def quantiles(values: Sequence[float | None], at: Sequence[float] = (0.05, 0.5, 0.95)) -> dict[str, Any]:
    """n, the quantiles (`p5`, `p50` ...), least and largest of the values that there are; None where there are none."""
    there = np.array([value for value in values if value is not None], dtype=np.float64)
    names = [f"p{100.0 * q:g}" for q in at]
    if not there.size:
        return {"n": 0, **dict.fromkeys([*names, "min", "max", "mean"])}
    found = dict(zip(names, (float(q) for q in np.quantile(there, at)), strict=True))
    return {"n": int(there.size), **found, "min": float(there.min()), "max": float(there.max()), "mean": float(there.mean())}
