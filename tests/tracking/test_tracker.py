"""The tracker's laws: life and death of tracks, geometry, mirror, time, sectors."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mcdas_opt.catalogue.sensors import load_sensor
from mcdas_opt.domain.body import Body
from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.measurement import RadarDetection, Scan
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.track import Track
from mcdas_opt.domain.vocabulary import Sector
from mcdas_opt.errors import InputError, ParameterError
from mcdas_opt.simulation.sensors import mounting
from mcdas_opt.tracking.track_life import COAST_S
from mcdas_opt.tracking.tracker import Tracker
from tests.tracking.worlds import BEND, CAR, STRAIGHT, body_of, host_at, ideal_scan, radar_scan

CORNER = load_sensor("corner_radar")
PERIOD = 0.05


def moving(name: str, s: float, d: float, speed: float, t: float, road: Road = STRAIGHT, length: float = 4.5) -> Body:
    """A car whose s grows evenly: on the outside of a bend it drives faster."""
    there = s + speed * t
    return Body(name=name, s_m=there, d_m=d, speed_mps=speed * (1.0 - d * float(road.curvature_at(there))), length_m=length)


def feed(tracker: Tracker, times: list[float], cars, *, road: Road = STRAIGHT, random=None) -> None:
    """Front radar scans of `cars(t)` at `times`, each taken in at its own time."""
    for t in times:
        tracker.update([radar_scan(t, cars(t), road=road, random=random)], host_at(t, road), road, t)


def beats(first: int, last: int) -> list[float]:
    return [PERIOD * k for k in range(first, last)]


def lead(t: float) -> list[Body]:
    return [moving("lead", 40.0, 0.0, 13.0, t)]


def only(tracker: Tracker, now: float) -> Track:
    (track,) = tracker.tracks(now)
    return track


def test_three_hits_of_four_confirm_a_track() -> None:
    tracker = Tracker()
    for k, expected in ((1, 0), (2, 0), (3, 1)):
        feed(tracker, beats(k - 1, k), lead)
        assert len(tracker.tracks(PERIOD * (k - 1))) == expected
    assert only(tracker, 2 * PERIOD).id == "1"


def test_one_miss_is_forgiven_two_are_not() -> None:
    tracker = Tracker()
    feed(tracker, beats(0, 2), lead)
    feed(tracker, beats(2, 3), lambda t: [])
    feed(tracker, beats(3, 4), lead)
    assert len(tracker.tracks(3 * PERIOD)) == 1
    tracker.reset()
    feed(tracker, beats(0, 1), lead)
    feed(tracker, beats(1, 3), lambda t: [])
    feed(tracker, beats(3, 5), lead)
    assert tracker.tracks(4 * PERIOD) == ()
    assert tracker.counters["initiated"] == 2


def test_clutter_confirms_nothing() -> None:
    """Points that jump about never become a car."""
    tracker, random = Tracker(), np.random.default_rng(1)
    for t in beats(0, 100):
        points = tuple(
            RadarDetection(range_m=random.uniform(5, 150), azimuth_rad=random.uniform(-0.6, 0.6), range_rate_mps=random.uniform(-30, 10))
            for _ in range(2)
        )
        scan = Scan(sensor="esr", sector=Sector.FRONT, t_s=t, mounting=mounting(Sector.FRONT, CAR), radar=points, period_s=PERIOD)
        tracker.update([scan], host_at(t), STRAIGHT, t)
        assert tracker.tracks(t) == ()
    assert tracker.counters["initiated"] > 100


def test_coasting_then_gone() -> None:
    """Without detections a track goes on at its speed, says so, grows vague, and ends after coast_s."""
    tracker = Tracker()
    feed(tracker, beats(0, 21), lead)
    seen = only(tracker, 1.0)
    assert not seen.coasting
    feed(tracker, beats(21, 35), lambda t: [])
    later = only(tracker, 1.7)
    assert later.coasting
    assert later.id == seen.id
    assert later.speed_s_mps == pytest.approx(seen.speed_s_mps)
    assert later.s_m == pytest.approx(seen.s_m + 0.7 * seen.speed_s_mps)
    assert later.covariance[0, 0] > 10.0 * seen.covariance[0, 0]
    assert len(tracker.tracks(1.0 + COAST_S)) == 1
    assert tracker.tracks(1.0 + COAST_S + 0.01) == ()
    feed(tracker, beats(42, 43), lambda t: [])
    assert tracker.tracks(2.1) == ()
    feed(tracker, beats(43, 46), lead)
    assert only(tracker, 2.25).id == "2"  # numbers are not used twice


def test_a_track_that_comes_back_is_the_same_track() -> None:
    tracker = Tracker()
    feed(tracker, beats(0, 21), lead)
    feed(tracker, beats(21, 31), lambda t: [])
    feed(tracker, beats(31, 41), lead)
    track = only(tracker, 2.0)
    assert (track.id, track.coasting) == ("1", False)
    assert track.s_m == pytest.approx(40.0 + 13.0 * 2.0, abs=1e-3)
    assert track.age_s == pytest.approx(2.0)


@pytest.mark.parametrize("road", [STRAIGHT, BEND], ids=["straight", "bend"])
@pytest.mark.parametrize(("sector", "s", "d"), [(Sector.FRONT, 30.0, 0.0), (Sector.FRONT, 45.0, 3.7), (Sector.REAR, -30.0, -3.7)])
def test_a_noise_free_radar_tracks_the_body_s_centre(road: Road, sector: Sector, s: float, d: float) -> None:
    tracker = Tracker()
    for t in beats(0, 61):
        cars = [moving("car", s, d, 13.0, t, road)]
        tracker.update([radar_scan(t, cars, sector=sector, road=road)], host_at(t, road), road, t)
    track, truth = only(tracker, 3.0), moving("car", s, d, 13.0, 3.0, road)
    assert track.s_m == pytest.approx(truth.s_m, abs=0.01)
    assert track.d_m == pytest.approx(truth.d_m, abs=0.01)
    assert track.speed_s_mps == pytest.approx(13.0, abs=0.01)
    assert track.speed_d_mps == pytest.approx(0.0, abs=0.01)


def test_the_neighbour_alongside_by_a_corner_radar() -> None:
    tracker, random = Tracker(), np.random.default_rng(7)
    for t in beats(0, 41):
        cars = [moving("car", -4.0, 3.7, 14.0, t)]
        tracker.update([radar_scan(t, cars, sector=Sector.LEFT, sensor=CORNER, random=random)], host_at(t), STRAIGHT, t)
    track = only(tracker, 2.0)
    assert track.s_m == pytest.approx(-4.0 + 28.0, abs=0.3)
    assert track.d_m == pytest.approx(3.7, abs=0.3)
    assert track.speed_s_mps == pytest.approx(14.0, abs=1.0)


def test_the_steering_host_s_own_motion_is_taken_off() -> None:
    """On a straight road, turning the wheels: a standing car stands, seen obliquely from a swinging bumper."""
    tracker = Tracker()
    for t in beats(0, 41):
        yaw_rate = 0.2 * math.cos(2.0 * t)
        heading = 0.1 * math.sin(2.0 * t)
        host = HostState(s_m=10.0 * t, d_m=0.0, heading_rad=heading, speed_mps=10.0, steering_rad=math.atan(2.7 * yaw_rate / 10.0))
        tracker.update([radar_scan(t, [Body(name="parked", s_m=60.0, d_m=-5.0)], host=host)], host, STRAIGHT, t)
    track = only(tracker, 2.0)
    assert track.s_m == pytest.approx(60.0, abs=0.01)
    assert track.speed_s_mps == pytest.approx(0.0, abs=0.01)
    assert track.speed_d_mps == pytest.approx(0.0, abs=0.05)


def test_ideal_detections_are_the_truth_at_once() -> None:
    """Confirmed by the first scan, size and velocity with it; a brake is followed without delay; nobody is confused."""
    tracker = Tracker()

    def cars(t: float) -> list[Body]:
        braking = Body(name="front", s_m=30.0 + 12.0 * t - 4.0 * t**2, speed_mps=12.0 - 8.0 * t, length_m=7.0, width_m=2.1)
        return [braking, moving("beside", 5.0, 3.7, 12.0, t), moving("behind it", 9.0, 3.7 + 1.9, 12.0, t)]

    for k, t in enumerate(beats(0, 21)):
        scans = [ideal_scan(t, cars(t), sector=sector) for sector in Sector]
        tracker.update(scans, host_at(t), STRAIGHT, t)
        tracks = tracker.tracks(t)
        assert len(tracks) == 3, k
        for body in cars(t):
            track = min(tracks, key=lambda track: math.hypot(track.s_m - body.s_m, track.d_m - body.d_m))
            np.testing.assert_allclose([track.s_m, track.d_m], [body.s_m, body.d_m], atol=1e-4)
            np.testing.assert_allclose([track.speed_s_mps, track.speed_d_mps], [body.speed_mps, 0.0], atol=1e-3)
            assert (track.length_m, track.width_m) == (body.length_m, body.width_m)
            assert np.sqrt(np.diag(track.covariance)).max() < 2e-3
    assert {track.id for track in tracks} == {"1", "2", "3"}


def test_a_radar_and_an_ideal_sensor_see_one_car() -> None:
    """Even a truck whose length the radar does not know: one car, one track, the true size."""
    tracker, random = Tracker(), np.random.default_rng(2)

    def truck(t: float) -> list[Body]:
        return [Body(name="truck", s_m=30.0 + 12.0 * t, d_m=1.2, speed_mps=12.0, length_m=12.0, width_m=2.5)]

    feed(tracker, beats(0, 10), truck, random=random)
    assert only(tracker, 0.45).length_m == 4.5
    for t in beats(10, 60):
        scans = [radar_scan(t, truck(t), random=random), ideal_scan(t, truck(t), sector=Sector.LEFT)]
        tracker.update(scans, host_at(t), STRAIGHT, t)
    track = only(tracker, 2.95)
    assert (track.id, track.length_m, track.width_m) == ("1", 12.0, 2.5)
    assert track.s_m == pytest.approx(30.0 + 12.0 * 2.95, abs=0.01)


def test_two_points_of_one_car_are_one_track() -> None:
    tracker = Tracker()
    for t in beats(0, 30):
        scan = radar_scan(t, lead(t))
        (point,) = scan.radar
        scan = replace(scan, radar=(point, replace(point, range_m=point.range_m + 1.5, azimuth_rad=point.azimuth_rad + 0.01)))
        tracker.update([scan], host_at(t), STRAIGHT, t)
        assert len(tracker.tracks(t)) <= 1
    assert tracker.counters["initiated"] == 1


def test_crossing_cars_keep_their_names() -> None:
    """One overtakes the other in the next lane: ids stay with the lanes."""
    tracker, random = Tracker(), np.random.default_rng(4)

    def cars(t: float) -> list[Body]:
        return [moving("slow", 50.0, 0.0, 12.0, t), moving("fast", 30.0, 3.7, 22.0, t)]

    feed(tracker, beats(0, 10), cars, random=random)
    names = {track.id: track.d_m > 1.8 for track in tracker.tracks(0.45)}
    feed(tracker, beats(10, 80), cars, random=random)
    assert {track.id: track.d_m > 1.8 for track in tracker.tracks(3.95)} == names
    assert len(names) == 2


@settings(deadline=None, max_examples=12)
@given(seed=st.integers(0, 10_000), bend=st.booleans())
def test_a_mirrored_world_gives_mirrored_tracks(seed: int, bend: bool) -> None:
    """d, azimuths, yaws, headings and the road's curvature flipped: the same tracks with d and its speed flipped, to 1e-9."""
    random = np.random.default_rng(seed)
    road = BEND if bend else STRAIGHT
    mirrored_road = replace(road, curvature=tuple((s, -k) for s, k in road.curvature))
    cars = [(f"car {k}", 14.0 * (k + 1) * (-1) ** k, random.uniform(-5.0, 5.0), random.uniform(8.0, 16.0)) for k in range(4)]
    one, other = Tracker(), Tracker()
    for t in beats(0, 25):
        host = replace(host_at(t, road), heading_rad=0.03 * math.sin(t), d_m=0.3 * t)
        bodies = [moving(name, s, d, v, t, road) for name, s, d, v in cars]
        front = radar_scan(t, bodies, road=road, host=host, random=random)
        rear = radar_scan(t, bodies, sector=Sector.REAR, road=road, host=host, random=random)
        left = radar_scan(t, bodies, sector=Sector.LEFT, sensor=CORNER, road=road, host=host, random=random)
        scans = [front, rear, left, ideal_scan(t, bodies, sector=Sector.RIGHT, host=host)]
        one.update(scans, host, road, t)
        other.update([mirror(scan) for scan in scans], mirror_host(host), mirrored_road, t)
        a, b = one.tracks(t), other.tracks(t)
        assert [track.id for track in a] == [track.id for track in b]
        flip = np.diag([1.0, 1.0, -1.0, -1.0])
        for x, y in zip(a, b, strict=True):
            np.testing.assert_allclose(
                [x.s_m, x.speed_s_mps, x.d_m, x.speed_d_mps], flip @ [y.s_m, y.speed_s_mps, y.d_m, y.speed_d_mps], atol=1e-9
            )
            np.testing.assert_allclose(x.covariance, flip @ y.covariance @ flip, atol=1e-9)
        seen, mirrored = one.coverage(t), other.coverage(t)
        assert (seen.front, seen.rear, seen.left, seen.right) == (mirrored.front, mirrored.rear, mirrored.right, mirrored.left)
    assert len(a) >= 2
    assert one.counters == other.counters


