"""What the simulated car really drove passes the judge: also through a stop, with commands beyond its actuators."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.vehicle import GRAVITY_MPS2
from mcdas_opt.simulation.kinematic_plant import KinematicPlant
from mcdas_opt.simulation.metrics import History, driven
from mcdas_opt.verification.judge import judge
from tests.verification.rollouts import NOBODY, SEDAN, WIDE, WIDE_CURVED


@settings(max_examples=12, deadline=None)
@given(seed=st.integers(0, 10**9), speed=st.floats(0.0, 12.0), braking=st.booleans())
@pytest.mark.parametrize("road", [WIDE, WIDE_CURVED], ids=["straight", "curved"])
def test_a_driven_trajectory_passes(road, seed, speed, braking):
    rng = np.random.default_rng(seed)
    start = HostState(speed_mps=speed)
    plant = KinematicPlant(SEDAN, road, start)
    states, applied = [plant.state.to_vector()], []
    for _ in range(25):
        jerk = rng.uniform(-60.0, 20.0) if braking else rng.uniform(-40.0, 40.0)
        rate = rng.uniform(-0.6, 0.6)
        for _ in range(10):
            done = plant.step(jerk, rate)
            applied.append((done.jerk_mps3, done.steering_rate_radps, done.lateral_acceleration_mps2))
            states.append(plant.state.to_vector())
    x, u = np.array(states), np.array(applied)
    across = x[:, 3] ** 2 * np.tan(x[:, 5]) / SEDAN.wheelbase_m
    nobody = np.full(len(x), np.inf)
    trajectory = driven(
        History(
            states=x,
            inputs=u[:, :2],
            lateral_acceleration_mps2=u[:, 2],
            clearance_m=nobody,
            sideslip_rad=nobody,
            yaw_rate_radps=nobody,
            friction=nobody,
            sideslip_estimate_rad=nobody,
            sideslip_sd_rad=nobody,
            friction_estimate=nobody,
        )
    )
    verdict = judge(trajectory, start, SEDAN, road, NOBODY)
    if np.hypot(x[:, 4], across).max() < road.friction * GRAVITY_MPS2:
        assert verdict.passed, verdict.reason
    else:  # the tyres slid: no bicycle drives that path
        assert np.hypot(x[:, 4], across).max() < 1.03 * road.friction * GRAVITY_MPS2 or not verdict.passed
