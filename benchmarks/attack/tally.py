"""What came of an attack: how often it was answered, refused in our own words, or something that must not be."""

from __future__ import annotations

import math
import time
import traceback
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, TypeVar

import numpy as np

from mcdas_opt import Plan, Situation, Status, Vehicle, verify
from mcdas_opt.domain.settings import PredictionSettings
from mcdas_opt.errors import McdasError

HANG_S = 2.0  # of the processor's time: a machine under load is no hang
_KEPT = 50_000  # characters of an input: whole, so that it can be asked again
T = TypeVar("T")


@dataclass(slots=True, kw_only=True)
class Tally:
    """Counts of one attack. `faults` holds for each distinct fault the shortest input that showed it. `different` are decisions that
    the origin of a clock has changed."""

    tried: int = 0
    answered: int = 0
    refused: int = 0
    foreign: int = 0
    hangs: int = 0
    non_finite: int = 0
    unverified: int = 0
    lost: int = 0
    different: int = 0
    worst_s: float = 0.0
    faults: dict[str, str] = field(default_factory=dict)
    counted: dict[str, int] = field(default_factory=dict)

    @property
    def wrong(self) -> int:
        return self.foreign + self.hangs + self.non_finite + self.unverified + self.lost + self.different

    def ask(self, question: Callable[[], T], shown: Callable[[], str], *, may_refuse: bool = True, most_s: float = HANG_S) -> T | None:
        """The answer; None where it was refused in our own words, or is a fault, which is counted: an exception of another kind, or any
        where none may be raised. Every other question is asked by somebody who has numpy raise at each underflow."""
        self.tried += 1
        began = time.process_time()
        try:
            with np.errstate(all="raise" if self.tried % 2 else None):
                answer = question()
        except Exception as error:
            answer = None
            if may_refuse and isinstance(error, McdasError):
                self.refused += 1
            else:
                self.fault(error, shown())
        else:
            self.answered += 1
        took = time.process_time() - began
        self.worst_s = max(self.worst_s, took)
        if took > most_s:
            self.hangs += 1
            self.note(f"longer than {most_s:g} s", shown())
        return answer

    def fault(self, error: Exception, shown: str) -> None:
        """An exception that must not be."""
        self.foreign += 1
        self.note(f"{type(error).__name__} in {_innermost(error)}: {str(error)[:80]}", shown)

    def add(self, what: str, count: int) -> None:
        """Something else that an attack counts: what is told of it under the table."""
        self.counted[what] = self.counted.get(what, 0) + count

    def note(self, fault: str, shown: str) -> None:
        """A fault with an input that shows it; of several the shortest is kept."""
        text = shown if len(shown) <= _KEPT else shown[:_KEPT] + " ..."
        if fault not in self.faults or len(text) < len(self.faults[fault]):
            self.faults[fault] = text

    def check_plan(
        self, plan: Plan, situation: Situation, vehicle: Vehicle | None = None, prediction: PredictionSettings | None = None
    ) -> None:
        """Finite, and what is not called unavoidable passes the judge, asked anew where the host's state could be believed. Where it does
        not pass so: with the followers braking whom its end names as expected to; where tracks are doubted, with those that it was planned
        around, which who remembers the cycles before may believe elsewhere than the judge does, who remembers nothing."""
        numbers_finite = bool(np.isfinite(plan.trajectory.table).all()) and all_finite(plan.to_dict())
        if not numbers_finite:
            self.non_finite += 1
            self.note("a number that is not finite left", situation.to_json())
            return
        if plan.status is Status.UNAVOIDABLE:
            return
        believed = "state cannot be" not in plan.reason
        try:
            passed = plan.verdict.passed and (not believed or verify(plan.trajectory, situation, None, prediction, vehicle).passed)
            relied = None if plan.safe_end is None else plan.safe_end.relies_on
            if plan.verdict.passed and not passed and relied is not None:
                passed = verify(plan.trajectory, situation, None, prediction, vehicle, relied).passed
                self.add("plans that rely on a follower to brake", 1)
            if plan.verdict.passed and not passed and plan.believed is not None and plan.believed is not plan.situation:
                passed = verify(plan.trajectory, plan.believed, None, prediction, vehicle, relied).passed
                self.add("plans around tracks that are doubted, judged as they were believed", 1)
        except Exception as error:
            self.foreign += 1
            self.note(f"the judge asked anew: {type(error).__name__} in {_innermost(error)}: {str(error)[:80]}", situation.to_json())
            return
        if not passed:
            self.unverified += 1
            self.note(f"unverified, called {plan.status.value}", situation.to_json())


def all_finite(document: Any) -> bool:
    """Whether every number of a JSON document is finite."""
    if isinstance(document, dict):
        return all(map(all_finite, document.values()))
    if isinstance(document, (list, tuple)):
        return all(map(all_finite, document))
    return not isinstance(document, float) or math.isfinite(document)


def _innermost(error: Exception) -> str:
    """The innermost place of the package that it came out of."""
    frames = traceback.extract_tb(error.__traceback__)
    ours = [frame for frame in frames if "mcdas_opt" in frame.filename] or frames
    return f"{ours[-1].filename.rpartition('mcdas_opt/')[2]}:{ours[-1].lineno}"
