"""The severity model's laws: how hard, how much of the width, whom, and where the road ends."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mcdas_opt.domain.road import Road
from mcdas_opt.domain.track import Track
from mcdas_opt.domain.trajectory import Trajectory
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.planning.fallback.severity import severity
from mcdas_opt.tracking.prediction import predict
from tests.planning.situations import under

CAR, ROAD = Vehicle(), Road(lanes_left=1, lanes_right=1)
SPEEDS = st.floats(5.0, 30.0)
CLOSINGS = st.floats(1.0, 15.0)


def straight(speed: float, d_m: float = 0.0, seconds: float = 8.0) -> Trajectory:
    t = np.arange(0.0, seconds, 0.01)
    states = np.zeros((t.size, 6))
    states[:, 0], states[:, 1], states[:, 3] = speed * t, d_m, speed
    return Trajectory.from_states(t, states, np.zeros((t.size - 1, 2)))


def hit(speed: float, ahead: bool, closing: float, across_m: float = 0.0, d_m: float = 0.0) -> float:
    """Equivalent speed of running into a car 8 m away, or of being run into by it, so far off the middle."""
    other = Track(id="x", s_m=8.0 if ahead else -8.0, d_m=across_m, speed_s_mps=speed - closing if ahead else speed + closing)
    return severity(straight(speed, d_m), under(predict((other,)), CAR, ROAD))[0]


@given(speed=st.floats(16.0, 30.0), closing=CLOSINGS, ahead=st.booleans())
def test_in_front_and_behind_it_is_the_relative_speed_at_the_first_contact(speed: float, closing: float, ahead: bool) -> None:
    assert hit(speed, ahead, closing) == pytest.approx(closing, rel=1e-9)


@given(speed=st.floats(16.0, 30.0), closing=CLOSINGS, share=st.floats(0.5, 1.0))
def test_a_part_of_the_width_counts_by_its_energy_and_half_at_least(speed: float, closing: float, share: float) -> None:
    width = CAR.width_m
    assert hit(speed, True, closing, across_m=(1.0 - share) * width) == pytest.approx(closing * math.sqrt(share), rel=1e-6)
    graze = hit(speed, True, closing, across_m=0.9 * width)
    assert graze == pytest.approx(closing * math.sqrt(0.5), rel=1e-6)


@given(speed=st.floats(16.0, 30.0), closing=CLOSINGS)
def test_a_third_vehicle_is_worse_than_who_threatens_and_leaving_the_road_worse_than_both(speed: float, closing: float) -> None:
    third = Track(id="beside", s_m=8.0, d_m=ROAD.lane_width_m, speed_s_mps=speed - closing)
    swerve = straight(speed)
    states = swerve.states.copy()
    states[1:, 1] = ROAD.lane_width_m  # over there at once
    over = Trajectory.from_states(swerve.t_s, states, np.zeros((swerve.t_s.size - 1, 2)))
    at_third = severity(over, under(predict((third,)), CAR, ROAD))[0]
    off = severity(straight(speed, d_m=ROAD.left_edge_m), under(predict(()), CAR, ROAD))[0]
    assert 30.0 < at_third < off
    assert severity(over, under(predict(()), CAR, ROAD))[0] == 0.0
