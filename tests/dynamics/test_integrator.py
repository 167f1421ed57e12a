"""The integrator's order and its indifference to the number system."""

from __future__ import annotations

import math

import numpy as np
import pytest

from mcdas_opt.dynamics.integrator import rk4


def pendulum(x):
    return [x[1], -np.sin(x[0])]


def drive(steps):
    x = [1.0, 0.0]
    for _ in range(steps):
        x = rk4(pendulum, x, 2.0 / steps)
    return np.array(x)


def test_is_of_fourth_order():
    fine = drive(4000)
    errors = [np.abs(drive(n) - fine).max() for n in (10, 20, 40)]
    assert math.log2(errors[0] / errors[1]) == pytest.approx(4.0, abs=0.3)
    assert math.log2(errors[1] / errors[2]) == pytest.approx(4.0, abs=0.3)


def test_is_exact_for_motion_under_constant_jerk():
    t, a, v, s = 0.7, -2.0, 9.0, 1.0
    assert rk4(lambda x: [x[1], x[2], 3.0], [s, v, a], t) == pytest.approx(
        [s + v * t + a * t**2 / 2 + 3.0 * t**3 / 6, v + a * t + 1.5 * t**2, a + 3.0 * t]
    )


def test_arrays_are_many_floats():
    starts = np.array([[0.1, 0.7, -2.0], [0.0, 1.0, 0.5]])
    together = np.array(rk4(pendulum, list(starts), 0.1))
    apart = np.array([rk4(pendulum, list(column), 0.1) for column in starts.T]).T
    assert together == pytest.approx(apart, abs=1e-15)
