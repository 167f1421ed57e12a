"""The paper's eq 1-9: literal as printed, corrected as physics has it."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from mcdas_opt.dynamics.radar import (
    LIGHT_MPS,
    closing_speed,
    distance_literal,
    doppler_shift,
    position,
    position_covariance,
    position_literal,
    range_from_delay,
    sensor_velocity,
    target_speed,
    target_speed_literal,
    velocity,
    velocity_literal,
)

ESR_HZ = 76.5e9
KMH = 1.0 / 3.6
angles = st.floats(-math.pi, math.pi)


def test_a_microsecond_is_150_metres() -> None:
    assert range_from_delay(1e-6) == pytest.approx(149.896229)
    assert range_from_delay(0.1, wave_speed=343.0) == pytest.approx(17.15)  # "speed of light/sound"


@settings(deadline=None)
@given(closing=st.floats(-80.0, 80.0))
def test_a_positive_shift_is_an_approach(closing: float) -> None:
    """To first order an echo from a mirror that comes nearer by v is raised by the factor (c + v) / (c - v): eq 5 gives v back."""
    received = ESR_HZ * (LIGHT_MPS + closing) / (LIGHT_MPS - closing)
    shift = doppler_shift(received, ESR_HZ)
    assert (shift > 0.0) == (closing > 0.0) or abs(closing) < 1e-4
    assert closing_speed(shift, ESR_HZ) == pytest.approx(closing, abs=1e-3)


@settings(deadline=None)
@given(r=st.floats(0.0, 200.0), theta=angles)
def test_literal_polar_coordinates_are_the_mirror_image_of_the_iso_ones(r: float, theta: float) -> None:
    x, y = position_literal(r, theta, math)  # right positive
    assert distance_literal(x, y, 0.0, 0.0, math) == pytest.approx(r)
    assert position(r, -theta, 0.0, 0.0, 0.0, math) == pytest.approx((x, -y), abs=1e-9)


@settings(deadline=None)
@given(r=st.floats(0.1, 200.0), azimuth=angles, x=st.floats(-5, 5), y=st.floats(-5, 5), yaw=angles)
def test_a_point_lies_at_its_range_from_a_sensor_anywhere(r: float, azimuth: float, x: float, y: float, yaw: float) -> None:
    px, py = position(r, azimuth, x, y, yaw, math)
    assert distance_literal(px, py, x, y, math) == pytest.approx(r)
    assert math.remainder(math.atan2(py - y, px - x) - yaw - azimuth, 2 * math.pi) == pytest.approx(0.0, abs=1e-9)


def test_eq_7_is_right_behind_and_reversed_ahead() -> None:
    """Host 40 km/h; the rear car at 60 closes by 20, a front car at 20 closes by 20 as well."""
    host, closing = 40.0 * KMH, 20.0 * KMH
    assert target_speed_literal(host, closing) == pytest.approx(60.0 * KMH)  # the rear one's: right
    assert target_speed(host, closing, math.pi, 0.0, math) == pytest.approx(60.0 * KMH)
    assert target_speed(host, closing, 0.0, 0.0, math) == pytest.approx(20.0 * KMH)  # the front one's; eq 7 says 60


@settings(deadline=None)
@given(
    bearing=angles,
    direction=st.floats(-0.5, 0.5),
    speed=st.floats(0.0, 50.0),
    host=st.floats(0.0, 50.0),
)
def test_the_corrected_speed_is_the_true_one_wherever_the_target_is(bearing: float, direction: float, speed: float, host: float) -> None:
    assume(abs(math.cos(bearing - direction)) > 0.05)
    vx, vy = velocity(speed, direction, math)
    closing = -((vx - host) * math.cos(bearing) + vy * math.sin(bearing))
    assert target_speed(host, closing, bearing, direction, math) == pytest.approx(speed, abs=1e-6)


def test_eq_8_and_9_count_the_angle_from_y() -> None:
    """A target straight ahead (theta = 0 in eq 2-3), driving straight on at 10 m/s: eq 8-9 send it sideways."""
    assert position_literal(30.0, 0.0, math) == (30.0, 0.0)
    assert velocity_literal(10.0, 0.0, math) == pytest.approx((0.0, 10.0))
    assert velocity(10.0, 0.0, math) == pytest.approx((10.0, 0.0))


@settings(deadline=None)
@given(r=st.floats(1.0, 174.0), bearing=angles)
def test_covariance_by_jacobian(r: float, bearing: float) -> None:
    sd_r, sd_b = 0.25, math.radians(0.5)
    xx, xy, yy = position_covariance(r, bearing, sd_r, sd_b, math)
    J = np.array([[math.cos(bearing), -r * math.sin(bearing)], [math.sin(bearing), r * math.cos(bearing)]])
    np.testing.assert_allclose([[xx, xy], [xy, yy]], J @ np.diag([sd_r**2, sd_b**2]) @ J.T, atol=1e-12)


def test_covariance_is_that_of_a_sample_and_the_bias_is_what_the_docstring_says() -> None:
    random = np.random.default_rng(1)
    r, bearing, sd_b = 174.0, 0.3, math.radians(0.5)
    x, y = position(r + 0.25 * random.standard_normal(400_000), bearing + sd_b * random.standard_normal(400_000), 0, 0, 0, np)
    xx, xy, yy = position_covariance(r, bearing, 0.25, sd_b, math)
    np.testing.assert_allclose(np.cov(x, y), [[xx, xy], [xy, yy]], rtol=0.02)
    along = x.mean() * math.cos(bearing) + y.mean() * math.sin(bearing)
    assert r - along == pytest.approx(0.5 * r * sd_b**2, abs=0.002)


@settings(deadline=None)
@given(speed=st.floats(-10, 40), yaw_rate=st.floats(-1, 1), yaw=angles, ahead=st.floats(-2, 4), left=st.floats(-1, 1))
def test_a_sensor_moves_with_its_car(speed: float, yaw_rate: float, yaw: float, ahead: float, left: float) -> None:
    """Against the finite difference of the point's place."""

    def place(h: float) -> np.ndarray:
        turned = yaw + yaw_rate * h
        axle = h * speed * np.array([math.cos(yaw + 0.5 * yaw_rate * h), math.sin(yaw + 0.5 * yaw_rate * h)])
        return axle + np.array(position(1.0, 0.0, 0.0, 0.0, turned, math)) * ahead + left * np.array([-math.sin(turned), math.cos(turned)])

    h = 1e-5
    np.testing.assert_allclose(sensor_velocity(speed, yaw_rate, yaw, ahead, left, math), (place(h) - place(-h)) / (2 * h), atol=1e-6)
