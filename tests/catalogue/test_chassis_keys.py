"""The chassis in vehicle files: the published cars' figures, and what is refused by file and key."""

from __future__ import annotations

from pathlib import Path

import pytest

from mcdas_opt.catalogue.data_files import models_folder
from mcdas_opt.catalogue.vehicles import load_vehicle
from mcdas_opt.domain.chassis import Chassis
from mcdas_opt.domain.vehicle import GRAVITY_MPS2
from mcdas_opt.errors import InputError


def test_the_bmw_has_commonroads_tyres() -> None:
    c = Chassis.of(load_vehicle("bmw_320i"))
    front = c.mass_kg * GRAVITY_MPS2 * c.cog_to_rear_axle_m / c.wheelbase_m
    rear = c.mass_kg * GRAVITY_MPS2 - front
    assert c.cornering_stiffness_front_nprad / front == pytest.approx(21.92, rel=1e-3)
    assert c.cornering_stiffness_rear_nprad / rear == pytest.approx(21.92, rel=1e-3)
    assert abs(c.understeer_gradient) < 1e-4  # neutral


def test_the_lincoln_is_apollos() -> None:
    c = Chassis.of(load_vehicle("lincoln_mkz"))
    assert (c.mass_kg, c.cornering_stiffness_front_nprad) == (2080.0, 155494.663)
    assert c.cog_to_front_axle_m == pytest.approx(0.5 * c.wheelbase_m)
    assert c.understeer_gradient == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize(
    ("line", "key", "words"),
    [
        ("mass_kg = -1.0", "mass_kg", "greater than 0"),
        ("cog_to_front_axle_m = 2.7", "cog_to_front_axle_m", "less than the wheelbase"),
        ("yaw_inertia_kgm2 = nan", "yaw_inertia_kgm2", "finite"),
        ("mass_kg = 3.1", r"mass_kg = 3.1", r"must lie in \[100, 100000\]"),
        ("yaw_inertia_kgm2 = 8.5", "yaw_inertia_kgm2 = 8.5", "must lie in"),
        ("cornering_stiffness_rear_nprad = 140.0", "cornering_stiffness_rear_nprad = 140.0", "must lie in"),
        ("cornering_stiffness_front_nprad = 120.0", "cornering_stiffness_front_nprad = 120.0", "must lie in"),
        ("axle_load_front_kg = 1.4\naxle_load_rear_kg = 1640.0\ncog_height_m = 0.65", "axle_load_front_kg = 1.4", "must lie in"),
        ("axle_load_front_kg = 60.0\naxle_load_rear_kg = 3000.0\ncog_height_m = 0.65", "cog_height_m = 0.65", "must lie in"),
        ("[actuators]\nsteering_lag_s = 50.0", "actuators.steering_lag_s = 50.0", "must lie in"),
        ("cornering_stiffness_front = 1.0", "cornering_stiffness_front", "did you mean"),
    ],
)
def test_a_chassis_that_cannot_be_is_refused(tmp_path: Path, line: str, key: str, words: str) -> None:
    path = tmp_path / "car.toml"
    path.write_text((models_folder() / "vehicles" / "sedan.toml").read_text() + line + "\n")
    with pytest.raises(InputError, match=words) as caught:
        load_vehicle(str(path))
    assert key in str(caught.value)
    assert str(path) in str(caught.value)
