"""A lower speed limit ahead is kept from where it begins; the host passed the sign 2.5 m/s faster, and was for 2 s."""

from __future__ import annotations

import numpy as np
import pytest

from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.lane import Lane
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.settings import Settings, WarningSettings
from mcdas_opt.domain.situation import Coverage, Situation
from mcdas_opt.planning.planner import Planner

SIGN_M = 200.0


def driven(limits_mps: tuple[float, float], excess: float = 0.0) -> list[HostState]:
    before, behind = limits_mps
    planner = Planner(settings=Settings(warning=WarningSettings(escapes=False), speed_limit_excess=excess))
    road = Road(speed_limit_mps=36.0, lanes=(Lane(lane=0, speed_limit_mps=((0.0, before), (SIGN_M, behind))),))
    hosts = [HostState(speed_mps=before)]
    while hosts[-1].s_m < SIGN_M + 20.0:
        asked = Situation(time_s=round(0.1 * len(hosts), 1), host=hosts[-1], road=road, desired_speed_mps=40.0, coverage=Coverage())
        trajectory = planner.plan(asked).trajectory
        hosts.append(HostState.from_vector(trajectory.states[int(np.searchsorted(trajectory.t_s, 0.1 - 1e-9))]))
    return hosts


@pytest.mark.parametrize("limits_mps", [(36.0, 28.0), (28.0, 14.0), (22.0, 14.0), (28.0, 8.3)])
def test_it_is_kept_from_where_it_begins(limits_mps: tuple[float, float]) -> None:
    hosts = driven(limits_mps)
    assert max(host.speed_mps for host in hosts if host.s_m >= SIGN_M) < limits_mps[1] + 0.4
    assert min(host.acceleration_mps2 for host in hosts) > -3.0
    assert hosts[3].speed_mps > limits_mps[0] - 1.0  # not braked for before it has to


def test_it_may_be_exceeded_by_the_share_that_the_settings_give() -> None:
    behind = [host.speed_mps for host in driven((28.0, 14.0), excess=0.2) if host.s_m >= SIGN_M]
    assert 1.15 * 14.0 < min(behind) <= max(behind) < 1.2 * 14.0 + 0.4


def test_a_short_stretch_of_a_lower_limit_before_a_higher_one_is_kept_too() -> None:
    planner = Planner(settings=Settings(warning=WarningSettings(escapes=False)))
    lane = Lane(lane=0, speed_limit_mps=((0.0, 14.0), (100.0, 8.0), (110.0, 30.0)))
    hosts = [HostState(speed_mps=14.0)]
    while hosts[-1].s_m < 115.0:
        asked = Situation(
            time_s=round(0.1 * len(hosts), 1),
            host=hosts[-1],
            road=Road(speed_limit_mps=36.0, lanes=(lane,)),
            desired_speed_mps=30.0,
            coverage=Coverage(),
        )
        trajectory = planner.plan(asked).trajectory
        hosts.append(HostState.from_vector(trajectory.states[int(np.searchsorted(trajectory.t_s, 0.1 - 1e-9))]))
    assert max(host.speed_mps for host in hosts if 100.0 <= host.s_m < 110.0) < 8.5
