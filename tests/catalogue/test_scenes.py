"""Scene files: what is refused, and that the refusal names file, key, value and rule."""

from __future__ import annotations

import math
import re
import tomllib
from pathlib import Path
from typing import Any

import pytest
from pydantic import ValidationError

from mcdas_opt.catalogue import scenes
from mcdas_opt.catalogue.data_files import models_folder, shipped
from mcdas_opt.catalogue.scenes import Scene, load_scene, scene_from_document
from mcdas_opt.errors import InputError
from mcdas_opt.geometry.frenet import FrenetFrame
from mcdas_opt.geometry.rectangle import separation

GOOD = """\
name = "good"
duration_s = 4

[road]
lanes_left = 1

[host]
speed_mps = 10

[[neighbour]]
name = "front"
s_m = 30
speed_mps = 10

[[neighbour.motion]]
start_s = 1
acceleration_mps2 = -3

[sensors]
front = "delphi_esr"
"""
HEADER = "t_s,s_m,d_m,heading_rad,speed_mps\n"
RECORDED = '\n[[neighbour]]\nname = "recorded"\ntrajectory = "other.csv"\n'


def refused(folder: Path, text: str) -> InputError:
    path = folder / "scene.toml"
    path.write_text(text)
    with pytest.raises(InputError) as caught:
        load_scene(path)
    return caught.value


def after(line: str, more: str) -> str:
    """The good scene with a line added below one of its own."""
    assert GOOD.count(line + "\n") == 1
    return GOOD.replace(line + "\n", f"{line}\n{more}\n")


def changed(old: str, new: str) -> str:
    assert GOOD.count(old) == 1
    return GOOD.replace(old, new)


@pytest.mark.parametrize("name", shipped("scenes"))
def test_every_shipped_scene_loads(name):
    scene = load_scene(name)
    assert scene.name == name
    assert scene.vehicle.name == scene.host.vehicle


def test_whole_numbers_stand_for_real_ones(tmp_path):
    path = tmp_path / "scene.toml"
    path.write_text(GOOD)
    scene = load_scene(path)
    assert (scene.host.speed_mps, scene.neighbour[0].initial) == (10.0, (30.0, 0.0, 0.0, 10.0))
    assert isinstance(scene.host_state.speed_mps, float)
    assert scene.file == str(path)


@pytest.mark.parametrize(
    ("text", "key", "near"),
    [
        ("sede = 3\n" + GOOD, "sede", "seed"),
        (after("[road]", "lane_widht_m = 3.0"), "road.lane_widht_m", "lane_width_m"),
        (after("[host]", 'vehicel = "sedan"'), "host.vehicel", "vehicle"),
        (changed("[host]\nspeed_mps", "[host]\nsped_mps"), "host.sped_mps", "speed_mps"),
        (after("s_m = 30", "lenght_m = 4.0"), "neighbour[0].lenght_m", "length_m"),
        (after("start_s = 1", "until_sped_mps = 3.0"), "neighbour[0].motion[0].until_sped_mps", "until_speed_mps"),
        (after("[sensors]", 'rera = "none"'), "sensors.rera", "rear"),
    ],
)
def test_an_unknown_key_is_named_with_the_nearest_known_one(tmp_path, text, key, near):
    error = refused(tmp_path, text)
    assert error.key == key
    assert error.rule == f"unknown key; did you mean {near!r}?"
    assert str(tmp_path / "scene.toml") in str(error)


def test_an_unknown_key_near_nothing_lists_the_known(tmp_path):
    error = refused(tmp_path, after("start_s = 1", "xyzzy = 3"))
    assert error.rule == "unknown key; known: acceleration_mps2, duration_s, lateral_to_m, start_s, until_speed_mps"


