"""Parking cases: what is read, what is repaired with a note, and what is refused by name."""

from functools import partial
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from mcdas_opt.catalogue.data_files import shipped
from mcdas_opt.catalogue.vehicles import load_vehicle
from mcdas_opt.errors import InputError, ParameterError
from mcdas_opt.geometry.polygon import signed_area
from mcdas_opt.parking.case_file import is_parking_case, load_parking_case, parking_case_from_document, slot_case
from mcdas_opt.parking.closed_loop.follow import follow
from mcdas_opt.parking.closed_loop.settings import FollowSettings
from mcdas_opt.parking.park import park
from mcdas_opt.parking.trajectory_file import load_parking_trajectory

SQUARE = [[10.0, 10.0], [12.0, 10.0], [12.0, 12.0], [10.0, 12.0]]
PLAIN = {"start": {"x_m": 0.0, "y_m": 0.0, "heading_rad": 0.0}, "goal": {"x_m": 5.0, "y_m": 0.0, "heading_rad": 0.0}}


def test_the_slot_builds_the_contracts_obstacles():
    case = slot_case(5.4)
    rear, front, kerb, opposite = case.obstacles
    assert rear.min(0).tolist() == [-6.0, -2.1]
    assert rear.max(0).tolist() == [0.0, 0.0]
    assert front.min(0).tolist() == [5.4, -2.1]
    assert front.max(0).tolist() == [11.4, 0.0]
    assert kerb.min(0).tolist() == [-6.0, -2.6]
    assert kerb.max(0).tolist() == [11.4, -2.1]
    assert opposite.min(0).tolist() == [-6.0, 4.5]
    assert opposite.max(0).tolist() == [11.4, 5.0]
    assert case.start.tolist() == [6.4, 1.4, 0.0]
    assert case.goal == pytest.approx([1.35, -1.05, 0.0])


@pytest.mark.parametrize(
    ("document", "words"),
    [
        ({"slot": {"length_m": 4.31}}, ["slot.length_m", "slot 4.31 m, car 4.50 m"]),
        ({"slot": {"length_m": 5.4, "depth_m": 1.7}}, ["slot.depth_m", "car 1.80 m wide"]),
        ({"slot": {"length_m": 5.4}, "goal": {"y_m": -0.5}}, ["goal", "out of the slot by 0.40 m"]),
        ({"slot": {"length_m": 5.4}, "start": {"y_m": 0.5}}, ["start", "overlaps front car by 0.40 m"]),
        ({"slott": {"length_m": 5.4}}, ["slott", "did you mean 'slot'"]),
        ({"slot": {"length_m": -1.0}}, ["slot.length_m", "greater than 0"]),
        ({"slot": {"length_m": 1e308}}, ["slot.length_m", "1000"]),
        ({**PLAIN, "goal": {**PLAIN["goal"], "y_m": 1e308}}, ["goal[1]", "must lie in"]),
        ({**PLAIN, "obstacle": [{"vertices_m": [[0, 0], [1, 0], [0, 1e308]]}]}, ["obstacle[0].vertices_m", "must lie within 1e+09 m"]),
        ({"slot": {"length_m": 5.4}, "start": {"steering_rad": 0.8}}, ["start.steering_rad", "-0.55, 0.55"]),
        ({"slot": {"length_m": 5.4}, "limits": {"clearance_m": -0.1}}, ["limits.clearance_m"]),
        ({**PLAIN, "obstacle": [{"vertices_m": [[0, 0], [1, 0]]}]}, ["obstacle[0].vertices_m"]),
        ({**PLAIN, "obstacle": [{"vertices_m": [[9, 9], [10, 10], [11, 11]]}]}, ["obstacle[0].vertices_m", "no area"]),
        ({"start": PLAIN["start"]}, ["goal.x_m", "missing key"]),
    ],
)
def test_bad_input_is_named(document, words):
    with pytest.raises(InputError) as caught:
        parking_case_from_document(document, Path("bad.toml"))
    for word in ["bad.toml", *words]:
        assert word in str(caught.value)


def test_polygons_are_repaired_with_a_note():
    clockwise = {**PLAIN, "obstacle": [{"vertices_m": SQUARE[::-1]}]}
    case = parking_case_from_document(clockwise)
    assert signed_area(case.obstacles[0]) == pytest.approx(4.0)
    assert "clockwise" in case.notes[0]
    crossed = {**PLAIN, "obstacle": [{"vertices_m": [SQUARE[k] for k in (0, 2, 1, 3)], "name": "bow tie"}]}
    case = parking_case_from_document(crossed)
    assert signed_area(case.obstacles[0]) == pytest.approx(4.0)
    assert "bow tie crosses itself" in case.notes[0]


