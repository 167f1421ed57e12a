"""What a vehicle file leaves open is typical; what it gives is kept; what cannot be is refused."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from mcdas_opt.domain.chassis import Chassis
from mcdas_opt.domain.host import HostState, SlidingState
from mcdas_opt.domain.vehicle import GRAVITY_MPS2, Vehicle
from mcdas_opt.errors import ParameterError


def test_the_default_car_has_the_figures_its_file_names() -> None:
    c = Chassis.of(Vehicle())
    assert (c.mass_kg, c.cog_to_front_axle_m, c.cog_height_m) == (1500.0, pytest.approx(1.2), 0.55)
    assert c.yaw_inertia_kgm2 == pytest.approx(2700.0)
    assert c.cornering_stiffness_front_nprad == pytest.approx(120e3, rel=0.002)
    assert c.cornering_stiffness_rear_nprad == pytest.approx(140e3, rel=0.002)
    assert math.degrees(c.understeer_gradient * GRAVITY_MPS2) == pytest.approx(1.2, abs=0.05)


def test_what_is_given_is_kept() -> None:
    given = {
        "mass_kg": 1200.0, "yaw_inertia_kgm2": 1900.0, "cog_to_front_axle_m": 1.3, "cog_height_m": 0.0,
        "cornering_stiffness_front_nprad": 9e4, "cornering_stiffness_rear_nprad": 8e4,
    }  # fmt: skip
    chassis = Chassis.of(Vehicle(**given))
    assert {name: getattr(chassis, name) for name in given} == given


def test_a_heavier_typical_car_understeers_alike() -> None:
    light, heavy = Chassis.of(Vehicle()), Chassis.of(Vehicle(mass_kg=2300.0))
    assert heavy.understeer_gradient == pytest.approx(light.understeer_gradient)


@pytest.mark.parametrize(
    ("name", "value", "words"),
    [("mass_kg", 0.0, "greater than 0"), ("cog_to_front_axle_m", 2.7, "less than the wheelbase"), ("cog_height_m", -0.1, "at least 0")],
)
def test_what_cannot_be_is_refused(name: str, value: float, words: str) -> None:
    with pytest.raises(ParameterError, match=words):
        Chassis.of(replace(Vehicle(), **{name: value}))


def test_without_slip_is_the_same_state_where_there_is_none() -> None:
    rolling = SlidingState(s_m=3.0, d_m=1.0, heading_rad=0.1, speed_mps=9.0, steering_rad=0.05, yaw_rate_radps=9.0 * math.tan(0.05) / 2.7)
    assert rolling.without_slip(2.7).to_vector() == pytest.approx(rolling.to_vector(), abs=1e-15)
    drifting = replace(rolling, lateral_speed_mps=-0.9, yaw_rate_radps=0.1).without_slip(2.7)
    assert drifting.heading_rad == pytest.approx(0.1 + math.atan(-0.1))
    assert type(drifting) is HostState
    with pytest.raises(ParameterError, match="yaw_rate_radps"):
        SlidingState(yaw_rate_radps=math.nan)
