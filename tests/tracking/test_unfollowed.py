"""Whom a radar reports in every scan is known, or nobody says that the road there was watched."""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.measurement import Mounting, RadarDetection, Scan
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.vocabulary import Sector
from mcdas_opt.errors import MeasurementWarning
from mcdas_opt.planning.planner import Planner
from mcdas_opt.tracking.screening import MOST_DETECTIONS
from mcdas_opt.tracking.track_life import MOST_SOURCES
from mcdas_opt.tracking.tracker import Tracker
from mcdas_opt.tracking.unfollowed import SCANS, UnfollowedReturns
from tests.tracking.worlds import CAR, STRAIGHT

CYCLE_S = 0.1
CAR_MPS, GAP_M = 10.0, 75.0
PLACE = Mounting(x_m=2.25)
Clock = Callable[[int], float]


def scan(t_s: float, *points: RadarDetection, period_s: float = CYCLE_S, mounting: Mounting = PLACE) -> Scan:
    return Scan(sensor="r", sector=Sector.FRONT, t_s=t_s, mounting=mounting, radar=points, period_s=period_s)


def clutter(random: np.random.Generator, count: int, farthest_m: float = 170.0) -> list[RadarDetection]:
    r, phi, rate = random.uniform(1.0, farthest_m, count), random.uniform(-0.17, 0.17, count), random.uniform(-30.0, 10.0, count)
    return [RadarDetection(range_m=a, azimuth_rad=b, range_rate_mps=c) for a, b, c in zip(r, phi, rate, strict=True)]


def come(returns: UnfollowedReturns, points: list[RadarDetection], t_s: float) -> int:
    """Each begins a track of its own."""
    return returns.take([(point, object()) for point in points], t_s)


def chase(
    *,
    clock: Clock = lambda k: CYCLE_S * k,
    place: Callable[[float], float] = lambda s: s,
    rate: Callable[[float], float] = lambda rate_mps: rate_mps,
    heading: Callable[[int], float] = lambda k: 0.0,
    every: int = 1,
    period_s: float = CYCLE_S,
    beside: Callable[[], list[RadarDetection]] = list,
    cycles: int = 160,
    car_mps: float = CAR_MPS,
    gap_m: float = GAP_M,
) -> tuple[float, int, int]:
    """The host, 10 m/s faster, behind a car that every scan reports: the speed [m/s] at which it meets it (0: never), the longest run of
    cycles in which the front was covered and nobody known, and the cycles in which the car was known."""
    planner = Planner()
    s_m, speed_mps, acceleration_mps2 = 0.0, 20.0, 0.0
    unknown = longest = known = 0
    for k in range(cycles):
        now = clock(k)
        car = RadarDetection(range_m=gap_m, azimuth_rad=0.0, range_rate_mps=rate(car_mps - speed_mps))
        scans = [] if k % every else [scan(now, car, *beside(), period_s=period_s)]
        host = HostState(s_m=place(s_m), speed_mps=speed_mps, heading_rad=heading(k), acceleration_mps2=acceleration_mps2)
        plan = planner.step(scans, host, now, desired_speed_mps=20.0)
        unknown = unknown + 1 if plan.situation.coverage.front and not plan.situation.tracks else 0
        longest, known = max(longest, unknown), known + bool(plan.situation.tracks)
        acceleration_mps2 = plan.command_at(0.5 * CYCLE_S).acceleration_mps2
        after_mps = max(speed_mps + acceleration_mps2 * CYCLE_S, 0.0)
        way_m, speed_mps = 0.5 * (speed_mps + after_mps) * CYCLE_S, after_mps
        s_m, gap_m = s_m + way_m, gap_m - way_m + car_mps * CYCLE_S
        if gap_m <= 0.0:
            return speed_mps - car_mps, longest, known
    return 0.0, longest, known


def noise(sd: float) -> Callable[[int], float]:
    drawn = np.random.default_rng(7).normal(0.0, sd, 400)
    return lambda k: float(drawn[k])


CLOCKS: dict[str, Clock] = {
    "twice too fast": lambda k: 0.2 * k,
    "thrice too fast": lambda k: 0.3 * k,
    "five times too fast": lambda k: 0.5 * k,
    "running back": lambda k: 100.0 - 0.04 * k,
    "standing, 2 ms of noise": lambda k: 100.0 + noise(0.002)(k),
    "standing, 10 ms of noise": lambda k: 100.0 + noise(0.010)(k),
}


