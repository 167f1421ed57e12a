"""Sensor and motion files: what ships is sound and sourced, what is wrong is named."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from mcdas_opt.catalogue.data_files import find, read_toml, shipped
from mcdas_opt.catalogue.motion import load_motion
from mcdas_opt.catalogue.sensors import SensorFile, known_sensors, load_sensor
from mcdas_opt.errors import InputError

ESR = find("sensors", "delphi_esr").read_text()
CAR = find("motion", "car").read_text()


@pytest.mark.parametrize("name", shipped("sensors"))
def test_every_shipped_sensor_is_sound_and_every_number_has_a_source(name: str) -> None:
    sensor = load_sensor(name)
    assert sensor.name == name
    assert 0.5 < sensor.detection_probability <= 1.0
    entry = SensorFile.model_validate(read_toml(find("sensors", name)))
    assert set(entry.sources) == set(SensorFile.NUMBERS)
    assert all(len(text) > 10 for text in [*entry.sources.values(), *(beam.source for beam in entry.beam)])


def test_the_esr_is_the_published_one() -> None:
    esr = load_sensor("delphi_esr")
    assert [(b.range_max_m, round(math.degrees(b.half_angle_rad), 9)) for b in esr.beams] == [(174.0, 10.0), (60.0, 45.0)]
    assert (esr.rate_hz, esr.period_s, esr.range_max_m) == (20.0, 0.05, 174.0)
    assert (esr.range_sd_m, esr.azimuth_sd_rad, esr.range_rate_sd_mps) == (0.25, pytest.approx(math.radians(0.5)), 0.12)


def test_known_sensors_are_files_and_words() -> None:
    assert known_sensors() == ("corner_radar", "delphi_esr", "ideal", "none")


def written(folder: Path, text: str) -> str:
    path = folder / "mine.toml"
    path.write_text(text)
    return str(path)


def test_a_file_of_one_s_own(tmp_path: Path) -> None:
    path = written(tmp_path, ESR.replace("rate_hz = 20.0", "rate_hz = 10.0"))
    assert load_sensor(path).period_s == 0.1
    assert load_sensor("mine.toml", beside=tmp_path).name == "mine"


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("rate_hz = 20.0", "rate_herz = 20.0", ["rate_herz", "unknown key", "did you mean 'rate_hz'"]),
        ("rate_hz = 20.0", "", ["rate_hz", "missing key"]),
        ("rate_hz = 20.0", 'rate_hz = "20"', ["rate_hz", "'20'"]),
        ("rate_hz = 20.0", "rate_hz = nan", ["rate_hz", "finite"]),
        ("rate_hz = 20.0", "rate_hz = 0.0", ["rate_hz", "greater than 0"]),
        ("range_sd_m = 0.25", "range_sd_m = -0.25", ["range_sd_m", "-0.25", "greater than 0"]),
        ("range_min_m = 1.0", "range_min_m = 500.0", ["range_min_m", "500.0", "longest beam"]),
        ("range_max_m = 174.0", "range_max_m = -174.0", ["range_max_m", "greater than 0"]),
        ("range_max_m = 174.0", "range_maximum_m = 174.0", ["beam[0].range_maximum_m", "did you mean 'range_max_m'"]),
        ("half_angle_rad = 0.17453292519943295", "half_angle_rad = 10.0", ["half_angle_rad", "10.0", "must lie in"]),
        ("detection_probability = 0.98", "detection_probability = 98.0", ["detection_probability", "98.0", "must lie in [0, 1]"]),
        ('range_rate_sd_mps = "de Ponte', 'range_rate_sd = "de Ponte', ["sources.range_rate_sd", "did you mean 'range_rate_sd_mps'"]),
        ('detection_probability = "chosen', '# "', ["sources.detection_probability", "where it comes from"]),
        ("[[beam]]", "[[beam]", ["not TOML"]),
    ],
)
def test_a_wrong_sensor_file_is_named(tmp_path: Path, old: str, new: str, said: list[str]) -> None:
    assert old in ESR
    path = written(tmp_path, ESR.replace(old, new, 1))
    with pytest.raises(InputError) as caught:
        load_sensor(path)
    for words in [path, *said]:
        assert words in str(caught.value)


def test_a_sensor_that_is_not_there() -> None:
    with pytest.raises(InputError, match="known: corner_radar, delphi_esr, ideal, none"):
        load_sensor("velodyne")
    with pytest.raises(InputError, match="no such file"):
        load_sensor("nowhere/esr.toml")
    with pytest.raises(InputError, match="word of a scene"):
        load_sensor("ideal")


def test_a_sensor_file_that_was_changed_is_read_anew(tmp_path: Path) -> None:
    path = written(tmp_path, ESR)
    before = load_sensor(path)
    assert load_sensor(path) is before
    written(tmp_path, ESR.replace("detection_probability = 0.98", "detection_probability = 0.81", 1))
    assert load_sensor(path).detection_probability == 0.81


@pytest.mark.parametrize("name", shipped("motion"))
def test_every_shipped_motion_is_sound(name: str) -> None:
    motion = load_motion(name)
    assert motion.name == name
    assert motion.acceleration_across_mps2 < motion.acceleration_along_mps2


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("acceleration_along_mps2 = 8.0", "acceleration_along_mps2 = 0.0", ["acceleration_along_mps2", "greater than 0"]),
        ("acceleration_along_mps2 = 8.0", "acceleration_alon_mps2 = 8.0", ["did you mean 'acceleration_along_mps2'"]),
        ('acceleration_across_mps2 = "chosen', '# "', ["sources.acceleration_across_mps2"]),
    ],
)
def test_a_wrong_motion_file_is_named(tmp_path: Path, old: str, new: str, said: list[str]) -> None:
    assert old in CAR
    path = written(tmp_path, CAR.replace(old, new, 1))
    with pytest.raises(InputError) as caught:
        load_motion(path)
    for words in [path, *said]:
        assert words in str(caught.value)
    with pytest.raises(InputError, match="known: car, truck"):
        load_motion("horse")