def test_a_tpcap_line_far_from_the_origin_is_shifted(tmp_path):
    far = 4.0e9
    values = [far, -far, 0.1, far + 5.0, -far + 1.0, 0.2, 1, 4]
    for x, y in [(10, 10), (10, 12), (12, 12), (12, 10)]:
        values += [far + x, -far + y]
    file = tmp_path / "far.csv"
    file.write_text(",".join(repr(float(v)) if k > 7 or k < 6 else str(v) for k, v in enumerate(values)) + "\n")
    case = load_parking_case(file)
    assert case.vehicle.name == "tpcap"
    assert case.vehicle.length_m == pytest.approx(4.689)
    assert case.limits.clearance_m == 0.0
    assert case.start[:2].tolist() == [0.0, 0.0]
    assert case.goal == pytest.approx([5.0, 1.0, 0.2], abs=1e-5)
    assert signed_area(case.obstacles[0]) == pytest.approx(4.0, abs=1e-4)
    assert case.notes == ()
    assert load_parking_case(file, vehicle="sedan", clearance_m=0.05).limits.clearance_m == 0.05
    assert is_parking_case(file)


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("0,0,0,5,0,x,0", ["line 1, column 6", "'x'"]),
        ("0,0,0,5,0,0,1,4,1,1,2,2", ["line 1, column 13", "16 announced"]),
        ("0,0,0,5,0,0", ["line 1, column 7", "missing"]),
        ("0,0,0,5,0,0,1,2,1,1,2,2", ["line 1, column 8", "at least 3"]),
        ("0,0,0,5,0,nan,0", ["line 1, column 6", "finite"]),
        ("", ["exactly one line"]),
    ],
)
def test_a_malformed_csv_is_named_by_line_and_column(tmp_path, line, words):
    file = tmp_path / "bad.csv"
    file.write_text(line + "\n")
    with pytest.raises(InputError) as caught:
        load_parking_case(file)
    for word in words:
        assert word in str(caught.value)


@pytest.mark.parametrize("name", shipped("cases"))
def test_shipped_cases_load(name):
    assert is_parking_case(name)
    assert load_parking_case(name).name == name


def test_a_scene_is_no_parking_case():
    assert not is_parking_case("sandwich-60-40")


def test_trajectory_files_name_what_is_wrong(tmp_path):
    file = tmp_path / "t.csv"
    file.write_text("t_s,x_m,y_m,heading_rad,speed_mps,steering_rad\n0,0,0,0,0,0\n0.05,a,0,0,0,0\n")
    with pytest.raises(InputError, match=r"line 3, column 2 \(x_m\)"):
        load_parking_trajectory(file)
    file.write_text("t_s,x_m,y_m,heading_rad,speed_mps\n0,0,0,0,0\n")
    with pytest.raises(InputError, match="steering_rad"):
        load_parking_trajectory(file)
    file.write_text("t_s,x_m,y_m,heading_rad,speed_mps,steering_rad\n0,0,0,0,0,0\n0.05,0,0,0,0.05,0.01\n")
    driven = load_parking_trajectory(file)
    assert driven.acceleration_mps2.tolist() == pytest.approx([1.0, 1.0])
    assert np.all(driven.steering_rate_radps == pytest.approx(0.2))


@pytest.mark.parametrize("ask", [park, partial(follow, planner="search", settings=FollowSettings(replans=0))])
def test_another_car_parks_as_on_the_command_line(ask, monkeypatch):
    """Which case is posed, of `--vehicle` and of `vehicle=`; nobody drives."""
    asked = []
    monkeypatch.setattr("mcdas_opt.parking.park.World", SimpleNamespace(of=asked.append))
    monkeypatch.setattr("mcdas_opt.parking.closed_loop.follow._Drive", lambda case, *rest: asked.append(case))
    for vehicle in ("bmw_320i", load_vehicle("bmw_320i")):
        with pytest.raises(AttributeError):  # of what stands in for the rest
            ask("parallel", vehicle=vehicle)
    wanted = load_parking_case("parallel", vehicle="bmw_320i")
    assert [case.vehicle for case in asked] == [wanted.vehicle] * 2
    assert asked == [wanted] * 2
    with pytest.raises(ParameterError, match=r"vehicle = .*load_parking_case\(name, vehicle=\.\.\.\)"):
        ask(load_parking_case("parallel"), vehicle="bmw_320i")
    with pytest.raises(ParameterError, match="vehicle"):
        ask("parallel", vehicle=3)
    with pytest.raises(InputError, match="no such file"):
        ask("parallel", vehicle="sedann")
