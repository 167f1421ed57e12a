"""Every kind of bad measurement is counted under its name and moves no track by a bit."""

from __future__ import annotations

import math
from collections.abc import Callable
from contextlib import nullcontext
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mcdas_opt.domain.body import Body
from mcdas_opt.domain.measurement import BodyDetection, Mounting, RadarDetection, Scan
from mcdas_opt.domain.track import Track
from mcdas_opt.domain.vocabulary import Sector
from mcdas_opt.errors import ParameterError
from mcdas_opt.tracking.tracker import Tracker
from tests.tracking.worlds import STRAIGHT, host_at, ideal_scan, radar_scan

NAN, INF = math.nan, math.inf
NOW = 1.0  # of the scans with the faults; the track was fed until 0.95


def lead(t: float) -> list[Body]:
    return [Body(name="lead", s_m=40.0 + 13.0 * t, speed_mps=13.0)]


def fed(scan_of: Callable[..., Scan] = radar_scan) -> Tracker:
    tracker = Tracker()
    for k in range(20):
        tracker.update([scan_of(0.05 * k, lead(0.05 * k))], host_at(0.05 * k), STRAIGHT, 0.05 * k)
    return tracker


def same(a: tuple[Track, ...], b: tuple[Track, ...]) -> bool:
    if [track.id for track in a] != [track.id for track in b]:
        return False
    values = [[(t.s_m, t.d_m, t.speed_s_mps, t.speed_d_mps, t.covariance.tobytes()) for t in tracks] for tracks in (a, b)]
    return values[0] == values[1]


def take(tracker: Tracker, scan: Scan, now: float = NOW) -> None:
    tracker.update([scan], host_at(NOW), STRAIGHT, now)


BAD_POINTS = {
    "not_finite": [
        {"range_m": NAN},
        {"azimuth_rad": NAN},
        {"range_rate_mps": NAN},
        {"range_m": INF},
        {"range_rate_mps": -INF},
        {"range_sd_m": NAN},
        {"azimuth_sd_rad": INF},
    ],
    "negative_range": [{"range_m": -1.0}, {"range_m": -1e-9}],
    "implausible": [
        {"range_m": 1e6},
        {"range_m": 301.0},
        {"range_rate_mps": 101.0},
        {"range_rate_mps": -1e6},
        {"azimuth_rad": 4.0},
        {"range_sd_m": 0.0},
        {"range_rate_sd_mps": -0.1},
        {"range_sd_m": 1e200},
        {"azimuth_sd_rad": 5e-324},
    ],
}


@pytest.mark.parametrize(("kind", "change"), [(kind, change) for kind, changes in BAD_POINTS.items() for change in changes])
def test_a_bad_point_is_counted_and_moves_nothing(kind: str, change: dict[str, float]) -> None:
    tracker = fed()
    before, counters = tracker.tracks(NOW), dict(tracker.counters)
    good = radar_scan(NOW, lead(NOW))
    take(tracker, replace(good, radar=(replace(good.radar[0], **change),)))
    assert same(tracker.tracks(NOW), before)
    assert tracker.counters == {**counters, kind: 1, "scans": counters["scans"] + 1}
    assert not tracker.coverage(NOW).front  # nothing but nonsense vouches for nothing


def test_a_good_point_beside_bad_ones_is_used() -> None:
    clean, dirty = fed(), fed()
    good = radar_scan(NOW, lead(NOW))
    (point,) = good.radar
    take(clean, good)
    take(dirty, replace(good, radar=(replace(point, range_m=NAN), point, replace(point, range_m=-5.0), point)))
    assert same(clean.tracks(NOW), dirty.tracks(NOW))
    assert (dirty.counters["not_finite"], dirty.counters["negative_range"], dirty.counters["duplicate"]) == (1, 1, 1)
    assert dirty.coverage(NOW).front


@pytest.mark.parametrize("change", [{"range_m": 75.0}, {"range_rate_mps": -9.0}, {"azimuth_rad": 0.15}])
def test_an_outlier_is_gated_and_moves_nothing(change: dict[str, float]) -> None:
    tracker = fed()
    before = tracker.tracks(NOW)
    good = radar_scan(NOW, lead(NOW))
    take(tracker, replace(good, radar=(replace(good.radar[0], **change),)))
    assert tracker.counters["gated"] == 1
    assert same(tracker.tracks(NOW), before)  # it may have begun a tentative track, which nobody is shown
    assert tracker.coverage(NOW).front


BAD_TIMES = {
    "duplicate": [(0.95, NOW)],
    "out_of_order": [(0.9, NOW), (-5.0, NOW)],
    "future": [(NOW + 0.06, NOW), (1e9, NOW)],
    "not_finite": [(NAN, NOW), (INF, NOW), (-INF, NOW)],
}


