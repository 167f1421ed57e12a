"""A way out, posed as the lane problem and solved: parameters, guess, solve, roll-out."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from mcdas_opt.domain.assessment import Assessment
from mcdas_opt.domain.prediction import PredictedBody, Prediction
from mcdas_opt.domain.rules import Array
from mcdas_opt.domain.settings import Settings
from mcdas_opt.domain.situation import Situation
from mcdas_opt.domain.trajectory import Trajectory
from mcdas_opt.domain.vehicle import GRAVITY_MPS2, Vehicle
from mcdas_opt.dynamics.bicycle import road_bicycle
from mcdas_opt.dynamics.integrator import rk4
from mcdas_opt.ocp.lane_mpc import FAR_M, LaneParameters, LaneProblem
from mcdas_opt.planning.ways import Way
from mcdas_opt.solvers.ipopt_engine import IpoptEngine
from mcdas_opt.solvers.osqp_engine import OsqpEngine
from mcdas_opt.solvers.outcome import Ending, Outcome
from mcdas_opt.solvers.stage_problem import StageGuess


@dataclass(frozen=True, slots=True, kw_only=True)
class StageSettings:
    """Counted work and margins of one solve."""

    neighbours: int = 6
    iterations_warm: int = 3
    iterations_event: int = 10
    friction_share: float = 0.97
    clearance_along_m: float = 0.5
    clearance_across_m: float = 0.25
    event_position_m: float = 0.5
    event_speed_mps: float = 0.5
    cold_start: str = "osqp"  # or "ipopt"


@dataclass(frozen=True, slots=True)
class _Memory:
    """What a way's last solve leaves for the next: thrown away at an event."""

    time_s: float
    way: Way
    outcome: Outcome
    bodies: dict[str, PredictedBody]


@dataclass(frozen=True, slots=True, kw_only=True)
class Solved:
    """A trajectory, or None with the reason in words."""

    trajectory: Trajectory | None
    reason: str
    iterations: int
    objective: float = float("nan")


