"""Last moments of a car whose actuators answer late: full braking commanded then, through the actuator model, does not hit."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import mcdas_opt as mo
from mcdas_opt.domain.actuator_response import ActuatorResponse
from mcdas_opt.domain.escapes import Closer
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.simulation.car import Car
from mcdas_opt.simulation.idm import STEP_S
from mcdas_opt.time_to_react.escapes import escapes


def room_left_m(situation: mo.Situation, vehicle: Vehicle, start_s: float) -> float:
    """To the car ahead [m], once full braking that was commanded at `start_s` has ended; jerk stays at its limit."""
    car = Car("kinematic", vehicle, situation.road, situation.host)
    for k in range(3000):
        car.step(vehicle.jerk_min_mps3 if k * STEP_S >= start_s - 1e-9 else 0.0, 0.0)
        if car.state.speed_mps <= 0.0:
            break
    return situation.tracks[0].s_m - car.state.s_m - 0.5 * (vehicle.length_m + situation.tracks[0].length_m)


def drawn(seed: int) -> tuple[mo.Situation, Vehicle]:
    r = np.random.default_rng(seed)
    response = ActuatorResponse(
        steering_delay_s=round(float(r.uniform(0.0, 0.3)), 2),
        brake_build_up_s=float(r.uniform(0.0, 0.5)),
        engine_lag_s=float(r.uniform(0.0, 0.5)),
    )
    speed, friction = float(r.uniform(5.0, 35.0)), float(r.uniform(0.4, 0.9))
    stop = speed**2 / (2.0 * min(8.0, friction * 9.80665))
    wall = mo.Track(id="wall", s_m=stop + float(r.uniform(0.3, 4.0)) * speed + 4.5, d_m=0.0, speed_s_mps=0.0)
    host = mo.HostState(speed_mps=speed, acceleration_mps2=float(r.uniform(-1.0, 0.0)))
    return mo.Situation(host=host, tracks=(wall,), coverage=mo.Coverage(), road=mo.Road(friction=friction)), Vehicle(actuators=response)


def test_full_braking_commanded_at_the_last_moment_does_not_hit() -> None:
    opened = 0
    for seed in range(60):
        situation, vehicle = drawn(seed)
        last = escapes(situation, vehicle).brake.last_moment_s
        if last is not None:
            opened += 1
            assert room_left_m(situation, vehicle, last) > 0.0, seed
    assert opened > 40


@pytest.mark.parametrize(
    ("response", "earlier_s"),
    [
        (ActuatorResponse(brake_build_up_s=0.2), (0.2, 0.0, 0.0, 0.0)),
        (ActuatorResponse(engine_lag_s=0.3), (0.0, 0.3, 0.0, 0.0)),
        (ActuatorResponse(steering_delay_s=0.05, steering_lag_s=0.05), (0.06, 0.06, 0.1, 0.1)),
    ],
    ids=["brakes", "engine", "steering"],
)
def test_each_option_is_earlier_by_what_its_own_actuator_takes(response: ActuatorResponse, earlier_s: tuple[float, ...]) -> None:
    front = mo.Track(id="front", s_m=60.0, d_m=0.0, speed_s_mps=10.0)
    rear = mo.Track(id="rear", s_m=-60.0, d_m=0.0, speed_s_mps=24.0)
    at_once = mo.Situation(
        host=mo.HostState(speed_mps=20.0), tracks=(rear,), coverage=mo.Coverage(), road=mo.Road(lanes_left=1, lanes_right=1)
    )
    for situation in (at_once, replace(at_once, tracks=(front,))):
        before, after = (escapes(situation, Vehicle(actuators=one)) for one in (ActuatorResponse(), response))
        for quick, slow, earlier in zip(before.candidates, after.candidates, earlier_s, strict=True):
            if quick.last_moment_s is None or quick.closed_by is None:
                assert slow == quick
            else:
                assert slow.last_moment_s == pytest.approx(quick.last_moment_s - earlier)


def test_what_would_have_to_be_commanded_before_now_is_closed_for_its_reason() -> None:
    wall = mo.Track(id="wall", s_m=20.0**2 / 16.0 + 4.5 + 3.5, d_m=0.0, speed_s_mps=0.0)
    situation = mo.Situation(host=mo.HostState(speed_mps=20.0), tracks=(wall,), coverage=mo.Coverage(), road=mo.Road())
    assert escapes(situation, Vehicle()).brake.open
    late = escapes(situation, Vehicle(actuators=ActuatorResponse(brake_build_up_s=0.6))).brake
    assert (late.open, late.last_moment_s, late.closed_by) == (False, None, Closer.FRONT)