@pytest.mark.parametrize(("kind", "t", "now"), [(kind, *times) for kind, both in BAD_TIMES.items() for times in both])
@pytest.mark.parametrize("scan_of", [radar_scan, ideal_scan])
def test_a_scan_of_a_bad_time_is_counted_and_moves_nothing(kind: str, t: float, now: float, scan_of: Callable[..., Scan]) -> None:
    tracker = fed(scan_of)
    before, counters = tracker.tracks(NOW), dict(tracker.counters)
    seen_s = 0.05 * 19 if kind == "duplicate" else NOW
    with pytest.warns(UserWarning, match="another clock, or milliseconds") if t == 1e9 else nullcontext():
        take(tracker, replace(scan_of(seen_s, lead(seen_s)), t_s=t), now)
    assert same(tracker.tracks(NOW), before)
    assert tracker.counters == {**counters, kind: 1}
    assert tracker.coverage(1.05).front
    assert not tracker.coverage(1.2).front  # a refused scan is no sign of life


def test_a_sensor_far_behind_another_is_out_of_order() -> None:
    tracker = fed()
    take(tracker, radar_scan(0.7, lead(0.7), sector=Sector.REAR))
    assert tracker.counters["out_of_order"] == 1
    take(tracker, radar_scan(0.8, [], sector=Sector.REAR))
    assert tracker.counters["out_of_order"] == 1


def test_a_little_ahead_of_the_clock_is_allowed() -> None:
    tracker = fed()
    take(tracker, radar_scan(NOW + 0.04, lead(NOW + 0.04)))
    assert tracker.counters["future"] == 0
    assert tracker.counters["associated"] == 20


@pytest.mark.parametrize("place", [Mounting(x_m=NAN), Mounting(y_m=INF), Mounting(yaw_rad=NAN)])
def test_a_sensor_that_is_nowhere(place: Mounting) -> None:
    tracker = fed()
    before = tracker.tracks(NOW)
    take(tracker, replace(radar_scan(NOW, lead(NOW)), mounting=place))
    assert tracker.counters["not_finite"] == 1
    assert same(tracker.tracks(NOW), before)


def test_a_sensor_that_is_on_no_car() -> None:
    tracker = fed()
    before = tracker.tracks(NOW)
    take(tracker, replace(radar_scan(NOW, lead(NOW)), mounting=Mounting(x_m=1e300)))
    assert tracker.counters["implausible"] == 1
    assert same(tracker.tracks(NOW), before)


@pytest.mark.parametrize(
    ("kind", "change"),
    [
        ("not_finite", {"s_m": NAN}),
        ("not_finite", {"speed_d_mps": INF}),
        ("not_finite", {"length_m": NAN}),
        ("implausible", {"width_m": 0.0}),
        ("implausible", {"speed_s_mps": 400.0}),
        ("gated", {"s_m": 100.0}),
        ("gated", {"d_m": -1e6}),
    ],
)
def test_a_bad_ideal_detection_is_counted_and_moves_nothing(kind: str, change: dict[str, float]) -> None:
    tracker = fed(ideal_scan)
    before, counters = tracker.tracks(NOW), dict(tracker.counters)
    good = ideal_scan(NOW, lead(NOW))
    take(tracker, replace(good, bodies=(replace(good.bodies[0], **change),)))
    assert same(tracker.tracks(NOW), before)
    assert tracker.counters == {**counters, kind: 1, "scans": counters["scans"] + 1}


def test_one_name_twice_in_a_scan_counts_once() -> None:
    tracker = fed(ideal_scan)
    good = ideal_scan(NOW, lead(NOW))
    take(tracker, replace(good, bodies=(good.bodies[0], replace(good.bodies[0], s_m=good.bodies[0].s_m + 1.0))))
    assert tracker.counters["duplicate"] == 1
    assert tracker.tracks(NOW)[0].s_m == pytest.approx(53.0, abs=1e-3)


def test_the_clock_itself_must_be_a_number() -> None:
    with pytest.raises(ParameterError, match="now"):
        Tracker().update([], host_at(0.0), STRAIGHT, NAN)


anything = st.one_of(st.floats(), st.sampled_from([NAN, INF, -INF, 0.0, -0.0, 1e300, -1e300, 1e-300]))


@pytest.mark.filterwarnings("ignore:scan of 'mad'.* ahead of now")
@settings(deadline=None, max_examples=60)
@given(
    points=st.lists(st.tuples(anything, anything, anything), max_size=4),
    bodies=st.lists(st.tuples(anything, anything, anything, anything, anything, anything), max_size=3),
    t=anything,
)
def test_whatever_a_sensor_says_tracks_stay_numbers(points, bodies, t: float) -> None:
    tracker = fed()
    scan = Scan(
        sensor="mad",
        sector=Sector.LEFT,
        t_s=t,
        radar=tuple(RadarDetection(range_m=r, azimuth_rad=phi, range_rate_mps=v) for r, phi, v in points),
        bodies=tuple(
            BodyDetection(name=f"b{k}", s_m=s, d_m=d, speed_s_mps=v, speed_d_mps=w, length_m=length, width_m=width)
            for k, (s, d, v, w, length, width) in enumerate(bodies)
        ),
    )
    for candidate in (scan, replace(scan, t_s=NOW), replace(scan, t_s=NOW + 0.02)):
        take(tracker, candidate)
        for track in tracker.tracks(NOW + 0.02):  # a Track cannot be born with a NaN
            assert np.all(np.isfinite(track.covariance))
