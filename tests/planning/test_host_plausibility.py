"""A host's state that no car can have: answered from one that it can, by a judged plan that says so."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mcdas_opt.domain.host import HostState, SlidingState
from mcdas_opt.domain.plan import Plan
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.situation import Coverage, Situation
from mcdas_opt.domain.track import Track
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.domain.vocabulary import Status
from mcdas_opt.planning.measurement.host_plausibility import HostPlausibility
from mcdas_opt.planning.planner import Planner
from tests.tracking.test_clock import scans

BEND, STRAIGHT = Road(lanes_left=1, curvature=((0.0, 0.0005),)), Road(lanes_left=1)
GLITCHES = [
    ({"speed_mps": 127.0}, "moves at 127 m/s"),
    ({"speed_mps": 400.0}, "moves at 400 m/s"),
    ({"speed_mps": 60.0}, "jumped by 40.0 m/s"),
    ({"acceleration_mps2": 1000.0}, "accelerates at 1e+03 m/s^2"),
    ({"acceleration_mps2": -9000.0}, "accelerates at"),
    ({"heading_rad": 90.0}, "heading against the road is 90 rad"),
    ({"steering_rad": 3.0}, "wheels are turned by 3 rad"),
    ({"steering_rad": -1.0}, "wheels are turned by -1 rad at 20 m/s"),
    ({"d_m": 5000.0}, "beyond the edge of the road"),
    ({"speed_mps": 127.0, "heading_rad": -90.0}, "; the host's heading"),
]


def asked(time_s: float, road: Road, **glitch: float) -> Situation:
    s = 240.0 + 20.0 * time_s
    lead = Track(id="f", s_m=290.0 + 20.0 * time_s, d_m=0.0, speed_s_mps=20.0)
    host: dict[str, Any] = {"s_m": s, "speed_mps": 20.0, **glitch}
    return Situation(time_s=time_s, host=HostState(**host), road=road, tracks=(lead,), coverage=Coverage())


def is_finite(plan: Plan) -> bool:
    return bool(np.isfinite(plan.trajectory.table).all())


@pytest.mark.parametrize("road", [BEND, STRAIGHT])
@pytest.mark.parametrize(("glitch", "said"), GLITCHES)
def test_a_glitch_while_driving_is_answered_by_a_plan_that_passes(glitch: dict[str, float], said: str, road: Road) -> None:
    """And only it: the cycle after it plans as if nothing had been."""
    planner = Planner()
    for k in range(3):
        before = planner.plan(asked(0.1 * k, road))
    plan = planner.plan(asked(0.3, road, **glitch))
    assert said in plan.reason
    assert (plan.status, plan.verdict.passed, is_finite(plan)) == (Status.FALLBACK, True, True)
    assert float(plan.trajectory.speed_mps[0]) == pytest.approx(
        float(np.interp(0.1, before.trajectory.t_s, before.trajectory.speed_mps)), abs=0.1
    )
    assert planner.plan(asked(0.4, road)).status is Status.PLANNED


@pytest.mark.parametrize("road", [BEND, STRAIGHT])
@pytest.mark.parametrize(("glitch", "said"), [case for case in GLITCHES if "jumped" not in case[1]])
def test_a_glitch_in_the_first_cycle_is_cut_to_what_the_car_can_do(glitch: dict[str, float], said: str, road: Road) -> None:
    plan = Planner().plan(asked(0.0, road, **glitch))
    assert said in plan.reason
    assert plan.status is not Status.PLANNED
    assert is_finite(plan)
    assert plan.trajectory.speed_mps[0] <= Vehicle().speed_max_mps


def test_a_glitch_does_not_spoil_the_tracks() -> None:
    """The radar's range rates are read with the speed that is believed."""
    planner, other = Planner(), Planner()
    for k in range(8):
        now, s = 0.1 * k, 2.0 * k
        host = HostState(s_m=s, speed_mps=20.0)
        planner.step(scans(now, 55.0 - 1.5 * k), host if k != 5 else replace(host, speed_mps=127.0), now)
        other.step(scans(now, 55.0 - 1.5 * k), host, now)
    (one,), (two,) = planner.tracker.tracks(0.7), other.tracker.tracks(0.7)
    assert one.speed_s_mps == pytest.approx(two.speed_s_mps, abs=0.2)
    assert one.s_m == pytest.approx(two.s_m, abs=0.2)


def test_a_speed_that_is_measured_twice_is_believed() -> None:
    watch = HostPlausibility()
    for k, (speed, wrong) in enumerate(((0.0, False), (25.0, True), (25.0, False), (25.1, False))):
        believed, fault = watch.plausible_state(HostState(speed_mps=speed), 0.1 * k, STRAIGHT, Vehicle(), None)
        assert bool(fault) is wrong
        assert wrong or believed.speed_mps == speed


@pytest.mark.parametrize(
    ("glitch", "said"),
    [
        ({"speed_mps": -4.0}, "moves backwards at 4 m/s"),
        ({"s_m": 1e300}, "at 1e+300 m along the road"),
        ({"speed_mps": -1e200}, "backwards"),
    ],
)
def test_a_step_is_answered_where_no_situation_could_be_made(glitch: dict[str, float], said: str) -> None:
    planner = Planner()
    host = HostState(speed_mps=20.0)
    for k in range(3):
        planner.step(scans(0.1 * k, 55.0), replace(host, s_m=2.0 * k), 0.1 * k)
    plan = planner.step(scans(0.3, 55.0), replace(host, **{"s_m": 6.0, **glitch}), 0.3)
    assert said in plan.reason
    assert (plan.status, plan.verdict.passed, is_finite(plan)) == (Status.FALLBACK, True, True)


def test_a_car_that_rolls_back_a_little_stands() -> None:
    planner = Planner()
    plan = planner.step((), HostState(speed_mps=-0.01), 0.0)
    assert planner.situation is not None
    assert planner.situation.host.speed_mps == 0.0
    assert "cannot be" not in plan.reason


def test_a_car_half_a_world_away_makes_no_difference() -> None:
    here = Situation(host=HostState(s_m=-1e9, speed_mps=20.0), coverage=Coverage())
    far = replace(here, tracks=(Track(id="far", s_m=1e9, d_m=0.0, speed_s_mps=10.0), Track(id="off", s_m=0.0, d_m=-1e9, speed_s_mps=1.0)))
    assert Planner().plan(far).trajectory.table.tobytes() == Planner().plan(here).trajectory.table.tobytes()


NUMBER = st.floats(-100.0, 100.0)


@given(
    speed=st.floats(0.0, 150.0), d=st.one_of(NUMBER, st.floats(-1e6, 1e6)), heading=NUMBER, steering=st.floats(-3.0, 3.0),
    acceleration=st.one_of(NUMBER, st.floats(-1e4, 1e4)), slip=st.none() | st.tuples(NUMBER, NUMBER), bend=st.booleans(),
)  # fmt: skip
def test_what_is_believed_is_believable(
    speed: float, d: float, heading: float, steering: float, acceleration: float, slip: tuple[float, float] | None, bend: bool
) -> None:
    state = {"d_m": d, "heading_rad": heading, "speed_mps": speed, "acceleration_mps2": acceleration, "steering_rad": steering}
    host = HostState(**state) if slip is None else SlidingState(**state, lateral_speed_mps=slip[0], yaw_rate_radps=slip[1])
    road = BEND if bend else STRAIGHT
    believed, fault = HostPlausibility().plausible_state(host, 0.0, road, Vehicle(), None)
    assert (believed is host) is (not fault)
    assert HostPlausibility().plausible_state(believed, 0.0, road, Vehicle(), None) == (believed, "")
