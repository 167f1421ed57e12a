"""Records cannot be born wrong, cannot be changed, and say what is wrong."""

from __future__ import annotations

import ast
import dataclasses
import json
import math
import pickle
import warnings
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import mcdas_opt
from mcdas_opt.domain.body import Body
from mcdas_opt.domain.destination import Destination
from mcdas_opt.domain.grid import TimeGrid
from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.measurement import Mounting
from mcdas_opt.domain.parking import ParkingCase
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.rules import covariance, vector, within
from mcdas_opt.domain.sensor import Beam
from mcdas_opt.domain.settings import PredictionSettings, SelectorSettings, Settings, SigmoidSettings
from mcdas_opt.domain.situation import Situation
from mcdas_opt.domain.track import Coverage, Track
from mcdas_opt.domain.trajectory import Trajectory
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.domain.verdict import Verdict, Violation, ViolationKind
from mcdas_opt.domain.vocabulary import Sector
from mcdas_opt.errors import ParameterError, nearest

TRACK = {"id": "front", "s_m": 30.0, "d_m": 0.0, "speed_s_mps": 10.0}
numbers = st.floats(-1e6, 1e6)


@pytest.mark.parametrize(
    ("build", "name"),
    [
        (lambda: Track(**TRACK, heading_rad=180.0), "heading_rad"),
        (lambda: Mounting(yaw_rad=180.0), "yaw_rad"),
        (lambda: Destination(lane=0, heading_rad=(-10.0, 10.0)), "heading_rad"),
        (lambda: Vehicle(steering_max_rad=30.0), "steering_max_rad"),
        (lambda: Beam(name="wide", range_max_m=60.0, half_angle_rad=45.0), "half_angle_rad"),
        (lambda: ParkingCase(start=[0.0, 0.0, 90.0], goal=[0.0, 0.0, 0.0]), "start[2]"),
        (lambda: ParkingCase(start=[0.0, 0.0, 0.0], goal=[0.0, 0.0, -90.0]), "goal[2]"),
    ],
)
def test_an_angle_in_degrees_is_asked_about(build: Any, name: str) -> None:
    with pytest.raises(ParameterError, match=r"rad: must lie in \[.*\]: radians, not degrees\?$") as caught:
        build()
    assert caught.value.name == name


def test_a_mounting_that_is_no_number_is_left_to_the_tracker() -> None:
    assert math.isinf(Mounting(yaw_rad=math.inf).yaw_rad)


@pytest.mark.parametrize(
    "wrong",
    [
        {"length_m": 0.0},
        {"s_m": math.nan},
        {"d_m": 1e300},
        {"speed_s_mps": "1"},
        {"heading_rad": math.inf},
        {"kind": "tank"},
        {"covariance": np.eye(3)},
        {"turn_rate_sd_radps": -1.0},
    ],
)
def test_an_error_of_a_track_names_the_track(wrong: dict[str, Any]) -> None:
    """With a dozen tracks a field alone tells nobody which."""
    with pytest.raises(ParameterError, match=r"^track 'x7': ") as caught:
        Track(**{**TRACK, "id": "x7", **wrong})
    assert caught.value.name == next(iter(wrong))
    assert caught.value.of == "track 'x7'"


def test_a_track_elsewhere_is_the_same_but_for_its_place() -> None:
    track = Track(**{**TRACK, "heading_rad": 0.3, "kind": "lorry", "covariance": np.diag([1.0, 0.0, 0.2, 0.0]), "coasting": True})
    assert track.moved_to(7.0, -2.0) == replace(track, s_m=7.0, d_m=-2.0)
    assert track.later(0.5) == replace(track, s_m=track.s_m + 0.5 * track.speed_s_mps, d_m=track.d_m + 0.5 * track.speed_d_mps)


@pytest.mark.parametrize(
    ("place", "name"), [((math.nan, 0.0), "s_m"), ((0.0, math.nan), "d_m"), ((0.0, -1e300), "d_m"), ((math.inf, 0.0), "s_m")]
)
def test_a_track_is_not_moved_where_nothing_can_be(place: tuple[float, float], name: str) -> None:
    with pytest.raises(ParameterError, match=r"^track 'x7': ") as caught:
        Track(**{**TRACK, "id": "x7"}).moved_to(*place)
    assert caught.value.name == name


@given(rows=st.lists(st.lists(st.floats(-3.0, 3.0), min_size=4, max_size=4), max_size=4), exact=st.sets(st.integers(0, 3)))
def test_what_is_known_exactly_has_rows_and_columns_of_zeros(rows: list[list[float]], exact: set[int]) -> None:
    square = np.array(rows).T @ np.array(rows) if rows else np.zeros((4, 4))
    for i in exact:
        square[i, :] = square[:, i] = 0.0
    covariance("p", square, 4)
    for i in exact:
        wrong = square.copy()
        wrong[i - 1, i] += 1e-3
        with pytest.raises(ParameterError, match="symmetric and positive"):
            covariance("p", wrong, 4)


