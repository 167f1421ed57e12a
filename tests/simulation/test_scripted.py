"""Laws of scripted motion: exact in time, smooth, ended and begun as the contract says."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mcdas_opt.catalogue.neighbour_tables import MotionPart
from mcdas_opt.domain.road import Road
from mcdas_opt.simulation.scripted import LateralPiece, ScriptedMotion

ROAD = Road(lanes_left=1, lanes_right=1, speed_limit_mps=36.0)


def motion(*script: dict[str, float], s_m: float = 10.0, d_m: float = 0.0, speed_mps: float = 15.0, road: Road = ROAD) -> ScriptedMotion:
    parts = [MotionPart.model_validate(piece) for piece in script]
    return ScriptedMotion.from_script(s_m=s_m, d_m=d_m, speed_mps=speed_mps, script=parts, road=road)


def pieces(strategy_of_one: st.SearchStrategy[dict[str, float]]) -> st.SearchStrategy[list[dict[str, float]]]:
    return st.lists(strategy_of_one, max_size=5).map(lambda script: sorted(script, key=lambda p: p["start_s"]))


STARTS = st.floats(0.0, 8.0)
SPEED_PIECES = pieces(
    st.one_of(
        st.fixed_dictionaries({"start_s": STARTS, "acceleration_mps2": st.floats(-8.0, 3.0)}),
        st.fixed_dictionaries({"start_s": STARTS, "acceleration_mps2": st.floats(-8.0, 3.0), "until_speed_mps": st.floats(0.0, 40.0)}),
    )
)
LATERAL_PIECES = pieces(st.fixed_dictionaries({"start_s": STARTS, "lateral_to_m": st.floats(-4.0, 4.0), "duration_s": st.floats(0.5, 5.0)}))


@given(SPEED_PIECES, st.floats(0.0, 35.0))
@settings(max_examples=60, deadline=None)
def test_s_is_the_integral_of_speed(script: list[dict[str, float]], speed: float) -> None:
    t = np.linspace(-1.0, 12.0, 5201)
    path = motion(*script, speed_mps=speed)(t)
    # trapezia are exact on linear speed, but for the steps that hold a corner of it: each errs by at most |a| h^2 / 4
    steps = 0.5 * np.diff(t) * (path.speed_s_mps[1:] + path.speed_s_mps[:-1])
    np.testing.assert_allclose(path.s_m[0] + np.cumsum(steps), path.s_m[1:], atol=2e-4)
    assert np.abs(np.diff(path.speed_s_mps)).max() <= 8.0 * np.diff(t).max() + 1e-9  # no jump
    assert path.speed_s_mps.min() >= 0.0


@given(LATERAL_PIECES)
@settings(max_examples=60, deadline=None)
def test_d_is_smooth_through_interruptions(script: list[dict[str, float]]) -> None:
    path = motion(*script)
    pieces = path.lateral
    for before, after in itertools.pairwise(pieces):
        np.testing.assert_allclose(after.at(after.t_s), before.at(after.t_s), rtol=1e-9, atol=1e-9)
    for piece in pieces:  # and each is the integral of its own rates
        t = np.linspace(piece.t_s, piece.t_s + piece.duration_s, 400)
        d, rate, bend = piece.at(t)
        h = t[1] - t[0]
        scale = max(1.0, float(np.abs(bend).max()), float(np.abs(rate).max()))
        np.testing.assert_allclose(np.gradient(d, h)[1:-1], rate[1:-1], atol=1e-3 * scale)
        np.testing.assert_allclose(np.gradient(rate, h)[1:-1], bend[1:-1], atol=1e-3 * scale / min(1.0, piece.duration_s))
    for piece in pieces:
        assert path(np.array([piece.t_s])).d_m[0] == pytest.approx(next(p for p in reversed(pieces) if p.t_s <= piece.t_s).at(piece.t_s)[0])


@pytest.mark.parametrize(
    ("piece", "end"),
    [
        ({"acceleration_mps2": -6.0, "until_speed_mps": 5.0}, 5.0),
        ({"acceleration_mps2": -6.0}, 0.0),
        ({"acceleration_mps2": 2.0}, 36.0),
        ({"acceleration_mps2": 2.0, "until_speed_mps": 20.0}, 20.0),
        ({"acceleration_mps2": -2.0, "until_speed_mps": 20.0}, 15.0),  # already past it: nothing
        ({"acceleration_mps2": 2.0, "until_speed_mps": 10.0}, 15.0),
        ({"acceleration_mps2": 0.0}, 15.0),
    ],
)
def test_speed_reaches_its_target_exactly_and_is_held(piece: dict[str, float], end: float) -> None:
    path = motion({"start_s": 1.0, **piece})(np.array([0.5, 1.0, 30.0, 31.0]))
    assert path.speed_s_mps.tolist() == [15.0, 15.0, end, end]
    assert path.s_m[3] - path.s_m[2] == pytest.approx(end, abs=1e-9)


def test_braking_distance_is_the_textbooks() -> None:
    path = motion({"start_s": 2.0, "acceleration_mps2": -5.0})(np.array([2.0, 60.0]))
    assert path.s_m[1] - path.s_m[0] == pytest.approx(15.0**2 / (2.0 * 5.0))


def test_a_later_piece_ends_the_earlier_of_its_channel_only() -> None:
    script = (
        {"start_s": 0.0, "acceleration_mps2": -5.0},
        {"start_s": 0.5, "lateral_to_m": 3.7, "duration_s": 2.0},
        {"start_s": 1.0, "acceleration_mps2": 0.0},
    )
    path = motion(*script)(np.array([0.5, 1.0, 2.5, 9.0]))
    assert path.speed_s_mps.tolist() == [12.5, 10.0, 10.0, 10.0]
    assert path.d_m.tolist()[2:] == [3.7, 3.7]


@given(st.lists(st.floats(-3.0, 3.0), min_size=3, max_size=3), st.floats(-4.0, 4.0), st.floats(0.5, 6.0))
@settings(deadline=None)
def test_the_quintic_meets_its_six_conditions(state: list[float], to_m: float, duration: float) -> None:
    piece = LateralPiece.from_state(1.0, duration, to_m, np.array(state))
    np.testing.assert_allclose(piece.at(1.0), state, atol=1e-9)
    np.testing.assert_allclose(piece.at(1.0 + duration * (1.0 - 1e-12)), [to_m, 0.0, 0.0], atol=1e-6)
    assert piece.at(1.0 + duration + 1e-9).tolist() == [to_m, 0.0, 0.0]


def test_a_lateral_move_needs_a_speed_above_1_at_its_start() -> None:
    move = {"start_s": 1.0, "lateral_to_m": 3.7, "duration_s": 3.0}
    assert motion(move, speed_mps=1.0)(np.array([9.0])).d_m[0] == 0.0
    assert motion(move, speed_mps=1.01)(np.array([9.0])).d_m[0] == 3.7
    stopped = ({"start_s": 0.0, "acceleration_mps2": -8.0}, {**move, "start_s": 1.9})
    assert motion(*stopped)(np.array([9.0])).d_m[0] == 0.0


def test_heading_is_the_direction_of_travel() -> None:
    path = motion({"start_s": 0.0, "lateral_to_m": 3.7, "duration_s": 3.0})
    t = np.linspace(0.1, 2.9, 50)
    h = 1e-5
    before, after = path(t - h), path(t + h)
    direction = np.arctan2(after.d_m - before.d_m, after.s_m - before.s_m)
    np.testing.assert_allclose(path(t).heading_rad, direction, atol=1e-8)


def test_on_a_curved_road_heading_accounts_for_the_shorter_way_inside() -> None:
    road = Road(lanes_left=1, curvature=((0.0, 0.02),))
    moment = motion({"start_s": 0.0, "lateral_to_m": 3.7, "duration_s": 3.0}, road=road)(np.array([1.5]))
    over_ground = 15.0 * (1.0 - 0.02 * moment.d_m)
    np.testing.assert_allclose(np.tan(moment.heading_rad), moment.speed_d_mps / over_ground)


@given(LATERAL_PIECES, SPEED_PIECES)
@settings(max_examples=30, deadline=None)
def test_mirror_the_script_and_the_motion_mirrors(lateral: list[dict[str, float]], speed: list[dict[str, float]]) -> None:
    t = np.linspace(0.0, 10.0, 101)
    script = sorted([*lateral, *speed], key=lambda p: p["start_s"])
    mirrored = [{**p, "lateral_to_m": -p["lateral_to_m"]} if "lateral_to_m" in p else p for p in script]
    left, right = motion(*script, d_m=0.5)(t), motion(*mirrored, d_m=-0.5)(t)
    np.testing.assert_array_equal(left.s_m, right.s_m)
    np.testing.assert_array_equal(left.d_m, -right.d_m)
    np.testing.assert_array_equal(left.heading_rad, -right.heading_rad)


@given(SPEED_PIECES, LATERAL_PIECES, st.floats(0.0, 35.0))
@settings(max_examples=60, deadline=None)
def test_who_is_oncoming_drives_the_same_way_towards_smaller_s(
    script: list[dict[str, float]], aside: list[dict[str, float]], speed: float
) -> None:
    parts = [MotionPart.model_validate(piece) for piece in sorted(script + aside, key=lambda piece: piece["start_s"])]
    there, back = (
        ScriptedMotion.from_script(s_m=10.0, d_m=0.5, speed_mps=speed, script=parts, road=ROAD, oncoming=oncoming)(
            np.linspace(-1.0, 12.0, 300)
        )
        for oncoming in (False, True)
    )
    np.testing.assert_allclose(back.s_m - 10.0, 10.0 - there.s_m, atol=1e-9)
    assert (back.speed_s_mps == -there.speed_s_mps).all()
    assert (back.d_m == there.d_m).all()
    assert np.cos(back.heading_rad + there.heading_rad) == pytest.approx(-1.0)  # to the same side, the other way


def test_who_is_oncoming_follows_a_bend() -> None:
    bend = Road(lanes_left=1, curvature=((0.0, 0.0), (60.0, 0.01)))
    path = ScriptedMotion.from_script(s_m=90.0, d_m=3.7, speed_mps=10.0, script=(), road=bend, oncoming=True)(np.linspace(0.0, 9.0, 50))
    assert (path.d_m == 3.7).all()
    assert np.cos(path.heading_rad) == pytest.approx(-1.0)
    assert path.s_m[-1] == pytest.approx(0.0)
