"""The sigmoid's design: where its optimum must lie, that nothing beats it, and what its multipliers say."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mcdas_opt import tune
from mcdas_opt.domain.vocabulary import Side
from mcdas_opt.dynamics.sigmoid import renormalised, sigmoid
from mcdas_opt.errors import ParameterError
from mcdas_opt.geometry.rectangle import corners, separation
from mcdas_opt.tuning.design import Design, design
from mcdas_opt.tuning.request import DesignRequest
from mcdas_opt.tuning.study_options import StudyOptions

SPEEDS = st.floats(4.0, 40.0)
LAX: dict[str, Any] = {
    "lateral_jerk_mps3": 1e4,
    "heading_jump_rad": 1.0,
    "curvature_1pm": 10.0,
    "vehicle": replace(DesignRequest().vehicle, steering_rate_max_radps=1e3, steering_max_rad=1.4),
    "b_bounds": (50.0, 50.0),
    "friction": 9.0,
}


@settings(max_examples=15, deadline=None)
@given(speed=st.floats(8.0, 40.0), limit=st.floats(1.0, 8.0), offset=st.floats(-2.0, 2.0), b=st.floats(5.0, 200.0))
def test_where_only_lateral_acceleration_binds_a_is_the_closed_form(speed: float, limit: float, offset: float, b: float) -> None:
    found = design(DesignRequest(speed_mps=speed, lateral_acceleration_mps2=limit, offset_m=offset, **LAX | {"b_bounds": (b, b)}))
    gain = (found.y_max_m + offset) * (b + 1.0) / (b - 1.0)
    assert found.a_per_m == pytest.approx(-math.sqrt(6.0 * math.sqrt(3.0) * limit / (gain * speed**2)), rel=1e-6)
    assert any(words.startswith("lateral acceleration binds") for words in found.active)


@settings(max_examples=10, deadline=None)
@given(speed=SPEEDS, limit=st.floats(1.0, 30.0))
def test_where_only_lateral_jerk_binds_a_is_the_cube_root(speed: float, limit: float) -> None:
    found = design(DesignRequest(speed_mps=speed, lateral_acceleration_mps2=1e3, **LAX | {"lateral_jerk_mps3": limit, "friction": 200.0}))
    gain = found.y_max_m * 51.0 / 49.0
    assert found.a_per_m == pytest.approx(-((8.0 * limit / (gain * speed**3)) ** (1.0 / 3.0)), rel=1e-6)


def measured(found: Design) -> dict[str, float]:
    """Peaks of a design by finite differences of the curve itself: no formula of the optimiser's."""
    x = np.linspace(0.0, found.end_m, 4001)
    y = found.sigmoid.reach_m * renormalised(x, found.a_per_m, found.b, np)
    h, v = x[1], found.speed_mps
    first, second, third = np.gradient(y, h, edge_order=2), np.diff(y, 2) / h**2, np.diff(y, 3) / h**3
    kappa = second / (1.0 + first[1:-1] ** 2) ** 1.5
    steering = np.arctan(found.request.vehicle.wheelbase_m * kappa)
    return {
        "lateral acceleration": v**2 * np.abs(second).max(),
        "lateral jerk": v**3 * np.abs(third).max(),
        "curvature": np.abs(kappa).max(),
        "steering": np.abs(steering).max(),
        "steering rate": v * np.abs(np.diff(steering)).max() / h,
        "initial heading jump": math.atan(first[0]),
        "settling error": abs(y[-1] - found.request.lane_width_m),
        "length": float(np.interp(found.request.lane_width_m - 0.1, y, x)),
    }


REQUESTS = st.builds(
    DesignRequest,
    speed_mps=SPEEDS,
    offset_m=st.floats(-2.0, 2.0),
    side=st.sampled_from([Side.LEFT, Side.RIGHT]),
    lateral_acceleration_mps2=st.floats(1.0, 8.0),
    lateral_jerk_mps3=st.floats(3.0, 60.0),
    friction=st.floats(0.2, 1.0),
    heading_jump_rad=st.floats(0.005, 0.05),
    settling_m=st.floats(0.001, 0.09),
)


@settings(max_examples=20, deadline=None)
@given(request=REQUESTS)
def test_reported_values_are_those_of_the_curve_and_keep_their_limits(request: DesignRequest) -> None:
    found = design(request)
    peaks = measured(found)
    for row in found.constraints:
        assert row.value <= row.limit * (1.0 + 1e-6) + 1e-6
        if row.name in peaks:
            assert row.value == pytest.approx(peaks[row.name], rel=5e-3, abs=1e-5)
    assert found.length_m == pytest.approx(peaks["length"], rel=1e-3)
    assert found.path.x_m[-1] == pytest.approx(found.end_m)
    assert np.diff(found.path.x_m).max() < 0.1 + 1e-9


