"""Whether tuning helped: defaults and tuned values on the test scenes, which neither the search nor its acceptance has seen."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from mcdas_opt.domain.declared_types import require_types
from mcdas_opt.evaluation.statistics import LEVEL, Pairs, Share
from mcdas_opt.tuning.traffic import DriveFigures, cost_of


@dataclass(frozen=True, slots=True, kw_only=True)
class Gain:
    """`defaults`, `tuned`: how many of the scenes collided. `better`, `worse`: in how many scenes the tuned values have the lower or the
    higher score; `score_difference`: tuned less default, the mean over the scenes (0 without any)."""

    defaults: Share
    tuned: Share
    better: int
    worse: int
    score_difference: float

    def __post_init__(self) -> None:
        require_types(self)

    @property
    def p(self) -> float:
        """Two-sided exact sign test over the scenes whose scores differ."""
        return Pairs(first="defaults", second="tuned", n=self.tuned.n, only_first=self.better, only_second=self.worse).p

    @property
    def helped(self) -> bool:
        """Lower scores that are hardly chance, lower in the mean too, and no collision more."""
        return self.better > self.worse and self._is_plain and self.score_difference < 0.0 and self.tuned.k <= self.defaults.k

    @property
    def verdict(self) -> str:
        """One sentence."""
        if not self.tuned.n:
            return "nothing is known of other scenes: there was none to test on"
        if not self.better and not self.worse:
            return "no better than the defaults: the same scores"
        told = f"score lower in {self.better}, higher in {self.worse} of {self.tuned.n} test scenes, p = {self.p:.2g}"
        if self.helped:
            return f"better than the defaults: {told}"
        if self.tuned.k > self.defaults.k:
            return f"no better than the defaults: collides in {self.tuned.k} of {self.tuned.n} test scenes, they in {self.defaults.k}"
        if self.worse > self.better and self._is_plain:
            return f"worse than the defaults: {told}"
        if self.better > self.worse and self.score_difference < 0.0:
            return f"not shown to be better than the defaults: {told}, which may be chance; more scenes would tell"
        return f"no better than the defaults: {told}"

    @property
    def _is_plain(self) -> bool:
        return self.p < 1.0 - LEVEL

    def to_dict(self) -> dict[str, Any]:
        """As in the JSON document of a study."""
        counts = {"better": self.better, "worse": self.worse, "score_difference": self.score_difference, "p": self.p}
        shares = {"defaults": self.defaults.to_dict(), "tuned": self.tuned.to_dict()}
        return {**shares, **counts, "helped": self.helped, "verdict": self.verdict}


def gain_of(default: Sequence[DriveFigures], tuned: Sequence[DriveFigures]) -> Gain:
    """From the same scenes driven with either values, in the same order."""
    differences = [cost_of([new]).score - cost_of([old]).score for old, new in zip(default, tuned, strict=True)]
    return Gain(
        defaults=Share(k=sum(one.collided for one in default), n=len(default)),
        tuned=Share(k=sum(one.collided for one in tuned), n=len(tuned)),
        better=sum(difference < 0.0 for difference in differences),
        worse=sum(difference > 0.0 for difference in differences),
        score_difference=float(np.mean(differences)) if differences else 0.0,
    )
