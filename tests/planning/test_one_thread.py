"""A planner that two threads are in at the same time refuses the second one; its first one's answer stays what it is."""

from __future__ import annotations

import copy
import threading
from collections.abc import Callable

import pytest

from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.plan import Plan, Refusal
from mcdas_opt.domain.situation import Coverage, Situation
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.errors import SharedPlannerError
from mcdas_opt.planning.planner import Planner

SITUATION = Situation(host=HostState(speed_mps=20.0), coverage=Coverage())


class Waiting:
    """Refuses once it is allowed to go on."""

    has_ladder = True
    vehicle = Vehicle()

    def __init__(self) -> None:
        self.entered, self.go_on = threading.Event(), threading.Event()

    def plan(self, situation: Situation, previous: Plan | None) -> Plan | Refusal:
        self.entered.set()
        assert self.go_on.wait(60.0)
        return Refusal(reason="asked to")


def test_a_second_thread_is_refused_and_the_first_one_has_its_answer() -> None:
    method, answers = Waiting(), list[Plan]()
    planner = Planner(method=method)
    first = threading.Thread(target=lambda: answers.append(planner.plan(SITUATION)))
    first.start()
    assert method.entered.wait(60.0)
    doors: tuple[Callable[[], object], ...] = (
        lambda: planner.plan(SITUATION),
        lambda: planner.step([], SITUATION.host, 0.0),
        lambda: planner.set_destination(None),
        lambda: planner.set_zero_sideslip_point(1.0),
        planner.reset,
    )
    for ask in doors:
        with pytest.raises(SharedPlannerError, match="another thread is in it"):
            ask()
    method.go_on.set()
    first.join(60.0)
    assert "asked to" in answers[0].reason
    planner.reset()
    assert planner.plan(SITUATION).trajectory.table.tobytes() == answers[0].trajectory.table.tobytes()


def test_threads_may_take_turns_and_a_planner_can_be_copied() -> None:
    planner = copy.copy(Planner(method="closed-form-corrected"))
    answers = [planner.plan(SITUATION)]
    other = threading.Thread(target=lambda: answers.append(planner.plan(SITUATION)))
    other.start()
    other.join(60.0)
    assert len(answers) == 2
