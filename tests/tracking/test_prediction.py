"""Tracks go on at constant velocity; who plainly moves sideways also goes on into the next lane."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mcdas_opt.domain.prediction import CruisingBody
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.settings import PredictionSettings
from mcdas_opt.domain.track import Track
from mcdas_opt.domain.variant import Variant
from mcdas_opt.tracking.prediction import (
    ACROSS_MPS,
    CHANGE_FASTEST_S,
    CHANGE_GROWTH,
    CHANGE_PEAK_MPS,
    SHIELDED_SHARE,
    YOUNG_MPS,
    lane_change,
    predict,
)

ROAD = Road(lanes_left=2, lanes_right=1)
SETTINGS = PredictionSettings()


def test_a_prediction_holds_every_track_with_the_settings_of_the_planner() -> None:
    covariance = np.diag([0.04, 0.01, 0.09, 0.25])
    tracks = [
        Track(id="1", s_m=30.0, d_m=0.2, speed_s_mps=12.0, covariance=covariance),
        Track(id="2", s_m=-30.0, d_m=3.7, speed_s_mps=15.0, speed_d_mps=-0.8, covariance=covariance, length_m=9.0, width_m=2.4),
    ]
    settings = PredictionSettings(sigmas=2.0, growth_s=0.5, cap_along_m=0.45, cap_across_m=10.0, lateral_fade_s=2.0)
    prediction = predict(tracks, settings)
    assert prediction.name == "constant-velocity"
    assert [(b.id, b.length_m, b.width_m) for b in prediction.bodies] == [("1", 4.5, 1.8), ("2", 9.0, 2.4)]
    t = np.array([0.0, 1.0, 4.0])
    first, second = (body.at(t) for body in prediction.bodies)
    np.testing.assert_allclose(first.s_m, 30.0 + 12.0 * t)
    np.testing.assert_allclose(first.d_m, 0.2)
    np.testing.assert_allclose(second.d_m, 3.7 - 0.8 * 2.0 * (1.0 - np.exp(-t / 2.0)))
    along, across = prediction.bodies[0].margin_along_m(t), prediction.bodies[0].margin_across_m(t)
    np.testing.assert_allclose(along, [0.4, 2.0 * np.sqrt(0.04 + 0.25 * 0.01), 2.0 * np.sqrt(0.0425)])
    np.testing.assert_allclose(across, 2.0 * np.sqrt([0.09, 0.09 + 0.0625, 0.09 + 0.0625]))
    assert predict([]).bodies == ()


SEEN_SD_MPS = 0.15


def sideways(d: float, vd: float, *, sd: float = SEEN_SD_MPS, speed: float = 15.0) -> Track:
    return Track(id="7", s_m=20.0, d_m=d, speed_s_mps=speed, speed_d_mps=vd, covariance=np.diag([0.01, 0.04, 0.01, sd * sd]))


@given(vd=st.floats(-4.0, 4.0), sd=st.floats(0.0, 0.5), speed=st.floats(-2.0, 2.0))
def test_who_stands_does_not_slide_sideways_unless_that_is_clear(vd: float, sd: float, speed: float) -> None:
    """Noise across of a car that hardly moves is no motion; what is seen beyond noise is (a car that crosses, its heading unknown)."""
    told = predict([sideways(0.0, vd, sd=sd, speed=speed)]).bodies[0].at(np.zeros(1)).speed_d_mps[0]
    clear = abs(vd) > 2.5 * sd
    assert told == pytest.approx(vd if clear else np.clip(vd, -abs(speed), abs(speed)), abs=1e-12)


@given(vd=st.floats(-4.0, 4.0), sd=st.floats(0.0, 5.0))
def test_a_young_tracks_speed_across_the_lane_counts_by_how_well_it_is_known(vd: float, sd: float) -> None:
    told = predict([sideways(0.0, vd, sd=sd)]).bodies[0].at(np.zeros(1)).speed_d_mps[0]
    assert abs(told) <= abs(vd)
    assert told * vd >= 0.0
    if sd <= YOUNG_MPS:
        assert told == vd
    else:
        assert told == pytest.approx(vd / (1.0 + (sd**2 - YOUNG_MPS**2) / ACROSS_MPS**2))


places, sideways_mps = st.floats(-6.0, 10.0), st.floats(-4.0, 4.0)


@st.composite
def under_way(draw: st.DrawFn) -> tuple[float, float]:
    """(d, its rate) of one who has left the middle of his lane for the next one, and would not settle before it."""
    gone = draw(st.floats(0.21, 2.4))
    speed = draw(st.floats(0.5, min(3.0, ROAD.lane_width_m - gone - 0.01)))
    lane, side = draw(st.sampled_from([(0, 1.0), (1, 1.0), (-1, 1.0), (0, -1.0), (1, -1.0), (2, -1.0)]))
    return ROAD.lane_centre_m(lane, 0.0) + side * gone, side * speed


def changing(track: Track, road: Road = ROAD) -> CruisingBody:
    """The body of the lane change; the drift stands before it, unchanged."""
    alone = predict([track], SETTINGS).bodies
    bodies = predict([track], SETTINGS, road).bodies
    assert bodies[0] == alone[0]
    assert len(bodies) == 2
    assert isinstance(bodies[1], CruisingBody)
    assert bodies[1].id == Variant.CHANGING.of("7")
    return bodies[1]


@given(state=under_way())
def test_a_lane_change_begins_as_the_track_is_and_ends_in_the_middle_of_a_lane_ahead_of_it(state: tuple[float, float]) -> None:
    d, vd = state
    body = changing(sideways(d, vd))
    t = np.linspace(0.0, 60.0, 6001)
    motion = body.at(t)
    for column in (motion.s_m, motion.d_m, motion.heading_rad, motion.speed_s_mps, motion.speed_d_mps):
        assert np.isfinite(column).all()
    assert motion.d_m[0] == d
    assert motion.speed_d_mps[0] == pytest.approx(body.speed_d_mps, rel=1e-12)
    assert abs(vd) <= body.speed_d_mps * np.sign(vd) <= abs(vd) + SETTINGS.sigmas * SEEN_SD_MPS + 1e-12
    lane = ROAD.lane_of(float(motion.d_m[-1]), 0.0)
    assert motion.d_m[-1] == pytest.approx(ROAD.lane_centre_m(lane, 0.0), abs=1e-6)
    assert (motion.speed_d_mps * np.sign(vd) >= 0.0).all()
    np.testing.assert_allclose(np.diff(motion.d_m), 0.01 * 0.5 * (motion.speed_d_mps[1:] + motion.speed_d_mps[:-1]), atol=2e-4)
    assert abs(motion.d_m[-1] - d) > abs(vd) * SETTINGS.lateral_fade_s  # else it would be the drift once more


@given(state=under_way())
def test_what_is_left_shrinks_as_a_logistic_curve_and_never_faster_than_the_fastest(state: tuple[float, float]) -> None:
    d, vd = state
    body = changing(sideways(d, vd))
    peak = min(CHANGE_GROWTH * abs(body.speed_d_mps), CHANGE_PEAK_MPS)
    assert body.lateral_fade_s >= min(CHANGE_FASTEST_S, 0.25 * ROAD.lane_width_m / peak) - 1e-9
    assert body.lateral_swell >= 0.0
    motion = body.at(np.linspace(0.0, 5.0, 51))
    end = float(body.at(1e3).d_m)
    left = np.abs(end - motion.d_m)
    width = left[0] * (1.0 + 1.0 / body.lateral_swell)
    np.testing.assert_allclose(np.abs(motion.speed_d_mps), left * (1.0 - left / width) / body.lateral_fade_s, rtol=1e-6, atol=1e-9)
    assert np.abs(motion.speed_d_mps).max() <= max(0.25 * width / body.lateral_fade_s, abs(body.speed_d_mps)) + 1e-9


@given(d=places, vd=sideways_mps)
def test_the_mirrored_world_has_the_mirrored_lane_change(d: float, vd: float) -> None:
    other = Road(lanes_left=ROAD.lanes_right, lanes_right=ROAD.lanes_left)
    here, there = lane_change(sideways(d, vd), SETTINGS, ROAD), lane_change(sideways(-d, -vd), SETTINGS, other)
    assert here == (there and (-there[0], *there[1:]))


@given(d=places, vd=sideways_mps, sd=st.floats(0.0, 2.0), speed=st.floats(-30.0, 40.0))
def test_nobody_changes_lanes_who_does_not_plainly_move_sideways(d: float, vd: float, sd: float, speed: float) -> None:
    if lane_change(sideways(d, vd, sd=sd, speed=speed), SETTINGS, ROAD) is not None:
        assert abs(vd) >= max(0.5, 2.5 * sd)
        assert abs(vd) <= abs(speed)
        assert abs(d - ROAD.lane_centre_m(round(d / ROAD.lane_width_m), 0.0)) > 0.0
    assert lane_change(sideways(d, 0.45, sd=sd), SETTINGS, ROAD) is None
    assert lane_change(sideways(0.1, 0.8), SETTINGS, ROAD) is None  # hardly out of the middle of its lane
    assert lane_change(sideways(d, vd), SETTINGS, Road()) is None or abs(d) > 1.85 - 0.2  # nowhere to go on a single lane


@pytest.mark.parametrize("duration_s", [2.8, 4.0, 5.5, 7.0])
@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_a_smooth_lane_change_is_foretold_better_than_by_the_drift(duration_s: float, side: float) -> None:
    """A quintic over one lane, seen exactly: a second ahead, the lane change errs by less than half of what the drift does."""
    width, ahead_s = ROAD.lane_width_m, 1.0

    def at(t: float) -> tuple[float, float]:
        x = min(t / duration_s, 1.0)
        return side * width * (10 * x**3 - 15 * x**4 + 6 * x**5), side * width * 30 * (x * (1 - x)) ** 2 / duration_s

    errors = []
    for t in np.arange(0.0, 0.6 * duration_s, 0.05):
        d, vd = at(float(t))
        bodies = predict([sideways(d, vd, sd=0.0)], SETTINGS, ROAD).bodies
        if len(bodies) == 2:
            errors.append([abs(float(body.at(ahead_s).d_m) - at(float(t) + ahead_s)[0]) for body in bodies])
    drift, change = np.mean(errors, axis=0)
    assert len(errors) >= 5
    assert change < 0.5 * drift


@pytest.mark.parametrize("duration_s", [2.3125, 2.8, 3.5, 5.0])
@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_who_changes_lanes_is_not_ahead_of_his_lane_change_although_a_filter_lags_behind_him(duration_s: float, side: float) -> None:
    """A quintic over one lane, up to 3 m/s, believed to be slower by as much as its sigmas allow: half a second on he is nowhere
    nearer by more than a hand's breadth."""
    width, ahead_s, sd = ROAD.lane_width_m, 0.5, 0.18

    def at(t: float) -> tuple[float, float]:
        x = min(t / duration_s, 1.0)
        return width * (10 * x**3 - 15 * x**4 + 6 * x**5), width * 30 * (x * (1 - x)) ** 2 / duration_s

    foretold = 0
    for t in np.arange(0.0, 0.5 * duration_s, 0.02):
        d, vd = at(float(t))
        bodies = predict([sideways(side * d, side * (vd - SETTINGS.sigmas * sd), sd=sd)], SETTINGS, ROAD).bodies
        if len(bodies) == 2:
            foretold += 1
            assert side * float(bodies[1].at(ahead_s).d_m) >= at(float(t) + ahead_s)[0] - 0.15
    assert foretold >= 5


