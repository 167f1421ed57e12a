"""Bends in lanes that the car's body takes nearly whole."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.plan import Plan
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.settings import Settings, WarningSettings
from mcdas_opt.domain.situation import Situation
from mcdas_opt.domain.track import Coverage
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.domain.vocabulary import Alert, Status
from mcdas_opt.planning.lane_problem.bends import given_up_m
from mcdas_opt.planning.planner import Planner

VEHICLE, ASKED_M = Vehicle(), 0.1


def bend(kappa: float, width_m: float) -> Road:
    radius = 1.0 / abs(kappa)
    ends = 30.0 + np.cumsum([0.0, 0.35 * radius, 1.6 * radius, 0.35 * radius])
    knots = tuple(zip(ends.tolist(), (0.0, kappa, kappa, 0.0), strict=True))
    return Road(lane_width_m=width_m, lanes_left=0, lanes_right=0, curvature=knots)


def driven(road: Road, seconds: float, *, warns: bool = False, speed_mps: float = 8.0) -> tuple[list[HostState], list[Plan]]:
    """Everything goes as planned, for 0.2 s at a time."""
    planner = Planner(settings=Settings(warning=WarningSettings(escapes=warns)))
    host, hosts, plans = HostState(speed_mps=speed_mps), [], []
    for k in range(round(seconds / 0.2)):
        plan = planner.plan(Situation(time_s=round(0.2 * k, 1), host=host, road=road, desired_speed_mps=10.0, coverage=Coverage()))
        host = HostState.from_vector(plan.trajectory.states[int(np.searchsorted(plan.trajectory.t_s, 0.2 - 1e-9))])
        hosts.append(host)
        plans.append(plan)
    return hosts, plans


@pytest.mark.parametrize("side", [1.0, -1.0])
@pytest.mark.parametrize(("radius_m", "width_m"), [(8.0, 2.61), (12.0, 2.40), (20.0, 2.21)])
def test_a_bend_with_a_tenth_of_a_metre_to_spare_is_driven(radius_m: float, width_m: float, side: float) -> None:
    """A car that turns steadily takes 2.51, 2.30 and 2.11 m of these."""
    hosts, plans = driven(bend(side / radius_m, width_m), 18.0)
    assert hosts[-1].s_m > 30.0 + 2.3 * radius_m + 10.0
    assert min(host.speed_mps for host in hosts) > 2.0
    assert max(abs(host.speed_mps**2 * np.tan(host.steering_rad)) for host in hosts) / VEHICLE.wheelbase_m < 3.0
    assert {plan.status for plan in plans} == {Status.PLANNED}


@pytest.mark.parametrize("side", [1.0, -1.0])
@pytest.mark.parametrize("radius_m", [8.0, 12.0, 16.0])
def test_nobody_is_warned_of_a_turn_that_is_driven_in_comfort(radius_m: float, side: float) -> None:
    """With its inputs held the car would leave the road, and no manoeuvre of the map's stays in it; it speeds up out of the turn."""
    hosts, plans = driven(bend(side / radius_m, 3.25), 14.0, warns=True)
    assert hosts[-1].s_m > 30.0 + 2.3 * radius_m + 10.0
    assert {plan.alert for plan in plans} == {Alert.NONE}


@pytest.mark.parametrize("side", [1.0, -1.0])
@pytest.mark.parametrize(("radius_m", "speed_mps"), [(10.0, 15.0), (12.0, 15.0), (12.0, 17.0), (12.0, 19.0)])
def test_who_comes_too_fast_to_a_bend_that_it_drives_through_is_warned_and_no_more(radius_m: float, speed_mps: float, side: float) -> None:
    # it was the last moment, for the map: with its inputs held it meets the road's edge, and none of the map's manoeuvres stays in it
    hosts, plans = driven(bend(side / radius_m, 3.25), 10.0, warns=True, speed_mps=speed_mps)
    assert hosts[-1].s_m > 30.0 + 1.5 * radius_m
    assert {plan.status for plan in plans} == {Status.PLANNED}
    assert {plan.alert for plan in plans} == {Alert.NONE, Alert.WARN}


@given(kappa=st.floats(0.002, 0.2), width_m=st.floats(1.85, 6.0), more_m=st.floats(0.0, 1.0))
def test_what_is_given_up_is_bounded_and_no_more_than_must_be(kappa: float, width_m: float, more_m: float) -> None:
    s = np.linspace(0.0, 60.0, 41)
    left, right = (Road(lane_width_m=1.0, lanes_left=0, lanes_right=0, curvature=((20.0, 0.0), (30.0, k))) for k in (kappa, -kappa))
    given_up, wider = (np.broadcast_to(given_up_m(left, s, width, ASKED_M, VEHICLE), s.shape) for width in (width_m, width_m + more_m))
    np.testing.assert_array_equal(given_up, np.broadcast_to(given_up_m(right, s, width_m, ASKED_M, VEHICLE), s.shape))
    assert np.all((given_up >= 0.0) & (given_up < ASKED_M))
    assert np.all(wider <= given_up)
    assert np.all(given_up[s < 20.0 - VEHICLE.length_m] < 1e-3), "straight on nothing is"


def test_a_host_that_stands_before_a_bend_that_is_too_tight_says_so() -> None:
    hosts, plans = driven(bend(1.0 / 12.0, 2.25), 14.0)
    assert hosts[-1].speed_mps < 0.1
    assert "takes 2.30 m of a road of 2.25 m" in plans[-1].reason
    assert not any("takes" in plan.reason for plan in driven(bend(1.0 / 12.0, 2.6), 14.0)[1])
