"""Documents: records to JSON and back, and trajectory files by anybody."""

from __future__ import annotations

import json
import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mcdas_opt.catalogue.trajectories import COLUMNS, load_trajectory
from mcdas_opt.domain.document import from_document, to_document
from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.plan import Plan
from mcdas_opt.domain.prediction import Prediction
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.situation import Situation
from mcdas_opt.domain.track import Coverage, Track
from mcdas_opt.domain.trajectory import Trajectory
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.domain.verdict import Verdict, Violation, ViolationKind
from mcdas_opt.domain.vocabulary import Mode, Request
from mcdas_opt.errors import InputError
from mcdas_opt.verification.judge import judge

numbers = st.floats(-1e3, 1e3)
positives = st.floats(0.1, 50.0)


@st.composite
def tracks(draw, name):
    root = np.array(draw(st.lists(st.floats(-2.0, 2.0), min_size=16, max_size=16))).reshape(4, 4)
    return Track(
        id=name,
        s_m=draw(numbers),
        d_m=draw(numbers),
        speed_s_mps=draw(numbers),
        speed_d_mps=draw(numbers),
        covariance=root @ root.T,
        length_m=draw(positives),
        coasting=draw(st.booleans()),
    )


@st.composite
def situations(draw):
    names = draw(st.lists(st.text(min_size=1, max_size=5), unique=True, max_size=3))
    kappa = draw(st.floats(-0.02, 0.02))
    return Situation(
        time_s=draw(numbers),
        host=HostState(s_m=draw(numbers), speed_mps=draw(positives), steering_rad=draw(st.floats(-0.5, 0.5))),
        tracks=tuple(draw(tracks(name)) for name in names),
        coverage=Coverage(rear=draw(st.booleans())),
        road=Road(lanes_left=draw(st.integers(0, 3)), curvature=((0.0, 0.0), (40.0, kappa)), road_end_s_m=draw(st.none() | positives)),
        desired_speed_mps=draw(st.none() | positives),
        request=draw(st.sampled_from(Request)),
    )


@settings(max_examples=60, deadline=None)
@given(situation=situations())
def test_a_situation_comes_back_from_its_json(situation):
    text = situation.to_json()
    back = Situation.from_json(text)
    assert back.to_json() == text
    assert back.tracks == () or np.array_equal(back.tracks[0].covariance, situation.tracks[0].covariance)
    assert (back.host, back.road, back.coverage, back.request) == (situation.host, situation.road, situation.coverage, situation.request)


def document():
    road = Road(lanes_left=1)
    track = Track(id="front", s_m=30.0, d_m=0.0, speed_s_mps=10.0)
    return Situation(host=HostState(speed_mps=10.0), tracks=(track,), road=road, coverage=Coverage()).to_dict()


@pytest.mark.parametrize(
    ("path", "value", "key", "words"),
    [
        (("hots",), {}, "hots", "did you mean 'host'?"),
        (("host", "sped_mps"), 3.0, "host.sped_mps", "did you mean 'speed_mps'?"),
        (("tracks", 0, "lenght_m"), 3.0, "tracks[0].lenght_m", "did you mean 'length_m'?"),
        (("road", "lanes_lefft"), 3, "road.lanes_lefft", "did you mean 'lanes_left'?"),
        (("host", "speed_mps"), math.nan, "host.speed_mps", "must be finite"),
        (("host", "speed_mps"), math.inf, "host.speed_mps", "must be finite"),
        (("host", "speed_mps"), "10", "host.speed_mps", "must be a number"),
        (("host", "speed_mps"), True, "host.speed_mps", "must be a number"),
        (("host", "speed_mps"), None, "host.speed_mps", "must be a number"),
        (("tracks", 0, "s_m"), math.nan, "tracks[0].s_m", "must be finite"),
        (("tracks", 0, "length_m"), -4.5, "tracks[0].length_m", "greater than 0"),
        (("tracks", 0, "id"), 3, "tracks[0].id", "must be text"),
        (("tracks", 0, "coasting"), 1, "tracks[0].coasting", "true or false"),
        (("tracks", 0, "covariance"), [[1.0]], "tracks[0].covariance", "4 x 4"),
        (("tracks", 0, "covariance"), [[-1.0] * 4] * 4, "tracks[0].covariance", "no negative variance"),
        (("tracks",), {}, "tracks", "must be a list"),
        (("host",), 3, "host", "must be an object"),
        (("request",), "fly", "request", "must be one of drive, park"),
        (("road", "lanes_left"), 1.5, "road.lanes_left", "whole number"),
        (("road", "curvature"), [[0.0]], "road.curvature", "pairs"),
        (("road", "curvature"), [[0.0, math.nan]], "road.curvature", "finite"),
        (("road", "friction"), 0, "road.friction", "must lie in [0.01, 10]"),
        (("desired_speed_mps"), -1.0, "desired_speed_mps", "at least 0"),
    ],
)
def test_a_fault_in_a_situation_names_file_and_key(path, value, key, words):
    changed = document()
    inner = changed
    path = (path,) if isinstance(path, str) else path
    for part in path[:-1]:
        inner = inner[part]
    inner[path[-1]] = value
    with pytest.raises(InputError) as caught:
        Situation.from_json(json.dumps(changed), "mine.json")
    assert (caught.value.file, caught.value.key) == ("mine.json", key)
    assert words in caught.value.rule


