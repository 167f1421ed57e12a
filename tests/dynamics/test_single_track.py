"""Fiala's tyre and the forces of two axles: never beyond friction, linear at zero slip, mirror images."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mcdas_opt.domain.chassis import Chassis
from mcdas_opt.domain.vehicle import GRAVITY_MPS2, Vehicle
from mcdas_opt.dynamics.single_track import axle_forces, axle_loads, body_accelerations, fiala, fiala_slip

CHASSIS = Chassis.of(Vehicle())
WEIGHT = CHASSIS.mass_kg * GRAVITY_MPS2
MOTION = st.tuples(st.floats(0.0, 50.0), st.floats(-15.0, 15.0), st.floats(-3.0, 3.0), st.floats(-12.0, 12.0), st.floats(-0.6, 0.6))


@given(st.floats(1e3, 3e5), st.floats(10.0, 2e4))
def test_the_tyre_starts_at_its_stiffness_grows_and_ends_smoothly_at_the_limit(stiffness: float, limit: float) -> None:
    assert fiala(1e-7, stiffness, limit) == pytest.approx(1e-7 * stiffness, rel=1e-3)
    slides = math.atan(3.0 * limit / stiffness)
    forces = [fiala(float(slip), stiffness, limit) for slip in np.linspace(0.0, min(slides, 1.4), 200)]
    assert np.diff(forces).min() >= -1e-12 * limit
    assert max(forces) <= limit
    if slides < 1.4:
        assert (fiala(slides, stiffness, limit), fiala(1.45, stiffness, limit)) == pytest.approx((limit, limit))
        assert limit - fiala(0.99 * slides, stiffness, limit) < 1e-3 * limit


@given(MOTION, st.floats(0.05, 1.5))
def test_no_axle_asks_for_more_than_friction_gives(motion: tuple[float, ...], friction: float) -> None:
    front, rear = axle_forces(*motion, CHASSIS, friction)
    assert front.load + rear.load == pytest.approx(WEIGHT)
    for axle in (front, rear):
        assert axle.load >= 0.0
        assert math.hypot(axle.along, axle.across) <= friction * axle.load * (1.0 + 1e-12)
    forward, aside, _ = body_accelerations(front, rear, motion[4], CHASSIS)
    assert math.hypot(forward, aside) <= friction * GRAVITY_MPS2 * (1.0 + 1e-12)


@given(MOTION, st.floats(0.05, 1.5))
def test_mirrored_motion_has_mirrored_forces(motion: tuple[float, ...], friction: float) -> None:
    v, vy, r, a, delta = motion
    for axle, other in zip(
        axle_forces(v, vy, r, a, delta, CHASSIS, friction), axle_forces(v, -vy, -r, a, -delta, CHASSIS, friction), strict=True
    ):
        assert (other.along, other.across, other.load) == pytest.approx((axle.along, -axle.across, axle.load))


@given(MOTION, st.floats(0.05, 1.5), st.floats(0.0, 1.0))
def test_anti_lock_brakes_give_what_is_asked_up_to_nearly_all_friction_whatever_their_split(
    motion: tuple[float, ...], friction: float, share: float
) -> None:
    v, vy, r, a, delta = motion
    axles = axle_forces(v, vy, r, -abs(a), delta, replace(CHASSIS, brake_share_front=share), friction)
    assert sum(axle.along for axle in axles) == pytest.approx(-min(CHASSIS.mass_kg * abs(a), 0.95 * friction * WEIGHT), abs=1e-6)
    assert all(math.hypot(axle.along, axle.across) <= friction * axle.load * (1.0 + 1e-9) for axle in axles)


@given(MOTION, st.floats(0.05, 1.5), st.floats(0.0, 1.0))
def test_without_an_axle_locks_and_slides_where_it_was_going(motion: tuple[float, ...], friction: float, share: float) -> None:
    v, vy, r, a, delta = motion
    chassis = replace(CHASSIS, brake_share_front=share, anti_lock=False)
    axles = axle_forces(v, vy, r, -abs(a), delta, chassis, friction)
    slips = (
        delta - math.atan2(vy + chassis.cog_to_front_axle_m * r, max(v, 0.1)),
        -math.atan2(vy - chassis.cog_to_rear_axle_m * r, max(v, 0.1)),
    )
    for axle, part, slip in zip(axles, (share, 1.0 - share), slips, strict=True):
        asked, most = part * chassis.mass_kg * abs(a), friction * axle.load
        if asked > most * (1.0 + 1e-6):
            assert (axle.along, axle.across) == pytest.approx((-most * math.cos(slip), most * math.sin(slip)))
        elif asked < most * (1.0 - 1e-6):
            assert axle.along == pytest.approx(-asked)


@given(MOTION)
def test_sliding_tyres_take_power_out_of_the_car(motion: tuple[float, ...]) -> None:
    v, vy, r, _, delta = motion
    v = v + 1.0
    front, rear = axle_forces(v, vy, r, 0.0, delta, CHASSIS, 0.8)
    forward, aside, turning = body_accelerations(front, rear, delta, CHASSIS)
    power = CHASSIS.mass_kg * (forward * v + aside * vy) + CHASSIS.yaw_inertia_kgm2 * turning * r
    assert power <= 1e-6 * WEIGHT or abs(math.atan2(vy + CHASSIS.cog_to_front_axle_m * r, v) - delta) > math.pi / 2


@given(st.floats(-8.0, 3.0))
def test_braking_leans_on_the_front(acceleration: float) -> None:
    front, rear = axle_loads(CHASSIS, acceleration)
    leaning = CHASSIS.cog_to_front_axle_m * front - CHASSIS.cog_to_rear_axle_m * rear
    assert leaning == pytest.approx(-CHASSIS.mass_kg * acceleration * CHASSIS.cog_height_m, abs=1e-6)


@given(st.floats(0.001, 0.99), st.floats(2e4, 3e5), st.floats(200.0, 2e4))
def test_the_slip_for_a_force_gives_that_force(part: float, stiffness: float, limit: float) -> None:
    slip = fiala_slip(part * limit, stiffness, limit)
    assert fiala_slip(-part * limit, stiffness, limit) == -slip
    assert fiala(slip, stiffness, limit) == pytest.approx(part * limit, rel=1e-9, abs=1e-9 * limit)
    assert slip >= math.atan(part * limit / stiffness) * (1.0 - 1e-9)  # never less than stiffness alone would need


@given(st.floats(0.99, 50.0), st.floats(2e4, 3e5), st.floats(0.0, 2e4))
def test_no_more_slip_is_given_for_what_no_tyre_has(part: float, stiffness: float, limit: float) -> None:
    slip = fiala_slip(part * limit + 1.0, stiffness, limit)
    assert slip == fiala_slip(2.0 * part * limit + 2.0, stiffness, limit)
    assert 0.0 <= math.tan(slip) <= 3.0 * limit / stiffness
