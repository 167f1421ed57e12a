"""The least time to collision of a drive: with whom it counts."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mcdas_opt.domain.lane import Lane
from mcdas_opt.domain.prediction import BodyMotion
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.simulation.metrics import times_to_collision

CAR, SIZE = Vehicle(), (4.5, 1.8)
BESIDE = Road(lanes_left=1, lanes=(Lane(lane=1, shoulder=True, oncoming=True),))  # one lane, and who comes towards it beside
NARROWING = Road(lanes_left=1, lanes_right=1, lanes=(Lane(lane=1, width_m=((0.0, 3.7), (40.0, 0.0))), Lane(lane=-1, shoulder=True)))


def least(ahead_m: float, d_m: float, speed_mps: float, road: Road) -> tuple[float | None, float | None]:
    """Of a host that drives by 10 m/s for a second."""
    t = np.linspace(0.0, 1.0, 101)
    host = np.zeros((t.size, 6))
    host[:, 0], host[:, 3] = 10.0 * t, 10.0
    zero = np.zeros(t.size)
    other = BodyMotion(s_m=ahead_m + speed_mps * t, d_m=zero + d_m, heading_rad=zero, speed_s_mps=zero + speed_mps, speed_d_mps=zero)
    return times_to_collision(host, (other,), (SIZE,), CAR, road)


@pytest.mark.parametrize("d_m", [0.0, 1.0, 1.8])
def test_who_is_ahead_in_the_lane_counts(d_m: float) -> None:
    front, rear = least(40.0, d_m, 5.0, Road())
    assert front == pytest.approx((40.0 - 5.0 - 0.5 * (4.5 + CAR.length_m)) / 5.0, abs=1e-6)
    assert rear is None


def test_who_comes_from_behind_counts_as_such() -> None:
    front, rear = least(-40.0, 0.0, 25.0, Road())
    assert front is None
    assert rear == pytest.approx((40.0 - 15.0 - 0.5 * (4.5 + CAR.length_m)) / 15.0, abs=1e-6)


@pytest.mark.parametrize(("road", "d_m"), [(BESIDE, 2.9), (Road(), 2.9), (NARROWING, -3.2)])
def test_who_passes_beside_the_lanes_does_not(road: Road, d_m: float) -> None:
    """He is in no lane, so that the nearest one was taken for his."""
    assert least(12.0, d_m, -8.0, road) == (None, None)


@given(d_m=st.floats(-8.0, 8.0), s_m=st.floats(-10.0, 60.0))
@pytest.mark.parametrize("road", [BESIDE, NARROWING, Road(lanes_left=2, lanes_right=1)])
def test_a_place_is_in_the_lane_that_holds_it(road: Road, d_m: float, s_m: float) -> None:
    lanes = np.arange(-road.lanes_right, road.lanes_left + 1)
    inside = lanes[road.are_in(lanes, np.full(lanes.size, d_m), np.full(lanes.size, s_m))]
    there = road.lane_of(d_m, s_m)
    if abs(d_m - road.lane_centre_m(there, s_m)) < 0.5 * road.lane_width_at(there, s_m) - 1e-9:
        assert there in inside
    for lane in inside.tolist():
        assert abs(d_m - road.lane_centre_m(lane, s_m)) <= 0.5 * road.lane_width_at(lane, s_m) + 1e-9
