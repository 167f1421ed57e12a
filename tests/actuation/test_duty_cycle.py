"""Table 2, and what its equation does to a car."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from mcdas_opt.actuation.duty_cycle import duty_of_speed, implied_acceleration, next_duty
from mcdas_opt.errors import ParameterError


def test_table_2() -> None:
    assert duty_of_speed(60.0, 240.0) == pytest.approx(0.25, abs=1e-12)
    assert duty_of_speed(40.0, 240.0) == pytest.approx(0.16666667, abs=5e-9)
    assert next_duty(40.0 / 240.0, 60.0, 240.0) == pytest.approx(0.25, abs=1e-12)


@given(st.floats(0, 1), st.floats(0, 250))
def test_eq_11_is_deadbeat_in_both_directions(duty: float, rear: float) -> None:
    assert next_duty(duty, rear, 240.0) == pytest.approx(rear / 240.0, abs=1e-12)


def test_the_jump_to_60_kmh_is_1_13_g() -> None:
    assert implied_acceleration(40 / 3.6, 60 / 3.6) / 9.80665 == pytest.approx(1.13, abs=0.005)


def test_no_speed_scale_no_duty() -> None:
    with pytest.raises(ParameterError):
        duty_of_speed(60.0, 0.0)