def mirror(scan: Scan) -> Scan:
    swap = {Sector.LEFT: Sector.RIGHT, Sector.RIGHT: Sector.LEFT}
    return replace(
        scan,
        sector=swap.get(scan.sector, scan.sector),
        mounting=replace(scan.mounting, y_m=-scan.mounting.y_m, yaw_rad=-scan.mounting.yaw_rad),
        radar=tuple(replace(point, azimuth_rad=-point.azimuth_rad) for point in scan.radar),
        bodies=tuple(replace(body, d_m=-body.d_m, speed_d_mps=-body.speed_d_mps) for body in scan.bodies),
    )


def mirror_host(host: HostState) -> HostState:
    return replace(host, d_m=-host.d_m, heading_rad=-host.heading_rad, steering_rad=-host.steering_rad)


def test_same_scans_same_tracks_to_the_bit() -> None:
    def drive() -> tuple[Track, ...]:
        tracker = Tracker()
        feed(tracker, beats(0, 40), lambda t: [*lead(t), moving("other", 60.0, 3.7, 15.0, t)], random=np.random.default_rng(3))
        return tracker.tracks(2.0)

    for x, y in zip(drive(), drive(), strict=True):
        assert (x.id, x.s_m, x.d_m, x.speed_s_mps, x.speed_d_mps) == (y.id, y.s_m, y.d_m, y.speed_s_mps, y.speed_d_mps)
        np.testing.assert_array_equal(x.covariance, y.covariance)


