"""The least time to collision of a drive: with whom it counts."""

from __future__ import annotations

import numpy as np
import pytest

from mcdas_opt.domain.lane import Lane
from mcdas_opt.domain.prediction import BodyMotion
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.simulation.metrics import times_to_collision

CAR, SIZE = Vehicle(), (4.5, 1.8)
BESIDE = Road(lanes_left=1, lanes=(Lane(lane=1, shoulder=True, oncoming=True),))  # one lane, and who comes towards it beside


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


@pytest.mark.parametrize("speed_mps", [-8.0, 4.0])
@pytest.mark.parametrize("road", [BESIDE, Road(), Road(lane_width_m=8.0)])
def test_who_is_passed_beside_does_not(road: Road, speed_mps: float) -> None:
    """Also where his middle is in the host's lane, as a cyclist's: passing him was a time to collision of 0 s."""
    assert least(12.0, 0.5 * (SIZE[1] + CAR.width_m) + 0.4, speed_mps, road) == (None, None)
