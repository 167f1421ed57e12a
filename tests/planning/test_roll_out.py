"""The roll-out: what inputs make of the car, to a standstill and from it."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mcdas_opt.domain.grid import TimeGrid
from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.prediction import Prediction
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.situation import Coverage, Situation
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.domain.verdict import ViolationKind
from mcdas_opt.domain.vocabulary import Status
from mcdas_opt.native.library import library
from mcdas_opt.planning.lane_problem.roll_out import interpreted, roll_out, soon, within_reach
from mcdas_opt.planning.planner import Planner
from mcdas_opt.verification.judge import judge
from tests.planning.situations import car

CAR, GRID = Vehicle(), TimeGrid()
NOBODY = Prediction(name="nobody")


@given(v=st.floats(0.0, 6.0), a=st.floats(-7.5, -0.5))
def test_braking_on_ends_in_a_standing_car_that_the_judge_passes(v: float, a: float) -> None:
    host = HostState(speed_mps=v, acceleration_mps2=a if v > 0.05 else 0.0)
    driven = roll_out(host, np.zeros(41), np.zeros((40, 2)), GRID, CAR, Road())
    assert driven.speed_mps.min() >= 0.0
    assert driven.speed_mps[-1] == pytest.approx(max(v + 4.0 * a, 0.0) if v > 0.05 else v, abs=1e-9)
    assert np.all(np.diff(driven.s_m) >= -1e-12)
    verdict = judge(driven, host, CAR, Road(), NOBODY)
    assert verdict.passed, verdict.reason


@given(v=st.floats(1e-4, 0.1), a=st.floats(-2.0, -0.01), jerk=st.floats(0.0, 20.0))
def test_a_stop_eased_too_late_is_a_stop_that_the_judge_passes(v: float, a: float, jerk: float) -> None:
    """Where the speed dips below zero in a step at whose end the jerk would have the car accelerate."""
    host = HostState(speed_mps=v, acceleration_mps2=a)
    inputs = np.zeros((40, 2))
    inputs[0, 0] = jerk
    driven = roll_out(host, np.zeros(41), inputs, GRID, CAR, Road())
    states = interpreted(host, np.zeros(41), inputs, GRID, CAR, Road())
    assert driven.states == pytest.approx(states, abs=1e-9)
    verdict = judge(driven, host, CAR, Road(), NOBODY)
    assert all(one.kind is not ViolationKind.RESIDUAL for one in verdict.violations), verdict.reason
    assert all(one.kind is not ViolationKind.REINTEGRATED_END for one in verdict.violations), verdict.reason


@given(v=st.floats(0.0, 49.9), a=st.floats(-8.0, 3.0))
def test_the_optimisers_start_can_keep_the_bounds_on_speed(v: float, a: float) -> None:
    x = within_reach(HostState(speed_mps=v, acceleration_mps2=a), CAR)
    if x[4] < 0.0:
        assert v - x[4] ** 2 / (2.0 * CAR.jerk_max_mps3) >= -1e-9
    if x[4] > 0.0:
        assert v + x[4] ** 2 / (2.0 * -CAR.jerk_min_mps3) <= CAR.speed_max_mps
    assert abs(x[4]) <= abs(a) + 1e-12


@pytest.mark.parametrize(("v", "a"), [(0.3, -6.0), (0.05, -2.0), (0.0, 0.0), (1.0, -7.9), (49.7, 3.0)])
def test_there_is_a_plan_at_either_end_of_the_speeds(v: float, a: float) -> None:
    wall = car("wall", 4.5 + 2.0 + 60.0 * (v > 10.0), 0.0, 0.0 if v < 10.0 else 50.0)
    host = HostState(speed_mps=v, acceleration_mps2=a)
    plan = Planner().plan(Situation(host=host, tracks=(wall,), desired_speed_mps=min(v, 40.0), coverage=Coverage()))
    assert plan.verdict.passed, plan.verdict.reason
    assert plan.status is Status.PLANNED or v > 49.0  # at top speed, still accelerating: the ladder's


@pytest.mark.skipif(library() is None, reason="there is no native library")
@given(
    v=st.one_of(st.just(0.0), st.floats(0.0, 30.0)),
    bend=st.floats(-0.01, 0.01),
    seed=st.integers(0, 10**6),
    push=st.floats(-8.0, 8.0),
)
def test_the_compiled_roll_out_is_the_interpreted_one(v: float, bend: float, seed: int, push: float) -> None:
    """Through stops, standstill and drive-off, on a road that is straight, bends and bends back."""
    rng = np.random.default_rng(seed)
    road = Road(curvature=((0.0, 0.0), (20.0, bend), (60.0, -bend)))
    host = HostState(d_m=rng.normal(), heading_rad=0.1 * rng.normal(), speed_mps=v, acceleration_mps2=rng.normal() if v else 0.0)
    inputs = np.column_stack([rng.normal(push, 6.0, 40), rng.normal(0.0, 0.1, 40)])
    planned = rng.choice([0.0, 1.0], 41)
    u = inputs.copy()
    states = interpreted(host, soon(planned, GRID), u, GRID, CAR, road)
    driven = roll_out(host, planned, inputs, GRID, CAR, road)
    assert driven.states == pytest.approx(states, abs=1e-9)
    assert np.array_equal(driven.inputs[:-1], u)


def test_a_standing_car_drives_off_as_planned() -> None:
    """The first step of driving off is slow: it must not be taken for standing."""
    jerk = np.zeros((40, 2))
    jerk[0, 0], jerk[1, 0] = 20.0, 9.0
    driven = roll_out(HostState(), 0.145 + 2.9 * np.maximum(GRID.times_s - 0.2, -0.05), jerk, GRID, CAR, Road())
    assert driven.acceleration_mps2[2:] == pytest.approx(2.9)
    assert driven.speed_mps[-1] == pytest.approx(2.9 * 3.8 + 0.1 + 0.245, abs=1e-9)


@given(seed=st.integers(0, 10**6))
def test_a_car_that_waits_drives_off_with_the_steering_and_the_acceleration_that_are_meant(seed: int) -> None:
    # the steering of the steps before was left out, and what they lowered the acceleration by
    rng = np.random.default_rng(seed)
    waits = int(rng.integers(2, 8))
    inputs = np.zeros((40, 2))
    inputs[:waits] = np.column_stack([rng.uniform(-1.5, 1.5, waits), rng.uniform(-0.5, 0.5, waits)])
    inputs[waits, 0] = 10.0 - 10.0 * inputs[:waits, 0].sum() * 0.1
    meant = 0.1 * np.cumsum(inputs, axis=0)
    planned = np.where(np.arange(41) > waits + 4, 1.0, 0.0)  # half a second before it is told to be so fast
    driven = roll_out(HostState(), planned, inputs, GRID, CAR, Road())
    assert driven.steering_rad[1:] == pytest.approx(meant[:, 1])
    assert driven.acceleration_mps2[waits + 1 :] == pytest.approx(meant[waits:, 0])
    again = roll_out(HostState(), planned, driven.inputs[:-1], GRID, CAR, Road())
    assert again.states == pytest.approx(driven.states, abs=1e-9)


def test_a_car_that_stays_steers_nothing() -> None:
    driven = roll_out(HostState(steering_rad=0.1), np.full(41, 0.1), np.full((40, 2), [1.0, 0.2]), GRID, CAR, Road())
    assert np.all(driven.steering_rad == 0.1)


def test_a_standing_car_never_rolls_back() -> None:
    driven = roll_out(HostState(), np.full(41, 1.0), np.full((40, 2), [-5.0, 0.0]), GRID, CAR, Road())
    assert driven.speed_mps.min() == 0.0
    assert driven.s_m.max() == driven.s_m.min() == 0.0
