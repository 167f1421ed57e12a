"""CommonRoad's reactive planner as a method, through its public interface: sampled polynomials in the Frenet frame.

Source: Werling, Ziegler, Kammel, Thrun, ICRA 2010; package commonroad-reactive-planner of TU Munich. It is told what every method is
told; its answers are judged as they are. Extra `commonroad-planner`, and then the package itself: `pip install --no-deps` of `PACKAGES`.
"""

from __future__ import annotations

import time
from dataclasses import dataclass
from types import SimpleNamespace
from typing import Any

import numpy as np

from mcdas_opt.baselines.lane import LaneMethod, judged, strongest_braking_mps2
from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.plan import Candidate, Plan, Timing
from mcdas_opt.domain.prediction import Prediction
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.rules import Array
from mcdas_opt.domain.settings import Settings
from mcdas_opt.domain.situation import Situation
from mcdas_opt.domain.trajectory import Trajectory
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.domain.vocabulary import Mode, Side
from mcdas_opt.errors import of_extra
from mcdas_opt.geometry.frenet import FrenetFrame
from mcdas_opt.planning.memory import carried
from mcdas_opt.tracking.prediction import predict_for
from mcdas_opt.verification.judge import judge

# They pin osqp 0.6, ours needs 1.0: pip can install both sides only apart. What they do with it (smoothing a line) is not asked for here.
PACKAGES = ("commonroad-clcs==2025.1.1", "commonroad-route-planner==2025.1.0", "commonroad-reactive-planner==2025.1")
STEP_S = 0.1
_STEPS = 40
_AGAIN_S = 0.3  # the package's own replanning frequency: every third step
_BEHIND_M, _AHEAD_M = 120.0, 600.0  # of the reference line around the place where it was laid
_KEPT_M = 250.0  # of it that must lie ahead, or it is laid anew
_SPACING_M = 2.0  # of the reference line's points
_WALL_M, _SEGMENT_M = 1.0, 5.0  # half depth and length of the pieces of the road's edges
_STEADY_MPS2 = 0.2


@dataclass(frozen=True, slots=True, kw_only=True)
class ActivePlan:
    """A trajectory of the package, driven for three steps; handed from cycle to cycle."""

    planned_s: float
    trajectory: Trajectory


@dataclass(frozen=True, slots=True, kw_only=True)
class FullBraking:
    """What is done, for three steps too, when no sample is free of collisions: the package itself leaves that open."""

    planned_s: float
    strength_mps2: float

    def wanted_mps2(self, t_s: float, s_m: float, speed_mps: float) -> float:
        return -self.strength_mps2


