"""Gradients through the MPC: what they say is what solving anew finds, and they lead downhill."""

from __future__ import annotations

import numpy as np
import pytest

from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.settings import PredictionSettings, Settings, SigmoidSettings
from mcdas_opt.domain.situation import Coverage, Situation
from mcdas_opt.domain.track import Track
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.domain.vocabulary import Side
from mcdas_opt.ocp.sensitivities import KNOBS, PlanSensitivity
from mcdas_opt.planning.cycle import Cycle
from mcdas_opt.planning.proposals.evade import steer_out
from mcdas_opt.tracking.prediction import predict
from mcdas_opt.tuning.gradient import MeanMerit, PosedPlan, at_random, by_gradient, posed_plan

NODES = 20
SENSITIVITY = PlanSensitivity(Vehicle(), neighbours=2, nodes=NODES)


def plan(speed: float, gap: float, offset: float, side: Side) -> PosedPlan:
    front = Track(id="front", s_m=gap + 4.5, d_m=offset, speed_s_mps=0.6 * speed)
    rear = Track(id="rear", s_m=-20.0, d_m=0.0, speed_s_mps=speed + 4.0)
    situation = Situation(
        host=HostState(speed_mps=speed), tracks=(front, rear), road=Road(lanes_left=1, lanes_right=1), coverage=Coverage()
    )
    gentle = Settings(sigmoid=SigmoidSettings(lateral_acceleration_mps2=3.0))
    cycle = Cycle.of(situation, Vehicle(), gentle)
    return posed_plan(SENSITIVITY, situation, steer_out(cycle, side), predict(situation.tracks, PredictionSettings()).bodies)


PLANS = [plan(14.0, 14.0, 0.4, Side.LEFT), plan(20.0, 22.0, -0.3, Side.RIGHT), plan(25.0, 30.0, 0.2, Side.LEFT)]


@pytest.mark.parametrize("posed", PLANS)
def test_gradients_are_those_of_solving_anew(posed: PosedPlan) -> None:
    here = SENSITIVITY.measured(posed.parameters, posed.guess, gradients=True)
    assert here.converged
    for knob in KNOBS:
        value = SENSITIVITY.knob(posed.parameters, knob)
        step = 2e-4 * max(abs(value), 1e-2)
        up, down = (
            SENSITIVITY.measured(SENSITIVITY.with_knob(posed.parameters, knob, value + sign * step), here.solution.w, gradients=False)
            for sign in (1.0, -1.0)
        )
        assert up.converged
        assert down.converged
        for name in ("cost", "clearance_m", "merit"):
            by = getattr(here, name.removesuffix("_m") + "_by")[knob]
            difference = (getattr(up, name) - getattr(down, name)) / (2.0 * step)
            assert by == pytest.approx(difference, rel=2e-3, abs=2e-5), (knob, name)


def test_the_mean_merit_slope_is_that_of_its_values_and_rollouts_are_counted() -> None:
    merit = MeanMerit(PLANS, SENSITIVITY)
    at = np.full(len(merit.knobs), 0.1)
    _, slope = merit(at, gradient=True)
    direction = np.random.default_rng(1).normal(size=at.size)
    up, down = (merit(at + sign * 1e-4 * direction, gradient=False)[0] for sign in (1.0, -1.0))
    assert slope @ direction == pytest.approx((up - down) / 2e-4, rel=2e-3)
    assert merit.rollouts == 3 * len(PLANS)


def test_a_few_gradient_steps_beat_as_many_random_draws() -> None:
    merit = MeanMerit(PLANS, SENSITIVITY)
    down, drawn = by_gradient(merit, 8), at_random(merit, 16, seed=2)
    assert down.rollouts[-1] == 8 * len(PLANS)
    assert down.merits[0] == pytest.approx(drawn.merits[0])
    assert np.all(np.diff(down.merits) <= 0.0)
    assert down.merits[-1] < drawn.merits[-1]
