"""A candidate of somebody's own that is faulty: it is refused by name, and the plan is the one without it."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from mcdas_opt.domain.vocabulary import Mode, Side
from mcdas_opt.errors import PlannerFaultWarning
from mcdas_opt.planning.candidate import Proposed
from mcdas_opt.planning.cycle import Cycle
from mcdas_opt.planning.planner import Planner
from mcdas_opt.planning.proposals import sampled
from mcdas_opt.planning.proposals.keep_lane import keep_path
from tests.planning.situations import sandwich


def creep(cycle: Cycle, **changes: Any) -> Proposed:
    sound = Proposed(name="creep", mode=Mode.BRAKE, side=Side.NONE, path=keep_path(cycle), speed_mps=2.0)
    return replace(sound, **changes)


def with_further(monkeypatch: pytest.MonkeyPatch, function: Any) -> tuple[Any, Any]:
    without = Planner().plan(sandwich())
    monkeypatch.setattr(sampled, "FURTHER", (*sampled.FURTHER, function))
    return without, Planner().plan(sandwich())


@pytest.mark.parametrize(
    ("changes", "says"),
    [
        ({"path": None}, "path"),
        ({"side": None}, "side"),
        ({"mode": "brake"}, "mode"),
        ({"speed_mps": 200.0}, r"speed_mps = 200.0 m/s: must lie in [0, 50]"),
        ({"speed_mps": np.nan}, "speed_mps"),
        ({"guess": np.zeros((3, 6))}, "guess = 'shape (3, 6)'"),
        ({"speeds_mps": np.full(41, np.nan)}, "speeds_mps"),
        ({"name": "left"}, "there is another 'left'"),
    ],
)
def test_a_faulty_one_is_refused_by_name(monkeypatch: pytest.MonkeyPatch, changes: dict[str, Any], says: str) -> None:
    def faulty(cycle: Cycle) -> Iterable[Proposed]:
        yield creep(cycle, **changes)

    without, plan = with_further(monkeypatch, faulty)
    (row,) = (one for one in plan.candidates if one.refusal.startswith("faulty: "))
    assert row.name == changes.get("name", "creep")
    assert says in row.refusal
    assert np.array_equal(plan.trajectory.table, without.trajectory.table)


@pytest.mark.parametrize("function", [creep, lambda cycle: 1 / 0, lambda cycle: None, lambda cycle: ["creep"]])
def test_a_function_that_fails_is_named(monkeypatch: pytest.MonkeyPatch, function: Any) -> None:
    with pytest.warns(PlannerFaultWarning, match=f"{function.__name__} failed: "):
        without, plan = with_further(monkeypatch, function)
    assert [one.name for one in plan.candidates if "failed: " in one.refusal] == [function.__name__]
    assert np.array_equal(plan.trajectory.table, without.trajectory.table)


def test_a_sound_one_competes(monkeypatch: pytest.MonkeyPatch) -> None:
    _, plan = with_further(monkeypatch, lambda cycle: [creep(cycle)])
    assert [one.refusal[:6] for one in plan.candidates if one.name == "creep"] in ([""], ["not so"])
