"""A radar whose ranges change otherwise than its range rates say is not believed."""

from __future__ import annotations

import math

import numpy as np
import pytest

from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.measurement import RadarDetection, Scan
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.vocabulary import Sector
from mcdas_opt.errors import MeasurementWarning
from mcdas_opt.tracking.range_rates import RangeRates
from mcdas_opt.tracking.tracker import Tracker

SD_M = 0.25


def found(
    off_mps: float, *, cars: int, seed: int, period_s: float = 0.1, seconds: float = 4.0, rate_sd_mps: float = 0.1, aside_rad: float = 0.0
) -> list[float]:
    """What is said of so many cars in each scan, at range rates from -10 to 10 m/s, all of them too high by `off_mps`."""
    random, rates = np.random.default_rng(seed), RangeRates()
    begins_m, rate_mps = random.uniform(700.0, 900.0, cars), random.uniform(-10.0, 10.0, cars)
    said = []
    for k in range(round(seconds / period_s)):
        ranges_m = begins_m + rate_mps * k * period_s + random.normal(0.0, SD_M, cars)
        points = {
            RadarDetection(range_m=r, azimuth_rad=aside_rad, range_rate_mps=v + off_mps, range_rate_sd_mps=rate_sd_mps): j
            for j, (r, v) in enumerate(zip(ranges_m.tolist(), rate_mps.tolist(), strict=True))
        }
        said.append(rates.take(points, period_s * k, 0.0))
    return said


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("period_s", [0.04, 0.1, 0.5])
@pytest.mark.parametrize("cars", [1, 5, 30])
def test_rates_that_are_right_are_never_called_wrong(cars: int, period_s: float, seed: int) -> None:
    assert not any(found(0.0, cars=cars, seed=seed, period_s=period_s, seconds=60.0))


@pytest.mark.parametrize("off_mps", [-7.0, -3.0, 3.0, 7.0])
@pytest.mark.parametrize("period_s", [0.04, 0.1, 0.5])
@pytest.mark.parametrize("cars", [1, 5, 30])
def test_how_far_rates_are_off_is_told_within_two_seconds(cars: int, period_s: float, off_mps: float) -> None:
    said = found(off_mps, cars=cars, seed=cars, period_s=period_s, seconds=2.5)
    assert next(mps for mps in said if mps != 0.0) == pytest.approx(off_mps, abs=1.5)


def test_a_rate_that_says_itself_that_it_is_vague_is_not_wrong() -> None:
    assert not any(found(-8.0, cars=5, seed=1, rate_sd_mps=10.0))


def test_who_is_seen_from_the_side_does_not_count() -> None:
    assert not any(found(-8.0, cars=5, seed=1, aside_rad=0.3))


def test_a_reflection_that_jumps_along_a_lorry_makes_no_rate_wrong() -> None:
    rates = RangeRates()
    for k in range(100):
        jump_m = 12.0 if k % 40 >= 20 else 0.0
        assert rates.take({RadarDetection(range_m=60.0 + jump_m, azimuth_rad=0.0, range_rate_mps=0.0): 1}, 0.1 * k, 0.0) == 0.0


def test_noise_stays_noise_where_nothing_was_seen_again() -> None:
    """2.4 m farther than the rates say, within 1.2 s, and then a scan without returns."""
    rates = RangeRates()
    for k in range(13):
        assert rates.take({RadarDetection(range_m=60.0 + 0.2 * k, azimuth_rad=0.0, range_rate_mps=0.0): 1}, 0.1 * k, 0.0) == 0.0
    assert rates.take({}, 1.3, 0.0) == 0.0


def test_range_rates_that_are_not_believed_are_tried_again_after_a_minute() -> None:
    rates = RangeRates()
    assert rates.are_believed(0.0)
    rates.disbelieve(10.0)
    assert [rates.are_believed(t_s) for t_s in (9.0, 10.0, 69.0, 71.0)] == [True, False, False, True]


@pytest.mark.parametrize("off_mps", [-5.0, 3.0, 5.0, 7.0])
def test_in_dense_traffic_cars_are_tracked_on_by_their_places(off_mps: float) -> None:
    """Two rows of cars, close together: what begins beside a body that is seen is no return that nobody follows."""
    tracker, road, random = Tracker(), Road(lanes_left=1, lanes_right=1), np.random.default_rng(3)
    cars = [(15.0 + 9.0 * k, 3.5 * (k % 2), 22.0 + 0.5 * (k % 3)) for k in range(8)]
    host_mps = 25.0

    def scan(now: float) -> Scan:
        points = []
        for s, d, v in cars:
            x = s + (v - host_mps) * now
            r, phi = math.hypot(x, d), math.atan2(d, x)
            rate_mps = (v - host_mps) * x / r + off_mps
            points.append(RadarDetection(range_m=r + float(random.normal(0.0, 0.1)), azimuth_rad=phi, range_rate_mps=rate_mps))
        return Scan(sensor="r", sector=Sector.FRONT, t_s=now, radar=tuple(points), period_s=0.05)

    def cycle(now: float) -> None:
        tracker.update([scan(now)], HostState(s_m=host_mps * now, speed_mps=host_mps), road, now)

    def drive() -> int:
        """Cycles in which the front is not covered."""
        uncovered = 0
        for k in range(80):
            cycle(0.05 * k)
            uncovered += not tracker.coverage(0.05 * k).front
        return uncovered

    with pytest.warns(MeasurementWarning, match=f"its range rates are .* m/s too {'high' if off_mps > 0.0 else 'low'}"):
        assert drive() <= 4
    assert tracker.counters["range_rates"] == 1
    speeds = sorted(track.speed_s_mps for track in tracker.tracks(0.05 * 79) if not track.coasting)
    assert len(speeds) == len(cars)
    assert speeds == pytest.approx(sorted(v for _, _, v in cars), abs=1.5)
