"""A way out, posed as the lane problem and solved: warm start or guess, solve, roll-out."""

from __future__ import annotations

import copy
import os
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from itertools import chain

import numpy as np

from mcdas_opt.domain.prediction import Prediction
from mcdas_opt.domain.rules import Array
from mcdas_opt.domain.settings import Settings
from mcdas_opt.domain.situation import Situation
from mcdas_opt.domain.trajectory import Trajectory
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.ocp.compiled_drive import compiled_drive
from mcdas_opt.ocp.lane_mpc import CENTRE, LaneParameters, LaneProblem
from mcdas_opt.planning.grown_bodies import build_grown_bodies
from mcdas_opt.planning.lane_parameters import Seated, guessed_states, seated, shared_values, vacant_values, way_values
from mcdas_opt.planning.mirror import TurnedParameters, is_turned, turned_guess, turned_inputs, turned_states
from mcdas_opt.planning.roll_out import roll_out, within_reach
from mcdas_opt.planning.stage_settings import StageSettings
from mcdas_opt.planning.ways import Way
from mcdas_opt.solvers.guarded import ask
from mcdas_opt.solvers.held_interrupts import held_interrupts
from mcdas_opt.solvers.interior_point import SWITCH, InteriorPointEngine
from mcdas_opt.solvers.ipopt_engine import IpoptEngine
from mcdas_opt.solvers.osqp_engine import OsqpEngine, OsqpSettings
from mcdas_opt.solvers.outcome import Ending, Outcome
from mcdas_opt.solvers.stage_problem import StageGuess

_IPOPT_ITERATIONS = 200
Engine = InteriorPointEngine | OsqpEngine | IpoptEngine
Asked = tuple[Engine, Callable[[], StageGuess], int]  # who, from which guess, with which cap on iterations


@dataclass(frozen=True, slots=True)
class _Memory:
    """What a way's last solve leaves for the next: thrown away at an event."""

    time_s: float
    way: Way
    outcome: Outcome
    engine: Engine
    turned: bool
    others: Seated


@dataclass(frozen=True, slots=True)
class _Scene:
    """What the ways of one situation share: the neighbours on the grid, the parameters that are the same for all, and the state to begin in
    (a measured one a hair outside a hard bound, by rounding or a limit just touched, is brought to it)."""

    situation: Situation
    prediction: Prediction
    others: Seated
    posed: Posed
    matrix: Array
    start: Array


@dataclass(frozen=True, slots=True, kw_only=True)
class Solved:
    """A trajectory, or None with the reason in words."""

    trajectory: Trajectory | None
    reason: str
    iterations: int
    converged: bool = False


class Posed:
    """The lane problem for a number of neighbours, with its engines, each built when first asked for."""

    def __init__(self, lane: LaneProblem, nodes: int) -> None:
        self.seats, self.nodes = lane.neighbours, nodes
        self.osqp_settings = OsqpSettings()
        self.problem = lane.stage_problem()
        self.parameters = LaneParameters(names=self.problem.parameters)
        self.turned = TurnedParameters(self.problem.parameters)

    def twin(self, osqp_settings: OsqpSettings | None = None) -> Posed:
        """The same problem with engines of its own."""
        twin = copy.copy(self)
        twin.osqp_settings = osqp_settings or self.osqp_settings
        for name in ("interior_point", "osqp", "ipopt"):
            twin.__dict__.pop(name, None)
        twin.__dict__["interior_point"] = self.interior_point.twin()
        return twin

    @cached_property
    @held_interrupts()
    def interior_point(self) -> InteriorPointEngine:
        """The engine of choice."""
        return InteriorPointEngine(self.problem, self.nodes)

    @cached_property
    @held_interrupts()
    def osqp(self) -> OsqpEngine:
        """The second opinion, and the engine of choice where the settings say so."""
        return OsqpEngine(self.problem, self.nodes, self.osqp_settings)

    @cached_property
    @held_interrupts()
    def ipopt(self) -> IpoptEngine:
        """The reference."""
        return IpoptEngine(self.problem, self.nodes)