@pytest.mark.parametrize(
    ("build", "name", "words"),
    [
        (lambda: HostState(speed_mps=math.nan), "speed_mps", "finite"),
        (lambda: HostState(d_m=True), "d_m", "number"),
        (lambda: HostState(d_m="1"), "d_m", "number"),
        (lambda: Vehicle(width_m=0.0), "width_m", "greater than 0"),
        (lambda: Vehicle(steering_max_rad=30.0), "steering_max_rad", "must lie in"),
        (lambda: Vehicle(acceleration_min_mps2=2.0), "acceleration_min_mps2", "less than 0"),
        (lambda: Vehicle(jerk_min_mps3=math.nan), "jerk_min_mps3", "finite"),
        (lambda: Vehicle(acceleration_min_mps2=-math.inf), "acceleration_min_mps2", "finite"),
        (lambda: Road(lane_width_m=-1.0), "lane_width_m", "must lie in [0.1, 20]"),
        (lambda: Road(lanes_left=-1), "lanes_left", "whole number"),
        (lambda: Road(lanes_left=True), "lanes_left", "whole number"),
        (lambda: Road(friction=0.0), "friction", "must lie in [0.01, 10]"),
        (lambda: Road(shoulder_left_m=math.inf), "shoulder_left_m", "finite"),
        (lambda: Road(curvature=()), "curvature", "at least one"),
        (lambda: Road(curvature=((0.0, 0.0), (0.0, 0.1))), "curvature", "increase"),
        (lambda: Road(curvature=((0.0, 0.0), (1e-9, 0.1))), "curvature", "increase, by at least 1e-06"),
        (lambda: Road(curvature=((0.0, 0.49),)), "curvature", "too tight"),
        (lambda: Road(curvature=((0.0, 1e308),)), "curvature", "too tight"),
        (lambda: Road(curvature=(1.0,)), "curvature", "pairs"),
        (lambda: Track(**{**TRACK, "s_m": math.inf}), "s_m", "finite"),
        (lambda: Track(**TRACK, length_m=-1.0), "length_m", "greater than 0"),
        (lambda: Track(**TRACK, covariance=np.eye(3)), "covariance", "4 x 4"),
        (lambda: Track(**TRACK, covariance=-np.eye(4)), "covariance", "no negative variance"),
        (lambda: Track(**TRACK, covariance=np.full((4, 4), math.nan)), "covariance", "finite"),
        (lambda: Track(**TRACK, covariance=np.eye(4) + np.eye(4, k=1)), "covariance", "symmetric"),
        (lambda: Body(name="x", s_m=math.nan), "s_m", "finite"),
        (lambda: Body(name="x", s_m=0.0, width_m=0.0), "width_m", "greater than 0"),
        (lambda: TimeGrid(steps_s=np.array([0.1])), "steps_s", "two positive steps"),
        (lambda: TimeGrid(steps_s=np.array([0.1, 0.0])), "steps_s", "two positive steps"),
        (lambda: TimeGrid(steps_s=np.array([0.1, 0.2])), "steps_s", "may exceed 0.1 s"),
        (lambda: Situation(host=HostState(), desired_speed_mps=-1.0, coverage=Coverage()), "desired_speed_mps", "at least 0"),
        (lambda: Situation(host=HostState(), tracks=(Track(**TRACK), Track(**TRACK)), coverage=Coverage()), "tracks.id", "unique"),
        (lambda: vector("x", [1.0, math.nan]), "x[1]", "finite"),
        (lambda: vector("x", [[1.0]]), "x", "list of numbers"),
        (lambda: vector("x", [1.0], length=2), "x", "2 numbers"),
        (lambda: vector("x", ["a"]), "x", "list of numbers"),
        (lambda: covariance("p", "a", 2), "p", "2 x 2"),
        (lambda: within("x", 3.0, 0.0, 1.0, "m"), "x", "[0, 1]"),
    ],
)
def test_a_wrong_value_is_refused_by_name(build, name, words):
    with pytest.raises(ParameterError) as caught:
        build()
    assert caught.value.name == name
    assert words in caught.value.rule
    assert name in str(caught.value)


@pytest.mark.parametrize(
    "record", [HostState(), Vehicle(), Road(), Track(**TRACK), Body(name="x", s_m=0.0), TimeGrid(), Coverage(), Verdict()]
)
def test_records_are_frozen_and_keyword_only(record):
    name = dataclasses.fields(record)[0].name
    with pytest.raises(dataclasses.FrozenInstanceError):
        setattr(record, name, 1.0)
    with pytest.raises(TypeError):
        type(record)(1.0)


