"""Who does not follow the road goes straight on in the plane, or ends a turn; everybody else is predicted as without a heading."""

from __future__ import annotations

import math
import os
from dataclasses import replace
from unittest.mock import patch

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from mcdas_opt.domain.document import to_document
from mcdas_opt.domain.prediction import BodyMotion, CruisingBody, FreeBody, sizes_on_road
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.track import ALIGNED_RAD, Track
from mcdas_opt.domain.variant import Variant
from mcdas_opt.domain.vocabulary import BodyKind
from mcdas_opt.errors import ParameterError
from mcdas_opt.geometry.window import frame_near
from mcdas_opt.native.form import SWITCH
from mcdas_opt.tracking.free_motion import straight_on, turning_in
from mcdas_opt.tracking.prediction import ACCELERATING_MPS2, ACCELERATING_S, PULLING_AWAY_MPS, TURN_FADE_S, predict
from mcdas_opt.tracking.track_life import course

STRAIGHT = Road(lanes_left=1, lanes_right=1)
CORNER = Road(lanes_left=1, curvature=((0.0, 0.0), (20.0, 0.0), (25.0, 0.12), (38.0, 0.12), (43.0, 0.0)))
TIMES = np.linspace(0.0, 6.0, 241)


def track(heading: float, speed: float, **more: object) -> Track:
    moving = {"speed_s_mps": speed * math.cos(heading), "speed_d_mps": speed * math.sin(heading), "heading_rad": heading}
    return replace(Track(id="1", s_m=30.0, d_m=6.0, speed_s_mps=0.0), **moving | more)


@given(
    st.floats(-math.pi, math.pi), st.floats(0.0, 15.0), st.sampled_from([STRAIGHT, CORNER]), st.floats(-5.0, 60.0), st.floats(-15.0, 3.0)
)
def test_it_goes_straight_on_in_the_plane(heading: float, speed: float, road: Road, s_m: float, d_m: float) -> None:
    stretch = 1.0 - d_m * float(road.curvature_at(s_m))
    one = track(heading, speed, s_m=s_m, d_m=d_m, speed_s_mps=speed * math.cos(heading) / stretch)
    at = straight_on(one, road)(TIMES)
    x, y, yaw = frame_near(road, s_m).to_plane(at.s_m, at.d_m, at.heading_rad)
    np.testing.assert_allclose(np.hypot(x - x[0], y - y[0]), speed * TIMES, atol=0.05 + 0.05 * speed)  # half a sample where s jumps
    np.testing.assert_allclose(np.cos(yaw - yaw[0]), 1.0, atol=5e-3)
    sideways = (x - x[0]) * math.sin(yaw[0]) - (y - y[0]) * math.cos(yaw[0])
    assert np.abs(sideways).max() < 0.15


@given(
    st.floats(-math.pi, math.pi), st.floats(0.0, 15.0), st.sampled_from([STRAIGHT, CORNER]), st.floats(-5.0, 60.0), st.floats(-15.0, 3.0)
)
def test_both_forms_put_it_in_one_place(heading: float, speed: float, road: Road, s_m: float, d_m: float) -> None:
    one = track(heading, speed, s_m=s_m, d_m=d_m)
    compiled = straight_on(one, road)(TIMES)
    with patch.dict(os.environ, {SWITCH: "0"}):
        interpreted = straight_on(one, road)(TIMES)
    np.testing.assert_allclose(compiled.s_m, interpreted.s_m, atol=1e-9)
    np.testing.assert_allclose(compiled.d_m, interpreted.d_m, atol=1e-9)
    np.testing.assert_allclose(compiled.heading_rad, interpreted.heading_rad, atol=1e-9)


@given(st.floats(-1.5, 1.5), st.floats(5.0, 90.0), st.floats(1 / 90, 1 / 30), st.floats(-1000.0, 1000.0), st.floats(-10.0, 10.0))
@example(heading=-0.9, speed=90.0, curvature=0.017656526657684263, shift_m=774.0, d_m=0.0)
def test_on_a_road_that_turns_full_circle_it_is_where_it_is_wherever_s_is_counted_from(
    heading: float, speed: float, curvature: float, shift_m: float, d_m: float
) -> None:
    road = Road(curvature=((-2000.0, curvature),))
    at, shifted = (straight_on(track(heading, speed, s_m=s_m, d_m=d_m), road)(TIMES) for s_m in (0.0, shift_m))
    np.testing.assert_allclose(shifted.s_m - shift_m, at.s_m, atol=1e-5)
    np.testing.assert_allclose(shifted.d_m, at.d_m, atol=1e-5)