class ReactiveMethod(LaneMethod):
    """The package's defaults stand (four sampling levels, its cost, a plan every 0.3 s), but for the vehicle's size and limits, the
    width of the road for the lateral samples, and a horizon of 4 s. It knows no friction circle. When no sample is free it brakes in its
    lane until it plans again. Raises `MissingExtraError` where the package is not installed."""

    name = "commonroad-reactive"

    def __init__(self, vehicle: Vehicle, settings: Settings | None = None) -> None:
        super().__init__(vehicle, settings)
        self._package = _package()
        self._planner: Any = None
        self._road: Road | None = None
        self._from_s_m = 0.0
        self._line: Any = None
        self._frame = FrenetFrame(road=Road())

    def drive(self, situation: Situation, previous: Plan | None) -> Plan:
        started = time.perf_counter()
        prediction = predict_for(situation, self.settings.prediction)
        self._lay(situation)
        before = carried(previous, ActivePlan) or carried(previous, FullBraking)
        if before is not None and situation.time_s - before.planned_s < _AGAIN_S - 1e-6:
            if isinstance(before, FullBraking):
                return self._braking(situation, before)
            return self._plan(situation, prediction, before, "goes on", started)
        trajectory = self._found(situation, prediction)
        if trajectory is None:
            strongest = strongest_braking_mps2(situation, self.vehicle)
            return self._braking(situation, FullBraking(planned_s=situation.time_s, strength_mps2=strongest))
        active = ActivePlan(planned_s=situation.time_s, trajectory=trajectory)
        return self._plan(situation, prediction, active, f"cheapest free one of {self._planner.total_count_samples} samples", started)

    def _braking(self, situation: Situation, law: FullBraking) -> Plan:
        why = "no sample is free: brakes"
        return judged(self.name, situation, self.vehicle, self.settings, law=law, reason=why, warning=True, memory=law)

    def _plan(self, situation: Situation, prediction: Prediction, active: ActivePlan, reason: str, started: float) -> Plan:
        trajectory = _from(active.trajectory, situation.time_s - active.planned_s)
        solved = time.perf_counter()
        verdict = judge(trajectory, situation.host, self.vehicle, situation.road, prediction)
        mode, side = _meaning(trajectory, situation.road)
        return Plan(
            planner=self.name,
            mode=mode,
            side=side,
            reason=reason,
            verdict=verdict,
            prediction=prediction.name,
            trajectory=trajectory,
            candidates=(Candidate(name=mode.value, cost=None, passed=verdict.passed, refusal="" if verdict.passed else verdict.reason),),
            timing_ms=Timing(solve=1e3 * (solved - started), verify=1e3 * (time.perf_counter() - solved)),
            chosen=mode.value,
            time_s=situation.time_s,
            memory=active,
        )

    def _lay(self, situation: Situation) -> None:
        """The reference line around the host, and the planner on it; anew where the road is another, or the line's end comes near."""
        s, road = situation.host.s_m, situation.road
        if self._road == road and 0.0 <= s - self._from_s_m <= _AHEAD_M - _KEPT_M:
            return
        self._road, self._from_s_m = road, s
        along = np.arange(s - _BEHIND_M, s + _AHEAD_M, _SPACING_M)
        self._frame = FrenetFrame(road=road, s_min_m=min(s - 2.0 * _BEHIND_M, 0.0), s_max_m=max(s + 1.2 * _AHEAD_M, 0.0))
        x, y, _ = self._frame.to_plane(along, np.zeros_like(along), np.zeros_like(along))
        self._line = self._package.line(np.column_stack([x, y]), preprocess_reference=False, clcs_params=self._package.line_settings())
        self._planner = self._package.planner(self._configuration(situation))

    def _configuration(self, situation: Situation) -> Any:
        config, car = self._package.configuration(), self.vehicle
        config.debug.multiproc, config.debug.draw_traj_set, config.debug.logging_level = False, False, "CRITICAL"
        config.planning.dt, config.planning.time_steps_computation = STEP_S, _STEPS
        config.vehicle = type(config.vehicle)(
            length=car.length_m,
            width=car.width_m,
            wb_rear_axle=car.centre_m,
            wb_front_axle=car.wheelbase_m - car.centre_m,
            a_max=strongest_braking_mps2(situation, car),
            delta_min=-car.steering_max_rad,
            delta_max=car.steering_max_rad,
            v_delta_min=-car.steering_rate_max_radps,
            v_delta_max=car.steering_rate_max_radps,
        )
        half = 0.5 * car.width_m
        config.sampling.d_min, config.sampling.d_max = situation.road.right_edge_m + half, situation.road.left_edge_m - half
        config.update(scenario=self._package.scenario(dt=STEP_S), planning_problem=None)
        return config

    def _found(self, situation: Situation, prediction: Prediction) -> Trajectory | None:
        """The package's answer as a trajectory of ours."""
        host = situation.host
        x, y, yaw = (float(q) for q in self._frame.to_plane(*(np.array(q) for q in (host.s_m, host.d_m, host.heading_rad))))
        centre = self.vehicle.centre_m
        start = self._package.state(
            time_step=0,
            position=np.array([x - centre * np.cos(yaw), y - centre * np.sin(yaw)]),
            orientation=yaw,
            velocity=host.speed_mps,
            acceleration=host.acceleration_mps2,
            steering_angle=host.steering_rad,
            yaw_rate=host.speed_mps * float(np.tan(host.steering_rad)) / self.vehicle.wheelbase_m,
        )
        self._planner.reset(
            initial_state_cart=start, collision_checker=self._obstacles(situation, prediction), coordinate_system=self._line
        )
        self._planner.set_desired_velocity(desired_velocity=situation.wanted_speed_mps, current_speed=max(host.speed_mps, 0.01))
        answer = self._planner.plan()
        return None if answer is None else self._trajectory(answer[0].state_list, host)

    def _obstacles(self, situation: Situation, prediction: Prediction) -> Any:
        """The neighbours where they are predicted, and the road's edges."""
        shapes, road = self._package.shapes, situation.road
        checker = shapes.CollisionChecker()
        t = STEP_S * np.arange(_STEPS + 1)
        for body in prediction.bodies:
            motion = body.at(t)
            if np.abs(motion.s_m - situation.host.s_m).max() > _BEHIND_M + _AHEAD_M:
                continue
            moving = shapes.TimeVariantCollisionObject(0)
            for x, y, yaw in zip(*self._frame.to_plane(motion.s_m, motion.d_m, motion.heading_rad), strict=True):
                moving.append_obstacle(shapes.RectOBB(0.5 * body.length_m, 0.5 * body.width_m, float(yaw), float(x), float(y)))
            checker.add_collision_object(moving)
        edges = shapes.ShapeGroup()
        s = np.arange(situation.host.s_m - 20.0, situation.host.s_m + _KEPT_M, _SEGMENT_M)
        for d in (road.left_edge_m + _WALL_M, road.right_edge_m - _WALL_M):
            for x, y, yaw in zip(*self._frame.to_plane(s, np.full_like(s, d), np.zeros_like(s)), strict=True):
                edges.add_shape(shapes.RectOBB(0.55 * _SEGMENT_M, _WALL_M, float(yaw), float(x), float(y)))
        if road.road_end_s_m is not None:
            x, y, yaw = (float(q) for q in self._frame.to_plane(*(np.array(q) for q in (road.road_end_s_m + _WALL_M, 0.0, 0.0))))
            edges.add_shape(shapes.RectOBB(_WALL_M, road.left_edge_m - road.right_edge_m, yaw, x, y))
        checker.add_collision_object(edges)
        return checker

    def _trajectory(self, found: Any, host: HostState) -> Trajectory:
        """Rear-axle states every 0.1 s, put into the road's frame at the body centre; inputs are their differences."""
        x, y, yaw, v, a, delta = np.array(
            [[*one.position, one.orientation, one.velocity, one.acceleration, one.steering_angle] for one in found], dtype=np.float64
        ).T
        centre = self.vehicle.centre_m
        s, d, psi = self._frame.to_road(x + centre * np.cos(yaw), y + centre * np.sin(yaw), yaw, near_s_m=host.s_m)
        states = np.column_stack([s, d, psi, v, a, delta])
        inputs = np.diff(np.column_stack([a, delta]), axis=0) / STEP_S
        return Trajectory.from_states(np.round(STEP_S * np.arange(len(states)), 9), states, inputs)


