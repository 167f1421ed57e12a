"""The fallback ladder: what passes only because it is over soon is no plan."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from mcdas_opt.catalogue.vehicles import load_vehicle
from mcdas_opt.domain.grid import TimeGrid
from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.settings import Settings
from mcdas_opt.domain.situation import Coverage, Situation
from mcdas_opt.domain.trajectory import Trajectory
from mcdas_opt.domain.vocabulary import Mode, Side, Status
from mcdas_opt.planning.cycle import Cycle
from mcdas_opt.planning.fallback.ladder import NothingPasses, fall_back
from mcdas_opt.planning.memory import Memory, PreviousPlan
from tests.planning.situations import car

SPEED_MPS = 12.0


def steady(seconds: float) -> Trajectory:
    t = np.round(np.arange(0.0, seconds + 0.05, 0.1), 9)
    states = np.zeros((t.size, 6))
    states[:, 0], states[:, 3] = SPEED_MPS * t, SPEED_MPS
    return Trajectory.from_states(t, states, np.zeros((t.size - 1, 2)))


@pytest.mark.parametrize("left_s", [0.2, 0.5, 0.9])
def test_the_last_moment_of_a_plan_is_no_plan_before_a_wall(left_s: float) -> None:
    """Going on for so long touches nobody, and braking does not do: the remainder passed, again and again, until it was used up."""
    tracks = (car("wall", 16.0, 0.0, 0.0), car("behind", -12.0, 0.0, 14.5))
    situation = Situation(time_s=5.0, host=HostState(speed_mps=SPEED_MPS), tracks=tracks, road=Road(), coverage=Coverage())
    previous = PreviousPlan(trajectory=steady(left_s + 0.1), mode=Mode.HOLD, side=Side.NONE)
    memory = Memory(situation=replace(situation, time_s=4.9), previous=previous)
    plan = fall_back(Cycle.of(situation, load_vehicle("sedan"), None, memory), NothingPasses(reason="nothing"))
    assert plan.status is Status.UNAVOIDABLE
    assert plan.trajectory.t_s[-1] >= 4.0
    assert float(plan.trajectory.acceleration_mps2.min()) <= -2.0


@pytest.mark.parametrize("gap_m", [14.0, 18.0, 24.0])
def test_a_horizon_that_is_shorter_than_that_still_has_an_answer(gap_m: float) -> None:
    """Everything passes for so long, and nothing ends safely."""
    settings = Settings(grid=TimeGrid(steps_s=np.full(8, 0.1)))
    tracks = (car("wall", gap_m, 0.0, 0.0), car("behind", -12.0, 0.0, 14.5))
    situation = Situation(time_s=5.0, host=HostState(speed_mps=SPEED_MPS), tracks=tracks, road=Road(), coverage=Coverage())
    plan = fall_back(Cycle.of(situation, load_vehicle("sedan"), settings), NothingPasses(reason="nothing"))
    assert plan.status in (Status.FALLBACK, Status.UNAVOIDABLE)
    assert (plan.status is Status.FALLBACK) == plan.verdict.passed
