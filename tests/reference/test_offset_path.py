"""Laws of the corrected offset path."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mcdas_opt.errors import ParameterError
from mcdas_opt.reference.offset_path import OffsetPath, corrected
from mcdas_opt.reference.steering_demand import peak_lateral_acceleration, starting_heading_jump

PATHS = st.builds(
    corrected,
    start_s_m=st.floats(-50, 200),
    start_d_m=st.floats(-4, 4),
    target_d_m=st.floats(-8, 8),
    speed_mps=st.floats(0, 45),
    lateral_acceleration_mps2=st.floats(0.5, 8),
    b=st.floats(5, 300),
    bend_m=st.floats(-2, 2),
    bend_s_m=st.floats(-20, 200),
    bend_width_m=st.floats(1, 40),
)


@given(PATHS)
@settings(max_examples=60, deadline=None)
def test_slope_and_curvature_are_the_derivatives_of_d(path: OffsetPath) -> None:
    h = 1e-4 * min(path.length_m, path.bend_width_m)
    start, end = path.start_s_m, path.start_s_m + path.length_m
    pieces = ((start, end), (end, end + 30), (start - 9, start))
    for low, high in pieces:
        s = np.linspace(low + 2 * h, high - 2 * h, 101)
        scale = abs(path.amplitude_m) + abs(path.bend_m) + 0.1
        slope = (path.d(s + h) - path.d(s - h)) / (2 * h)
        bend = (path.slope(s + h) - path.slope(s - h)) / (2 * h)
        np.testing.assert_allclose(path.slope(s), slope, atol=1e-6 * scale / h * 1e-3)
        np.testing.assert_allclose(path.curvature(s), bend / (1 + path.slope(s) ** 2) ** 1.5, atol=1e-6 * scale / h**2 * 1e-3)


@given(PATHS)
@settings(max_examples=60, deadline=None)
def test_ends_are_met_exactly_and_d_is_continuous(path: OffsetPath) -> None:
    before, start, end = path.start_s_m - 5.0, path.start_s_m, path.start_s_m + path.length_m
    assert path.d(before) == path.start_d_m
    assert path.d(start) == pytest.approx(path.start_d_m, abs=1e-12)
    bend = path.bend_m * math.exp(-(((end - path.bend_s_m) / path.bend_width_m) ** 2))
    assert path.d(end) == pytest.approx(path.target_d_m + bend, abs=1e-9)
    assert path.d(np.nextafter(end, np.inf)) == pytest.approx(float(path.d(end)), abs=1e-9)


@given(PATHS, st.integers(0, 10_000))
@settings(max_examples=30, deadline=None)
def test_mirrored_path_is_the_mirror_image(path: OffsetPath, where: int) -> None:
    mirrored = OffsetPath(
        start_s_m=path.start_s_m,
        start_d_m=-path.start_d_m,
        amplitude_m=-path.amplitude_m,
        a_per_m=path.a_per_m,
        b=path.b,
        bend_m=-path.bend_m,
        bend_s_m=path.bend_s_m,
        bend_width_m=path.bend_width_m,
    )
    s = path.start_s_m - 5 + where * 0.01
    assert mirrored.d(s) == -path.d(s)
    assert mirrored.slope(s) == -path.slope(s)
    assert mirrored.curvature(s) == -path.curvature(s)


@pytest.mark.parametrize("speed_kmh", range(20, 131, 5))
@pytest.mark.parametrize("bound", [1.0, 4.0, 6.0])
def test_bound_is_kept_and_nearly_used_at_every_speed(speed_kmh: int, bound: float) -> None:
    v = speed_kmh / 3.6
    peak = peak_lateral_acceleration(corrected(0.0, 0.0, 3.7, v, bound), v)
    assert peak <= bound
    assert peak >= 0.75 * bound  # no needless length: exact curvature is below d'' only by the slope


@given(
    st.floats(-6, 6),
    st.floats(0.5, 45),
    st.floats(0.5, 8),
    st.floats(-2.5, 2.5),
    st.floats(-10, 120),
    st.floats(0.5, 30),
    st.floats(3, 300),
)
@settings(max_examples=100, deadline=None)
def test_bound_is_kept_with_any_bend(y: float, v: float, bound: float, bend: float, at: float, width: float, b: float) -> None:
    path = corrected(0.0, 1.0, 1.0 + y, v, bound, b=b, bend_m=bend, bend_s_m=at, bend_width_m=width)
    s = np.linspace(-10.0, 150.0 + path.length_m, 8001)
    assert v**2 * np.abs(path.curvature(s)).max() <= bound * (1 + 1e-12)


@given(st.floats(6, 45), st.floats(1, 6))
@settings(max_examples=25, deadline=None)
def test_length_follows_the_closed_form(v: float, bound: float) -> None:
    y_prime = 3.7 * 51 / 49
    path = corrected(0.0, 0.0, 3.7, v, bound)
    assert path.a_per_m == pytest.approx(-math.sqrt(6 * math.sqrt(3) * bound / (y_prime * v**2)), rel=1e-12)
    assert path.length_m == pytest.approx(2 * math.log(50) / -path.a_per_m, rel=1e-12)


def test_lateral_speed_of_the_heading_jump_does_not_depend_on_speed() -> None:
    jumps = [v * math.tan(starting_heading_jump(corrected(0.0, 0.0, 3.7, v, 4.0))) for v in (6.0, 17.0, 36.0)]
    np.testing.assert_allclose(jumps, jumps[0], rtol=1e-12)
    assert 0.2 < jumps[0] < 0.3


def test_no_displacement_is_a_straight_line() -> None:
    path = corrected(10.0, 1.2, 1.2, 15.0, 4.0)
    s = np.linspace(0, 60, 61)
    np.testing.assert_array_equal(path.d(s), 1.2)
    np.testing.assert_array_equal(path.curvature(s), 0.0)


@pytest.mark.parametrize(
    ("name", "value"), [("a_per_m", 0.0), ("a_per_m", 0.4), ("b", 1.0), ("b", math.nan), ("bend_width_m", 0.0), ("amplitude_m", math.inf)]
)
def test_bad_numbers_are_refused_by_name(name: str, value: float) -> None:
    good = {"start_s_m": 0.0, "start_d_m": 0.0, "amplitude_m": 3.7, "a_per_m": -0.4, "b": 50.0}
    with pytest.raises(ParameterError) as error:
        OffsetPath(**{**good, name: value})
    assert error.value.name == name
