"""Steering rate and grip that plans leave to feedback: the optimiser's bounds, nobody else's."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from mcdas_opt.catalogue.vehicles import load_vehicle
from mcdas_opt.domain.chassis import Chassis
from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.settings import Settings
from mcdas_opt.domain.situation import Situation
from mcdas_opt.domain.track import Coverage
from mcdas_opt.domain.vehicle import GRAVITY_MPS2
from mcdas_opt.domain.vocabulary import Mode
from mcdas_opt.dynamics.axle_limits import AxleLimits
from mcdas_opt.errors import ParameterError
from mcdas_opt.planning.candidate import Driven
from mcdas_opt.planning.cycle import Cycle
from mcdas_opt.planning.lane_problem.lane_mpc_solver import LaneMpcSolver
from mcdas_opt.planning.proposals.evade import basic_four
from mcdas_opt.planning.proposals.keep_lane import keep_lane
from mcdas_opt.simulation.controller import EDGE_RESERVE_M, FRICTION_SHARE, STEERING_RATE_SHARE, planned_for
from tests.planning.situations import car as car_at
from tests.planning.situations import random_sandwich


def test_the_share_bounds_the_steering_rate_of_the_problem_and_nothing_else() -> None:
    car = load_vehicle("sedan")
    shares = (replace(Settings(), steering_rate_share=share) for share in (1.0, STEERING_RATE_SHARE))
    whole, part = (LaneMpcSolver(car, settings).problems.holding(2, car).problem for settings in shares)
    for one, other in ((whole.u_lower, part.u_lower), (whole.u_upper, part.u_upper)):
        assert other == pytest.approx(one * np.array([1.0, STEERING_RATE_SHARE]))
    assert np.array_equal(part.x_lower, whole.x_lower)
    assert np.array_equal(part.x_upper, whole.x_upper)


def test_only_a_car_that_slips_is_planned_with_a_reserve() -> None:
    settings = Settings()
    assert planned_for(settings, slips=False) is settings
    slips = planned_for(settings, slips=True)
    kept = (slips.steering_rate_share, slips.friction_share, slips.edge_reserve_m)
    assert kept == (STEERING_RATE_SHARE, FRICTION_SHARE, EDGE_RESERVE_M)
    careful = replace(
        settings,
        steering_rate_share=0.5 * STEERING_RATE_SHARE,
        friction_share=0.5 * FRICTION_SHARE,
        edge_reserve_m=2.0 * EDGE_RESERVE_M,
    )
    assert planned_for(careful, slips=True) == careful


@pytest.mark.parametrize("share", [0.0, -1.0, 1.01, float("nan")])
@pytest.mark.parametrize("name", ["steering_rate_share", "friction_share"])
def test_a_share_that_is_none_is_refused(share: float, name: str) -> None:
    with pytest.raises(ParameterError, match=name):
        Settings(**{name: share})


def test_a_reserve_to_the_edge_is_no_negative_one() -> None:
    with pytest.raises(ParameterError, match="edge_reserve_m"):
        Settings(edge_reserve_m=-0.1)
    with pytest.raises(ParameterError, match="lateral_jerk_mps3"):
        Settings(lateral_jerk_mps3=-1.0)


@pytest.mark.parametrize("left", [True, False])
def test_a_candidate_keeps_its_reserve_to_the_edge_where_it_can(left: bool) -> None:
    """In the middle of the next lane 0.95 m of road are left beside the car: who wants to keep more leans towards its own."""
    car, side = load_vehicle("sedan"), 1.0 if left else -1.0
    road = Road(lanes_left=int(left), lanes_right=int(not left))
    situation = Situation(host=HostState(speed_mps=15.0), road=road, tracks=(car_at("standing", 45.0, 0.0, 0.0),), coverage=Coverage())
    room = []
    for reserve in (0.0, 1.2):
        settings = replace(Settings(), edge_reserve_m=reserve)
        cycle = Cycle.of(situation, car, settings)
        out = next(one for one in basic_four(cycle, None) if one.side.value == ("left" if left else "right"))
        solved = LaneMpcSolver(car, settings).solve(cycle, out)
        assert isinstance(solved, Driven)
        reach = 0.5 * (car.width_m * np.cos(solved.trajectory.heading_rad) + car.length_m * np.abs(np.sin(solved.trajectory.heading_rad)))
        room.append(float((5.55 - side * solved.trajectory.d_m - reach).min()))
    assert room[1] > room[0] + 0.1


@pytest.mark.parametrize("seed", [0, 1, 4])
def test_a_candidate_keeps_to_its_share_of_the_friction_circle(seed: int) -> None:
    """The optimiser's own answer, where it would take more if it might."""
    situation, car = random_sandwich(seed), load_vehicle("sedan")
    worst = []
    for share in (1.0, 0.6):
        settings = replace(Settings(), friction_share=share)
        cycle = Cycle.of(situation, car, settings)
        solved = LaneMpcSolver(car, settings).solve(cycle, keep_lane(cycle, Mode.BRAKE))
        assert isinstance(solved, Driven)
        x = solved.trajectory
        across = x.speed_mps**2 * np.tan(x.steering_rad) / car.wheelbase_m
        worst.append(float(np.hypot(x.acceleration_mps2, across).max()) / (situation.road.friction * GRAVITY_MPS2))
    assert worst[0] > 0.9
    assert worst[1] <= 0.6


