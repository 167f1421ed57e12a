"""Vehicle files: the shipped cars, their sources, and what is refused."""

from __future__ import annotations

import math
from dataclasses import fields

import pytest

from mcdas_opt.catalogue.data_files import models_folder, read_toml, shipped
from mcdas_opt.catalogue.vehicles import VehicleFile, load_vehicle, vehicle_text
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.errors import InputError, ParameterError

NUMBERS = set(VehicleFile.model_fields) - {"source", "sources"}
PUBLISHED = tuple(name for name in shipped("vehicles") if name != "sedan")
SEDAN = (models_folder() / "vehicles" / "sedan.toml").read_text()


def test_the_sedan_is_the_contracts_default():
    assert load_vehicle("sedan") == Vehicle()
    assert Vehicle().length_m == pytest.approx(4.5)
    assert Vehicle().centre_m == pytest.approx(1.35)


@pytest.mark.parametrize("name", PUBLISHED)
def test_every_number_of_a_published_car_has_its_source(name):
    document = read_toml(models_folder() / "vehicles" / f"{name}.toml")
    numbers = NUMBERS & set(document)
    assert set(document["sources"]) == numbers
    assert all(text.strip() for text in document["sources"].values())
    assert document["source"].strip()
    assert load_vehicle(name).name == name


def test_there_are_two_published_cars_at_least():
    assert len(PUBLISHED) >= 2


def test_the_lincoln_turns_in_the_circle_that_its_source_gives():
    car = load_vehicle("lincoln_mkz")
    assert car.wheelbase_m / math.tan(car.steering_max_rad) == pytest.approx(5.05386147161, rel=1e-4)
    assert car.length_m == pytest.approx(4.933)
    assert car.centre_m == pytest.approx((3.89 - 1.043) / 2)


def test_the_bmw_is_as_long_as_its_source_says():
    car = load_vehicle("bmw_320i")
    assert car.length_m == pytest.approx(4.508)
    assert car.wheelbase_m == pytest.approx((3.793293 + 4.667707) * 0.3048, abs=1e-4)
    assert car.acceleration_max_mps2 == pytest.approx(11.5 * 7.319 / 50.8, rel=0.01)


@pytest.mark.parametrize("name", shipped("vehicles"))
def test_a_vehicle_written_as_a_file_reads_back_the_same(name, tmp_path):
    """Whoever adds a field to `Vehicle` says here whether files have it: each field but these two is a key that is written and read."""
    car = load_vehicle(name)
    path = tmp_path / f"{name}.toml"
    path.write_text(vehicle_text(car))
    assert load_vehicle(str(path)) == car
    given = {field.name for field in fields(Vehicle) if getattr(car, field.name) is not None}
    assert set(read_toml(path)) == given - {"name", "zero_sideslip_point_m"}


def test_what_no_vehicle_file_can_say_is_not_written():
    with pytest.raises(ParameterError, match="zero_sideslip_point_m"):
        vehicle_text(Vehicle(zero_sideslip_point_m=1.3))


@pytest.mark.parametrize(
    ("old", "new", "key", "words"),
    [
        ("width_m", "widht_m", "widht_m", "unknown key; did you mean 'width_m'?"),
        ("width_m = 1.8", "", "width_m", "missing key"),
        ("width_m = 1.8", "width_m = -1.8", "width_m", "greater than 0"),
        ("width_m = 1.8", "width_m = nan", "width_m", "finite"),
        ("width_m = 1.8", "width_m = '1.8'", "width_m", "valid number"),
        ("width_m = 1.8", "width_m = true", "width_m", "valid number"),
        ("jerk_min_mps3 = -40.0", "jerk_min_mps3 = 40.0", "jerk_min_mps3", "less than 0"),
        ("steering_max_rad = 0.55", "steering_max_rad = 31.5", "steering_max_rad", "must lie in [0.01, 1.4]"),
    ],
)
def test_faults_name_file_and_key(tmp_path, old, new, key, words):
    assert SEDAN.count(old) == 1
    path = tmp_path / "mine.toml"
    path.write_text(SEDAN.replace(old, new))
    with pytest.raises(InputError) as caught:
        load_vehicle(str(path))
    assert (caught.value.file, caught.value.key) == (str(path), key)
    assert words in caught.value.rule


def test_a_car_of_ones_own(tmp_path):
    path = tmp_path / "mine.toml"
    path.write_text(SEDAN.replace("width_m = 1.8", "width_m = 2"))
    assert load_vehicle(str(path)).width_m == 2.0
    assert load_vehicle("mine.toml", beside=tmp_path).name == "mine"
    with pytest.raises(InputError, match="known: bmw_320i, lincoln_mkz, sedan"):
        load_vehicle("mine")