@pytest.mark.filterwarnings("ignore::mcdas_opt.errors.MeasurementWarning")
@pytest.mark.parametrize("clock", CLOCKS.values(), ids=CLOCKS.keys())
def test_under_a_wrong_clock_no_car_is_driven_into_on_a_watched_road(clock: Clock) -> None:
    hit_mps, unknown, _ = chase(clock=clock)
    assert hit_mps == 0.0
    assert unknown <= SCANS


FAULTS: dict[str, dict[str, Callable[..., float]]] = {
    "the host's place is never said": {"place": lambda s: 0.0},
    "a heading that flips": {"heading": lambda k: math.pi * (k % 2)},
}


@pytest.mark.parametrize("fault", FAULTS.values(), ids=FAULTS.keys())
def test_with_a_wrong_host_no_car_is_driven_into_on_a_watched_road(fault: dict[str, Callable[..., float]]) -> None:
    with pytest.warns(
        MeasurementWarning, match=r"the host's place moved by .* in which its speed says|a return has come in 8 scans and no track"
    ):
        hit_mps, unknown, _ = chase(**fault)  # type: ignore[arg-type]
    assert hit_mps == 0.0
    assert unknown <= SCANS


@pytest.mark.parametrize(("car_mps", "gap_m"), [(CAR_MPS, GAP_M), (0.0, 120.0)])
@pytest.mark.parametrize("factor", [-1.0, 0.0, 3.6])
def test_where_range_rates_are_wrong_cars_are_tracked_by_their_places(factor: float, car_mps: float, gap_m: float) -> None:
    """Of the other sign, always 0, in km/h: also a car that stands."""
    with pytest.warns(MeasurementWarning, match="a return has come in 8 scans .* its range rates are not believed"):
        hit_mps, unknown, known = chase(rate=lambda rate_mps: factor * rate_mps, car_mps=car_mps, gap_m=gap_m)
    assert hit_mps == 0.0
    assert unknown <= SCANS
    assert known >= 145


@pytest.mark.parametrize(("car_mps", "gap_m"), [(CAR_MPS, GAP_M), (0.0, 120.0)])
@pytest.mark.parametrize("too_high_mps", [3.0, 4.0, 5.0, 6.0, 7.0, 8.0])
def test_a_track_that_is_lost_and_begun_anew_again_and_again_is_none(too_high_mps: float, car_mps: float, gap_m: float) -> None:
    """It is confirmed each time, and seems to close more slowly than it does."""
    with pytest.warns(MeasurementWarning, match="m/s too high, as its ranges change|a return has come in 8 scans"):
        hit_mps, unknown, known = chase(rate=lambda rate_mps: rate_mps + too_high_mps, car_mps=car_mps, gap_m=gap_m)
    assert hit_mps == 0.0
    assert unknown <= SCANS
    assert known >= 145


def test_what_was_counted_is_forgotten_where_the_track_lives_on() -> None:
    point, car = RadarDetection(range_m=50.0, azimuth_rad=0.1, range_rate_mps=-3.0), object()
    for lives, counted in ((5, 4), (15, 3), (40, 1)):
        returns = UnfollowedReturns()
        assert [returns.take([(point, car)], 0.1 * k) for k in range(4)] == [1, 2, 3, 4]
        for k in range(lives):
            assert returns.take([], 0.4 + 0.1 * k, {car}, {point: car}) == 0
        assert returns.take([(point, object())], 0.4 + 0.1 * lives) == counted


@pytest.mark.parametrize(("every", "period_s"), [(1, 0.1), (2, 0.1), (4, 0.1), (5, 0.1), (8, 0.1), (5, 0.5), (8, 0.8)])
def test_who_is_seen_seldom_is_known(every: int, period_s: float, recwarn: pytest.WarningsRecorder) -> None:
    """Frames that are lost, and a slow radar: a tentative track waits for as long as a confirmed one."""
    hit_mps, _, known = chase(every=every, period_s=period_s)
    assert hit_mps == 0.0
    assert known >= 160 - 2 * every - 1
    assert not recwarn.list


def test_a_sector_is_not_covered_for_longer_than_tracks_live() -> None:
    tracker = Tracker()
    tracker.update([scan(0.0, period_s=50.0)], HostState(speed_mps=20.0), STRAIGHT, 0.0)
    assert tracker.coverage(1.0).front
    assert not tracker.coverage(1.01).front


