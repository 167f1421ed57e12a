"""Random lane situations and noisy closed loops, posed as the planner poses them: what the solver race and the solver tests run on.

Evasions: a slower car ahead, mostly a faster one behind, others in the side lanes, but one side lane open; the proposal is the corrected
sigmoid into that lane at a lateral acceleration the road bears. Drawn so that a way through exists; nothing is filtered by a solver.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.rules import Array
from mcdas_opt.domain.settings import PredictionSettings
from mcdas_opt.domain.situation import Situation
from mcdas_opt.domain.track import Coverage, Track
from mcdas_opt.domain.vehicle import GRAVITY_MPS2, Vehicle
from mcdas_opt.domain.vocabulary import Mode, Side
from mcdas_opt.dynamics.bicycle import road_bicycle
from mcdas_opt.dynamics.integrator import rk4
from mcdas_opt.ocp.lane_mpc import LaneParameters, LaneProblem
from mcdas_opt.planning.candidate import Proposed
from mcdas_opt.planning.lane_problem.lane_parameters import guessed_states, obstacle_slots, proposal_values, shared_values
from mcdas_opt.planning.lanes.manoeuvre import Manoeuvre
from mcdas_opt.reference.offset_path import corrected
from mcdas_opt.solvers.stage_problem import StageGuess, StageProblem
from mcdas_opt.tracking.prediction import predict

STEP_S = 0.1
_LANE_M = 3.7
_NOISE = np.array([0.03, 0.03, 0.003, 0.1, 0.1, 0.003])  # of the host's state, each step: s, d, psi, v, a, delta
_COVARIANCE = np.diag([0.04, 0.04, 0.01, 0.01])


@dataclass(frozen=True, slots=True, kw_only=True)
class Posed:
    """A problem's data, ready for an engine."""

    x0: Array
    p: Array
    steps: Array
    guess: StageGuess


def lane_problem(slots: int, vehicle: Vehicle | None = None) -> StageProblem:
    return LaneProblem(vehicle=vehicle or Vehicle(), neighbours=slots).stage_problem()


def evasion(rng: np.random.Generator, neighbours: int = 3, *, side: Side | None = None, urgency: float = 1.0) -> tuple[Situation, Proposed]:
    """A front car at 1.2 to 2.5 s (at least 8 m), a rear car, `neighbours` - 2 more beside; the proposal leads into the open lane.

    An `urgency` above 1 divides times and distances: at 2 many of them end in a scrape.
    """
    v = rng.uniform(12.0, 30.0)
    friction = float(rng.choice([0.9, 0.9, 0.7, 0.5]))
    sign = (1 if side is Side.LEFT else -1) if side is not None else int(rng.choice([-1, 1]))
    bend = rng.uniform(-1.0, 1.0) * min(0.01, 0.15 * friction * GRAVITY_MPS2 / v**2) * float(rng.random() < 0.5)
    road = Road(lanes_left=1, lanes_right=1, friction=friction, curvature=((0.0, 0.0), (60.0, bend)))
    host = HostState(
        d_m=rng.uniform(-0.4, 0.4),
        heading_rad=rng.uniform(-0.03, 0.03),
        speed_mps=v,
        acceleration_mps2=rng.uniform(-1.0, 1.0),
        steering_rad=rng.uniform(-0.2, 0.2) / v,
    )
    length = 4.5
    slower = rng.uniform(3.0, 15.0)
    cars = []
    if neighbours > 0:
        front_v = max(v - slower, 0.0)
        gap = max(8.0, (v - front_v) * rng.uniform(1.2, 2.5) * (0.9 / friction) ** 0.5) / urgency
        cars.append(Track(id="front", s_m=gap + length, d_m=rng.uniform(-0.3, 0.3), speed_s_mps=front_v, covariance=_COVARIANCE))
    if neighbours > 1:
        rear_s = -length - rng.uniform(9.0, 25.0) / urgency
        cars.append(Track(id="rear", s_m=rear_s, d_m=rng.uniform(-0.3, 0.3), speed_s_mps=v + rng.uniform(0.0, 6.0), covariance=_COVARIANCE))
    for i in range(neighbours - 2):  # the other side lane is taken; the open one has cars far ahead or far behind
        beside = rng.random() < 0.7
        s = rng.uniform(-15.0, 15.0) + 12.0 * i if beside else float(rng.choice([-1.0, 1.0])) * rng.uniform(55.0, 90.0)
        lane = -sign if beside else sign
        cars.append(
            Track(
                id=f"side{i}",
                s_m=s,
                d_m=lane * _LANE_M + rng.uniform(-0.2, 0.2),
                speed_s_mps=v * rng.uniform(0.95, 1.05),
                covariance=_COVARIANCE,
            )
        )
    situation = Situation(host=host, coverage=Coverage(), tracks=tuple(cars), road=road, desired_speed_mps=v)
    return situation, evading(situation, Side.LEFT if sign > 0 else Side.RIGHT)


