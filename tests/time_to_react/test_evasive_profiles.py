"""Evasive profiles: a bicycle that is given their inputs drives as they say, and asks what they say."""

from __future__ import annotations

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from mcdas_opt.domain.road import Road
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.dynamics.bicycle import road_bicycle
from mcdas_opt.dynamics.integrator import rk4
from mcdas_opt.manoeuvres.family import Demand
from mcdas_opt.manoeuvres.starts import Starts
from mcdas_opt.time_to_react.evasive_profiles import EvasiveProfiles, Motions, evasive_motions

CAR = Vehicle()
WIDE = Road(lanes_left=3, lanes_right=3, shoulder_left_m=20.0, shoulder_right_m=20.0)
FREE = Demand(friction=1.0, steering=1.0)
TIMES = np.arange(401) * 0.01


def one(
    speed: float, level: float, until: float, target: float, push: float, heading: float, steering: float, road: Road = WIDE
) -> tuple[Motions, Starts]:
    row = [np.array([x]) for x in (level, until, target, push)]
    begin = [np.array([x]) for x in (0.0, 0.2, heading, speed, 0.0, steering)]
    start = Starts(**dict(zip(Starts.__dataclass_fields__, begin, strict=True)))
    profiles = EvasiveProfiles(level_mps2=row[0], until_s=row[1], target_d_m=row[2], lateral_mps2=row[3])
    return evasive_motions(profiles, TIMES, start, CAR, road, FREE), start


@settings(max_examples=60, deadline=None)
@given(
    speed=st.floats(6.0, 35.0),
    level=st.floats(-5.0, 2.5),
    until=st.floats(0.3, 5.0),
    target=st.sampled_from([3.7, -3.7, 2.0, float("nan")]),
    push=st.floats(0.5, 7.0),
    heading=st.floats(-0.02, 0.02),
    kappa=st.sampled_from([0.0, 0.0, 0.002, -0.002]),
)
def test_a_bicycle_that_steers_so_drives_so(
    speed: float, level: float, until: float, target: float, push: float, heading: float, kappa: float
) -> None:
    road = Road(lanes_left=3, lanes_right=3, shoulder_left_m=20.0, shoulder_right_m=20.0, curvature=((0.0, kappa),))
    steering = float(np.arctan(CAR.wheelbase_m * kappa))
    motions, _ = one(speed, level, until, target, push, heading, steering, road)
    if not motions.possible[0] or motions.speed_mps.min() < 2.0:
        return
    angle = np.arctan(CAR.wheelbase_m * motions.curvature_1pm[0])
    state = [0.0, 0.2, heading, speed, float(motions.acceleration_mps2[0, 0]), float(angle[0])]
    for k in range(TIMES.size - 1):
        inputs = (np.diff(motions.acceleration_mps2[0])[k] / 0.01, np.diff(angle)[k] / 0.01)
        state = rk4(lambda x, u=inputs: road_bicycle(x, u, kappa, CAR.wheelbase_m, CAR.centre_m, np), state, 0.01)
    assert abs(state[0] - motions.s_m[0, -1]) < 0.1
    assert abs(state[1] - motions.d_m[0, -1]) < 0.1
    assert abs(state[3] - motions.speed_mps[0, -1]) < 0.02


@settings(max_examples=80, deadline=None)
@given(speed=st.floats(6.0, 35.0), push=st.floats(0.5, 8.0), heading=st.floats(-0.02, 0.02), target=st.sampled_from([3.7, -3.7, 1.5]))
def test_a_lane_change_arrives_and_asks_no_more_than_it_says(speed: float, push: float, heading: float, target: float) -> None:
    motions, _ = one(speed, 0.0, 0.0, target, push, heading, 0.0)
    if not motions.possible[0]:
        return
    assert motions.demand_mps2[0] <= 1.05 * push + 0.05
    if push >= 2.0:  # gentler ones are not there after 4 s
        assert abs(motions.d_m[0, -1] - target) < 1e-6
        assert abs(motions.sine[0, -1]) < 1e-9


@settings(max_examples=40, deadline=None)
@given(speed=st.floats(6.0, 35.0), heading=st.floats(-0.03, 0.03), steering=st.floats(-0.01, 0.01), level=st.floats(-3.0, 2.0))
def test_a_car_that_straightens_up_ends_straight(speed: float, heading: float, steering: float, level: float) -> None:
    motions, _ = one(speed, level, 1.0, float("nan"), 1.5, heading, steering)
    travelled = motions.s_m[0, -1] - motions.s_m[0, 0]
    if travelled > 3.0 * speed:
        assert abs(motions.sine[0, -1]) < 1e-6


@settings(max_examples=40, deadline=None)
@given(
    speed=st.floats(3.0, 35.0),
    level=st.floats(-8.0, 3.0),
    until=st.floats(0.2, 9.0),
    heading=st.floats(-0.02, 0.02),
    push=st.floats(1.0, 7.0),
)
def test_the_mirrored_row_has_the_mirrored_motion(speed: float, level: float, until: float, heading: float, push: float) -> None:
    here, _ = one(speed, level, until, 3.9, push, heading, 0.003)
    row = [np.array([x]) for x in (level, until, -3.9, push)]
    begin = [np.array([x]) for x in (0.0, -0.2, -heading, speed, 0.0, -0.003)]
    start = Starts(**dict(zip(Starts.__dataclass_fields__, begin, strict=True)))
    profiles = EvasiveProfiles(level_mps2=row[0], until_s=row[1], target_d_m=row[2], lateral_mps2=row[3])
    there = evasive_motions(profiles, TIMES, start, CAR, WIDE, FREE)
    assert np.array_equal(here.d_m, -there.d_m)
    assert np.array_equal(here.s_m, there.s_m)
    assert np.array_equal(here.possible, there.possible)