@pytest.mark.parametrize("other", [Mounting(x_m=2.25, y_m=0.5), Mounting()])
def test_two_sensors_of_one_name_are_two(other: Mounting) -> None:
    """The second of them sees nobody, and is named first."""
    tracker = Tracker()
    for k in range(6):
        car = RadarDetection(range_m=50.0 - k, azimuth_rad=0.0, range_rate_mps=-10.0)
        both = [scan(CYCLE_S * k, mounting=other), scan(CYCLE_S * k, car)]
        tracker.update(both, HostState(s_m=2.0 * k, speed_mps=20.0), STRAIGHT, CYCLE_S * k)
    assert len(tracker.tracks(0.5)) == 1
    assert tracker.coverage(0.5).front


def test_two_scans_at_once_that_contradict_each_other_cover_nothing() -> None:
    tracker = Tracker()
    car = RadarDetection(range_m=50.0, azimuth_rad=0.0, range_rate_mps=-10.0)
    with pytest.warns(MeasurementWarning, match="two scans of t_s = 0.0 say different things"):
        tracker.update([scan(0.0), scan(0.0, car)], HostState(speed_mps=20.0), STRAIGHT, 0.0)
    assert not tracker.coverage(0.0).front
    again = Tracker()
    again.update([scan(0.0, car), scan(0.0, car)], HostState(speed_mps=20.0), STRAIGHT, 0.0)
    assert again.coverage(0.0).front


def test_a_radar_that_says_more_than_is_followed_covers_nothing() -> None:
    tracker, random = Tracker(), np.random.default_rng(0)
    with pytest.warns(MeasurementWarning, match="of 400 detections the nearest 256 are followed"):
        tracker.update([scan(0.0, *clutter(random, 400))], HostState(speed_mps=20.0), STRAIGHT, 0.0)
    assert not tracker.coverage(0.0).front
    tracker.update([scan(0.1, *clutter(random, MOST_DETECTIONS))], HostState(s_m=2.0, speed_mps=20.0), STRAIGHT, 0.1)
    assert tracker.coverage(0.1).front


@pytest.mark.parametrize("count", [1, 5, 20])
def test_clutter_comes_from_everywhere_and_is_not_counted(count: int, recwarn: pytest.WarningsRecorder) -> None:
    """2,000 scans of each density, of a radar's forty metres on; none of them is doubted."""
    random, returns, most = np.random.default_rng(count), UnfollowedReturns(), 0
    for k in range(2000):
        most = max(most, come(returns, [point for point in clutter(random, count) if point.range_m > 40.0], 0.05 * k))
    assert most < SCANS
    assert chase(beside=lambda: clutter(random, count), cycles=60)[0] == 0.0
    assert not recwarn.list


def test_one_missing_scan_does_not_end_the_count_and_two_do() -> None:
    point = RadarDetection(range_m=50.0, azimuth_rad=0.1, range_rate_mps=-3.0)
    for missing, counted in ((1, 5), (2, 1)):
        returns, t_s = UnfollowedReturns(), 0.0
        for _ in range(4):
            t_s += CYCLE_S
            come(returns, [point], t_s)
        for _ in range(missing):
            t_s += CYCLE_S
            assert come(returns, [], t_s) == 0
        assert come(returns, [replace(point, range_m=49.0)], t_s + CYCLE_S) == counted


def test_a_new_name_in_every_scan_is_not_remembered_for_ever() -> None:
    tracker = Tracker()
    for k in range(1000):
        car = RadarDetection(range_m=50.0, azimuth_rad=0.0, range_rate_mps=0.0)
        now, host = CYCLE_S * k, HostState(s_m=2.0 * k, speed_mps=20.0)
        tracker.update([replace(scan(now, car), sensor=f"r{k}")], host, STRAIGHT, now)
    assert len(tracker.tracks(now)) == 1
    for remembered in (tracker._heard, tracker._watch._heard, tracker._lives[0]._sources):
        assert len(remembered) <= MOST_SOURCES + 1


def test_an_echo_of_a_car_that_is_seen_is_no_car(recwarn: pytest.WarningsRecorder) -> None:
    """Over the guard rail: on a longer way, with the car's range rate, which does not fit where it seems to be."""
    tracker = Tracker()
    for k in range(60):
        now, s_m = CYCLE_S * k, 2.0 * k
        car = RadarDetection(range_m=30.0 - 0.3 * k, azimuth_rad=0.0, range_rate_mps=-3.0)
        echo = RadarDetection(range_m=120.0 - 1.4 * k, azimuth_rad=-0.1, range_rate_mps=-3.0)
        tracker.update([scan(now, car, echo)], HostState(s_m=s_m, speed_mps=20.0), STRAIGHT, now)
        assert tracker.coverage(now).front
    assert not recwarn.list