@settings(max_examples=6, deadline=None)
@given(request=REQUESTS, seed=st.integers(0, 1000))
def test_no_random_sigmoid_within_the_limits_is_shorter(request: DesignRequest, seed: int) -> None:
    found, rng = design(request), np.random.default_rng(seed)
    near = rng.random(40000) < 0.5
    a = found.a_per_m * np.where(near, rng.uniform(0.9, 1.1, near.size), np.exp(rng.uniform(-1.5, 1.5, near.size)))
    b = np.maximum(found.b * np.where(near, rng.uniform(0.8, 1.25, near.size), np.exp(rng.uniform(-2.5, 2.5, near.size))), 4.0)
    reach = request.lane_width_m + rng.uniform(-1.0, 1.0, near.size) * request.settling_m
    limits = {row.name: row.limit for row in found.constraints}
    v, gain, L = request.speed_mps, reach * (b + 1.0) / (b - 1.0), request.vehicle.wheelbase_m
    shape = 1.0 / (1.0 + b) + (0.5 - 1.0 / (1.0 + b)) * np.linspace(0.0, 1.0, 60)[:, None]
    q = shape * (1.0 - shape)
    first, second, third = -gain * a * q, gain * a**2 * q * (1.0 - 2.0 * shape), -gain * a**3 * q * (1.0 - 6.0 * q)
    kappa = second / (1.0 + first**2) ** 1.5
    rate = v * L * np.gradient(kappa, axis=0) / np.gradient(np.log(shape / (1.0 - shape)), axis=0) * -a / (1.0 + (L * kappa) ** 2)
    kept = v**2 * second.max(0) <= min(limits["lateral acceleration"], limits["friction"])
    kept &= (v**3 * np.abs(third).max(0) <= limits["lateral jerk"]) & (kappa.max(0) <= limits["curvature"])
    kept &= np.arctan(first[0]) <= limits["initial heading jump"]
    kept &= np.abs(rate).max(0) <= 0.998 * limits["steering rate"]
    start = 1.0 / (1.0 + b)
    at = start + (request.lane_width_m - 0.1) / reach * (1.0 - 2.0 * start)
    length = np.log((1.0 - at) / (at * b)) / a
    assert kept.any()
    assert length[kept].min() >= found.length_m * (1.0 - 2e-4)


@pytest.mark.parametrize(
    ("objective", "field", "name", "step"),
    [
        ("shortest", "lateral_acceleration_mps2", "lateral acceleration", 1e-3),
        ("shortest", "heading_jump_rad", "initial heading jump", 1e-5),
        ("shortest", "settling_m", "settling error", 1e-5),
        ("jerk", "heading_jump_rad", "initial heading jump", 1e-5),
        ("jerk", "clearance_m", "front clearance", -1e-4),
    ],
)
def test_multipliers_are_what_a_little_more_saves(objective: str, field: str, name: str, step: float) -> None:
    request = DesignRequest(objective=objective, front_gap_m=15.0 if objective == "jerk" else None)
    here = design(request)
    there = design(replace(request, **{field: getattr(request, field) + step}))
    multiplier = next(row.multiplier for row in here.constraints if row.name == name)
    assert multiplier > 0.0
    assert (here.value - there.value) / abs(step) == pytest.approx(multiplier, rel=2e-2)


def test_sides_mirror() -> None:
    left = design(DesignRequest(offset_m=0.7, objective="jerk"))
    right = design(replace(left.request, offset_m=-0.7, side=Side.RIGHT))
    assert np.array_equal(left.path.y_m, -right.path.y_m)
    assert left.a_per_m == right.a_per_m


@pytest.mark.parametrize(("gap", "other"), [(20.0, 5.0), (14.0, 8.0), (25.0, 0.0)])
def test_clearance_is_that_of_the_bodies(gap: float, other: float) -> None:
    """Both bodies moved as rectangles: never nearer than the design's clearance, and that near somewhere."""
    request = DesignRequest(objective="jerk", front_gap_m=gap, front_speed_mps=other, clearance_m=0.4)
    found, car = design(request), request.vehicle
    assert any(words.startswith("front clearance binds") for words in found.active)
    x = np.linspace(0.0, found.end_m + 10.0, 3000)
    y = found.sigmoid.reach_m * renormalised(np.minimum(x, found.end_m), found.a_per_m, found.b, np)
    heading = np.arctan(np.gradient(y, x))
    host = corners(x, y, heading, car.length_m, car.width_m)
    ahead = gap + car.length_m + other * x / found.speed_mps
    there = corners(ahead, np.zeros_like(x), np.zeros_like(x), car.length_m, request.other_width_m)
    least = separation(host, there).min()
    assert 0.3 < least <= 0.4 + 1e-3