@pytest.mark.parametrize(
    ("text", "key", "value"),
    [
        (changed("s_m = 30", "s_m = nan"), "neighbour[0].s_m", math.nan),
        (changed("s_m = 30", "s_m = inf"), "neighbour[0].s_m", math.inf),
        (after("[host]", "d_m = nan"), "host.d_m", math.nan),
        (after("[road]", "curvature = [[0.0, nan]]"), "road.curvature[0][1]", math.nan),
        (after("start_s = 1", "until_speed_mps = nan"), "neighbour[0].motion[0].until_speed_mps", math.nan),
        (after("s_m = 30", "length_m = -4.5"), "neighbour[0].length_m", -4.5),
        (after("s_m = 30", "width_m = 0"), "neighbour[0].width_m", 0),
        (after("s_m = 30", "length_m = 5e-324"), "neighbour[0].length_m", 5e-324),
        (after("[road]", "lane_width_m = -3.7"), "road.lane_width_m", -3.7),
        (after("[road]", "friction = 0.0"), "road.friction", 0.0),
        (after("[road]", "lanes_right = -1"), "road.lanes_right", -1),
        (changed("duration_s = 4", "duration_s = 0"), "duration_s", 0),
        (changed("s_m = 30\nspeed_mps = 10", "s_m = 30\nspeed_mps = -10"), "neighbour[0].speed_mps", -10),
        (after("[sensors]", "latency_s = 5.0"), "sensors.latency_s", 5.0),
        (changed("[host]\nspeed_mps = 10", "[host]\nspeed_mps = true"), "host.speed_mps", True),
        (changed("[host]\nspeed_mps = 10", '[host]\nspeed_mps = "10"'), "host.speed_mps", "10"),
        (changed('name = "front"', "name = 3"), "neighbour[0].name", 3),
        ("seed = 1.5\n" + GOOD, "seed", 1.5),
        (after("s_m = 30", 'behaviour = "human"'), "neighbour[0].behaviour", "human"),
        (after("[host]", 'request = "fly"'), "host.request", "fly"),
    ],
)
def test_a_value_of_the_wrong_kind_or_range_is_named(tmp_path, text, key, value):
    error = refused(tmp_path, text)
    assert error.key == key
    assert error.value == pytest.approx(value, nan_ok=True)
    assert repr(value) in str(error)
    assert str(tmp_path / "scene.toml") in str(error)


@pytest.mark.parametrize(
    ("text", "key", "value", "words"),
    [
        (changed("[host]\nspeed_mps = 10", "[host]\nspeed_mps = 60"), "host.speed_mps", 60.0, "maximum 50 m/s (speeds are m/s, not km/h)"),
        (after("[host]", "desired_speed_mps = 130.0"), "host.desired_speed_mps", 130.0, "maximum 50 m/s"),
        (changed("s_m = 30\nspeed_mps = 10", "s_m = 30\nspeed_mps = 120"), "neighbour[0].speed_mps", 120.0, "not km/h"),
        (changed("s_m = 30", "s_m = 3"), "neighbour[0].s_m", 3.0, "overlaps host at the start by 1.50 m"),
        (GOOD + "\n[[neighbour]]\ns_m = 33\nspeed_mps = 5\n", "neighbour[1].s_m", 33.0, "overlaps neighbour[0] (front) at the start"),
        (after("[host]", "d_m = 5.6"), "host.d_m", 5.6, "off the road"),
        (after("[host]", 'request = "park"'), "host.request", "park", "standstill"),
        (after("[host]", "acceleration_mps2 = -9.81"), "host.acceleration_mps2", -9.81, "[-8, 3]"),
        (changed("s_m = 30", "s_m = 5000"), "neighbour[0].s_m", 5000.0, "must lie in"),
        (after("[host]", 'vehicle = "sedn"'), "host.vehicle", "sedn", "did you mean 'sedan'? (known: bmw_320i, lincoln_mkz, sedan"),
        (after("[host]", 'vehicle = "submarine"'), "host.vehicle", "submarine", "known: bmw_320i, lincoln_mkz, sedan"),
        (after("[host]", 'vehicle = "./no.toml"'), "host.vehicle", "./no.toml", "shipped vehicles: bmw_320i, lincoln_mkz, sedan"),
        (changed('"delphi_esr"', '"delphi"'), "sensors.front", "delphi", "delphi_esr"),
        (GOOD + RECORDED, "neighbour[1].trajectory", "other.csv", "no such file"),
    ],
)
def test_rules_that_need_more_than_one_key(tmp_path, text, key, value, words):
    error = refused(tmp_path, text)
    assert (error.key, error.value) == (key, value)
    assert words in error.rule
    assert error.file == str(tmp_path / "scene.toml")


