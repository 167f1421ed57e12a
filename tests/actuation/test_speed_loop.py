"""The designed loop: stable with margins, inside the limits, and still so when the plant is not the model."""

from __future__ import annotations

import numpy as np
import pytest

from mcdas_opt.actuation.speed_law import SpeedLimits
from mcdas_opt.actuation.speed_loop import DriveByWire, SpeedLoop, design_speed_loop
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.errors import ParameterError

LIMITS = SpeedLimits.of(Vehicle())


@pytest.fixture(scope="module")
def loop() -> SpeedLoop:
    return design_speed_loop(LIMITS)


def test_margins(loop: SpeedLoop) -> None:
    m = loop.margins
    assert m.slowest_pole < 1.0
    assert m.gain > 2.0
    assert m.phase_deg > 45.0
    assert m.delay_s > 2 * loop.plant.delay_s
    assert m.sensitivity_peak < 1.5


def test_forty_to_sixty_within_every_limit(loop: SpeedLoop) -> None:
    """Where eq 11 asks for 1.13 g."""
    run = loop.run(40 / 3.6, 60 / 3.6, 8.0)
    assert LIMITS.acceleration_min_mps2 <= run.acceleration_mps2.min()
    assert run.acceleration_mps2.max() <= LIMITS.acceleration_max_mps2
    assert LIMITS.jerk_min_mps3 <= run.jerk_mps3.min()
    assert run.jerk_mps3.max() <= LIMITS.jerk_max_mps3
    assert run.speed_mps[-1] == pytest.approx(60 / 3.6, abs=1e-3)
    assert run.speed_mps.max() <= 60 / 3.6 + 1e-3
    np.testing.assert_allclose(run.speed_mps, run.reference_mps, atol=5e-3)


def test_random_demands_within_every_limit(loop: SpeedLoop) -> None:
    run = loop.run(20.0, np.repeat(np.random.default_rng(0).uniform(0, 40, 60), 15), 18.0)
    assert run.acceleration_mps2.min() >= LIMITS.acceleration_min_mps2
    assert run.acceleration_mps2.max() <= LIMITS.acceleration_max_mps2
    assert run.jerk_mps3.min() >= LIMITS.jerk_min_mps3
    assert run.jerk_mps3.max() <= LIMITS.jerk_max_mps3


@pytest.mark.parametrize("lag_s", [0.175, 0.25, 0.35])
@pytest.mark.parametrize("delay_s", [0.06, 0.1, 0.16])
def test_another_plant_than_the_model(loop: SpeedLoop, lag_s: float, delay_s: float) -> None:
    """Lag 30 % off, dead time 40-60 % off, on a slope of 3 %: jerk within the limits, acceleration within 20 % of them."""
    run = loop.run(40 / 3.6, 60 / 3.6, 10.0, actual=DriveByWire(lag_s=lag_s, delay_s=delay_s), disturbance_mps2=-0.3)
    assert run.acceleration_mps2.max() <= 1.2 * LIMITS.acceleration_max_mps2
    assert LIMITS.jerk_min_mps3 <= run.jerk_mps3.min()
    assert run.jerk_mps3.max() <= LIMITS.jerk_max_mps3
    assert run.speed_mps[-1] == pytest.approx(60 / 3.6, abs=0.02)
    assert run.speed_mps.max() < 60 / 3.6 + 0.2


def test_no_dead_time_is_a_plant_too() -> None:
    run = design_speed_loop(LIMITS, DriveByWire(delay_s=0.0)).run(10.0, 15.0, 6.0)
    assert run.speed_mps[-1] == pytest.approx(15.0, abs=1e-3)


def test_dead_time_must_be_whole_samples() -> None:
    with pytest.raises(ParameterError, match="delay_s"):
        design_speed_loop(LIMITS, DriveByWire(delay_s=0.105))
