"""The family's motions are the bicycle's; what it calls possible, the judge lets pass; nothing slips by its separations."""

from __future__ import annotations

from dataclasses import replace
from itertools import product
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.prediction import CruisingBody, Prediction
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.vehicle import GRAVITY_MPS2, Vehicle
from mcdas_opt.dynamics.bicycle import road_bicycle
from mcdas_opt.dynamics.integrator import rk4
from mcdas_opt.geometry.frenet import FrenetFrame
from mcdas_opt.geometry.rectangle import corners, separation
from mcdas_opt.manoeuvres.clearance import NEAR_M, clearance
from mcdas_opt.manoeuvres.driven import driven
from mcdas_opt.manoeuvres.family import Demand, roll_out
from mcdas_opt.manoeuvres.lane_change_profiles import LaneChangeProfiles
from mcdas_opt.manoeuvres.phases import Phases, speed_history
from mcdas_opt.verification.judge import judge

SEDAN = Vehicle()
BENDS = (Road(lanes_left=2, lanes_right=2), Road(lanes_left=2, lanes_right=2, curvature=((0.0, 0.004), (60.0, -0.006), (120.0, 0.0))))


def even(step: float, duration: float = 4.0) -> np.ndarray:
    return np.round(np.arange(round(duration / step) + 1) * step, 9)


def phases(*rows: tuple[float, float, float]) -> Phases:
    first, switch, then = np.array(rows, dtype=np.float64).T
    return Phases(first_mps2=first, switch_s=switch, then_mps2=then)


def lane_changes(*rows: tuple[float, float, float, float]) -> LaneChangeProfiles:
    target, lateral, delay, b = np.array(rows, dtype=np.float64).T
    return LaneChangeProfiles(target_d_m=target, lateral_mps2=lateral, delay_s=delay, b=b)


SPEEDS = phases((0.0, 0.0, 0.0), (-3.0, 9.0, 0.0), (2.5, 1.0, 0.0), (-6.0, 0.8, 1.0), (2.0, 1.5, -4.0))
SIDES = lane_changes(*product((3.7, -3.7, 0.0), (2.0, 5.0), (0.0, 0.6), (50.0, 12.0)))
hosts = st.builds(
    HostState,
    d_m=st.floats(-0.5, 0.5),
    heading_rad=st.floats(-0.06, 0.06),
    speed_mps=st.floats(6.0, 33.0),
    acceleration_mps2=st.floats(-2.0, 2.0),
    steering_rad=st.floats(-0.01, 0.01),
)


@pytest.mark.parametrize("road", BENDS, ids=("straight", "bends"))
@settings(max_examples=6, deadline=None)
@given(host=hosts)
def test_ways_are_what_the_bicycle_does_with_that_steering(road: Road, host: HostState) -> None:
    """Curvature and speed of the family, fed to the road's bicycle, lead to the family's own places."""
    times = even(0.02, 3.0)
    rolled = roll_out(SPEEDS[:, None], SIDES, times, host, SEDAN, road)
    shape = rolled.paths.s_m.shape
    v, a = (np.broadcast_to(q, shape) for q in (rolled.speeds.speed_mps, rolled.speeds.acceleration_mps2))
    x = [np.full(shape[:-1], value) for value in host.to_vector()]
    worst = 0.0
    for k in range(times.size - 1):
        h = float(times[k + 1] - times[k])
        u = ((a[..., k + 1] - a[..., k]) / h, (rolled.steering_rad[..., k + 1] - rolled.steering_rad[..., k]) / h)

        def right_side(state: Any, u: Any = u) -> list[Any]:
            return road_bicycle(state, u, road.curvature_at(state[0]), SEDAN.wheelbase_m, SEDAN.centre_m, np)

        x = rk4(right_side, x, h)
        x[3], x[4] = v[..., k + 1], a[..., k + 1]
        sound = rolled.possible
        off = np.hypot(x[0] - rolled.paths.s_m[..., k + 1], x[1] - rolled.paths.d_m[..., k + 1])
        worst = max(worst, float(off[sound].max(initial=0.0)))
        assert np.abs(x[2] - rolled.paths.heading_rad[..., k + 1])[sound].max(initial=0.0) < 0.01
    assert worst < (0.03 if road.is_straight else 0.08)


@settings(max_examples=6, deadline=None)
@given(host=hosts, friction=st.sampled_from([0.9, 0.5, 0.25]), bend=st.booleans())
def test_possible_members_pass_the_judge(host: HostState, friction: float, bend: bool) -> None:
    road = replace(BENDS[bend], friction=friction)
    host = replace(host, heading_rad=0.2 * host.heading_rad, acceleration_mps2=0.5 * host.acceleration_mps2)
    host = replace(host, steering_rad=0.05 * host.steering_rad + float(np.arctan(SEDAN.wheelbase_m * road.curvature_at(0.0))))
    times = even(0.05)
    grid = [(p, q) for p in range(5) for q in range(0, 24, 3)]
    p, q = np.array(grid).T
    rolled = roll_out(SPEEDS[p], SIDES[q], times, host, SEDAN, road, Demand(friction=0.96))
    for one, possible, on_road in zip(driven(rolled, host, SEDAN, road), rolled.possible, rolled.on_road, strict=True):
        if possible and on_road:
            verdict = judge(one, host, SEDAN, road, Prediction(name="nobody"))
            assert verdict.passed, verdict.reason


