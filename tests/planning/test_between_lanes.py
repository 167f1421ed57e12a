"""A host that finds itself between two lanes with nothing to fear, as where a lane change is given up, goes to a lane in comfort."""

from __future__ import annotations

import numpy as np
import pytest

from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.settings import Settings, WarningSettings
from mcdas_opt.domain.situation import Coverage, Situation
from mcdas_opt.domain.vocabulary import Status
from mcdas_opt.dynamics.bicycle import lateral_acceleration
from mcdas_opt.planning.planner import Planner

CYCLE_S, DRIVEN_S, WIDTH_M = 0.1, 6.0, 3.6
MOST_MPS2 = 3.3  # across: 4.0 before, and 6.0 in traffic


@pytest.fixture(scope="module")
def planner() -> Planner:
    return Planner(settings=Settings(warning=WarningSettings(escapes=False)))


def driven(planner: Planner, host: HostState) -> list[HostState]:
    """The host's states, every cycle, on an empty road with a lane to either side."""
    planner.reset()
    road, hosts = Road(lane_width_m=WIDTH_M, lanes_left=1, lanes_right=1), [host]
    for k in range(round(DRIVEN_S / CYCLE_S)):
        situation = Situation(
            time_s=round(k * CYCLE_S, 6), host=host, tracks=(), road=road, coverage=Coverage(), desired_speed_mps=host.speed_mps
        )
        plan = planner.plan(situation)
        assert plan.status is Status.PLANNED
        t, states = plan.trajectory.t_s, plan.trajectory.states
        host = HostState.from_vector(np.array([np.interp(CYCLE_S, t, column) for column in states.T]))
        hosts.append(host)
    return hosts


@pytest.mark.parametrize("speed_mps", [8.0, 15.0, 25.0])
@pytest.mark.parametrize("d_m", [1.2, 1.7, -1.75, 2.4])
@pytest.mark.parametrize("askew", [-0.3, 0.0, 0.5])
def test_returns_to_the_middle_in_comfort(planner: Planner, speed_mps: float, d_m: float, askew: float) -> None:
    """`askew` [m/s]: across the road, to the left."""
    hosts = driven(planner, HostState(speed_mps=speed_mps, d_m=d_m, heading_rad=askew / speed_mps))
    assert across_mps2(planner, hosts) <= MOST_MPS2
    d = np.array([one.d_m for one in hosts])
    middle = WIDTH_M * round(d[-1] / WIDTH_M)
    assert abs(d[-1] - middle) < 0.1
    assert np.abs(d - middle).max() <= abs(d_m - middle) + 0.3 * abs(askew) + 0.2  # goes no further than its heading takes it


@pytest.mark.parametrize("speed_mps", [15.0, 25.0])
@pytest.mark.parametrize(("d_m", "askew"), [(1.2, 2.0), (-1.2, -2.0), (-0.8, -1.9), (2.4, -2.0), (-1.75, -1.0)])
def test_who_heads_away_from_the_middle_is_turned_in_no_haste(planner: Planner, speed_mps: float, d_m: float, askew: float) -> None:
    # it was turned back at once, at 4.4 to 4.8 m/s^2 across, and 7 in traffic
    hosts = driven(planner, HostState(speed_mps=speed_mps, d_m=d_m, heading_rad=askew / speed_mps))
    assert across_mps2(planner, hosts) <= 4.0
    assert abs(hosts[-1].d_m - WIDTH_M * round(hosts[-1].d_m / WIDTH_M)) < 0.1


def across_mps2(planner: Planner, hosts: list[HostState]) -> float:
    """The most."""
    v, delta = (np.array([getattr(one, name) for one in hosts]) for name in ("speed_mps", "steering_rad"))
    return float(np.abs(lateral_acceleration(v, delta, planner.vehicle.wheelbase_m, np)).max())
