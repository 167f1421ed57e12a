"""The last cycle's solve serves the next one, however often and however evenly the planner is asked."""

from dataclasses import replace

import numpy as np
import pytest

from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.plan import Plan
from mcdas_opt.domain.situation import Situation
from mcdas_opt.domain.track import Coverage, Track
from mcdas_opt.planning.planner import Planner

NOISE_S = 4e-3
FOLLOWING = Situation(
    host=HostState(speed_mps=25.0),
    coverage=Coverage(),
    tracks=(Track(id="leader", s_m=45.0, d_m=0.0, speed_s_mps=25.0),),
)


def later(situation: Situation, plan: Plan, by_s: float, faster_mps: float = 0.0) -> Situation:
    drive = plan.trajectory
    s, d, psi, v, a, delta = (float(np.interp(by_s, drive.t_s, column)) for column in drive.table[1:7])
    host = HostState(s_m=s, d_m=d, heading_rad=psi, speed_mps=v, acceleration_mps2=a, steering_rad=delta)
    tracks = tuple(replace(t, s_m=t.s_m + by_s * t.speed_s_mps, speed_s_mps=t.speed_s_mps + faster_mps) for t in situation.tracks)
    return replace(situation, time_s=situation.time_s + by_s, host=host, tracks=tracks)


def newton_steps(cycle_s: float, noise_s: float = 0.0, faster_mps: float = 0.0) -> list[int]:
    planner, situation, random, steps = Planner(), FOLLOWING, np.random.default_rng(5), []
    for _ in range(12):
        plan = planner.plan(situation)
        steps.append(plan.iterations)
        situation = later(situation, plan, cycle_s + noise_s * float(random.uniform(-1.0, 1.0)), faster_mps)
    return steps


@pytest.mark.parametrize(("cycle_s", "noise_s"), [(0.1, 0.0), (0.1, 3e-4), (0.1, NOISE_S), (0.02, 0.0), (0.05, 0.0), (0.2, NOISE_S)])
def test_a_cycle_begins_from_the_last_one(cycle_s: float, noise_s: float) -> None:
    first, *others = newton_steps(cycle_s, noise_s)
    assert np.median(others) < 0.6 * first


def test_who_is_not_where_he_was_expected_makes_it_begin_anew() -> None:
    first, *others = newton_steps(0.1, faster_mps=-3.0)
    assert np.median(others) > 0.6 * first