@given(st.floats(-1000.0, 1000.0))
@example(s_m=647.1232288514595)
def test_the_fastest_car_is_believed_to_drive_and_not_to_jump(s_m: float) -> None:
    fastest = track(0.0, 100.0, s_m=s_m, d_m=0.0)
    at = straight_on(fastest, Road(curvature=((0.0, 1e-9),)))(TIMES)
    np.testing.assert_allclose(at.s_m - s_m, 100.0 * TIMES, atol=1e-5)


@given(st.floats(-math.pi, math.pi), st.floats(0.0, 15.0))
def test_the_mirrored_body_goes_the_mirrored_way_to_the_bit(heading: float, speed: float) -> None:
    one = track(heading, speed)
    other = replace(one, d_m=-one.d_m, speed_d_mps=-one.speed_d_mps, heading_rad=-heading)
    a, b = straight_on(one, STRAIGHT)(TIMES), straight_on(other, STRAIGHT)(TIMES)
    assert np.array_equal(a.s_m, b.s_m)
    assert np.array_equal(a.d_m, -b.d_m)
    assert np.array_equal(a.heading_rad, -b.heading_rad)


@given(st.floats(0.35, 2.79), st.floats(1.0, 15.0), st.floats(0.1, 2.0), st.sampled_from([-1.0, 1.0]), st.sampled_from([STRAIGHT, CORNER]))
def test_who_turns_in_turns_on_a_circle_until_it_points_along_the_road(
    heading: float, speed: float, rate: float, side: float, road: Road
) -> None:
    """At its speed, and straight on from there; the mirrored one, on the straight road, to the bit."""
    one = replace(track(heading, speed, s_m=-40.0), turn_rate_radps=side * rate)
    at = turning_in(one, road)(TIMES)
    x, y, yaw = frame_near(road, 0.0).to_plane(at.s_m, at.d_m, at.heading_rad)
    to_go = heading if side < 0.0 else math.pi - heading
    turned, radius = np.minimum(rate * TIMES, to_go), speed / rate
    after, end = speed * np.maximum(TIMES - to_go / rate, 0.0), heading + side * to_go
    circle = -40.0 + side * radius * (np.sin(heading + side * turned) - math.sin(heading)) + after * math.cos(end)
    np.testing.assert_allclose(x, circle, atol=0.05 + 0.05 * speed)  # half a sample where s jumps
    circle = 6.0 - side * radius * (np.cos(heading + side * turned) - math.cos(heading)) + after * math.sin(end)
    np.testing.assert_allclose(y, circle, atol=0.05 + 0.05 * speed)
    np.testing.assert_allclose(np.cos(yaw - heading - side * turned), 1.0, atol=5e-3 + 0.01 * rate**2)
    other = replace(one, d_m=-6.0, speed_d_mps=-one.speed_d_mps, heading_rad=-heading, turn_rate_radps=-side * rate)
    if road is STRAIGHT:
        assert np.array_equal(turning_in(other, road)(TIMES).d_m, -at.d_m)


@given(st.floats(0.35, 2.79), st.floats(0.3, 8.0), st.floats(-8.0, 8.0), st.sampled_from([STRAIGHT, CORNER]))
def test_who_clearly_pulls_away_across_the_road_is_predicted_to_go_on_so_too(heading: float, speed: float, rate: float, road: Road) -> None:
    """As far as a second of that takes him in the plane. (Who slows down: `test_slowing_down`.)"""
    sds = {"acceleration_s_sd_mps2": 0.3, "acceleration_d_sd_mps2": 0.3}
    rates = {"acceleration_s_mps2": rate * math.cos(heading), "acceleration_d_mps2": rate * math.sin(heading)}
    one = track(heading, speed, s_m=-40.0, **rates, **sds)
    steady, *changing = predict([one], road=road).bodies
    assert rate < 0.0 or to_document(steady.at(TIMES)) == to_document(straight_on(one, road)(TIMES))
    if rate < ACCELERATING_MPS2 + 1e-9 or speed > PULLING_AWAY_MPS[1] - 1e-9:
        assert not changing or abs(rate - ACCELERATING_MPS2) < 1e-6 or abs(speed - PULLING_AWAY_MPS[1]) < 1e-6
        return
    (body,) = changing
    assert body.id == Variant.ACCELERATING.of("1")
    changed = np.minimum(TIMES, ACCELERATING_S)
    way = speed * TIMES + rate * changed * (TIMES - 0.5 * changed)
    at = body.at(TIMES)
    x, y, _ = frame_near(road, 0.0).to_plane(at.s_m, at.d_m, at.heading_rad)
    np.testing.assert_allclose(x, -40.0 + way * math.cos(heading), atol=0.1 + 0.1 * (speed + rate))  # a sample where s jumps
    np.testing.assert_allclose(y, 6.0 + way * math.sin(heading), atol=0.1 + 0.1 * (speed + rate))
    if road is STRAIGHT:
        np.testing.assert_allclose(at.d_m, y, atol=1e-9)
        np.testing.assert_allclose(np.hypot(at.speed_s_mps, at.speed_d_mps), speed + rate * changed, atol=0.05 * rate)
    for unknown in (replace(one, acceleration_d_sd_mps2=None), replace(one, kind=BodyKind.PEDESTRIAN)):
        assert len(predict([unknown], road=road).bodies) == 1