@given(length=st.floats(0.0, 18.0, exclude_min=True), host_s_m=st.floats(-1e4, 1e4), origin=st.floats(-1e4, 1e4))
def test_who_is_just_behind_is_so_wherever_places_are_counted_from(length: float, host_s_m: float, origin: float) -> None:
    """He brakes, which nobody behind is predicted to go on with."""
    s_m = host_s_m - length
    for shift in (0.0, origin):
        track = Track(
            id="1", s_m=s_m - shift, d_m=0.0, speed_s_mps=6.0, length_m=length, acceleration_s_mps2=-5.0, acceleration_s_sd_mps2=0.5
        )
        assert [body.id for body in predict([track], road=ROAD, host_s_m=host_s_m - shift).bodies] == ["1"]


@given(
    speed=st.floats(1.0, 40.0),
    between_mps=st.floats(0.0, 20.0),
    gap=st.floats(1.0, 200.0),
    friction=st.floats(0.1, 1.0),
    d=st.floats(-4.0, 4.0),
)
def test_nobody_drives_through_who_follows_the_host_unless_hard_braking_cannot_keep_him_behind(
    speed: float, between_mps: float, gap: float, friction: float, d: float
) -> None:
    road = Road(friction=friction)
    between = Track(id="between", s_m=-8.0, d_m=0.0, speed_s_mps=between_mps)
    behind = Track(id="behind", s_m=between.s_m - between.length_m - gap, d_m=d, speed_s_mps=speed)
    needed = max(speed - between_mps, 0.0) ** 2 / (2.0 * gap)
    if abs(needed - SHIELDED_SHARE * road.grip_mps2) > 1e-6 and abs(abs(d) - 0.5 * between.width_m) > 1e-6:
        stays = needed <= SHIELDED_SHARE * road.grip_mps2 and abs(d) < 0.5 * between.width_m
        there = {body.id for body in predict((between, behind), road=road, host_s_m=0.0).bodies}
        assert ("behind" in there) is not stays
        assert "between" in there