@settings(max_examples=40, deadline=None)
@given(
    v=st.floats(0.0, 49.0),
    a=st.floats(-8.0, 3.0),
    first=st.floats(-8.0, 3.0),
    switch=st.floats(0.0, 4.0),
    then=st.floats(-8.0, 3.0),
    h=st.sampled_from([0.1, 0.05]),
)
def test_speed_keeps_jerk_and_never_reverses(v: float, a: float, first: float, switch: float, then: float, h: float) -> None:
    times = even(h, 6.0)
    history = speed_history(phases((first, switch, then)), times, v, a, SEDAN)
    speed, pull, travelled = history.speed_mps[0], history.acceleration_mps2[0], history.travelled_m[0]
    moving = speed[1:] > 0.0
    jerk = np.diff(pull)[moving] / h
    assert np.all(jerk <= SEDAN.jerk_max_mps3 + 1e-6)
    assert np.all(jerk >= SEDAN.jerk_min_mps3 - 1e-6)
    assert np.all(speed >= 0.0)
    assert speed.max() <= max(0.99 * SEDAN.speed_max_mps, v + max(a, 0.0) * 0.2)
    assert np.all(np.diff(travelled) >= -1e-12)
    assert np.all(np.abs(np.diff(travelled) - h * 0.5 * (speed[1:] + speed[:-1])) < 0.5 * h * max(8.0 * h, 1e-9) + 1e-9)
    assert pull[0] == pytest.approx(a) or speed[0] == 0.0


def test_mirrored_lane_changes_are_mirrored_paths() -> None:
    host = HostState(d_m=0.2, heading_rad=0.02, speed_mps=15.0, steering_rad=0.004)
    other = replace(host, d_m=-0.2, heading_rad=-0.02, steering_rad=-0.004)
    across = replace(SIDES, target_d_m=-SIDES.target_d_m)
    for road, mirror in ((BENDS[0], BENDS[0]), (BENDS[1], replace(BENDS[1], curvature=tuple((s, -k) for s, k in BENDS[1].curvature)))):
        one = roll_out(SPEEDS[:, None], SIDES, even(0.1), host, SEDAN, road)
        two = roll_out(SPEEDS[:, None], across, even(0.1), other, SEDAN, mirror)
        assert np.allclose(one.paths.d_m, -two.paths.d_m, atol=1e-9)
        assert np.allclose(one.paths.s_m, two.paths.s_m, atol=1e-9)
        assert np.array_equal(one.possible, two.possible)


def test_peak_of_lateral_acceleration_is_the_one_asked_for() -> None:
    """At constant speed, the paper's sigmoid, repaired: v^2 kappa peaks at the bound at every speed."""
    for speed in (8.0, 15.0, 30.0):
        profiles = lane_changes((3.7, 3.0, 0.0, 50.0), (-3.7, 5.0, 0.5, 50.0), (3.7, 1.0, 0.0, 50.0))
        rolled = roll_out(phases((0.0, 0.0, 0.0)), profiles, even(0.02, 6.0), HostState(speed_mps=speed), SEDAN, BENDS[0])
        peak = np.abs(rolled.lateral_mps2).max(-1)
        assert np.all(np.abs(peak / profiles.lateral_mps2 - 1.0) < 0.12)
        assert np.allclose(rolled.paths.d_m[:2, -1], profiles.target_d_m[:2], atol=0.05)


def random_body(rng: np.random.Generator) -> CruisingBody:
    return CruisingBody(
        id="car",
        length_m=rng.uniform(2.0, 12.0),
        width_m=rng.uniform(1.0, 2.6),
        s_m=rng.uniform(-30.0, 60.0),
        d_m=rng.uniform(-5.0, 5.0),
        speed_s_mps=rng.uniform(-5.0, 40.0),
        speed_d_mps=rng.uniform(-2.0, 2.0),
        covariance=np.zeros((4, 4)),
        lateral_swell=rng.choice([0.0, 20.0]),
    )


@pytest.mark.parametrize("seed", range(20))
@pytest.mark.parametrize("road", BENDS, ids=("straight", "bends"))
def test_separation_is_a_lower_bound(road: Road, seed: int) -> None:
    """At the samples it is never above the rectangles' own separation in the plane."""
    rng = np.random.default_rng(seed)
    times, body = even(0.1), random_body(rng)
    host = HostState(d_m=rng.uniform(-0.5, 0.5), heading_rad=rng.uniform(-0.05, 0.05), speed_mps=rng.uniform(6.0, 33.0))
    rolled = roll_out(SPEEDS[:, None], SIDES, times, host, SEDAN, road)
    at_samples = clearance(rolled.paths, times, [body], SEDAN, road).separation_m
    frame = FrenetFrame(road=road)

    def truth(s: np.ndarray, d: np.ndarray, psi: np.ndarray, t: np.ndarray) -> np.ndarray:
        motion = body.at(t)
        here = corners(*frame.to_plane(s, d, psi), SEDAN.length_m, SEDAN.width_m)
        there = corners(*frame.to_plane(motion.s_m, motion.d_m, motion.heading_rad), body.length_m, body.width_m)
        return separation(here, there)

    paths = rolled.paths
    assert np.all(at_samples <= np.minimum(truth(paths.s_m, paths.d_m, paths.heading_rad, times), NEAR_M) + 1e-9)


def test_grip_bounds_what_is_possible() -> None:
    rolled = roll_out(SPEEDS[:, None], SIDES, even(0.1), HostState(speed_mps=20.0), SEDAN, replace(BENDS[0], friction=0.3))
    a = np.broadcast_to(rolled.speeds.acceleration_mps2, rolled.lateral_mps2.shape)
    asked = np.hypot(a, rolled.lateral_mps2).max(-1)
    assert rolled.possible.any()
    assert not rolled.possible.all()
    assert np.all(asked[rolled.possible] <= 0.3 * GRAVITY_MPS2)