@given(values=st.lists(numbers, min_size=6, max_size=6))
def test_a_host_state_is_its_vector(values):
    state = HostState.from_vector(np.array(values))
    assert state.to_vector().tolist() == values
    assert HostState.from_vector(state.to_vector()) == state


def test_whole_numbers_become_real_ones():
    assert isinstance(HostState(speed_mps=10).speed_mps, float)
    assert isinstance(Track(**{**TRACK, "s_m": 30}).s_m, float)


def test_arrays_in_records_are_read_only():
    grid, track = TimeGrid(), Track(**TRACK)
    for array in (grid.steps_s, track.covariance, HostState().to_vector(), straight().s_m):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 1.0


def straight(count: int = 5) -> Trajectory:
    t = 0.1 * np.arange(count)
    x = np.zeros((count, 6))
    x[:, 0], x[:, 3] = 10.0 * t, 10.0
    return Trajectory.from_states(t, x, np.ones((count - 1, 2)))


def test_a_trajectory_repeats_its_last_input_and_gives_its_states_back():
    trajectory = straight()
    assert len(trajectory) == 5
    assert trajectory.inputs.shape == (5, 2)
    again = Trajectory.from_states(trajectory.t_s, trajectory.states, trajectory.inputs)
    assert again.to_dict() == trajectory.to_dict() == Trajectory.from_columns(trajectory.to_dict()).to_dict()


def test_a_trajectorys_columns_are_equally_long():
    with pytest.raises(ParameterError, match="must be a list of 5 numbers"):
        dataclasses.replace(straight(), d_m=np.zeros(4))
    with pytest.raises(ParameterError, match="must be a list of 5 numbers"):
        dataclasses.replace(straight(), d_m=np.zeros((5, 1)))


@given(left=st.integers(0, 3), right=st.integers(0, 3), width=st.floats(2.5, 4.0), d=st.floats(-20.0, 20.0))
def test_every_place_across_the_road_is_in_the_lane_whose_centre_is_nearest(left, right, width, d):
    road = Road(lanes_left=left, lanes_right=right, lane_width_m=width)
    lane = road.lane_of(d, 0.0)
    assert road.has_lane(lane, 0.0)
    others = [k for k in range(-right, left + 1) if k != lane]
    assert all(abs(d - road.lane_centre_m(lane, 0.0)) <= abs(d - road.lane_centre_m(k, 0.0)) + 1e-9 for k in others)
    assert road.left_edge_m - road.right_edge_m == pytest.approx((1 + left + right) * width)


@given(s=st.floats(-100.0, 100.0))
def test_curvature_is_linear_between_knots_and_held_beyond(s):
    road = Road(curvature=((-10.0, 0.01), (30.0, -0.03)))
    inside = min(max(s, -10.0), 30.0)
    assert float(road.curvature_at(s)) == pytest.approx(0.01 - 0.04 * (inside + 10.0) / 40.0)


@given(shift=st.floats(-1e5, 1e5))
def test_equal_roads_have_one_hash_wherever_they_come_from(shift):
    road = Road(lanes_left=1, curvature=((-10.0, 0.01), (30.0, -0.03)), road_end_s_m=500.0)
    told = Road(lanes_left=1, curvature=[(-10, 0.01), (30, -0.03)], road_end_s_m=500)
    moved = Road(lanes_left=1, curvature=((-10.0 - shift, 0.01), (30.0 - shift, -0.03)), road_end_s_m=500.0 - shift)
    for one, other in ((road, told), (road, pickle.loads(pickle.dumps(road))), (road.seen_from(shift), moved)):
        assert one == other
        assert hash(one) == hash(other)


def test_a_verdict_passes_exactly_without_violations():
    violation = Violation(kind=ViolationKind.SPEED, t_s=0.5, value=60.0, limit=50.0, unit="m/s")
    failed = Verdict(violations=(violation,), passed=True)
    assert not failed.passed
    assert failed.reason == "speed 60 m/s at 0.50 s, limit 50"
    assert Verdict(passed=False).passed
    assert Verdict().reason == "passed"


def test_coverage_answers_by_sector():
    coverage = Coverage(rear=False)
    assert [coverage.sees(sector) for sector in Sector] == [True, False, True, True]


@given(speed=st.floats(-50.0, 50.0), heading=st.floats(-3.0, 3.0))
def test_a_bodys_speed_has_its_components(speed, heading):
    body = Body(name="x", s_m=0.0, speed_mps=speed, heading_rad=heading)
    assert math.hypot(body.speed_along_mps, body.speed_across_mps) == pytest.approx(abs(speed))


