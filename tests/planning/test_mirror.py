"""Left and right are one."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from mcdas_opt.planning.planner import Planner
from tests.planning.situations import mirrored, random_sandwich, sandwich


@pytest.mark.parametrize("seed", range(100, 130))
def test_a_mirrored_situation_has_the_mirrored_plan_to_the_bit(seed: int) -> None:
    situation = random_sandwich(seed)
    plan, image = Planner().plan(situation).trajectory, Planner().plan(mirrored(situation)).trajectory
    assert np.array_equal(plan.d_m, -image.d_m)
    assert np.array_equal(plan.s_m, image.s_m)
    assert np.array_equal(plan.steering_rate_radps, -image.steering_rate_radps)


def test_so_has_a_manoeuvre_that_goes_on() -> None:
    here, there = Planner(), Planner()
    situation = sandwich(0.4)
    for k in range(6):
        now = replace(situation, time_s=round(0.1 * k, 1))
        plan, image = here.plan(now), there.plan(mirrored(now))
        assert np.array_equal(plan.trajectory.d_m, -image.trajectory.d_m)
        t = plan.trajectory
        moved = [replace(track, s_m=track.s_m + 0.1 * track.speed_s_mps) for track in situation.tracks]
        names = ("s_m", "d_m", "heading_rad", "speed_mps", "acceleration_mps2", "steering_rad")
        host = replace(situation.host, **{name: float(getattr(t, name)[1]) for name in names})
        situation = replace(situation, host=host, tracks=tuple(moved))
