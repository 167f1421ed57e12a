"""What axles leave of the friction circle is what loads and pulls of the single track leave of it."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from mcdas_opt.domain.chassis import Chassis
from mcdas_opt.domain.vehicle import GRAVITY_MPS2, DrivenAxle, Vehicle
from mcdas_opt.dynamics.axle_limits import AxleLimits
from mcdas_opt.dynamics.single_track import axle_loads, axle_pulls

FRONT, REAR = 0, 1


def cornering_mps2(chassis: Chassis, a: float, friction: float, axle: int) -> float:
    """The lateral acceleration of a steady turn at which that axle has no grip left."""
    loads = axle_loads(chassis, a)
    pull = axle_pulls(chassis, a, loads)[axle]
    mass = chassis.mass_kg * (chassis.cog_to_rear_axle_m, chassis.cog_to_front_axle_m)[axle] / chassis.wheelbase_m
    return math.sqrt(max((friction * loads[axle]) ** 2 - pull**2, 0.0)) / mass


def bounded_mps2(limits: AxleLimits, a: float, friction: float) -> float:
    """The same by `AxleLimits`, as `ocp.terms.AxleFriction` has it."""
    driving, braking = max(a, 0.0), min(a, 0.0)
    load = 1.0 + limits.braking_unloads * braking - limits.driving_unloads * driving
    pull = (limits.brakes_by_load * load + limits.braking_pull) * braking + limits.driving_pull * driving
    return math.sqrt(max((friction * GRAVITY_MPS2 * load) ** 2 - pull**2, 0.0))


@given(st.floats(-9.0, 3.0), st.floats(0.2, 1.0), st.sampled_from(DrivenAxle), st.floats(0.4, 0.6), st.floats(0.0, 0.7))
def test_braking_it_is_the_rear_axle_driving_the_driven_one(
    a: float, friction: float, driven: DrivenAxle, front: float, height: float
) -> None:
    chassis = Chassis.of(Vehicle(driven_axle=driven, cog_to_front_axle_m=2.7 * front, cog_height_m=height))
    bound = bounded_mps2(AxleLimits.of(chassis, friction), a, friction)
    if a > 0.0 and driven is not DrivenAxle.FRONT:
        pull = a if driven is DrivenAxle.BOTH else a / front
        assert bound == pytest.approx(math.sqrt(max((friction * GRAVITY_MPS2) ** 2 - pull**2, 0.0)))
        assert bound <= cornering_mps2(chassis, a, friction, REAR) * (1.0 + 1e-9)
    else:
        axle = FRONT if a > 0.0 and driven is DrivenAxle.FRONT else REAR
        assert bound == pytest.approx(cornering_mps2(chassis, a, friction, axle), abs=1e-6)


@given(st.floats(-8.0, -0.1), st.floats(0.3, 1.0))
def test_braking_in_a_turn_leaves_less_than_the_friction_circle(a: float, friction: float) -> None:
    assume(friction * GRAVITY_MPS2 > -a + 0.1)
    circle = math.sqrt((friction * GRAVITY_MPS2) ** 2 - a**2)
    assert bounded_mps2(AxleLimits.of(Chassis.of(Vehicle()), friction), a, friction) < circle
    assert bounded_mps2(AxleLimits(), a, friction) == pytest.approx(circle)


@given(st.floats(-9.0, -0.1), st.floats(0.2, 1.0), st.floats(0.0, 1.0), st.floats(0.4, 0.6), st.floats(0.0, 0.7))
def test_brakes_of_a_fixed_split_bring_one_axle_to_its_friction_first(
    a: float, friction: float, share: float, front: float, height: float
) -> None:
    chassis = Chassis.of(Vehicle(brake_share_front=share, cog_to_front_axle_m=2.7 * front, cog_height_m=height))
    hardest = -friction * GRAVITY_MPS2
    loads = axle_loads(chassis, hardest)
    used = [-pull / load for pull, load in zip(axle_pulls(chassis, hardest, loads), loads, strict=True)]
    bound = bounded_mps2(AxleLimits.of(chassis, friction), a, friction)
    assert bound == pytest.approx(cornering_mps2(chassis, a, friction, FRONT if used[FRONT] > used[REAR] else REAR), abs=1e-6)
    by_load = replace(chassis, brake_share_front=loads[FRONT] / sum(loads))
    assert bounded_mps2(AxleLimits.of(by_load, friction), 0.999 * hardest, friction) < 0.1 * friction * GRAVITY_MPS2