def test_missing_keys_and_broken_json_are_told():
    changed = document()
    del changed["tracks"][0]["d_m"]
    with pytest.raises(InputError, match=r"mine.json: tracks\[0\].d_m: missing key"):
        Situation.from_json(json.dumps(changed), "mine.json")
    changed = document()
    del changed["coverage"]["rear"]
    with pytest.raises(InputError, match=r"mine.json: coverage.rear: missing key: whether a working sensor watches it"):
        Situation.from_json(json.dumps(changed), "mine.json")
    del changed["coverage"]
    with pytest.raises(InputError, match=r"mine.json: coverage.front: missing key"):
        Situation.from_json(json.dumps(changed), "mine.json")
    with pytest.raises(InputError, match=r"mine.json: line 2: is not JSON"):
        Situation.from_json('{\n"host": }', "mine.json")
    with pytest.raises(InputError, match="must be an object"):
        Situation.from_json("[]", "mine.json")


def test_whole_numbers_stand_for_real_ones_in_json():
    changed = document()
    changed["host"]["speed_mps"] = 12
    changed["time_s"] = 3
    assert Situation.from_json(json.dumps(changed)).host.speed_mps == 12.0


def test_two_tracks_of_one_name_are_refused():
    changed = document()
    changed["tracks"].append(changed["tracks"][0])
    with pytest.raises(InputError, match="must be unique"):
        Situation.from_json(json.dumps(changed))


@given(
    value=st.recursive(
        st.floats() | st.none() | st.text() | st.booleans(), lambda inner: st.lists(inner) | st.dictionaries(st.text(), inner)
    )
)
def test_any_document_is_json_without_nan(value):
    json.dumps(to_document(value), allow_nan=False)
    json.dumps(to_document([np.float64(1.0), np.array([math.inf, 2.0]), Mode.EVADE, np.int64(3), np.bool_(True)]), allow_nan=False)


def test_a_verdict_comes_back():
    verdict = Verdict(violations=(Violation(kind=ViolationKind.SPEED, t_s=0.5, value=60.0, limit=50.0, unit="m/s"),))
    assert from_document(Verdict, json.loads(json.dumps(to_document(verdict))), "verdict.json") == verdict


# Trajectory files


def sample(count: int = 4) -> Trajectory:
    rng = np.random.default_rng(1)
    t = 0.1 * np.arange(count)
    return Trajectory.from_states(t, rng.normal(size=(count, 6)), rng.normal(size=(count - 1, 2)))


def csv_text(trajectory: Trajectory, order: list[str], **cells: str) -> str:
    table = [[cells.get(name, repr(float(getattr(trajectory, name)[k]))) for name in order] for k in range(len(trajectory))]
    return "\n".join([",".join(order), *(",".join(row) for row in table)]) + "\n"


def same(one: Trajectory, other: Trajectory) -> bool:
    return all(np.array_equal(getattr(one, name), getattr(other, name), equal_nan=True) for name in COLUMNS)


@settings(max_examples=20, deadline=None)
@given(order=st.permutations(COLUMNS))
def test_csv_columns_come_in_any_order(tmp_path_factory, order):
    path = tmp_path_factory.mktemp("t") / "t.csv"
    path.write_text(csv_text(sample(), order).replace(",", " , ").replace("\n", "\r\n") + "\r\n")
    read = load_trajectory(path)
    assert same(read.trajectory, sample())
    assert read.prediction is None


def test_json_may_be_a_trajectory_or_a_document_that_holds_one(tmp_path):
    trajectory = sample()
    path = tmp_path / "t.json"
    plan = Plan(planner="mpc", mode=Mode.HOLD, verdict=Verdict(), prediction="constant-velocity", trajectory=trajectory)
    for document, prediction in (
        (trajectory.to_dict(), None),
        ({"schema_version": 1, **trajectory.to_dict()}, None),
        (plan.to_dict(), "constant-velocity"),
        ({"outcome": "safe", "trajectory": trajectory.to_dict()}, None),
    ):
        path.write_text(json.dumps(document))
        read = load_trajectory(path)
        assert same(read.trajectory, trajectory)
        assert read.prediction == prediction