def test_an_unknown_name_is_answered_with_the_nearest_or_with_all():
    assert nearest("sped", ["speed", "width"]) == "did you mean 'speed'?"
    assert nearest("zzz", ["b", "a"]) == "known: a, b"


@pytest.mark.parametrize(
    ("record", "wrong", "named"),
    [
        (SelectorSettings, {"ttc_threat_s": -1.0}, "ttc_threat_s"),
        (SelectorSettings, {"ttc_clear_s": math.nan}, "ttc_clear_s"),
        (SelectorSettings, {"ttc_clear_s": 4.0}, "ttc_clear_s = 4"),
        (SelectorSettings, {"distance_front_short_m": 40.0}, "distance_front_long_m"),
        (PredictionSettings, {"sigmas": math.inf}, "sigmas"),
        (PredictionSettings, {"lateral_fade_s": 0.0}, "lateral_fade_s"),
        (SigmoidSettings, {"a_per_m": 0.4}, "a_per_m"),
        (SigmoidSettings, {"b": 1.0}, "greater than 1"),
        (SigmoidSettings, {"lateral_friction_share": 1.2}, "lateral_friction_share"),
        (Settings, {"cycle_s": 0.0}, "cycle_s"),
    ],
)
def test_settings_refuse_what_makes_no_sense(record: Any, wrong: dict[str, float], named: str) -> None:
    with pytest.raises(ParameterError, match=named):
        record(**wrong)


def test_records_that_hold_arrays_are_equal_by_value() -> None:
    def trajectory(last_m: float) -> Trajectory:
        return Trajectory(**{name: (0.0, last_m if name == "s_m" else 0.1) for name in Trajectory.__dataclass_fields__})

    def case(corner_m: float) -> ParkingCase:
        return ParkingCase(start=(6.0, 1.4, 0.0), goal=(1.0, -1.0, 0.0), obstacles=(((20.0, 20.0), (21.0, 20.0), (corner_m, 21.0)),))

    for make in (trajectory, case):
        assert make(20.5) == make(20.5)
        assert make(20.5) != make(20.6)
        assert make(20.5) != "another thing"
        with pytest.raises(TypeError):
            hash(make(20.5))


def test_which_sectors_are_watched_has_to_be_said() -> None:
    with pytest.warns(UserWarning, match=r"coverage: which sectors") as told:
        assert Situation(host=HostState()).coverage == Coverage(front=False, rear=False, left=False, right=False)
    assert [Path(one.filename) for one in told] == [Path(__file__)]
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        said = Situation(host=HostState(), coverage=Coverage(rear=False))
        assert dataclasses.replace(said, time_s=1.0).coverage == Situation.from_json(said.to_json()).coverage == said.coverage


def test_the_package_says_which_sectors_are_watched_wherever_it_makes_a_situation() -> None:
    folders = (Path(mcdas_opt.__file__).parent, Path(__file__).parents[2] / "benchmarks")
    for path in (path for folder in folders for path in folder.rglob("*.py")):
        for call in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(call, ast.Call) and isinstance(call.func, ast.Name) and call.func.id == "Situation":
                assert {"coverage", None} & {keyword.arg for keyword in call.keywords}, f"{path}:{call.lineno}"


@pytest.mark.parametrize(
    ("kind", "size"),
    [
        ("pedestrian", (0.5, 0.5)),
        ("bicycle", (1.8, 0.6)),
        ("motorcycle", (2.2, 0.8)),
        ("car", (4.5, 1.8)),
        ("lorry", (12.0, 2.5)),
        ("other", (4.5, 1.8)),
        (None, (4.5, 1.8)),
    ],
)
def test_a_track_that_says_no_size_has_that_of_its_kind(kind, size):
    track = Track(**TRACK, kind=kind)
    assert (track.length_m, track.width_m) == size
    assert Track(**TRACK, kind=kind, length_m=3.0).length_m == 3.0
    assert Track(**TRACK, kind=kind, length_m=3.0).width_m == size[1]
    assert Track(**TRACK, kind=kind, width_m=1.1).width_m == 1.1
    document = Situation(host=HostState(), tracks=(track,), coverage=Coverage()).to_dict()
    assert document["tracks"][0]["length_m"] == size[0]
    del document["tracks"][0]["length_m"], document["tracks"][0]["width_m"]
    assert Situation.from_json(json.dumps(document)).tracks == (track,)


def test_a_situation_tells_who_has_an_id() -> None:
    front, other = Track(**TRACK), Track(**{**TRACK, "id": "other"})
    situation = Situation(host=HostState(), tracks=(other, front), coverage=Coverage())
    assert situation.track("front") is front
    assert situation.track("nobody") is None
    assert situation.track(None) is None
