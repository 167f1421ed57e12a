"""Who can matter: nobody whom any drive can come near is left out, and everybody who can is in the optimiser when he is near."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mcdas_opt import Planner, verify
from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.prediction import CruisingBody, Prediction
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.settings import Settings
from mcdas_opt.domain.situation import Coverage, Situation
from mcdas_opt.domain.track import Track
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.domain.vocabulary import Status
from mcdas_opt.dynamics.axle_limits import available_mps2
from mcdas_opt.native.form import SWITCH
from mcdas_opt.planning.cycle import Cycle
from mcdas_opt.planning.lane_problem.lane_mpc_solver import LaneMpcSolver
from mcdas_opt.planning.lane_problem.lane_parameters import nearest_values
from mcdas_opt.planning.proposals.keep_lane import keep_lane
from mcdas_opt.planning.traffic.reach import Room, in_reach, in_reach_ever
from mcdas_opt.tracking.prediction import predict

CAR, TIMES = Vehicle(), np.arange(41) * 0.1


@given(
    v=st.floats(0.0, 45.0), gap=st.floats(-200.0, 200.0), other=st.floats(0.0, 45.0), switch=st.floats(0.0, 4.0),
    first=st.floats(-1.0, 1.0),
    then=st.floats(-1.0, 1.0),
)  # fmt: skip
def test_who_is_not_in_reach_is_met_by_no_drive(v: float, gap: float, other: float, switch: float, first: float, then: float) -> None:
    """Drives of two pieces, each braking or accelerating by a share of what the car can."""
    road, host = Road(), HostState(speed_mps=v)
    brake, accelerate = available_mps2(CAR, road.friction)
    body = predict([Track(id="other", s_m=gap, d_m=0.0, speed_s_mps=other)]).bodies[0]
    motion = Prediction(name="", bodies=(body,)).rows_on(TIMES)
    if in_reach(motion, np.array([4.5]), TIMES, host, CAR, road, Room(standstill_m=0.0))[0]:
        return
    rates = [share * (accelerate if share > 0.0 else brake) for share in (first, then)]
    fine = np.linspace(0.0, 4.0, 401)
    speed = np.clip(v + np.cumsum(np.where(fine < switch, *rates)) * 0.01, 0.0, max(CAR.speed_max_mps, v))
    s = np.cumsum(speed) * 0.01
    assert np.abs(s - (gap + other * fine)).min() > 4.5 - 0.5


def dense(count: int) -> Situation:
    cars = [
        Track(id=f"{lane}/{k}", s_m=14.0 * k + 5.0 * lane, d_m=3.7 * lane, speed_s_mps=20.0 + 0.3 * k)
        for lane in (-1, 0, 1)
        for k in range(-8, 9)
        if lane or k
    ]
    nearest = sorted(cars, key=lambda track: abs(track.s_m))[:count]
    return Situation(host=HostState(speed_mps=20.0), tracks=tuple(nearest), road=Road(lanes_left=1, lanes_right=1), coverage=Coverage())


def test_at_every_node_the_nearest_are_in_the_optimiser() -> None:
    """Of thirty bodies all that come within touch of where a candidate goes, whatever they were at its beginning."""
    cycle = Cycle.of(dense(30), CAR)
    solver, proposed = LaneMpcSolver(CAR, Settings()), replace(keep_lane(cycle, cycle.assessment.mode), speed_mps=5.0)
    others = solver.who_matters(cycle)
    assert len(others) > solver.own.slots[-1]
    guess_s = 20.0 * TIMES - 0.5 * 6.0 * np.minimum(TIMES, 2.5) ** 2
    values = nearest_values(others, 8, proposed, guess_s)
    placed = np.array([values[f"body{i}_s"] for i in range(8)]), np.array([values[f"body{i}_d"] for i in range(8)])
    for k in range(41):
        near = [i for i in range(len(others)) if abs(others.motion.s_m[i, k] - guess_s[k]) < 8.0 and abs(others.motion.d_m[i, k]) < 4.5]
        assert {(float(others.motion.s_m[i, k]), float(others.motion.d_m[i, k])) for i in near} <= set(
            zip(placed[0][:, k].tolist(), placed[1][:, k].tolist(), strict=True)
        )


def test_on_a_road_that_turns_full_circle_a_body_as_wide_as_the_circle_is_met_wherever_it_is_along_the_road() -> None:
    """The judge, asked anew, looks at everybody who may touch: the plan that passed is one that passes."""
    road = Road(curvature=((-200.0, 0.02),))
    wide = Track(id="wide", s_m=1228.0, d_m=0.0, speed_s_mps=70.6, width_m=400.0)
    situation = Situation(host=HostState(speed_mps=0.95), tracks=(wide,), road=road, coverage=Coverage(front=True))
    plan = Planner().plan(situation)
    assert plan.status is Status.UNAVOIDABLE or verify(plan.trajectory, situation).passed


def test_bodies_of_other_kinds_are_looked_at_too() -> None:
    body = CruisingBody(
        id="b", length_m=4.5, width_m=1.8, s_m=30.0, d_m=0.0, speed_s_mps=10.0, speed_d_mps=0.0, covariance=np.zeros((4, 4)),
        acceleration_mps2=-3.0, changing_s=3.0,
    )  # fmt: skip
    motion = Prediction(name="", bodies=(body, replace(body, s_m=-500.0))).rows_on(TIMES)
    near = in_reach(motion, np.array([4.5, 4.5]), TIMES, HostState(speed_mps=20.0), CAR, Road(), Room(standstill_m=2.0))
    assert near.tolist() == [True, False]


@given(seed=st.integers(0, 2**32 - 1), count=st.integers(1, 8))
def test_both_forms_reach_the_same(seed: int, count: int) -> None:
    rng = np.random.default_rng(seed)
    host = HostState(speed_mps=float(rng.uniform(0.0, 45.0)), acceleration_mps2=float(rng.uniform(-8.0, 5.0)))
    places, speeds = rng.uniform(-400.0, 400.0, count).tolist(), rng.uniform(-45.0, 45.0, count).tolist()
    prediction = predict([Track(id=str(k), s_m=s, d_m=0.0, speed_s_mps=v) for k, (s, v) in enumerate(zip(places, speeds, strict=True))])
    room = Room(standstill_m=float(rng.uniform(0.0, 20.0)), time_gap_s=float(rng.uniform(0.0, 2.0)), closing_s=float(rng.uniform(0.0, 5.0)))

    def both() -> tuple[list[bool], list[str]]:
        near = in_reach(prediction.rows_on(TIMES), np.full(count, 4.5), TIMES, host, CAR, Road(), room)
        return near.tolist(), [body.id for body in in_reach_ever(prediction, host, CAR, Road()).bodies]

    compiled = both()
    assert set(compiled[1]) >= {str(k) for k, s in enumerate(places) if abs(s) <= 150.0}
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv(SWITCH, "0")
        assert both() == compiled