@pytest.mark.parametrize("spacing_m", [1.5, 3.0, 4.0, 6.0])
@pytest.mark.parametrize("aside_m", [2.5, 4.5])
def test_posts_of_a_guard_rail_are_followed_one_by_one(spacing_m: float, aside_m: float, recwarn: pytest.WarningsRecorder) -> None:
    """Where one was the next one is, a cycle later: on both sides of the lane, on the road and beside it, with noise and losses."""
    for seed in range(4):
        tracker, random, speed_mps = Tracker(), np.random.default_rng(seed), 25.0
        for k in range(40):
            now, s_m, points = CYCLE_S * k, speed_mps * CYCLE_S * k, []
            for n in range(int((s_m + 4.0) / spacing_m) + 1, int((s_m + 60.0) / spacing_m)):
                for d_m in (-aside_m, aside_m):
                    x = n * spacing_m - s_m - PLACE.x_m
                    r, phi, noise = math.hypot(x, d_m), math.atan2(d_m, x), random.standard_normal(3) * (0.25, 0.0087, 0.12)
                    if x > 1.0 and abs(phi) < 0.785 and random.random() < 0.9:
                        rate = -speed_mps * math.cos(phi) + noise[2]
                        points.append(RadarDetection(range_m=r + noise[0], azimuth_rad=phi + noise[1], range_rate_mps=rate))
            tracker.update([scan(now, *points)], HostState(s_m=s_m, speed_mps=speed_mps), Road(), now)
        assert tracker.counters["unfollowed"] == 0
    assert not recwarn.list


def test_posts_round_a_roundabout_are_no_fault_of_the_radar(recwarn: pytest.WarningsRecorder) -> None:
    """5 m outside of a lane of 15 m radius: near the sensor their faces turn quickly, and their tracks begin anew."""
    radius_m, speed_mps, place = 15.0, 5.0, Mounting(y_m=-0.9, yaw_rad=-0.5 * math.pi)
    tracker, road = Tracker(), Road(curvature=((0.0, 1.0 / radius_m),), lane_width_m=5.0)
    for k in range(140):
        now, turned = CYCLE_S * k, speed_mps * CYCLE_S * k / radius_m
        at = complex(math.sin(turned), -math.cos(turned)) * radius_m
        axis = complex(math.cos(turned), math.sin(turned))
        sensor, yaw_rate, points = at + axis * complex(place.x_m, place.y_m), speed_mps / radius_m, []
        velocity = axis * speed_mps + 1j * yaw_rate * (sensor - at)
        for n in range(8):
            post = complex(math.sin(0.25 * math.pi * n + 0.2), -math.cos(0.25 * math.pi * n + 0.2)) * (radius_m + 5.0)
            seen = (post - sensor) / axis * 1j  # in the sensor's own frame, which looks to the right
            r, phi = abs(seen), math.atan2(seen.imag, seen.real)
            if r < 13.0 and abs(phi) < 1.3:
                rate = -((post - sensor).conjugate() * velocity).real / r
                points.append(RadarDetection(range_m=r, azimuth_rad=phi, range_rate_mps=rate))
        steering_rad = math.atan(CAR.wheelbase_m / radius_m)
        host = HostState(s_m=radius_m * turned, speed_mps=speed_mps, steering_rad=steering_rad)
        tracker.update([scan(now, *points, mounting=place)], host, road, now)
    assert tracker.counters["initiated"] > 1
    assert tracker.counters["unfollowed"] == 0
    assert not recwarn.list


NOTHING: dict[str, Callable[[Scan], Scan]] = {
    "is not finite": lambda s: replace(s, radar=(replace(s.radar[0], azimuth_rad=math.nan),)),
    "has a negative range": lambda s: replace(s, radar=(replace(s.radar[0], range_m=-5.0),)),
    "is beyond 300 m, 100 m/s or half a turn": lambda s: replace(s, radar=(replace(s.radar[0], range_m=7000.0),)),
    "is of a time that is still to come": lambda s: replace(s, t_s=s.t_s + 0.5),
    "is older than this sensor's last": lambda s: replace(s, t_s=s.t_s - 3.0),
}


