"""The constant-velocity target's F and Q."""

from __future__ import annotations

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from mcdas_opt.dynamics.target import process_noise, transition

steps = st.floats(0.0, 2.0)


@settings(deadline=None)
@given(a=steps, b=steps)
def test_transitions_compose_and_undo(a: float, b: float) -> None:
    np.testing.assert_allclose(transition(a) @ transition(b), transition(a + b), atol=1e-12)
    np.testing.assert_allclose(transition(-a) @ transition(a), np.eye(4), atol=1e-12)
    np.testing.assert_allclose(transition(a) @ [1.0, 2.0, 3.0, -4.0], [1.0 + 2.0 * a, 2.0, 3.0 - 4.0 * a, -4.0])


@settings(deadline=None)
@given(dt=steps, along=st.floats(0.1, 10.0), across=st.floats(0.1, 10.0))
def test_noise_is_that_of_an_acceleration_held_over_the_step(dt: float, along: float, across: float) -> None:
    push = np.array([[0.5 * dt**2, 0.0], [dt, 0.0], [0.0, 0.5 * dt**2], [0.0, dt]])
    np.testing.assert_allclose(process_noise(dt, along, across), push @ np.diag([along**2, across**2]) @ push.T, atol=1e-12)


@settings(deadline=None)
@given(dt=st.floats(0.01, 1.0))
def test_one_long_look_away_is_worse_than_two_short_ones(dt: float) -> None:
    once = process_noise(2.0 * dt, 8.0, 2.0)
    twice = transition(dt) @ process_noise(dt, 8.0, 2.0) @ transition(dt).T + process_noise(dt, 8.0, 2.0)
    assert np.all(np.diag(once) >= np.diag(twice) - 1e-12)