@pytest.mark.parametrize("speed", [0.0, 1e-310, 1e-12, 0.099, 0.1, 4.0])
@pytest.mark.parametrize("road", [STRAIGHT, CORNER])
def test_however_slowly_somebody_moves_his_prediction_is_a_number(speed: float, road: Road) -> None:
    """A millionth of a millionth of a metre a second, and accelerating: the prediction raised."""
    sds = {"acceleration_s_sd_mps2": 0.1, "acceleration_d_sd_mps2": 0.1}
    one = track(-0.5 * math.pi, speed, acceleration_d_mps2=-3.0, turn_rate_radps=-1e-310, turn_rate_sd_radps=0.0, **sds)
    bodies = predict([one], road=road).bodies
    assert len(bodies) == (2 if 0.1 <= speed <= 4.0 else 1)
    for body in bodies:
        assert all(np.isfinite(row).all() for row in _rows(body.at(TIMES)))


def _rows(motion: BodyMotion) -> tuple[np.ndarray, ...]:
    return motion.s_m, motion.d_m, motion.heading_rad, motion.speed_s_mps, motion.speed_d_mps


@given(st.floats(25.0, 100.0), st.floats(-1000.0, 1000.0))
def test_however_fast_it_goes_straight_on_as_long_as_it_is_followed(speed: float, s_m: float) -> None:
    """On a road that is told as bent and is not: 450 m on it once stood still, where the frame's table ended."""
    one = track(1.76, speed, s_m=s_m, speed_s_mps=speed, speed_d_mps=0.0)
    at = straight_on(one, Road(curvature=((10000.0, -1e-255),)))(np.linspace(0.0, 20.0, 41))
    np.testing.assert_allclose(at.s_m - s_m, speed * np.linspace(0.0, 20.0, 41), atol=1e-6)


@given(st.floats(-2.0 * math.pi, 2.0 * math.pi), st.floats(-400.0, 400.0))
@example(heading=2.0 * math.pi, shift_m=307.0)
def test_however_often_it_has_turned_it_goes_the_same_way_wherever_s_is_counted_from(heading: float, shift_m: float) -> None:
    road = Road(curvature=((0.0, -0.005),))
    at, shifted = (straight_on(replace(track(0.0, 20.0, s_m=s_m), heading_rad=heading), road)(TIMES) for s_m in (0.0, shift_m))
    assert abs(replace(track(0.0, 20.0), heading_rad=heading).heading_rad or 0.0) <= math.pi
    np.testing.assert_allclose(np.cos(shifted.heading_rad - at.heading_rad), 1.0, atol=1e-9)


@given(st.floats(-0.99 * ALIGNED_RAD, 0.99 * ALIGNED_RAD), st.sampled_from([0.0, math.pi]), st.floats(1.6, 20.0))
def test_who_drives_aligned_with_the_road_is_predicted_as_without_a_heading(turned: float, towards: float, speed: float) -> None:
    one = track(turned + towards, speed)
    bodies, without = (predict([each], road=STRAIGHT).bodies for each in (one, replace(one, heading_rad=None)))
    assert [to_document(body) for body in bodies] == [to_document(body) for body in without]
    assert (one.along_m, one.across_m) == (one.length_m, one.width_m)