class LaneStage:
    """Owns the engines (built once) and the warm starts, one per way. Not shared between threads."""

    def __init__(self, vehicle: Vehicle, settings: Settings, stage: StageSettings | None = None) -> None:
        self.vehicle, self.settings, self.stage = vehicle, settings, stage or StageSettings()
        self.problem = LaneProblem(vehicle=vehicle, neighbours=self.stage.neighbours).stage_problem()
        self.parameters = LaneParameters(names=self.problem.parameters)
        self.engine = OsqpEngine(self.problem, settings.grid.nodes)
        self._ipopt: IpoptEngine | None = None
        self._memory: dict[str, _Memory] = {}

    @property
    def ipopt(self) -> IpoptEngine:
        """The reference engine, built when first asked for."""
        if self._ipopt is None:
            self._ipopt = IpoptEngine(self.problem, self.settings.grid.nodes)
        return self._ipopt

    def forget(self) -> None:
        """Throws every warm start away."""
        self._memory.clear()
        self.engine.reset()

    def solve(self, situation: Situation, assessment: Assessment, prediction: Prediction, way: Way) -> Solved:
        bodies = self._nearest(situation, prediction)
        x0 = self._inside(situation.host.to_vector())
        steps = self.settings.grid.steps_s
        memory = self._memory.get(way.name)
        warm = memory is not None and not self._event(memory, situation, way, bodies)
        guess = self.engine.shifted(memory.outcome) if warm and memory is not None else self.guess(situation, way)
        p = self.matrix(situation, assessment, bodies, way, guess.x)
        iterations = self.stage.iterations_warm if warm else self.stage.iterations_event
        if not warm and self.stage.cold_start == "ipopt":
            outcome = self.ipopt.solve(x0, p, steps, guess)
        else:
            outcome = self.engine.solve(x0, p, steps, guess, iterations)
        if not outcome.usable and warm:  # the warm start may be what is wrong
            self.engine.reset()
            guess = self.guess(situation, way)
            p = self.matrix(situation, assessment, bodies, way, guess.x)
            outcome = self.engine.solve(x0, p, steps, guess, self.stage.iterations_event)
        if not outcome.usable:
            self._memory.pop(way.name, None)
            return Solved(trajectory=None, reason=outcome.message or outcome.ending.value, iterations=outcome.inner_iterations)
        self._memory[way.name] = _Memory(situation.time_s, way, outcome, {b.id: b for b in bodies})
        trajectory = self.roll_out(situation, outcome.u)
        reason = "" if outcome.ending is Ending.CONVERGED else outcome.ending.value
        return Solved(trajectory=trajectory, reason=reason, iterations=outcome.inner_iterations, objective=outcome.objective)

    def _inside(self, x: Array) -> Array:
        """A measured state a hair outside a hard bound (rounding, a limit just touched) is brought to it."""
        return np.clip(x, self.problem.x_lower, self.problem.x_upper)

    def _nearest(self, situation: Situation, prediction: Prediction) -> tuple[PredictedBody, ...]:
        """The bodies that come nearest over the horizon, at most as many as the problem has seats; order by id keeps seats."""
        times = self.settings.grid.times_s[::5]
        host = situation.host

        def reach(body: PredictedBody) -> float:
            motion = body.at(times)
            return float(np.abs(motion.s_m - host.s_m - host.speed_mps * times).min())

        chosen = sorted(prediction.bodies, key=lambda b: (reach(b), b.id))[: self.stage.neighbours]
        return tuple(sorted(chosen, key=lambda b: b.id))

    def _event(self, memory: _Memory, situation: Situation, way: Way, bodies: tuple[PredictedBody, ...]) -> bool:
        elapsed = situation.time_s - memory.time_s
        if abs(elapsed - float(self.settings.grid.steps_s[0])) > 1e-6 or memory.outcome.ending is not Ending.CONVERGED:
            return True
        if way.manoeuvre != memory.way.manoeuvre or abs(way.speed_mps - memory.way.speed_mps) > 1.0:
            return True
        if {b.id for b in bodies} != set(memory.bodies):
            return True
        for body in bodies:
            then, now = memory.bodies[body.id].at(np.array([elapsed])), body.at(np.zeros(1))
            moved = max(abs(float(then.s_m[0] - now.s_m[0])), abs(float(then.d_m[0] - now.d_m[0])))
            if moved > self.stage.event_position_m or abs(float(then.speed_s_mps[0] - now.speed_s_mps[0])) > self.stage.event_speed_mps:
                return True
        return False

    def guess(self, situation: Situation, way: Way) -> StageGuess:
        """The way's own path, driven towards its own speed: dynamically inconsistent on purpose, it only chooses the basin."""
        n, steps = self.settings.grid.nodes, self.settings.grid.steps_s
        host, vehicle = situation.host, self.vehicle
        gap = way.speed_mps - host.speed_mps
        rate = np.clip(gap / 2.0, 0.6 * vehicle.acceleration_min_mps2, 0.9 * vehicle.acceleration_max_mps2)
        t = self.settings.grid.times_s
        v = host.speed_mps + np.clip(rate * t, min(gap, 0.0), max(gap, 0.0))
        v = np.maximum(v, 0.0)
        s = host.s_m + np.concatenate([[0.0], np.cumsum(0.5 * (v[1:] + v[:-1]) * steps)])
        path_d = np.asarray(way.path.d(s))
        d = path_d + (host.d_m - path_d[0]) * np.exp(-t / 0.8)
        psi = np.arctan(np.asarray(way.path.slope(s)))
        x = np.column_stack([s, d, psi, v, np.zeros(n + 1), np.zeros(n + 1)])
        return StageGuess(x=x, u=np.zeros((n, 2)), s=np.zeros((n + 1, self.problem.ns)))

    def matrix(self, situation: Situation, assessment: Assessment, bodies: tuple[PredictedBody, ...], way: Way, x: Array) -> Array:
        """(N + 1, np): the parameters of every node, the road's curvature linearised around the guess x."""
        road, path, t = situation.road, way.path, self.settings.grid.times_s
        kappa = road.curvature_at(x[:, 0])
        slope = (road.curvature_at(x[:, 0] + 1.0) - road.curvature_at(x[:, 0] - 1.0)) / 2.0
        values: dict[str, Any] = {
            "kappa": kappa,
            "kappa_slope": slope,
            "kappa_s": x[:, 0],
            "ref_start_s": path.start_s_m,
            "ref_start_d": path.start_d_m,
            "ref_amplitude": path.amplitude_m,
            "ref_a": path.a_per_m,
            "ref_b": path.b,
            "ref_bend": path.bend_m,
            "ref_bend_s": path.bend_s_m,
            "ref_bend_width": path.bend_width_m,
            "speed_ref": way.speed_mps,
            "grip": self.stage.friction_share * road.friction * GRAVITY_MPS2,
            "left_edge": road.left_edge_m,
            "right_edge": road.right_edge_m,
            "road_end": FAR_M if road.road_end_s_m is None else road.road_end_s_m - 0.5,
            **self._headway(situation, bodies, way),
        }
        for i in range(self.stage.neighbours):
            if i < len(bodies):
                body, motion = bodies[i], bodies[i].at(t)
                seat: tuple[Any, ...] = (motion.s_m, motion.d_m)
                along = 0.5 * body.length_m + self.stage.clearance_along_m + body.margin_along_m(t)
                across = 0.5 * body.width_m + self.stage.clearance_across_m + body.margin_across_m(t)
                seat += (along, across)
            else:
                seat = (-FAR_M, 0.0, 2.25, 0.9)
            values |= dict(zip((f"body{i}_s", f"body{i}_d", f"body{i}_along", f"body{i}_across"), seat, strict=True))
        return self.parameters.matrix(self.settings.grid.nodes, values)

    def _headway(self, situation: Situation, bodies: tuple[PredictedBody, ...], way: Way) -> dict[str, Any]:
        """Bumpers ahead and behind in the lane that the way ends in, from the time it gets there."""
        t, host, road = self.settings.grid.times_s, situation.host, situation.road
        arrival = 0.0
        target = way.path.start_d_m + way.path.amplitude_m
        if way.manoeuvre is not None:
            half = way.path.start_s_m + 0.6 * way.path.length_m
            arrival = max(half - host.s_m, 0.0) / max(host.speed_mps, 1.0)
            target = way.manoeuvre.target_d_m
        front_bumper, front_speed = np.full_like(t, FAR_M), np.zeros_like(t)
        rear_bumper, rear_speed = np.full_like(t, -FAR_M), np.zeros_like(t)
        for body in bodies:
            motion = body.at(t)
            if abs(float(motion.d_m[0]) - target) > 0.5 * road.lane_width_m:
                continue
            if float(motion.s_m[0]) > host.s_m:
                bumper = motion.s_m - 0.5 * body.length_m
                nearer = bumper < front_bumper
                front_bumper, front_speed = np.where(nearer, bumper, front_bumper), np.where(nearer, motion.speed_s_mps, front_speed)
            else:
                bumper = motion.s_m + 0.5 * body.length_m
                nearer = bumper > rear_bumper
                rear_bumper, rear_speed = np.where(nearer, bumper, rear_bumper), np.where(nearer, motion.speed_s_mps, rear_speed)
        early = t < arrival
        front_bumper[early], rear_bumper[early] = FAR_M, -FAR_M
        return {
            "front_bumper": front_bumper,
            "front_speed": front_speed,
            "rear_bumper": rear_bumper,
            "rear_speed": rear_speed,
        }

    def roll_out(self, situation: Situation, u: Array) -> Trajectory:
        """The inputs, kept inside their limits, driven through the equations of motion from the measured state."""
        vehicle, road, grid = self.vehicle, situation.road, self.settings.grid
        u = np.clip(u, self.problem.u_lower, self.problem.u_upper)
        x = [float(value) for value in situation.host.to_vector()]
        states = [x]
        straight = road.is_straight
        for k in range(grid.nodes):
            inputs = (float(u[k, 0]), float(u[k, 1]))

            def right_side(state: Any, inputs: tuple[float, float] = inputs) -> list[Any]:
                kappa = 0.0 if straight else float(road.curvature_at(state[0]))
                return road_bicycle(state, inputs, kappa, vehicle.wheelbase_m, vehicle.centre_m, math)

            x = rk4(right_side, x, float(grid.steps_s[k]))
            states.append(x)
        return Trajectory.from_states(grid.times_s, np.array(states), u)
