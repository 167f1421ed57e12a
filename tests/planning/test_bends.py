"""Bends are seen ahead: entered at a comfortable lateral acceleration, by gentle braking, to either side."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from mcdas_opt.actuation.path_following import SpeedLaw
from mcdas_opt.catalogue.vehicles import load_vehicle
from mcdas_opt.domain.comfort import GRIP_SHARE
from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.manners import MannersSettings
from mcdas_opt.domain.plan import Plan
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.settings import Settings, WarningSettings
from mcdas_opt.domain.situation import Coverage, Situation
from mcdas_opt.domain.vehicle import GRAVITY_MPS2
from mcdas_opt.domain.vocabulary import Status
from mcdas_opt.dynamics.bicycle import lateral_acceleration
from mcdas_opt.planning.candidates.path_driving import follow
from mcdas_opt.planning.planner import Planner
from mcdas_opt.reference.lane_centre import LaneCentre

SETTINGS = Settings(warning=WarningSettings(escapes=False), manners=MannersSettings(changes_lanes=False))


def bend(kappa: float, way_m: float, friction: float = 0.9, opens_m: float = 30.0) -> Road:
    knots = ((way_m, 0.0), (way_m + opens_m, kappa), (way_m + 90.0, kappa), (way_m + 120.0, 0.0))
    return Road(lanes_left=1, lanes_right=1, speed_limit_mps=60.0, curvature=knots, friction=friction)


def most_lateral_mps2(hosts: list[HostState], planner: Planner) -> float:
    return max(abs(float(lateral_acceleration(host.speed_mps, host.steering_rad, planner.vehicle.wheelbase_m, np))) for host in hosts)


def driven(planner: Planner, road: Road, speed_mps: float, seconds: float) -> tuple[list[HostState], list[Plan]]:
    """Everything goes as planned, for 0.2 s at a time."""
    planner.reset()
    host, hosts, plans = HostState(speed_mps=speed_mps), [], []
    for k in range(round(seconds / 0.2)):
        plan = planner.plan(Situation(time_s=round(0.2 * k, 1), host=host, road=road, desired_speed_mps=speed_mps, coverage=Coverage()))
        later = int(np.searchsorted(plan.trajectory.t_s, 0.2 - 1e-9))
        host = HostState.from_vector(plan.trajectory.states[later])
        hosts.append(host)
        plans.append(plan)
    return hosts, plans


@pytest.mark.parametrize("method", ["mpc", "closed-form-corrected"])
@pytest.mark.parametrize(("speed_mps", "kappa"), [(30.0, -0.006), (22.0, 0.012), (14.0, 0.03), (14.0, -0.03)])
def test_a_bend_is_entered_in_comfort(method: str, speed_mps: float, kappa: float) -> None:
    planner = Planner(settings=SETTINGS, method=method)
    way_m = speed_mps * speed_mps / (2.0 * SETTINGS.comfort.bend_braking_mps2)
    hosts, plans = driven(planner, bend(kappa, way_m), speed_mps, 1.8 * (way_m + 60.0) / speed_mps)
    assert 0.85 * SETTINGS.comfort.lateral_mps2 <= most_lateral_mps2(hosts, planner) <= 1.05 * SETTINGS.comfort.lateral_mps2
    assert min(host.acceleration_mps2 for host in hosts) >= -SETTINGS.comfort.late_braking_mps2
    assert {plan.status for plan in plans} == {Status.PLANNED}


def test_a_bend_mirrored_is_driven_mirrored_to_the_bit() -> None:
    planner = Planner(settings=SETTINGS)
    left, right = (driven(planner, bend(kappa, 60.0), 18.0, 6.0)[0] for kappa in (0.02, -0.02))
    assert [host.d_m for host in left] == [-host.d_m for host in right]
    assert [host.speed_mps for host in left] == [host.speed_mps for host in right]


def test_who_comes_too_fast_brakes_but_not_hard() -> None:
    hosts, _ = driven(Planner(settings=SETTINGS), bend(0.02, -40.0), 14.0, 3.0)
    assert hosts[-1].speed_mps < 12.0
    assert min(host.acceleration_mps2 for host in hosts) >= -1.2 * SETTINGS.comfort.late_braking_mps2


@pytest.mark.parametrize("method", ["mpc", "closed-form-corrected"])
@pytest.mark.parametrize("friction", [0.1, 0.15, 0.25, 0.4])
@pytest.mark.parametrize(("speed_mps", "kappa"), [(15.0, 0.0133), (15.0, -0.02), (25.0, 0.0066)])
def test_a_slippery_bend_is_entered_with_grip_in_reserve(method: str, friction: float, speed_mps: float, kappa: float) -> None:
    planner = Planner(settings=SETTINGS, method=method)
    grip = GRAVITY_MPS2 * friction
    way_m = speed_mps * speed_mps / (2.0 * min(GRIP_SHARE * grip, SETTINGS.comfort.bend_braking_mps2))
    hosts, plans = driven(planner, bend(kappa, way_m, friction), speed_mps, 1.8 * (way_m + 60.0) / speed_mps)
    assert hosts[-1].s_m > way_m
    assert most_lateral_mps2(hosts, planner) <= min(0.5 * grip, 1.05 * SETTINGS.comfort.lateral_mps2)
    assert {plan.status for plan in plans} == {Status.PLANNED}


@pytest.mark.parametrize("kappa", [0.0333, -0.0333])
def test_a_bend_that_is_far_too_tight_is_braked_for_harder_than_is_comfortable(kappa: float) -> None:
    planner = Planner(settings=SETTINGS)
    road = bend(kappa, 35.0, opens_m=8.0)
    hosts, plans = driven(planner, road, 22.0, 4.0)
    assert min(host.acceleration_mps2 for host in hosts) < -SETTINGS.comfort.limits(20.0).braking_mps2
    assert most_lateral_mps2(hosts, planner) < 0.55 * road.grip_mps2
    assert {plan.status for plan in plans} == {Status.PLANNED}
    assert "brakes harder than is comfortable: the bend ahead is too tight for its speed" in plans[0].reason


def test_a_setting_says_what_is_comfortable() -> None:
    slow = Planner(settings=replace(SETTINGS, comfort=replace(SETTINGS.comfort, lateral_mps2=1.0)))
    hosts, _ = driven(slow, bend(0.02, 60.0), 14.0, 9.0)
    assert min(host.speed_mps for host in hosts) == pytest.approx(np.sqrt(0.9 / 0.02), abs=0.3)


@pytest.mark.parametrize("kappa", [0.14, -0.14])
def test_a_narrow_turn_is_planned_to_a_safe_end(kappa: float) -> None:
    """At a crossing: 2.5 m wide, 7 m of radius, where a body whose centre follows the middle would leave the lane with its nose."""
    knots = ((8.0, 0.0), (13.0, kappa), (23.0, kappa), (28.0, 0.0))
    planner = Planner(load_vehicle("bmw_320i"), settings=SETTINGS)
    _, plans = driven(planner, Road(lane_width_m=2.5, curvature=knots), 5.0, 5.0)
    assert {plan.status for plan in plans} == {Status.PLANNED}
    assert all(plan.safe_end is not None and plan.safe_end.safe for plan in plans)


@pytest.mark.parametrize("kappa", [0.02, 0.1, -0.1])
def test_what_is_swept_in_a_bend_is_in_the_middle_of_the_path(kappa: float) -> None:
    car, speed_mps = load_vehicle("bmw_320i"), 3.0
    road = Road(lane_width_m=4.0, curvature=((-1.0, kappa), (1.0, kappa)))
    law = SpeedLaw(speed_mps=speed_mps, acceleration_mps2=1.0)
    host = HostState(speed_mps=speed_mps)
    drive = follow(host, LaneCentre(d_m=0.0), law, vehicle=car, road=road, duration_s=8.0, lateral_acceleration_mps2=4.0)
    d, psi = float(drive.d_m[-1]), float(drive.heading_rad[-1])
    x, y = np.tile(np.linspace(-0.5, 0.5, 101) * car.length_m, 2), np.repeat([-0.5, 0.5], 101) * car.width_m
    radii = np.hypot(np.cos(psi) * x - np.sin(psi) * y, np.sin(psi) * x + np.cos(psi) * y + d - 1.0 / kappa)
    assert 0.5 * (radii.min() + radii.max()) == pytest.approx(1.0 / abs(kappa), abs=0.04)
