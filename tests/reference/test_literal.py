"""The published path: Table 3 to its last digit, and the faults that the correction mends."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mcdas_opt.domain.vocabulary import Side
from mcdas_opt.dynamics.integrator import rk4
from mcdas_opt.errors import ParameterError
from mcdas_opt.reference.literal import (
    commanded_speed,
    literal_path,
    offset,
    velocity_literal,
    y_left,
    y_parking,
    y_right,
)
from mcdas_opt.reference.steering_demand import peak_lateral_acceleration, starting_heading_jump

G = 9.80665


@pytest.mark.parametrize(("speed_kmh", "published_g"), [(40, 0.66), (60, 1.48), (80, 2.64), (100, 4.12)])
@pytest.mark.parametrize("side", [Side.LEFT, Side.RIGHT])
def test_peak_lateral_acceleration_of_the_literal_path(speed_kmh: float, published_g: float, side: Side) -> None:
    assert peak_lateral_acceleration(literal_path(side, 0.0), speed_kmh / 3.6) / G == pytest.approx(published_g, abs=0.005)


def test_heading_jump_at_the_start() -> None:
    assert math.degrees(starting_heading_jump(literal_path(Side.LEFT, 0.0))) == pytest.approx(1.63, abs=0.005)


@given(st.floats(-2.5, 2.5), st.floats(0, 40))
def test_road_frame_is_the_papers_frame_with_y_to_the_left(off_left: float, x: float) -> None:
    off_paper = offset(-off_left, 0.0)
    assert literal_path(Side.LEFT, off_left).d(x) == pytest.approx(-float(y_left(x, off_paper)), abs=1e-12)
    assert literal_path(Side.RIGHT, off_left).d(x) == pytest.approx(-float(y_right(x, off_paper)), abs=1e-12)
    assert literal_path(Side.LEFT, off_left).amplitude_m == pytest.approx(3.7 + off_left)
    assert literal_path(Side.RIGHT, off_left).amplitude_m == pytest.approx(-(3.7 - off_left))


@given(st.floats(-3, 3), st.floats(0, 40))
def test_left_and_right_mirror(off: float, x: float) -> None:
    assert y_left(x, -off) == -y_right(x, off)
    left, right = literal_path(Side.LEFT, off), literal_path(Side.RIGHT, -off)
    for what in ("d", "slope", "curvature"):
        assert getattr(left, what)(x) == -getattr(right, what)(x)


@given(st.floats(-2.5, 2.5))
def test_slope_and_curvature_are_derivatives(off: float) -> None:
    path, s, h = literal_path(Side.LEFT, off, start_s_m=3.0), np.linspace(3.1, 40, 200), 1e-4
    np.testing.assert_allclose(path.slope(s), (path.d(s + h) - path.d(s - h)) / (2 * h), atol=1e-7)
    bend = (path.slope(s + h) - path.slope(s - h)) / (2 * h)
    np.testing.assert_allclose(path.curvature(s), bend / (1 + path.slope(s) ** 2) ** 1.5, atol=1e-7)


def test_eq_24_read_with_the_hosts_speed_commands_360_kmh() -> None:
    assert commanded_speed(60.0, 40.0, 240.0, duty=1 / 6) == pytest.approx(360.0)
    assert commanded_speed(60.0, 240.0, 240.0, duty=1 / 6) == pytest.approx(60.0)


def test_eq_24_literal_is_undefined_at_the_start_and_drives_backwards_to_the_left() -> None:
    with pytest.raises(ParameterError):
        velocity_literal(0.0, y_right(0.0, 0.0), 60.0)
    x = np.linspace(1.0, 20.0, 20)
    assert np.all(velocity_literal(x, y_left(x, 0.0), 60.0).vx < 0.0)


def test_integrating_eq_24_gives_a_ray_and_not_the_path() -> None:
    path = literal_path(Side.LEFT, 0.0)

    def literal(z: list[float]) -> list[float]:
        v = velocity_literal(z[0], z[1], 10.0)
        return [float(v.vx), float(v.vy)]

    x0 = 4.0
    ray = [x0, float(path.d(x0))]
    for _ in range(200):
        ray = rk4(literal, ray, 0.01)
    assert ray[1] / ray[0] == pytest.approx(float(path.d(x0)) / x0, rel=1e-9)
    assert abs(ray[1] - float(path.d(ray[0]))) > 0.5


def test_parking_path_starts_at_zero_and_ends_short_by_its_own_start_value() -> None:
    assert y_parking(0.0) == 0.0
    assert y_parking(-200.0, b=50.0) + 3.7 == pytest.approx(3.7 / 51, abs=1e-12)


def test_no_side_is_no_path() -> None:
    with pytest.raises(ParameterError):
        literal_path(Side.NONE, 0.0)