@pytest.mark.parametrize(("speed_mps", "least", "most"), [(3.0, 0.9, 1.0), (12.0, 0.4, 1.0), (25.0, 0.0, STEERING_RATE_SHARE)])
def test_a_car_that_slips_steers_fast_where_that_asks_little_of_its_tyres(speed_mps: float, least: float, most: float) -> None:
    """The optimiser's own answer for somebody who stands ahead: 20 m/s^3 is all of the wheels' rate up to some 10 m/s."""
    settings = planned_for(Settings(), slips=True)
    car = replace(load_vehicle("sedan"), zero_sideslip_point_m=0.02 * speed_mps)
    host, standing = HostState(speed_mps=speed_mps), car_at("standing", 2.0 * speed_mps + 8.0, 0.0, 0.0)
    cycle = Cycle.of(Situation(host=host, road=Road(lanes_left=1), tracks=(standing,), coverage=Coverage()), car, settings)
    left = next(one for one in basic_four(cycle, None) if one.side.value == "left")
    solved = LaneMpcSolver(car, settings).solve(cycle, left)
    assert isinstance(solved, Driven)
    fastest = float(np.abs(solved.trajectory.steering_rate_radps).max()) / car.steering_rate_max_radps
    assert least <= fastest <= most


def test_who_slips_brakes_less_in_a_turn_than_the_friction_circle_allows() -> None:
    """Braking takes load from the rear axle: the optimiser's own answer keeps to what that axle has left."""
    settings, car = planned_for(Settings(), slips=True), replace(load_vehicle("sedan"), zero_sideslip_point_m=1.0)
    situation = random_sandwich(6)
    limits = AxleLimits.of(Chassis.of(car), situation.road.friction)
    most = {}
    for vehicle in (load_vehicle("sedan"), car):
        cycle = Cycle.of(situation, vehicle, settings)
        worst = []
        for proposed in basic_four(cycle, None):
            solved = LaneMpcSolver(vehicle, settings).solve(cycle, proposed)
            if not isinstance(solved, Driven):
                continue
            x = solved.trajectory
            across = x.speed_mps**2 * np.tan(x.steering_rad) / vehicle.wheelbase_m
            load = 1.0 + limits.braking_unloads * np.minimum(x.acceleration_mps2, 0.0)
            worst.append(float((np.hypot(FRICTION_SHARE * load * x.acceleration_mps2, across) / load).max()))
        most[vehicle is car] = max(worst) / (situation.road.friction * GRAVITY_MPS2)
    assert most[True] <= FRICTION_SHARE
    assert most[False] > 1.0
