"""Methods of others, who answer with drives of any sampling, size and length, with refusals and exceptions."""

from __future__ import annotations

import dataclasses
import warnings
from dataclasses import dataclass
from functools import partial

import numpy as np
from hypothesis import strategies as st

from benchmarks.attack.campaign import examples
from benchmarks.attack.strategies import EXTREMES, NOT_FINITE, situations
from benchmarks.attack.tally import Tally
from mcdas_opt import Plan, Planner, Situation, Vehicle
from mcdas_opt.domain.plan import Refusal
from mcdas_opt.domain.trajectory import Trajectory
from mcdas_opt.domain.verdict import Verdict
from mcdas_opt.domain.vocabulary import Mode, Side
from mcdas_opt.errors import ParameterError, PlannerFaultWarning

_CYCLES = 4  # of a method
_DRIVES = ("s_m", "d_m", "heading_rad", "speed_mps", "acceleration_mps2", "steering_rad")


@dataclass(frozen=True, slots=True, kw_only=True)
class _Answer:
    """The host's speed held for `length_s` in so many samples, with a column changed; or else a refusal or an exception."""

    samples: int
    length_s: float
    changes: dict[str, float]
    instead: Refusal | Exception | None = None


class _Theirs:
    vehicle, has_ladder = Vehicle(), True

    def __init__(self, answers: list[_Answer]) -> None:
        self._answers = iter(answers)

    def plan(self, situation: Situation, previous: Plan | None) -> Plan | Refusal:
        answer = next(self._answers)
        if isinstance(answer.instead, Exception):
            raise answer.instead
        if answer.instead is not None:
            return answer.instead
        host, t = situation.host, np.linspace(0.0, answer.length_s, answer.samples)
        states = np.tile(host.to_vector(), (t.size, 1))
        states[:, 0] += host.speed_mps * t
        for name, value in answer.changes.items():
            states[t.size // 2 :, _DRIVES.index(name)] += value
        drive = Trajectory.from_states(t, states, np.zeros((t.size - 1, 2)))
        return Plan(planner="theirs", mode=Mode.HOLD, side=Side.NONE, prediction="", verdict=Verdict(), trajectory=drive)


def attack(tally: Tally, count: int, seed: int) -> None:
    """So many plans, about."""

    def ask(asked: tuple[list[_Answer], tuple[Situation, ...]]) -> None:
        answers, traffic = asked
        planner = Planner(method=_Theirs(answers))
        for k, situation in enumerate(traffic[:_CYCLES]):
            later = dataclasses.replace(situation, time_s=situation.time_s + 0.1 * k, destination=None)
            plan = tally.ask(partial(planner.plan, later), lambda s=later: f"{answers}, {s.to_json()}", may_refuse=False)
            if plan is not None:
                tally.check_plan(plan, later)

    with warnings.catch_warnings():
        warnings.simplefilter("ignore", PlannerFaultWarning)  # it is what they are to say
        with np.errstate(all="ignore"):
            examples(st.tuples(st.lists(_answers(), min_size=_CYCLES, max_size=_CYCLES), situations()), ask, max(count // _CYCLES, 1), seed)


def _answers() -> st.SearchStrategy[_Answer]:
    changes = st.dictionaries(st.sampled_from(_DRIVES), st.one_of(st.floats(-3.0, 3.0), st.sampled_from(EXTREMES + NOT_FINITE)), max_size=2)
    raised = st.sampled_from(
        (ZeroDivisionError("of theirs"), ValueError(""), RecursionError(), MemoryError(), ParameterError("x", 1.0, "must be 2"))
    )
    return st.builds(
        _Answer,
        samples=st.sampled_from((2, 3, 41, 2001, 20_001)),
        length_s=st.sampled_from((1e-9, 1e-3, 0.1, 4.0, 60.0, 1e6)),
        changes=changes,
        instead=st.one_of(st.none(), st.none(), st.none(), st.just(Refusal(reason="no")), raised),
    )