def _circumstances() -> tuple[str, str]:
    """What decides how an engine is built: whether compiling is allowed, and where libraries are kept."""
    return os.environ.get(SWITCH, "1"), os.environ.get("XDG_CACHE_HOME", "")


@lru_cache(maxsize=12)
@held_interrupts()
def _original(vehicle: Vehicle, seats: int, free_weights: bool, free_centre: bool, nodes: int, circumstances: tuple[str, str]) -> Posed:
    """Built once a process: planners take twins of it."""
    return Posed(LaneProblem(vehicle=vehicle, neighbours=seats, free_weights=free_weights, free_centre=free_centre), nodes)


class LaneStage:
    """Owns the engines (one per number of seats) and the warm starts, one per way. Not shared between threads."""

    def __init__(self, vehicle: Vehicle, settings: Settings, stage: StageSettings | None = None) -> None:
        self.vehicle, self.settings, self.stage = vehicle, settings, stage or StageSettings()
        rate = settings.steering_rate_share * vehicle.steering_rate_max_radps
        self._planned = replace(vehicle, steering_rate_max_radps=rate, zero_sideslip_point_m=0.0)
        self._slips = False  # whether the car was ever said to roll elsewhere than on its rear axle; those problems hold at rest too
        self._posed: dict[tuple[int, bool], Posed] = {}
        self._constant: dict[tuple[str, ...], Array] = {}
        self._memory: dict[str, _Memory] = {}
        self._last: _Scene | None = None
        self._newton_steps = 0  # taken in that scene

    def posed(self, neighbours: int) -> Posed:
        """The problem with the fewest seats that hold so many neighbours (at most the last), built when first asked for."""
        seats = next((n for n in self.stage.seats if n >= neighbours), self.stage.seats[-1])
        self._slips |= self.vehicle.zero_sideslip_point_m > 0.0
        asked = seats, self._slips
        if asked not in self._posed:
            original = _original(self._planned, seats, self.stage.weights is not None, asked[1], self.settings.grid.nodes, _circumstances())
            second = OsqpSettings(qp_iterations=self.stage.qp_iterations_second)
            self._posed[asked] = original.twin(OsqpSettings() if self.stage.solver == "osqp" else second)
        return self._posed[asked]

    def warm_up(self) -> None:
        """Builds everything now that a drive may ask for but the second opinion: some tenths of a second once a process, else nothing."""
        for seats in self.stage.seats:
            self.posed(seats)
        compiled_drive()
        build_grown_bodies()

    def closer(self) -> LaneStage:
        """The same, with less clearance asked for."""
        least = self.stage.closer_m
        return LaneStage(self.vehicle, self.settings, replace(self.stage, clearance_along_m=least, clearance_across_m=least))

    @property
    def solver(self) -> str:
        """Which engine answers first, and in which form; known once it has solved."""
        if self.stage.solver == "osqp":
            return "osqp"
        kinds = {posed.interior_point.kind for posed in self._posed.values()}
        return f"interior-point ({', '.join(sorted(kinds))})"

    def forget(self) -> None:
        """Throws every warm start away."""
        self._memory.clear()
        if self.stage.solver == "osqp":
            for posed in self._posed.values():
                posed.osqp.reset()

    def second_opinion(self, situation: Situation, prediction: Prediction, way: Way) -> Solved:
        """OSQP's answer, from the way's own path."""
        return self.solve(situation, prediction, way, second=True)

    def solve(self, situation: Situation, prediction: Prediction, way: Way, *, second: bool = False) -> Solved:
        """From the way's last solve when that says something of this one, else from the way's own path. `second`: by OSQP alone."""
        scene = self._scene(situation, prediction)
        posed, others = scene.posed, scene.others
        turned = is_turned(situation, others, way)

        def cold() -> StageGuess:
            guess = self.guess(situation, way, posed)
            return turned_guess(guess) if turned else guess

        memory = self._memory.pop(way.name, None)
        best: Outcome | None = None
        attempts: Iterator[Asked] = self._attempts(posed, cold, second, lambda: best is not None)
        engine = posed.interior_point if self.stage.solver == "interior-point" else posed.osqp
        fits = memory is not None and memory.engine is engine and memory.turned == turned
        if memory is not None and fits and not self._event(memory, situation, way, others):
            outcome = memory.outcome
            steps = self._newton_cap() if engine is posed.interior_point else self.stage.iterations_warm
            attempts = chain([(engine, lambda: engine.shifted(outcome), steps)], attempts)
        x0 = turned_states(scene.start) if turned else scene.start
        by: Engine = engine
        iterations, reason = 0, ""
        for trial, guessed, cap in attempts:
            guess = guessed()
            p = self._filled(scene, way, guess.x[:, 0])
            p = posed.turned(p) if turned else p
            outcome = ask(trial, x0, p, self.settings.grid.steps_s, guess, cap)
            iterations += outcome.inner_iterations
            self._newton_steps += outcome.inner_iterations if trial is posed.interior_point else 0
            if outcome.usable and (best is None or outcome.ending is Ending.CONVERGED or outcome.objective < best.objective):
                best, by = outcome, trial
            if outcome.ending is Ending.CONVERGED:
                break
            reason = outcome.message or outcome.ending.value
        if best is None:
            return Solved(trajectory=None, reason=reason, iterations=iterations)
        self._memory[way.name] = _Memory(situation.time_s, way, best, by, turned, others)
        u = turned_inputs(best.u) if turned else best.u
        trajectory = self._driven(situation, posed, best.x[:, 3], u)
        return Solved(trajectory=trajectory, reason=reason, iterations=iterations, converged=best.ending is Ending.CONVERGED)

    def _attempts(self, posed: Posed, cold: Callable[[], StageGuess], second: bool, answered: Callable[[], bool]) -> Iterator[Asked]:
        """Engines in the order in which they are asked, from a cold start, with their iteration caps: the first that converges answers.

        The second opinion is for where it is asked for, or the first engine has not `answered` at all.
        """
        if second:
            pass
        elif self.stage.cold_start == "ipopt":
            yield posed.ipopt, cold, _IPOPT_ITERATIONS
        elif self.stage.solver == "osqp":
            yield posed.osqp, cold, self.stage.iterations_event
            return
        else:
            yield posed.interior_point, cold, self._newton_cap()
        if second or not answered():
            yield posed.osqp, cold, self.stage.iterations_second  # built when it is first asked

    def _newton_cap(self) -> int:
        """What is left of the cycle's for one solve."""
        left = self.stage.newton_steps_cycle - self._newton_steps
        return min(self.stage.newton_steps, max(left, self.stage.newton_steps_late))

    def _driven(self, situation: Situation, posed: Posed, speed_mps: Array, u: Array) -> Trajectory:
        """The inputs, kept inside their limits, driven through the equations of motion from the measured state."""
        u = np.minimum(np.maximum(u, posed.problem.u_lower), posed.problem.u_upper)
        return roll_out(situation.host, speed_mps, u, self.settings.grid, self.vehicle, situation.road)

    def nearest(self, situation: Situation, prediction: Prediction) -> Seated:
        """The bodies that come nearest over the horizon, at most as many as there are seats; in order of their ids, to keep seats."""
        times, most, host = self.settings.grid.times_s, self.stage.seats[-1], situation.host
        bodies, motion = prediction.bodies, prediction.rows_on(times)
        order = sorted(range(len(bodies)), key=lambda i: bodies[i].id)
        if len(order) > most:
            reach = np.abs(motion.s_m[:, ::5] - (host.s_m + host.speed_mps * times[::5])).min(axis=-1)
            order = sorted(sorted(order, key=lambda i: (reach[i], bodies[i].id))[:most], key=lambda i: bodies[i].id)
        if order != list(range(len(bodies))):
            bodies, motion = tuple(bodies[i] for i in order), motion.part(order)
        return seated(bodies, times, motion=motion, along_m=self.stage.clearance_along_m, across_m=self.stage.clearance_across_m)

    def _scene(self, situation: Situation, prediction: Prediction) -> _Scene:
        """Made for a situation's first way, and kept for the others."""
        last = self._last
        if last is None or last.situation is not situation or last.prediction is not prediction:
            others = self.nearest(situation, prediction)
            posed = self.posed(len(others))
            shared = self._alone(posed).copy()
            share = self.stage.friction_share * self.settings.friction_share
            values = shared_values(situation, others, seats=len(others), friction_share=share)
            if posed.problem.parameters[-1] == CENTRE:
                values[CENTRE] = self.vehicle.centre_m
            posed.parameters.fill(shared, values)
            start = np.minimum(np.maximum(within_reach(situation.host, self.vehicle), posed.problem.x_lower), posed.problem.x_upper)
            last = self._last = _Scene(situation, prediction, others, posed, shared, start)
            self._newton_steps = 0
        return last

    def _alone(self, posed: Posed) -> Array:
        """(N + 1, np): what stays as it is from scene to scene, the weights and nobody in any seat; the rest is to be filled in."""
        names = posed.parameters.names
        if names not in self._constant:
            matrix = self._constant[names] = np.full((self.settings.grid.nodes + 1, len(names)), np.nan)
            posed.parameters.fill(matrix, vacant_values(range(posed.seats)) | dict(self.stage.weights or ()))
        return self._constant[names]

    def _filled(self, scene: _Scene, way: Way, guess_s: Array) -> Array:
        """(N + 1, np): the parameters of every node."""
        p = scene.matrix.copy()
        values = way_values(scene.situation, scene.others, way, self.settings.grid.times_s, guess_s)
        values["left_edge"] -= self.settings.edge_reserve_m
        values["right_edge"] += self.settings.edge_reserve_m
        scene.posed.parameters.fill(p, values)
        return p

    def _event(self, memory: _Memory, situation: Situation, way: Way, others: Seated) -> bool:
        """Whether the last solve says little of this one: time jumped, another path or goal, somebody new or not where predicted."""
        elapsed = situation.time_s - memory.time_s
        if abs(elapsed - float(self.settings.grid.steps_s[0])) > 1e-6 or memory.outcome.ending is not Ending.CONVERGED:
            return True
        if way.manoeuvre != memory.way.manoeuvre or abs(way.speed_mps - memory.way.speed_mps) > 1.0:
            return True
        if [body.id for body in others.bodies] != [body.id for body in memory.others.bodies]:  # they are in the order of their ids
            return True
        most_m, most_mps = self.stage.event_position_m, self.stage.event_speed_mps
        for then, now in zip(memory.others.second, others.first, strict=True):  # one step later: node 1 of the last is node 0 of this one
            if abs(then[0] - now[0]) > most_m or abs(then[1] - now[1]) > most_m or abs(then[2] - now[2]) > most_mps:
                return True
        return False

    def guess(self, situation: Situation, way: Way, posed: Posed) -> StageGuess:
        """The cold start: the way's own path."""
        n, problem = self.settings.grid.nodes, posed.problem
        x = guessed_states(situation, way, self.vehicle, self.settings.grid.times_s) if way.guess is None else way.guess
        return StageGuess(x=x, u=np.zeros((n, problem.nu)), s=np.zeros((n + 1, problem.ns)))

    def parameters(self, situation: Situation, prediction: Prediction, way: Way, guess_s: Array) -> Array:
        """(N + 1, np): what the problem of a way is posed with, its road linearised around `guess_s` (N + 1)."""
        return self._filled(self._scene(situation, prediction), way, guess_s)