def evading(situation: Situation, side: Side) -> Proposed:
    """Into the next lane on `side` along the corrected sigmoid."""
    host, road = situation.host, situation.road
    target = road.lane_centre_m(road.lane_of(host.d_m, host.s_m) + (1 if side is Side.LEFT else -1), host.s_m)
    path = corrected(
        start_s_m=host.s_m,
        start_d_m=host.d_m,
        target_d_m=target,
        speed_mps=host.speed_mps,
        lateral_acceleration_mps2=min(4.0, 0.6 * road.friction * GRAVITY_MPS2),
    )
    manoeuvre = Manoeuvre(side=side, path=path, target_d_m=target, speed_mps=situation.wanted_speed_mps)
    return Proposed(name=side.value, mode=Mode.EVADE, side=side, path=path, speed_mps=situation.wanted_speed_mps, manoeuvre=manoeuvre)


def posed(situation: Situation, proposed: Proposed, problem: StageProblem, nodes: int = 40, guess: StageGuess | None = None) -> Posed:
    """With the proposal's own cold guess, or a warm one."""
    times = np.round(STEP_S * np.arange(nodes + 1), 9)
    if guess is None:
        x = guessed_states(situation, proposed, Vehicle(), times)
        guess = StageGuess(x=x, u=np.zeros((nodes, problem.nu)), s=np.zeros((nodes + 1, problem.ns)))
    bodies = predict(situation.tracks, PredictionSettings()).bodies
    others = obstacle_slots(bodies, times, along_m=0.5, across_m=0.25)
    slots = sum(1 for name in problem.parameters if name.startswith("body") and name.endswith("_along"))
    shared = shared_values(situation, others, slots=slots, friction_share=0.97)
    p = LaneParameters(names=problem.parameters).matrix(
        nodes, shared, proposal_values(situation, Vehicle(), others, proposed, times, guess.x[:, 0])
    )
    x0 = np.clip(situation.host.to_vector(), problem.x_lower, problem.x_upper)
    return Posed(x0=x0, p=p, steps=np.full(nodes, STEP_S), guess=guess)


class NoisyLoop:
    """A closed loop: the host is driven by the inputs it is given, disturbed each step; the others keep their speeds.

    Halfway a new car stands in the lane that the host has reached, and the proposal leads back: an event.
    """

    def __init__(self, seed: int, neighbours: int = 3, steps: int = 100, urgency: float = 1.0) -> None:
        self.rng = np.random.default_rng(seed)
        self.situation, self.proposed = evasion(self.rng, neighbours, urgency=urgency)
        self.steps, self.event, self.urgency = steps, True, urgency

    def run(self) -> Iterator[tuple[Situation, Proposed, bool]]:
        """Each step's situation, proposal and whether it is an event; `drive` must be called in between."""
        for k in range(self.steps):
            if k == self.steps // 2:
                self._second()
            yield self.situation, self.proposed, self.event
            self.event = False

    def drive(self, u: Array) -> None:
        """One step on, with the input (jerk, steering rate)."""
        situation, vehicle = self.situation, Vehicle()
        kappa = float(situation.road.curvature_at(situation.host.s_m))
        x = rk4(
            lambda state: road_bicycle(state, list(u), kappa, vehicle.wheelbase_m, vehicle.centre_m, np),
            list(situation.host.to_vector()),
            STEP_S,
        )
        noisy = np.asarray(x) + _NOISE * self.rng.standard_normal(6)
        noisy[3] = max(noisy[3], 0.0)
        tracks = tuple(replace(track, s_m=track.s_m + STEP_S * track.speed_s_mps) for track in situation.tracks)
        self.situation = replace(situation, host=HostState.from_vector(noisy), tracks=tracks, time_s=situation.time_s + STEP_S)

    def _second(self) -> None:
        situation, rng = self.situation, self.rng
        host, road = situation.host, situation.road
        lane = road.lane_of(host.d_m, host.s_m)
        speed = max(host.speed_mps - rng.uniform(3.0, 10.0), 0.0)
        gap = max(8.0, (host.speed_mps - speed) * rng.uniform(1.5, 2.5) * (0.9 / road.friction) ** 0.5) / self.urgency
        car = Track(id="front", s_m=host.s_m + gap + 4.5, d_m=road.lane_centre_m(lane, host.s_m), speed_s_mps=speed, covariance=_COVARIANCE)
        back = Side.RIGHT if lane > 0 or (lane == 0 and rng.random() < 0.5) else Side.LEFT
        others = tuple(t for t in situation.tracks if t.id != "front" and abs(t.s_m - host.s_m) > 25.0)
        wanted = max(host.speed_mps, 5.0)
        self.situation = replace(situation, tracks=(car, *others), desired_speed_mps=wanted)
        self.proposed = evading(self.situation, back)
        self.event = True