@pytest.mark.parametrize("why", NOTHING)
def test_where_nothing_can_be_taken_of_a_sensor_that_is_said(why: str) -> None:
    tracker = Tracker()

    def update(k: int, wrong: bool) -> None:
        car = RadarDetection(range_m=50.0, azimuth_rad=0.0, range_rate_mps=0.0)
        told = scan(CYCLE_S * k, car)
        tracker.update([NOTHING[why](told) if wrong else told], HostState(s_m=2.0 * k, speed_mps=20.0), STRAIGHT, CYCLE_S * k)

    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for k in range(33):  # never so many in a row
            update(k, wrong=k % SCANS > 0)
        for k in range(33, 33 + SCANS - 1):
            update(k, wrong=True)
    with pytest.warns(MeasurementWarning, match=rf"nothing could be taken of {SCANS} scans in a row.*{why}"):
        update(33 + SCANS - 1, wrong=True)
    assert not tracker.coverage(CYCLE_S * (33 + SCANS - 1)).front


def test_the_last_scan_said_again_and_again_is_no_fault(recwarn: pytest.WarningsRecorder) -> None:
    """A loop of 100 Hz that passes on what a radar of 10 Hz said last."""
    tracker = Tracker()
    for k in range(60):
        now, t_s = 0.01 * k, 0.1 * (k // 10)
        car = RadarDetection(range_m=50.0, azimuth_rad=0.0, range_rate_mps=0.0)
        tracker.update([scan(t_s, car)], HostState(s_m=20.0 * now, speed_mps=20.0), STRAIGHT, now)
        assert tracker.coverage(now).front
    assert not recwarn.list


@pytest.mark.parametrize(("sector", "yaw_rad", "azimuth_rad"), [("front", math.pi, 0.1), ("rear", 0.0, -0.1), ("rear", 0.3, 0.2)])
def test_a_sensor_that_looks_to_the_other_side_covers_nothing(sector: str, yaw_rad: float, azimuth_rad: float) -> None:
    tracker, car = Tracker(), RadarDetection(range_m=50.0, azimuth_rad=azimuth_rad, range_rate_mps=0.0)
    told = Scan(sensor="r", sector=Sector(sector), t_s=0.0, mounting=Mounting(yaw_rad=yaw_rad), radar=(car,))
    tracker.update([replace(told, radar=())], HostState(speed_mps=20.0), STRAIGHT, 0.0)
    assert tracker.coverage(0.0).sees(Sector(sector))
    with pytest.warns(MeasurementWarning, match="every return comes from the other side of the car"):
        tracker.update([replace(told, t_s=0.1)], HostState(s_m=2.0, speed_mps=20.0), STRAIGHT, 0.1)
    for k in range(2, 6):
        tracker.update([replace(told, t_s=0.1 * k)], HostState(s_m=2.0 * k, speed_mps=20.0), STRAIGHT, 0.1 * k)
    assert not tracker.tracks(0.5)
    assert not tracker.coverage(0.5).sees(Sector(sector))


@pytest.mark.parametrize(
    ("sector", "yaw_rad", "azimuths_rad"),
    [
        ("front", 0.8, (1.3,)),  # a corner radar, at its edge
        ("rear", 0.0, (3.0, -3.1)),  # angles against the car
        ("rear", -math.pi, (0.0, 3.0)),
        ("front", 1.5, (1.3,)),  # one that looks aside
        ("left", -1.5, (0.0,)),
        ("front", math.pi, ()),
        ("front", math.pi, (4.0,)),
    ],
)
def test_any_return_that_may_be_of_the_sector_is_enough(sector: str, yaw_rad: float, azimuths_rad: tuple[float, ...]) -> None:
    tracker = Tracker()
    points = [RadarDetection(range_m=50.0, azimuth_rad=azimuth, range_rate_mps=0.0) for azimuth in azimuths_rad]
    told = Scan(sensor="r", sector=Sector(sector), t_s=0.0, mounting=Mounting(yaw_rad=yaw_rad), radar=tuple(points))
    tracker.update([told], HostState(speed_mps=20.0), STRAIGHT, 0.0)
    assert tracker.counters["elsewhere"] == 0
    assert tracker.counters["scans"] == 1


@pytest.mark.parametrize("origin_s", [0.0, 1.7e9])
def test_a_scan_a_second_is_enough_whatever_the_clock_rounds_off(origin_s: float, recwarn: pytest.WarningsRecorder) -> None:
    tracker = Tracker()
    for k in range(40):
        now, car = origin_s + 0.1 + 1.0 * k, RadarDetection(range_m=50.0, azimuth_rad=0.0, range_rate_mps=0.0)
        now += (k % 2) * 2.4e-7
        tracker.update([scan(now, car, period_s=1.0)], HostState(s_m=20.0 * k, speed_mps=20.0), STRAIGHT, now)
        assert tracker.coverage(now).front
        assert tracker.counters["clock_ahead"] == 0
        assert len(tracker.tracks(now)) == (k > 1)
    assert not recwarn.list
