"""Situations and candidates, posed as the planner poses them, for the gradient tuner."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from mcdas_opt.domain.prediction import PredictedBody
from mcdas_opt.domain.situation import Situation
from mcdas_opt.ocp.lane_mpc import LaneParameters, default_weights
from mcdas_opt.ocp.sensitivities import PlanSensitivity
from mcdas_opt.planning.candidate import Proposed
from mcdas_opt.planning.lane_problem.lane_parameters import guessed_states, obstacle_slots, proposal_values, shared_values
from mcdas_opt.planning.solver_settings import SolverSettings
from mcdas_opt.solvers.stage_problem import StageGuess
from mcdas_opt.tuning.gradient import PosedPlan

STEP_S = 0.1


def posed_plan(sensitivity: PlanSensitivity, situation: Situation, proposed: Proposed, bodies: Sequence[PredictedBody]) -> PosedPlan:
    """The lane problem of one candidate at the weights' own values, with its path as guess."""
    problem, nodes, stage = sensitivity.problem, sensitivity.nodes, SolverSettings()
    times = np.round(STEP_S * np.arange(nodes + 1), 9)
    x = guessed_states(situation, proposed, sensitivity.lane.vehicle, times)
    others = obstacle_slots(bodies, times, along_m=stage.clearance_along_m, across_m=stage.clearance_across_m)
    shared = shared_values(situation, others, slots=sensitivity.lane.neighbours, friction_share=stage.friction_share)
    own = proposal_values(situation, sensitivity.lane.vehicle, others, proposed, times, x[:, 0])
    p = LaneParameters(names=sensitivity.names).matrix(nodes, shared, own, default_weights())
    x0 = np.clip(situation.host.to_vector(), problem.x_lower, problem.x_upper)
    guess = StageGuess(x=x, u=np.zeros((nodes, problem.nu)), s=np.zeros((nodes + 1, problem.ns)))
    return PosedPlan(parameters=sensitivity.pack(x0, p, np.full(nodes, STEP_S)), guess=guess)
