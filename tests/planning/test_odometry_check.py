"""The host's place moves as its speed, its heading and the clock say, or it is said that it does not."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.road import Road
from mcdas_opt.planning.measurement.odometry_check import OdometryCheck
from mcdas_opt.planning.measurement.standing_clock import CYCLES, StandingClock

CYCLE_S = 0.1


@given(
    speed_mps=st.floats(0.0, 60.0),
    acceleration_mps2=st.floats(-8.0, 8.0),
    kappa=st.floats(-0.02, 0.02),
    d_m=st.floats(-4.0, 4.0),
    cycle_s=st.floats(0.02, 0.5),
    seed=st.integers(0, 999),
)
def test_a_car_that_drives_as_it_says_is_believed(
    speed_mps: float, acceleration_mps2: float, kappa: float, d_m: float, cycle_s: float, seed: int
) -> None:
    """In a bend, braking or not, with 0.5 m of noise in its place, 2 % in its speed and 2 ms in the clock."""
    check, random, road = OdometryCheck(), np.random.default_rng(seed), Road(curvature=((0.0, kappa),))
    s_m, v, now = 0.0, speed_mps, 1.7e9
    for _ in range(60):
        noise = random.normal(0.0, (0.5, 0.02 * v, 0.002))
        host = HostState(s_m=s_m + noise[0], d_m=d_m, speed_mps=max(v + noise[1], 0.0))
        assert not check.fault(host, road, now + noise[2])
        after = min(max(v + acceleration_mps2 * cycle_s, 0.0), 60.0)
        s_m, v, now = s_m + 0.5 * (v + after) * cycle_s / (1.0 - d_m * kappa), after, now + cycle_s


@pytest.mark.parametrize(
    ("place", "speed", "clock"),
    [(0.0, 1.0, 1.0), (1.0, 3.6, 1.0), (1.0, 2.237, 1.0), (1.0, 1.0, 2.0), (1.0, 1.0, 0.5), (1.0, 1.0, -0.4), (-1.0, 1.0, 1.0)],
)
@pytest.mark.parametrize("speed_mps", [8.0, 20.0, 33.0])
def test_wrong_places_speeds_and_clocks_are_seen_within_three_seconds(place: float, speed: float, clock: float, speed_mps: float) -> None:
    check = OdometryCheck()
    said = [
        check.fault(HostState(s_m=place * speed_mps * CYCLE_S * k, speed_mps=speed * speed_mps), Road(), clock * CYCLE_S * k)
        for k in range(60)
    ]
    first = next(k for k, why in enumerate(said) if why)
    assert first * CYCLE_S <= 3.0
    assert all(said[first:])
    assert "the host's place moved by" in said[first]


def test_a_place_that_is_counted_from_elsewhere_is_doubted_once() -> None:
    check = OdometryCheck()
    said = [check.fault(HostState(s_m=2.0 * k - (500.0 if k >= 30 else 0.0), speed_mps=20.0), Road(), CYCLE_S * k) for k in range(60)]
    assert [k for k, why in enumerate(said) if why] == [30]
    assert "moved by -498 m along the road within 0.1 s" in said[30]


def test_a_pause_and_a_clock_set_back_begin_anew() -> None:
    for jump_s in (5.0, -3600.0):
        check = OdometryCheck()
        times = [CYCLE_S * k + (jump_s if k >= 30 else 0.0) for k in range(60)]
        assert not any(check.fault(HostState(s_m=2.0 * k, speed_mps=20.0), Road(), now) for k, now in enumerate(times))


@given(jitter=st.lists(st.floats(-0.05, 0.05), min_size=60, max_size=60), begun_s=st.sampled_from([0.0, 1.7e9]))
def test_a_clock_that_goes_on_may_jitter(jitter: list[float], begun_s: float) -> None:
    clock = StandingClock()
    assert not any(clock.stands(begun_s + CYCLE_S * k + off) for k, off in enumerate(jitter))


@pytest.mark.parametrize("sd_s", [0.0, 1e-4, 0.004, 0.01])
def test_a_clock_that_runs_to_and_fro_stands(sd_s: float) -> None:
    random, clock = np.random.default_rng(3), StandingClock()
    stood = [clock.stands(100.0 + off) for off in random.normal(0.0, sd_s, 2000)]
    assert np.mean(stood[CYCLES - 1 :]) > 0.95


def test_two_sensors_in_turn_are_no_clock_that_stands() -> None:
    """Each call at its sensor's own time, one 20 ms behind the other."""
    clock = StandingClock()
    assert not any(clock.stands(0.05 * (k // 2) - 0.02 * (k % 2)) for k in range(100))
    assert math.isclose(clock._shown[-1], 2.43)
