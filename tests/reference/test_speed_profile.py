"""The speed ahead of bends: comfortable in each, and reached by gentle braking from everywhere before it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mcdas_opt.domain.comfort import ComfortSettings
from mcdas_opt.domain.road import Road
from mcdas_opt.native.form import SWITCH
from mcdas_opt.reference.speed_profile import FrontCar, profile_ahead, speeds_along

COMFORT = ComfortSettings()
TIMES_S = 0.1 * np.arange(301)

roads = st.lists(st.tuples(st.floats(20.0, 120.0), st.floats(-0.05, 0.05)), min_size=1, max_size=6).map(
    lambda pieces: Road(lanes_left=1, curvature=tuple(zip(np.cumsum([p[0] for p in pieces]).tolist(), [p[1] for p in pieces], strict=True)))
)


@given(road=roads, fastest=st.floats(1.0, 45.0), d=st.sampled_from([0.0, 3.7]))
def test_bends_are_comfortable_and_reached_by_gentle_braking(road: Road, fastest: float, d: float) -> None:
    profile = profile_ahead(road, 0.0, d, fastest, COMFORT)
    if profile is None:
        assert road.is_straight
        return
    s = profile.step_m * np.arange(profile.speed_mps.size)
    kappa = road.curvature_at(s)
    assert np.all(profile.speed_mps**2 * np.abs(kappa / (1.0 - d * kappa)) <= COMFORT.lateral_mps2 * (1.0 + 1e-9))
    falling = np.diff(profile.speed_mps**2)
    assert falling.min() >= -2.0 * COMFORT.bend_braking_mps2 * profile.step_m - 1e-6
    free = np.sqrt(0.9 * COMFORT.lateral_mps2 / np.maximum(np.abs(kappa / (1.0 - d * kappa)), 1e-6))
    braked = np.isclose(profile.speed_mps, free) | (np.append(falling, 0.0) < -2.0 * COMFORT.bend_braking_mps2 * profile.step_m + 1e-6)
    assert np.all(braked)  # never slower than it has to be


@given(road=roads, moved=st.integers(-100_000, 100_000))
def test_place_and_side_make_no_difference(road: Road, moved: int) -> None:
    here = profile_ahead(road, 0.0, 0.0, 30.0, COMFORT)
    turned = replace(road, curvature=tuple((s + moved, -kappa) for s, kappa in road.curvature))
    there = profile_ahead(turned, float(moved), 0.0, 30.0, COMFORT)
    if here is None or there is None:
        assert here is there
        return
    np.testing.assert_allclose(there.speed_mps, here.speed_mps, rtol=1e-6)


@given(road=roads, speed=st.floats(0.0, 40.0), wanted=st.floats(0.0, 40.0))
def test_who_drives_along_it_obeys_it(road: Road, speed: float, wanted: float) -> None:
    profile = profile_ahead(road, 0.0, 0.0, 40.0, COMFORT)
    speeds = speeds_along(profile, speed, wanted, TIMES_S, rising_mps2=2.0, falling_mps2=2.0, late_mps2=3.0)
    change = np.diff(speeds) / np.diff(TIMES_S)
    assert change.max() <= 2.0 + 1e-9
    assert change.min() >= -3.0 - 1e-9
    if profile is None:
        assert speeds[-1] == pytest.approx(wanted)
        return
    way = np.concatenate([[0.0], np.cumsum(speeds[:-1] * np.diff(TIMES_S))])
    over = speeds - profile.at(way)
    late = np.maximum.accumulate(over[::-1])[::-1]
    if over[0] <= 0.0:
        assert late.max() <= 1e-6
    else:  # come too fast: braking hard until it obeys
        assert np.all((over[1:] <= 1e-6) | (change <= -3.0 + 1e-6) | (speeds[1:] == 0.0))


@given(room=st.floats(0.0, 150.0), speed=st.floats(0.0, 35.0), its_speed=st.floats(1.0, 35.0))
def test_who_follows_comes_to_the_gap_that_is_asked_for(room: float, speed: float, its_speed: float) -> None:
    times_s = 0.1 * np.arange(901)
    front = FrontCar(room + its_speed * times_s, np.full_like(times_s, its_speed), np.full_like(times_s, 1.2))
    speeds = speeds_along(None, speed, 40.0, times_s, rising_mps2=2.0, falling_mps2=2.0, late_mps2=3.0, fronts=(front,))
    left = front.room_m - np.concatenate([[0.0], np.cumsum(speeds[:-1] * np.diff(times_s))])
    assert np.diff(speeds).min() >= -0.3 - 1e-9
    if left.min() > 0.1:
        assert left[-1] == pytest.approx(1.2 * its_speed, abs=0.5 + 0.05 * its_speed)
    if room > 1.2 * max(speed, its_speed) + max(speed - its_speed, 0.0) ** 2 / 2.0:
        assert left.min() >= 1.2 * its_speed - 1.0 - 0.2 * max(speed - its_speed, 0.0)


def test_who_closes_in_over_a_long_way_brakes_gently() -> None:
    for closing in (2.0, 5.0, 10.0):
        room = 5.0 * closing
        front = FrontCar(room + (30.0 - closing) * TIMES_S, np.full_like(TIMES_S, 30.0 - closing), np.zeros_like(TIMES_S))
        speeds = speeds_along(None, 30.0, 40.0, TIMES_S, rising_mps2=2.0, falling_mps2=2.0, late_mps2=3.0, fronts=(front,))
        assert np.diff(speeds).min() >= -0.2 - 1e-9


@given(road=roads, speed=st.floats(0.0, 45.0), wanted=st.floats(0.0, 45.0), rooms=st.lists(st.floats(-5.0, 120.0), max_size=3))
def test_both_forms_drive_as_fast_to_the_bit(road: Road, speed: float, wanted: float, rooms: list[float]) -> None:
    profile = profile_ahead(road, 0.0, 0.0, max(speed, wanted), COMFORT)
    fronts = [FrontCar(room + 0.2 * room * TIMES_S, np.maximum(0.2 * room - 0.1 * TIMES_S, 0.0), 0.01 * TIMES_S) for room in rooms]

    def speeds() -> bytes:
        return speeds_along(profile, speed, wanted, TIMES_S, rising_mps2=2.0, falling_mps2=2.0, late_mps2=3.0, fronts=fronts).tobytes()

    compiled = speeds()
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv(SWITCH, "0")
        assert speeds() == compiled