@pytest.mark.parametrize(
    ("change", "key", "value", "words"),
    [
        (lambda text: text.replace("jerk_mps3", "jerk"), "line 1", "jerk", "unknown column; did you mean 'jerk_mps3'?"),
        (lambda text: text.replace("jerk_mps3", "t_s"), "line 1", "t_s", "stands twice"),
        (lambda text: "\n".join(line.rsplit(",", 1)[0] for line in text.splitlines()), "line 1", None, "missing column jerk_mps3"),
        (lambda text: text.replace("0.1,", "abc,", 1), "line 3, column t_s", "abc", "must be a number"),
        (lambda text: text.replace("0.1,", ",", 1), "line 3, column t_s", "", "must be a number"),
        (lambda text: text.replace("0.1,", "0.1,7,", 1), "line 3", 10, "must have 9 cells"),
        (lambda text: text.splitlines()[0], "", None, "no samples"),
        (lambda text: "", "line 1", None, "missing column t_s"),
    ],
)
def test_faults_of_a_csv_name_line_and_column(tmp_path, change, key, value, words):
    path = tmp_path / "t.csv"
    path.write_text(change(csv_text(sample(), list(COLUMNS))))
    with pytest.raises(InputError) as caught:
        load_trajectory(path)
    assert (caught.value.file, caught.value.key, caught.value.value) == (str(path), key, value)
    assert words in caught.value.rule


@pytest.mark.parametrize(
    ("change", "key", "words"),
    [
        ({"s_m": [1.0]}, "trajectory.s_m", "must have 4 numbers, as t_s"),
        ({"s_m": [1.0, "x", 2.0, 3.0]}, "trajectory.s_m[1]", "must be a number"),
        ({"s_m": [1.0, True, 2.0, 3.0]}, "trajectory.s_m[1]", "must be a number"),
        ({"s_m": [1.0, 10**400, 2.0, 3.0]}, "trajectory.s_m[1]", "too large"),
        ({"s_m": 3.0}, "trajectory.s_m", "must be a list"),
        ({"sm": []}, "trajectory", "unknown column"),
        ({name: [] for name in COLUMNS}, "trajectory.t_s", "no samples"),
    ],
)
def test_faults_of_a_json_trajectory_name_the_key(tmp_path, change, key, words):
    path = tmp_path / "t.json"
    path.write_text(json.dumps({"trajectory": {**sample().to_dict(), **change}, "prediction": "x"}))
    with pytest.raises(InputError) as caught:
        load_trajectory(path)
    assert (caught.value.file, caught.value.key) == (str(path), key)
    assert words in caught.value.rule


@pytest.mark.parametrize(
    ("text", "words"),
    [("[1]", "must be an object"), ("{", "is not JSON"), ('{"trajectory": 3}', "object of columns"), ('{"t_s": []}', "missing column s_m")],
)
def test_documents_that_hold_no_trajectory_are_refused(tmp_path, text, words):
    path = tmp_path / "t.json"
    path.write_text(text)
    with pytest.raises(InputError, match=words):
        load_trajectory(path)


def test_a_missing_file_is_told(tmp_path):
    for path in (tmp_path / "none.csv", tmp_path / "none.json", tmp_path):
        with pytest.raises(InputError, match="no such file"):
            load_trajectory(path)


@pytest.mark.parametrize("word", ["nan", "inf", "-inf", "1e999"])
def test_numbers_that_are_not_finite_are_the_judges_to_convict(tmp_path, word):
    csv_path, json_path = tmp_path / "t.csv", tmp_path / "t.json"
    csv_path.write_text(csv_text(sample(), list(COLUMNS), d_m=word))
    json_path.write_text(json.dumps({**sample().to_dict(), "d_m": [0.0, None, 0.0, math.nan]}))
    for path, count in ((csv_path, 4), (json_path, 2)):
        verdict = judge(load_trajectory(path).trajectory, None, Vehicle(), Road(), Prediction(name="nobody"))
        assert [(v.name, v.value) for v in verdict.violations] == [("not finite", count)]


def test_what_was_written_is_judged_as_what_was_planned(tmp_path):
    t = np.round(0.1 * np.arange(21), 9)
    states = np.zeros((21, 6))
    states[:, 0], states[:, 3] = 10.0 * t, 10.0
    trajectory = Trajectory.from_states(t, states, np.zeros((20, 2)))
    path = tmp_path / "t.json"
    path.write_text(json.dumps(trajectory.to_dict()))
    wide = replace(Road(), lanes_left=1)
    assert judge(load_trajectory(path).trajectory, HostState(speed_mps=10.0), Vehicle(), wide, Prediction(name="nobody")).passed
