"""The constant-input prediction against the bicycle."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.dynamics.bicycle import road_bicycle
from mcdas_opt.dynamics.integrator import rk4
from mcdas_opt.time_to_react.constant_input import constant_input

CAR = Vehicle()
ROADS = (Road(lanes_left=2, lanes_right=2), Road(lanes_left=2, lanes_right=2, curvature=((0.0, 0.004), (60.0, -0.006), (120.0, 0.0))))


@pytest.mark.parametrize("road", ROADS, ids=("straight", "bends"))
def test_a_car_that_keeps_its_inputs_goes_as_the_bicycle(road: Road) -> None:
    host = HostState(d_m=0.3, heading_rad=0.01, speed_mps=14.0, acceleration_mps2=-1.0, steering_rad=0.003)
    times = np.round(0.05 * np.arange(101), 9)
    path = constant_input(host, times, CAR, road)
    x: list[Any] = [float(q) for q in host.to_vector()]
    for k in range(times.size - 1):
        x = rk4(lambda s: road_bicycle(s, (0.0, 0.0), float(road.curvature_at(s[0])), CAR.wheelbase_m, CAR.centre_m, np), x, 0.05)
        for value, ours, room in (
            (x[0], path.s_m, 0.03),
            (x[1], path.d_m, 0.03),
            (x[2], path.heading_rad, 0.003),
            (x[3], path.speed_mps, 1e-9),
        ):
            assert abs(value - ours[k + 1]) < room
