"""Situations and ways out, posed as the planner poses them, for the gradient tuner."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from mcdas_opt.domain.prediction import PredictedBody
from mcdas_opt.domain.situation import Situation
from mcdas_opt.ocp.lane_mpc import LaneParameters, default_weights
from mcdas_opt.ocp.sensitivities import PlanSensitivity
from mcdas_opt.planning.lane_parameters import guessed_states, seated, shared_values, way_values
from mcdas_opt.planning.stage_settings import StageSettings
from mcdas_opt.planning.ways import Way
from mcdas_opt.solvers.stage_problem import StageGuess
from mcdas_opt.tuning.gradient import PosedPlan

STEP_S = 0.1


def posed_plan(sensitivity: PlanSensitivity, situation: Situation, way: Way, bodies: Sequence[PredictedBody]) -> PosedPlan:
    """The lane problem of one way at the weights' own values, with the way's path as guess."""
    problem, nodes, stage = sensitivity.problem, sensitivity.nodes, StageSettings()
    times = np.round(STEP_S * np.arange(nodes + 1), 9)
    x = guessed_states(situation, way, sensitivity.lane.vehicle, times)
    others = seated(bodies, times, along_m=stage.clearance_along_m, across_m=stage.clearance_across_m)
    shared = shared_values(situation, others, seats=sensitivity.lane.neighbours, friction_share=stage.friction_share)
    of_way = way_values(situation, others, way, times, x[:, 0])
    p = LaneParameters(names=sensitivity.names).matrix(nodes, shared, of_way, default_weights())
    x0 = np.clip(situation.host.to_vector(), problem.x_lower, problem.x_upper)
    guess = StageGuess(x=x, u=np.zeros((nodes, problem.nu)), s=np.zeros((nodes + 1, problem.ns)))
    return PosedPlan(parameters=sensitivity.pack(x0, p, np.full(nodes, STEP_S)), guess=guess)