@pytest.mark.parametrize(
    ("text", "key", "words"),
    [
        (changed("[host]\nspeed_mps = 10", "[host]"), "host.speed_mps", "missing key"),
        ("", "host", "missing key"),
        (changed("s_m = 30\n", ""), "neighbour[0]", "missing key s_m"),
        (changed("acceleration_mps2 = -3\n", ""), "neighbour[0].motion[0]", "needs acceleration_mps2 or lateral_to_m"),
        (changed("acceleration_mps2 = -3", "lateral_to_m = 3.7"), "neighbour[0].motion[0]", "lateral_to_m needs duration_s"),
        (after("acceleration_mps2 = -3", "[[neighbour.motion]]\nstart_s = 0\nacceleration_mps2 = 1"), "neighbour[0]", "time order"),
        (after("s_m = 30", 'behaviour = "idm"'), "neighbour[0]", "exclude each other"),
        (after("s_m = 30", 'trajectory = "other.csv"'), "neighbour[0]", "trajectory and s_m exclude each other"),
        (after("s_m = 30", "oncoming = true\nheading_rad = 3.1"), "neighbour[0]", "oncoming and heading_rad exclude each other"),
        (GOOD + RECORDED + "oncoming = true\n", "neighbour[1]", "trajectory and oncoming exclude each other"),
        (
            GOOD + '\n[[neighbour]]\ns_m = 60\nspeed_mps = 5\nbehaviour = "idm"\noncoming = true\n',
            "neighbour[1]",
            "oncoming and behaviour idm exclude each other",
        ),
        (GOOD + '\n[[neighbour]]\nname = "front"\ns_m = 60\nspeed_mps = 5\n', "neighbour", "two neighbours are called 'front'"),
        (after("[road]", "curvature = [[0.0, 0.0], [0.0, 0.01]]"), "road", "must increase"),
        (after("[road]", "curvature = [[0.0, 0.5]]"), "road", "too tight"),
        (after("[road]", "curvature = []"), "road.curvature", "at least 1"),
        (after("[road]", "curvature = [[0.0, 0.0, 0.0]]"), "road.curvature[0]", "at most 2"),
        ("road = 3\n[host]\nspeed_mps = 3\n", "road", "must be a table"),
        ("[neighbour]\ns_m = 1\n[host]\nspeed_mps = 3\n", "neighbour", "must be a list"),
    ],
)
def test_what_is_missing_or_contradicts_is_named(tmp_path, text, key, words):
    error = refused(tmp_path, text)
    assert error.key == key
    assert words in error.rule


@pytest.mark.parametrize(("text", "words"), [("[host\n", "is not TOML"), ("[host]\nspeed_mps = 1\nspeed_mps = 2\n", "is not TOML")])
def test_malformed_toml_tells_the_line(tmp_path, text, words):
    error = refused(tmp_path, text)
    assert words in error.rule
    assert "line" in error.rule


def test_missing_files_are_told(tmp_path):
    for name, words in (
        (tmp_path / "none.toml", "no such file"),
        ("sandwich", "did you mean 'sandwich-60-40'?"),
        (tmp_path, "no such file"),
    ):
        with pytest.raises(InputError, match="no such file") as caught:
            load_scene(name)
        assert words in caught.value.rule
        assert caught.value.file == str(name)


def test_bytes_that_are_no_text_are_told(tmp_path):
    (tmp_path / "scene.toml").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(InputError, match="cannot be read"):
        load_scene(tmp_path / "scene.toml")


@pytest.mark.parametrize(
    ("rows", "where", "words"),
    [
        ("t,s\n0,1\n", "line 1", "must be the header t_s,s_m,d_m,heading_rad,speed_mps"),
        ("", "line 1", "must be the header"),
        (HEADER + "0,60,0,0,4\n", "", "at least two rows"),
        (HEADER + "0,60,0,0,4\n1,x,0,0,4\n", "line 3", "must be numbers"),
        (HEADER + "0,60,0,0,4\n1,nan,0,0,4\n", "line 3", "finite numbers"),
        (HEADER + "0,60,0,0,4\n1,64,0,4\n", "line 3", "5 finite numbers"),
        (HEADER + "1,60,0,0,4\n\n1,64,0,0,4\n", "line 4", "t_s must increase"),
        (HEADER + "0,60,0,0,4\n1,964,0,0,4\n", "line 3", "jumps by 904 m in 1 s"),
        (HEADER + "0,60,0,0,4\n\n1,64,0,0,4\n2,964,0,0,4\n", "line 5", "jumps by 900 m in 1 s"),
        (HEADER + "0,1e9,0,0,4\n1,1e9,0,0,4\n", "line 2", "must lie within 100000 m"),
    ],
)
def test_faults_of_a_neighbours_recording_name_its_file_and_line(tmp_path, rows, where, words):
    (tmp_path / "other.csv").write_text(rows)
    error = refused(tmp_path, GOOD + RECORDED)
    assert (error.file, error.key) == (str(tmp_path / "other.csv"), where)
    assert words in error.rule