@pytest.mark.parametrize("heading", [math.radians(degrees) for degrees in (25.0, 90.0, 155.0, -90.0)])
def test_who_is_turned_is_one_free_body(heading: float) -> None:
    prediction = predict([track(heading, 5.0)], road=STRAIGHT)
    (body,) = prediction.bodies
    assert isinstance(body, FreeBody)
    motion = body.at(np.array([3.0]))
    assert float(motion.d_m[0]) == pytest.approx(6.0 + 15.0 * math.sin(heading))


def test_somebody_on_foot_never_follows_the_road_and_may_stray() -> None:
    (body,) = predict([track(0.0, 1.4, kind="pedestrian")], road=STRAIGHT).bodies
    assert isinstance(body, FreeBody)
    np.testing.assert_allclose(body.margin_across_m(np.array([0.0, 1.0, 4.0])), [0.0, 0.5, 0.5])


def names(one: Track, road: Road) -> list[str]:
    return [body.id for body in predict([one], road=road).bodies]


def test_who_comes_towards_us_at_a_tight_turn_may_go_straight_on_there() -> None:
    gentle = Road(lanes_left=1, curvature=((0.0, 0.01), (200.0, 0.01)))
    oncoming = track(math.pi, 7.0, s_m=50.0, d_m=3.0)
    assert names(oncoming, CORNER) == [Variant.STRAIGHT_ON.of("1"), "1"]
    assert names(oncoming, gentle) == ["1"]
    assert names(replace(oncoming, heading_rad=None), CORNER) == ["1"]
    ahead = track(0.0, 3.0, s_m=15.0, d_m=0.0)
    assert names(ahead, CORNER) == ["1"]
    assert names(replace(ahead, speed_s_mps=12.0), CORNER) == [Variant.STRAIGHT_ON.of("1"), "1"]


@given(speed=st.floats(3.0, 12.0), sideways=st.floats(0.5, 1.5), left=st.booleans())
def test_who_comes_towards_us_through_a_tight_turn_keeps_to_it_or_goes_straight_on(speed: float, sideways: float, left: bool) -> None:
    """He changes no lanes there, and hardly drifts; elsewhere, and who drives our way, as ever."""
    road = replace(CORNER, lanes_left=1)
    one = replace(track(math.pi, speed, s_m=50.0, d_m=2.9), speed_d_mps=sideways if left else -sideways)
    assert names(one, road) == [Variant.STRAIGHT_ON.of("1"), "1"]
    kept = predict([one], road=road).bodies[1]
    assert np.abs(kept.at(TIMES).d_m - one.d_m).max() <= TURN_FADE_S * sideways
    on_straight = predict([one], road=replace(STRAIGHT, lanes_left=1)).bodies[0]
    assert np.abs(on_straight.at(np.array([8.0])).d_m - one.d_m).item() > 0.99 * sideways


@given(st.floats(-math.pi, math.pi))
def test_a_turned_body_takes_the_box_around_it(heading: float) -> None:
    free, cruising = predict([track(math.pi / 2.0, 5.0), replace(track(0.0, 5.0), id="2")], road=STRAIGHT).bodies
    assert isinstance(cruising, CruisingBody)
    length, width = sizes_on_road([free, cruising], np.full((2, 3), heading))
    c, s = abs(math.cos(heading)), abs(math.sin(heading))
    np.testing.assert_allclose(length[0], 4.5 * c + 1.8 * s)
    np.testing.assert_allclose(width[0], 4.5 * s + 1.8 * c)
    assert set(length[1]) == {4.5}


def test_a_radar_tells_a_course_only_where_it_is_clear() -> None:
    sure, unsure = np.diag([0.1, 0.1, 0.1, 0.1]) ** 2, np.diag([1.0, 2.0, 1.0, 2.0]) ** 2
    assert course(0.0, 5.0, sure) == pytest.approx(math.pi / 2.0)
    assert course(0.0, 5.0, unsure) is None
    assert course(20.0, 2.0, sure) is None
    assert course(-8.0, 0.1, sure) == pytest.approx(math.pi, abs=0.02)


def test_a_track_says_what_it_is_in_the_words_there_are() -> None:
    assert Track(id="1", s_m=0.0, d_m=0.0, speed_s_mps=0.0, kind="bicycle").kind is BodyKind.BICYCLE  # type: ignore[arg-type]
    with pytest.raises(ParameterError, match="kind"):
        Track(id="1", s_m=0.0, d_m=0.0, speed_s_mps=0.0, kind="horse")  # type: ignore[arg-type]