def test_late_scans_are_predicted_to_now() -> None:
    """A latency of 0.3 s: the tracks at now are the truth at now, the sector is covered all the same."""
    tracker = Tracker()
    for t in beats(0, 41):
        tracker.update([ideal_scan(t, lead(t))], host_at(t), STRAIGHT, t + 0.3)
    track = only(tracker, 2.3)
    assert track.s_m == pytest.approx(40.0 + 13.0 * 2.3, abs=1e-3)
    assert not track.coasting
    assert tracker.coverage(2.3).front


def test_sensors_of_different_latency() -> None:
    """The rear radar reports 0.1 s later than the front one: its scans count, and do not drag anything back."""
    tracker = Tracker()
    cars = [("front", 40.0, 0.0, 13.0), ("rear", -35.0, 0.0, 15.0)]
    for t in beats(2, 42):
        bodies = [moving(*car, t) for car in cars]
        before = [moving(*car, t - 0.1) for car in cars]
        tracker.update([radar_scan(t, bodies)], host_at(t), STRAIGHT, t)
        tracker.update([radar_scan(t - 0.1, before, sector=Sector.REAR)], host_at(t - 0.1), STRAIGHT, t)
    assert tracker.counters["out_of_order"] == 0
    for track, (_, s, _, v) in zip(sorted(tracker.tracks(2.05), key=lambda track: -track.s_m), cars, strict=True):
        assert track.s_m == pytest.approx(s + v * 2.05, abs=0.01)


