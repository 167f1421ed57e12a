"""Tuning by the gradient through the MPC: the mean merit of plans over a set of problems, and its exact slope by the knobs.

The problems are situations and candidates, posed as the planner poses them.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from mcdas_opt.domain.prediction import PredictedBody
from mcdas_opt.domain.rules import Array, positive
from mcdas_opt.domain.situation import Situation
from mcdas_opt.ocp.lane_mpc import LaneParameters, default_weights
from mcdas_opt.ocp.sensitivities import PlanSensitivity
from mcdas_opt.planning.candidate import Proposed
from mcdas_opt.planning.lane_problem.lane_parameters import guessed_states, obstacle_slots, proposal_values, shared_values
from mcdas_opt.planning.solver_settings import SolverSettings
from mcdas_opt.solvers.stage_problem import StageGuess
from mcdas_opt.tuning.searchers import search

TUNED = (
    "a",
    "b",
    "weight_path_deviation",
    "weight_heading_deviation",
    "weight_speed_deviation",
    "weight_a",
    "weight_jerk",
    "weight_delta_rate",
    "weight_lateral_acceleration",
)
_REACH = math.log(4.0)  # every knob from a quarter to four times its own
_STEP, _MEAN, _SQUARE, _FLAT = 0.35, 0.8, 0.9, 1e-3  # of Adam: a step of a logarithm, its two memories, a slope that is none
_REFUSED = 100.0  # merit of a plan that is not found
STEP_S = 0.1


@dataclass(frozen=True, slots=True, kw_only=True)
class PosedPlan:
    """One problem: its parameters (p, h, x0) at the knobs' own values, and a guess to begin from."""

    parameters: Array
    guess: StageGuess


@dataclass(frozen=True, slots=True, kw_only=True)
class Curve:
    """A search by its rollouts: the best mean merit so far after each evaluation, and the point (logarithms of the knobs' factors)."""

    method: str
    rollouts: Array
    merits: Array
    best: Array


class MeanMerit:
    """Mean merit over problems as a function of the logarithms of the knobs' factors, all zero at first. Counts its rollouts (solves).

    Every solve starts from the problem's own solution at the knobs' own values, so that the value does not depend on what was asked
    before.
    """

    def __init__(self, plans: Sequence[PosedPlan], sensitivity: PlanSensitivity, knobs: Sequence[str] = TUNED) -> None:
        positive("plans", len(plans))
        self.plans, self.sensitivity, self.knobs = tuple(plans), sensitivity, tuple(knobs)
        self._starts: list[Array | StageGuess] = []
        for plan in self.plans:
            own = sensitivity.measured(plan.parameters, plan.guess, gradients=False)
            self._starts.append(own.solution.w if own.converged else plan.guess)
        self.rollouts = 0

    def __call__(self, factors: Array, *, gradient: bool) -> tuple[float, Array]:
        """(mean merit, its slope; zeros where it is not asked for). A plan that is not found has a fixed cost and no slope."""
        total, slope = 0.0, np.zeros(len(self.knobs))
        for plan, start in zip(self.plans, self._starts, strict=True):
            parameters = plan.parameters
            values = [self.sensitivity.knob(parameters, knob) * math.exp(factor) for knob, factor in zip(self.knobs, factors, strict=True)]
            for knob, value in zip(self.knobs, values, strict=True):
                parameters = self.sensitivity.with_knob(parameters, knob, value)
            found = self.sensitivity.measured(parameters, start, gradients=gradient)
            self.rollouts += 1
            total += found.merit if found.converged else _REFUSED
            if found.merit_by:
                slope += np.array([found.merit_by[knob] * value for knob, value in zip(self.knobs, values, strict=True)])
        return total / len(self.plans), slope / len(self.plans)


def by_gradient(merit: MeanMerit, evaluations: int) -> Curve:
    """Adam (Kingma, Ba 2015) from the knobs' own values, each at most four times up or down: a step of each knob is measured by its own
    slopes, so that a steep knob does not stop the others, and a worse point on the way does not either."""
    tried: list[tuple[float, Array]] = []
    at, mean, square = np.zeros(len(merit.knobs)), np.zeros(len(merit.knobs)), np.zeros(len(merit.knobs))
    for k in range(1, evaluations + 1):
        found, slope = merit(at, gradient=True)
        tried.append((found, at))
        mean, square = _MEAN * mean + (1.0 - _MEAN) * slope, _SQUARE * square + (1.0 - _SQUARE) * slope**2
        usual = np.sqrt(square / (1.0 - _SQUARE**k)) + _FLAT
        at = np.clip(at - _STEP * mean / (1.0 - _MEAN**k) / usual, -_REACH, _REACH)
    return _curve("gradient", merit, tried)


def at_random(merit: MeanMerit, evaluations: int, seed: int) -> Curve:
    """As many points of the same box, the knobs' own values first."""
    tried: list[tuple[float, Array]] = []

    def value(shares: Array) -> float:
        factors = _REACH * (2.0 * shares - 1.0)
        found, _ = merit(factors, gradient=False)
        tried.append((found, factors))
        return found

    search("random", value, len(merit.knobs), evaluations, seed, np.full(len(merit.knobs), 0.5))
    return _curve("random", merit, tried)


def _curve(method: str, merit: MeanMerit, tried: Sequence[tuple[float, Array]]) -> Curve:
    values = np.array([value for value, _ in tried])
    return Curve(
        method=method,
        rollouts=len(merit.plans) * np.arange(1.0, len(tried) + 1.0),
        merits=np.minimum.accumulate(values),
        best=tried[int(np.argmin(values))][1],
    )


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