def _from(trajectory: Trajectory, since_s: float) -> Trajectory:
    """The rest of a trajectory after some of its steps; at least its last two samples."""
    first = min(round(since_s / STEP_S), len(trajectory) - 2)
    if first <= 0:
        return trajectory
    t: Array = np.round(trajectory.t_s[first:] - trajectory.t_s[first], 9)
    return Trajectory.from_states(t, trajectory.states[first:], trajectory.inputs[first:])


def _meaning(trajectory: Trajectory, road: Road) -> tuple[Mode, Side]:
    """What the plan does, in the contract's words."""
    last, first = (road.lane_of(float(trajectory.d_m[k]), float(trajectory.s_m[k])) for k in (-1, 0))
    lanes = last - first
    if lanes:
        return Mode.EVADE, Side.LEFT if lanes > 0 else Side.RIGHT
    change = float(trajectory.speed_mps[-1] - trajectory.speed_mps[0]) / float(trajectory.t_s[-1])
    if abs(change) < _STEADY_MPS2:
        return Mode.HOLD, Side.NONE
    return (Mode.BRAKE if change < 0.0 else Mode.ACCELERATE), Side.NONE


def _package() -> SimpleNamespace:
    """What is used of the extra's packages."""
    with of_extra("commonroad-reactive-planner", "commonroad-planner", f"pip install --no-deps {' '.join(PACKAGES)}"):
        import commonroad_dc.pycrcc as shapes
        from commonroad.scenario.scenario import Scenario
        from commonroad_clcs.config import CLCSParams
        from commonroad_rp.reactive_planner import ReactivePlanner
        from commonroad_rp.state import ReactivePlannerState
        from commonroad_rp.utility.config import ReactivePlannerConfiguration
        from commonroad_rp.utility.utils_coordinate_system import CoordinateSystem
    return SimpleNamespace(
        planner=ReactivePlanner,
        configuration=ReactivePlannerConfiguration,
        state=ReactivePlannerState,
        line=CoordinateSystem,
        line_settings=CLCSParams,
        scenario=Scenario,
        shapes=shapes,
    )