def test_point_targets_are_their_own_centres() -> None:
    tracker = Tracker(reflection="centre")
    feed(tracker, beats(0, 20), lead)
    assert only(tracker, 0.95).s_m == pytest.approx(40.0 + 13.0 * 0.95 - 2.25, abs=1e-3)


def test_the_assumed_body_and_the_motion_are_the_caller_s() -> None:
    tracker = Tracker(motion="truck", body=(8.0, 2.5))
    feed(tracker, beats(0, 20), lambda t: [moving("truck", 40.0, 0.0, 13.0, t, length=8.0)])
    track = only(tracker, 0.95)
    assert (track.length_m, track.width_m) == (8.0, 2.5)
    assert track.s_m == pytest.approx(40.0 + 13.0 * 0.95, abs=1e-3)
    with pytest.raises(ParameterError, match="body length"):
        Tracker(body=(-1.0, 2.0))
    with pytest.raises(InputError, match="car, truck"):
        Tracker(motion="bicycle")
    with pytest.raises(ParameterError, match="reflection"):
        Tracker(reflection="bumper")


def test_reset_forgets_everything() -> None:
    tracker = Tracker()
    feed(tracker, beats(0, 20), lead)
    tracker.reset()
    assert tracker.tracks(1.0) == ()
    assert sum(tracker.counters.values()) == 0
    assert not tracker.coverage(1.0).front
    feed(tracker, beats(0, 20), lead)  # the clock begins anew, too
    assert only(tracker, 0.95).id == "1"


