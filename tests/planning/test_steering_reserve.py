"""Steering rate that plans leave to feedback: the optimiser's bound, nobody else's."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from mcdas_opt.catalogue.vehicles import load_vehicle
from mcdas_opt.domain.settings import Settings
from mcdas_opt.errors import ParameterError
from mcdas_opt.planning.lane_stage import LaneStage
from mcdas_opt.simulation.controller import STEERING_RATE_SHARE, planned_for


def test_the_share_bounds_the_steering_rate_of_the_problem_and_nothing_else() -> None:
    car = load_vehicle("sedan")
    whole, part = (LaneStage(car, replace(Settings(), steering_rate_share=share)).posed(2).problem for share in (1.0, STEERING_RATE_SHARE))
    for one, other in ((whole.u_lower, part.u_lower), (whole.u_upper, part.u_upper)):
        assert other == pytest.approx(one * np.array([1.0, STEERING_RATE_SHARE]))
    assert np.array_equal(part.x_lower, whole.x_lower)
    assert np.array_equal(part.x_upper, whole.x_upper)


def test_only_a_car_that_slips_is_planned_with_a_reserve() -> None:
    settings = Settings()
    assert planned_for("kinematic", settings) is settings
    assert planned_for("dynamic", settings).steering_rate_share == STEERING_RATE_SHARE
    careful = replace(settings, steering_rate_share=0.5 * STEERING_RATE_SHARE)
    assert planned_for("dynamic", careful) == careful


@pytest.mark.parametrize("share", [0.0, -1.0, 1.01, float("nan")])
def test_a_share_that_is_none_is_refused(share: float) -> None:
    with pytest.raises(ParameterError, match="steering_rate_share"):
        Settings(steering_rate_share=share)
