"""The speed law keeps its limits whatever is asked of it, arrives, and does not overshoot."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mcdas_opt.actuation.speed_law import SpeedLimits, next_acceleration
from mcdas_opt.domain.rules import Array
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.errors import ParameterError

LIMITS = st.builds(
    SpeedLimits,
    acceleration_min_mps2=st.floats(-10, -1),
    acceleration_max_mps2=st.floats(1, 6),
    jerk_min_mps3=st.floats(-60, -2),
    jerk_max_mps3=st.floats(2, 60),
)


def speed_profile(speed: float, acceleration: float, wanted: float, step_s: float, steps: int, limits: SpeedLimits) -> tuple[Array, Array]:
    """(steps + 1,) speeds and accelerations on the way to a constant wanted speed."""
    v, a = np.empty(steps + 1), np.empty(steps + 1)
    v[0], a[0] = speed, acceleration
    for k in range(steps):
        a[k + 1] = next_acceleration(a[k], wanted - v[k], step_s, limits)
        v[k + 1] = v[k] + 0.5 * step_s * (a[k] + a[k + 1])
    return v, a


@given(LIMITS, st.integers(0, 2**32 - 1), st.sampled_from([0.01, 0.02, 0.05, 0.1, 0.5]))
@settings(max_examples=40, deadline=None)
def test_limits_hold_at_every_sample_of_random_demands(limits: SpeedLimits, seed: int, h: float) -> None:
    wanted = np.repeat(np.random.default_rng(seed).uniform(0, 50, 25), 8)
    v, a = 20.0, 0.0
    for target in wanted:
        following = float(next_acceleration(a, target - v, h, limits))
        jerk = (following - a) / h
        assert limits.acceleration_min_mps2 <= following <= limits.acceleration_max_mps2
        assert limits.jerk_min_mps3 * (1 + 1e-9) <= jerk <= limits.jerk_max_mps3 * (1 + 1e-9)
        v, a = v + 0.5 * h * (a + following), following


def profile(start: float, wanted: float, h: float, limits: SpeedLimits, seconds: float) -> tuple[np.ndarray, np.ndarray]:
    """Speeds and accelerations on the way from steady `start` to `wanted`."""
    rows = [(start, 0.0)]
    for _ in range(round(seconds / h)):
        v, a = rows[-1]
        following = float(next_acceleration(a, wanted - v, h, limits))
        rows.append((v + 0.5 * h * (a + following), following))
    v, a = np.array(rows).T
    return v, a


@given(LIMITS, st.floats(0, 40), st.floats(0, 40), st.sampled_from([0.02, 0.05, 0.1]))
@settings(max_examples=25, deadline=None)
def test_a_step_arrives_without_overshoot(limits: SpeedLimits, start: float, wanted: float, h: float) -> None:
    v, a = profile(start, wanted, h, limits, 50.0)
    assert v[-1] == pytest.approx(wanted, abs=1e-3)
    assert abs(a[-1]) < 1e-2
    assert v.max() <= max(start, wanted) + 1e-9
    assert v.min() >= min(start, wanted) - 1e-9


def test_forty_to_sixty_takes_little_longer_than_the_acceleration_alone() -> None:
    vehicle = Vehicle()
    v, a = profile(40 / 3.6, 60 / 3.6, 0.02, SpeedLimits.of(vehicle), 5.0)
    arrived = 0.02 * int(np.argmax(v > 60 / 3.6 - 0.05))
    assert a.max() == pytest.approx(3.0)
    assert 20 / 3.6 / 3.0 < arrived < 20 / 3.6 / 3.0 + 0.4


@given(LIMITS, st.floats(-5, 5), st.floats(-30, 30))
def test_mirrored_limits_mirror_the_law(limits: SpeedLimits, a: float, error: float) -> None:
    mirrored = SpeedLimits(
        acceleration_min_mps2=-limits.acceleration_max_mps2,
        acceleration_max_mps2=-limits.acceleration_min_mps2,
        jerk_min_mps3=-limits.jerk_max_mps3,
        jerk_max_mps3=-limits.jerk_min_mps3,
    )
    assert next_acceleration(-a, -error, 0.02, mirrored) == pytest.approx(-next_acceleration(a, error, 0.02, limits), abs=1e-12)


def test_many_cars_at_once_as_one_by_one() -> None:
    limits = SpeedLimits.of(Vehicle())
    r = np.random.default_rng(0)
    a, error = r.uniform(-8, 3, 50), r.uniform(-20, 20, 50)
    one_by_one = [float(next_acceleration(x, y, 0.02, limits)) for x, y in zip(a, error, strict=True)]
    np.testing.assert_array_equal(next_acceleration(a, error, 0.02, limits), one_by_one)


def test_limits_of_the_wrong_sign_are_refused() -> None:
    with pytest.raises(ParameterError, match="jerk_min_mps3"):
        SpeedLimits(acceleration_min_mps2=-8, acceleration_max_mps2=3, jerk_min_mps3=4, jerk_max_mps3=4)