def test_a_recording_that_goes_round_and_round_takes_one_look_at_the_road(tmp_path, monkeypatch):
    """Its s jumps in every row and it does not move: the road from its beginning was tabulated anew for each."""
    made = []
    monkeypatch.setattr(scenes, "FrenetFrame", lambda **given: made.append(given) or FrenetFrame(**given))
    once_round = 2.0 * math.pi / 0.02
    (tmp_path / "other.csv").write_text(HEADER + "".join(f"{k},{60.0 + 10 * once_round * (k % 2)},0,0,4\n" for k in range(50)))
    (tmp_path / "scene.toml").write_text(after("[road]", "curvature = [[-10.0, 0.02]]") + RECORDED)
    assert load_scene(tmp_path / "scene.toml")
    assert len(made) < 5  # of 50


@pytest.mark.parametrize(
    ("row", "key", "words"),
    [("0,30,0,0,4", "neighbour[1].s_m", "overlaps neighbour[0] (front)"), ("0,60,0,0,400", "neighbour[1].speed_mps", "km/h")],
)
def test_a_recording_keeps_the_scenes_rules(tmp_path, row, key, words):
    (tmp_path / "other.csv").write_text(f"{HEADER}{row}\n1,70,0,0,4\n")
    error = refused(tmp_path, GOOD + RECORDED)
    assert error.key == key
    assert words in error.rule


def test_a_recording_is_read(tmp_path):
    (tmp_path / "other.csv").write_text(HEADER + "-1,50,3.7,0,10\n1,70,3.7,0.1,12\n")
    (tmp_path / "scene.toml").write_text(GOOD + RECORDED)
    neighbour = load_scene(tmp_path / "scene.toml").neighbour[1]
    assert neighbour.samples.shape == (2, 5)
    assert neighbour.initial == pytest.approx((60.0, 3.7, 0.05, 11.0))


def test_a_scene_from_a_dict_keeps_the_same_rules():
    document = tomllib.loads(GOOD)
    scene = Scene.model_validate(document)
    assert scene.vehicle.name == "sedan"
    assert scene.neighbour_name(0) == "front"
    for part, words in (
        ({"host": {"speed_mps": 60.0}}, "exceeds the vehicle's maximum"),
        ({"host": {"speed_mps": 10.0, "vehicle": "submarine"}}, "known: bmw_320i"),
        ({"neighbour": [{"s_m": 3.0, "speed_mps": 10.0}]}, "overlaps host"),
        ({"neighbour": [{"trajectory": "nowhere.csv"}]}, "no such file"),
    ):
        with pytest.raises(ValidationError, match=words):
            Scene.model_validate({**document, **part})


def test_wheels_stand_along_the_bend_at_the_start(tmp_path):
    (tmp_path / "scene.toml").write_text(after("[road]", "curvature = [[-10.0, 0.02]]"))
    scene = load_scene(tmp_path / "scene.toml")
    assert math.tan(scene.host_state.steering_rad) == pytest.approx(0.02 * scene.vehicle.wheelbase_m)


def test_the_assumed_friction_is_the_planners_alone(tmp_path):
    (tmp_path / "scene.toml").write_text(after("[host]", "assumed_friction = 0.5"))
    scene = load_scene(tmp_path / "scene.toml")
    assert (scene.assumed_road.friction, scene.true_road.friction) == (0.5, 0.9)


@pytest.mark.parametrize(("key", "value"), [("speed_limit_mps", 130.0), ("road_end_s_m", -5.0), ("road_end_s_m", 2.0)])
def test_a_limit_in_kmh_and_a_road_that_ends_under_the_host_are_refused(tmp_path, key, value):
    path = tmp_path / "scene.toml"
    path.write_text(f"[road]\n{key} = {value}\n[host]\nspeed_mps = 10.0\n", encoding="utf-8")
    with pytest.raises(InputError, match=f"road.{key}"):
        load_scene(path)


