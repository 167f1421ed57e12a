"""What a plan asks of the car at a time: its own states on the way, its last one past the end."""

from __future__ import annotations

import math

import numpy as np
import pytest

import mcdas_opt as mo
from mcdas_opt.domain.plan import Plan
from mcdas_opt.errors import ParameterError


@pytest.fixture(scope="module")
def plan() -> Plan:
    front = mo.Track(id="front", s_m=30.0, d_m=0.0, speed_s_mps=4.0)
    return mo.plan(mo.Situation(host=mo.HostState(speed_mps=11.0), tracks=(front,), coverage=mo.Coverage(), road=mo.Road(lanes_left=1)))


def test_commands_are_the_samples_and_what_constant_inputs_make_of_them_in_between(plan: Plan) -> None:
    driven = plan.trajectory
    for k in range(len(driven) - 1):
        after = 0.3 * (driven.t_s[k + 1] - driven.t_s[k])
        acceleration, steering = plan.command_at(float(driven.t_s[k] + after))
        assert acceleration == pytest.approx(driven.acceleration_mps2[k] + after * driven.jerk_mps3[k], abs=1e-3)
        assert steering == pytest.approx(driven.steering_rad[k] + after * driven.steering_rate_radps[k], abs=1e-3)
    at = [plan.command_at(t) for t in driven.t_s.tolist()]
    assert np.allclose(at, np.column_stack((driven.acceleration_mps2, driven.steering_rad)), atol=0.0)


def test_past_the_end_the_last_sample_is_held(plan: Plan) -> None:
    driven = plan.trajectory
    later = plan.command_at(float(driven.t_s[-1]) + 5.0)
    assert later == driven.command_at(1e6) == (driven.acceleration_mps2[-1], driven.steering_rad[-1])


@pytest.mark.parametrize("t_s", [math.nan, math.inf, -0.01, "0.1"])
def test_a_time_that_is_none_is_refused(plan: Plan, t_s: float) -> None:
    with pytest.raises(ParameterError, match="t_s"):
        plan.command_at(t_s)