@pytest.mark.parametrize("faster_mps", [8.0, 12.0, 17.0])
@pytest.mark.parametrize("seed", range(3))
def test_one_that_drives_through_another_takes_nobody_away(faster_mps: float, seed: int) -> None:
    """A scripted car runs into the one ahead, hides it for 0.4 s, and comes out before it: two tracks at all times, each the same."""
    random, tracker = np.random.default_rng(seed), Tracker()
    names: dict[str, set[str]] = {"slow": set(), "fast": set()}
    for k in range(60):
        t = 0.05 * k
        slow = np.array([40.0 + 9.0 * t, 9.0, 3.7, 0.0])
        fast = np.array([slow[0] + (t - 1.5) * faster_mps, 9.0 + faster_mps, 3.7, 0.0])
        seen = [fast] if 1.2 < t < 1.6 else [slow, fast]
        scans = [radar_scan(t, [body_of(x)], random=random) for x in seen]
        tracker.update([replace(scans[0], radar=tuple(point for scan in scans for point in scan.radar))], host_at(t), STRAIGHT, t)
        if t > 0.5:
            one, other = sorted(tracker.tracks(t), key=lambda track: track.speed_s_mps)
            names["slow"].add(one.id)
            names["fast"].add(other.id)
    assert len(names["slow"]) == len(names["fast"]) == 1