def test_more_clearance_is_not_to_be_had() -> None:
    most = tune(objective="clearance", front_gap_m=14.0, front_speed_mps=5.0)
    limits = {"objective": "jerk", "front_gap_m": 14.0, "front_speed_mps": 5.0}
    assert tune(**limits, clearance_m=most.value - 0.01).value > 0.0
    with pytest.raises(ParameterError, match="least gap"):
        tune(**limits, clearance_m=most.value + 0.02)


def test_speed_is_chosen_within_its_bounds() -> None:
    fixed = tune(objective="clearance", speed_mps=16.0, front_gap_m=14.0, front_speed_mps=5.0)
    free = tune(objective="clearance", speed_mps=16.0, front_gap_m=14.0, front_speed_mps=5.0, speed_bounds_mps=(10.0, 20.0))
    assert 10.0 <= free.speed_mps <= 20.0
    assert free.value > fixed.value


@pytest.mark.parametrize(("speed", "length"), [(100 / 3.6, 12.0), (60 / 3.6, 20.0), (30 / 3.6, 5.0)])
def test_what_cannot_settle_is_told_the_shortest(speed: float, length: float) -> None:
    with pytest.raises(ParameterError, match=f"settles within {length:g} m") as refused:
        tune(speed_mps=speed, length_max_m=length)
    shortest = float(str(refused.value).split("the shortest is ")[1].split()[0])
    assert shortest == pytest.approx(tune(speed_mps=speed).length_m, rel=5e-3)
    assert tune(speed_mps=speed, length_max_m=shortest * 1.01).length_m <= shortest * 1.01


def test_the_least_gap_that_is_named_suffices() -> None:
    with pytest.raises(ParameterError, match="least gap is") as refused:
        tune(objective="jerk", front_gap_m=6.0, front_speed_mps=0.0)
    gap = float(str(refused.value).split("least gap is ")[1].split()[0])
    assert tune(objective="jerk", front_gap_m=gap * 1.02, front_speed_mps=0.0).value > 0.0


@pytest.mark.parametrize(
    ("wrong", "words"),
    [
        ({"b_bounds": (50.0, 20.0)}, "wrong order"),
        ({"a_bounds_per_m": (-0.1, 0.1)}, "less than 0"),
        ({"objective": "shortes"}, "did you mean 'shortest'"),
        ({"speed_mps": float("nan")}, "finite"),
        ({"speed_mps": -3.0}, "greater than 0"),
        ({"friction": 0.0}, "greater than 0"),
        ({"settling_m": 0.2}, "must lie in"),
        ({"y_max_bounds_m": (1.0, 2.0)}, "exclude every path"),
        ({"front_gap_m": 20.0, "front_speed_mps": 30.0}, "would not be reached"),
        ({"lane_width_m": 1.0}, "greater than the vehicle's"),
        ({"a_bounds_per_m": (-0.5, -0.1), "b_bounds": (4.0, 5.0)}, "keeps this limit and all the others"),
        ({"a_bounds_per_m": (-1.0, -0.5)}, "nor all but one of them"),
        ({"lateral_jerk": 3.0}, "did you mean 'lateral_jerk_mps3'"),
        ({"objective": "jerk", "offset_m": 2.0}, "try right"),
    ],
)
def test_bad_requests_are_told_the_rule(wrong: dict[str, Any], words: str) -> None:
    with pytest.raises(ParameterError, match=words):
        tune(**wrong)


def test_the_papers_own_sigmoid_breaks_the_limits_that_the_design_keeps() -> None:
    x = np.linspace(0.0, 20.0, 2001)
    paper = np.diff(3.7 * sigmoid(x, -0.4, 50.0, np), 2) / x[1] ** 2
    for speed in (40 / 3.6, 60 / 3.6, 100 / 3.6):
        assert speed**2 * np.abs(paper).max() > 1.5 * max(r.value for r in tune(speed_mps=speed).constraints if r.unit == "m/s^2")


@pytest.mark.parametrize(
    ("asked", "said"),
    [
        ({"trials": 5}, "trials = 5: is of a study in traffic"),
        ({"storage": "x.db"}, "storage = .*: is of a study in traffic"),
        ({"scenes": "quick", "storage": "x.db", "friction": 0.5}, "friction = 0.5: is of a design"),
        ({"scenes": "quick", "storage": "x.db", "objective": "jerk"}, "objective = .*: is of a design"),
        (
            {"scenes": "quick", "storage": "x.db", "study": StudyOptions(), "speed_mps": 20.0},
            "speed_mps = 20.0: is said by study.speed_mps",
        ),
    ],
)
def test_what_would_not_be_read_is_refused(asked: dict[str, Any], said: str) -> None:
    with pytest.raises(ParameterError, match=said):
        tune(**asked)
