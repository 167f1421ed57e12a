"""An ordinary cycle stays small: what it does is counted in calls, which no machine makes faster or slower."""

from __future__ import annotations

from collections.abc import Callable
from cProfile import Profile
from pstats import Stats
from typing import Any

import pytest

from mcdas_opt import Planner, load_scene, simulate
from mcdas_opt.native.library import library

MOST_OF_A_PLAN, MOST_OF_A_SCAN = 3000, 300  # a tenth more than were counted (2,748 and 266); to be raised on purpose alone
pytestmark = pytest.mark.skipif(library() is None, reason="there is no native library")


def counted(planner: Planner, owner: Any, name: str) -> float:
    """Calls, of Python's functions and of C's, that a call of this one makes on average of a drive behind others."""
    function: Callable[..., Any] = getattr(owner, name)
    calls, times = Profile(), 0

    def run(*given: Any) -> Any:
        nonlocal times
        times += 1
        return calls.runcall(function, *given)

    setattr(owner, name, run)
    simulate(load_scene("benign-following"), planner, seed=0)
    return Stats(calls).total_calls / times  # type: ignore[attr-defined]


def test_a_plan_where_nothing_threatens() -> None:
    planner = Planner()
    assert 500 < counted(planner, planner, "plan") < MOST_OF_A_PLAN


def test_a_scan_in_which_nobody_is_new() -> None:
    planner = Planner()
    assert 50 < counted(planner, planner.tracker, "update") < MOST_OF_A_SCAN