def test_a_byte_order_mark_is_no_fault(tmp_path):
    path = tmp_path / "scene.toml"
    path.write_text("\ufeff[host]\nspeed_mps = 10.0\n", encoding="utf-8")
    assert load_scene(path).host.speed_mps == 10.0


@pytest.mark.parametrize(
    ("lane", "key", "said"),
    [
        ("lane = 1\nwidth_m = [[0.0, -3.0]]", "road.lane[0]", "must lie in [0, 20]"),
        ("lane = 1\nclosed_m = [[9.0, 3.0]]", "road.lane[0]", "must begin before it ends"),
        ("lane = 1\nwidht_m = []", "road.lane[0].widht_m", "width_m"),
        ("lane = 3\noncoming = true", "road", "is none of the road's"),
        ("lane = 1\noncoming = true\n[[road.lane]]\nlane = 1", "road", "described twice"),
        ('lane = 0\nmerges = "left"\nwidth_m = [[-10.0, 1.0], [50.0, 3.7]]', "road.lane 0: width_m", "is narrower at the host than its"),
        ("lane = 1\nspeed_limit_mps = 130.0", "road.lane[0].speed_limit_mps", "100"),
    ],
)
def test_lanes_that_cannot_be_are_refused(tmp_path, lane, key, said):
    path = tmp_path / "scene.toml"
    path.write_text(f"[road]\nlanes_left = 1\n[[road.lane]]\n{lane}\n[host]\nspeed_mps = 10.0\n", encoding="utf-8")
    with pytest.raises(InputError) as error:
        load_scene(path)
    assert str(path) in str(error.value)
    assert key in error.value.key
    assert said in str(error.value)


@pytest.mark.parametrize(
    ("line", "said"),
    [
        ("wheelbase_m = 3600", "car.toml: wheelbase_m = 3600.0: must lie in [0.1, 50]"),
        ("wheelbas_m = 2.7", "car.toml: wheelbas_m"),
    ],
)
def test_what_is_wrong_in_a_vehicle_file_is_said_of_that_file_also_beside_the_scene(
    line: str, said: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """In the current folder the file's name is all that the scene says of it."""
    monkeypatch.chdir(tmp_path)
    sedan = (models_folder() / "vehicles" / "sedan.toml").read_text("utf-8")
    Path("car.toml").write_text(re.sub("(?m)^wheelbase_m = .*$", line, sedan), "utf-8")
    Path("scene.toml").write_text('name = "x"\nduration_s = 2.0\n[road]\n[host]\nspeed_mps = 20.0\nvehicle = "car.toml"\n', "utf-8")
    with pytest.raises(InputError) as told:
        load_scene("scene.toml")
    assert str(told.value).startswith(said)


def test_a_heading_in_degrees_is_asked_about() -> None:
    with pytest.raises(InputError, match=r"host\.heading_rad = 90\.0: .*: radians, not degrees\?$"):
        scene_from_document({"name": "turned", "duration_s": 1.0, "host": {"speed_mps": 10.0, "heading_rad": 90.0}}, Path("turned.toml"))


def test_the_cost_of_a_scene_grows_with_its_cars_and_not_with_their_pairs(monkeypatch: pytest.MonkeyPatch) -> None:
    """An edit of a scene of 99 cars took 0.4 s: each pair was looked at by itself."""
    calls = 0

    def counted(*bodies: Any) -> Any:
        nonlocal calls
        calls += 1
        return separation(*bodies)

    monkeypatch.setattr("mcdas_opt.catalogue.scenes.separation", counted)
    cars = [{"s_m": 10.0 * k, "speed_mps": 10.0} for k in range(1, 100)]
    scene = Scene.model_validate({"host": {"speed_mps": 10.0}, "neighbour": cars})
    assert len(scene.neighbour) == 99
    assert calls <= 99
    with pytest.raises(ValueError, match=r"neighbour\[40\]\.s_m = 300\.5: overlaps neighbour\[29\] \(neighbour-30\) at the start by 1\.80"):
        Scene.model_validate({"host": {"speed_mps": 10.0}, "neighbour": [*cars[:40], {"s_m": 300.5, "speed_mps": 10.0}]})
