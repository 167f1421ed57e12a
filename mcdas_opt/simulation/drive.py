"""A drive so far: what happened, and what it amounts to."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from mcdas_opt.actuation.grip_monitor import GripMonitor
from mcdas_opt.catalogue.scenes import Scene
from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.plan import Plan
from mcdas_opt.domain.prediction import BodyMotion
from mcdas_opt.domain.rules import Array
from mcdas_opt.domain.track import Track
from mcdas_opt.domain.vocabulary import Status
from mcdas_opt.simulation.car import Car, PlantError
from mcdas_opt.simulation.contact import EDGE_SLACK_M, clearances, is_free, relative_speed, surroundings
from mcdas_opt.simulation.controller import Controller
from mcdas_opt.simulation.idm import STEP_S, step_times
from mcdas_opt.simulation.metrics import History, driven, lane_changed, settled_lanes, times_to_collision
from mcdas_opt.simulation.motion_sensors import MeasuredHost
from mcdas_opt.simulation.neighbours import Traffic, host_motion
from mcdas_opt.simulation.perception import Perception
from mcdas_opt.simulation.record import Cycle, CycleTimes, NeighbourHistory, Outcome, Simulation

_HARDER_MPS3 = 1.0


@dataclass(slots=True, kw_only=True)
class Drive:
    """Grows by `note` (a plan) and `advance` (one turn of plant and traffic). Any `outcome` but safe ends it."""

    scene: Scene
    traffic: Traffic
    car: Car
    host: MeasuredHost
    monitor: GripMonitor
    outcome: Outcome = Outcome.SAFE
    collided_with: str | None = None
    impact_speed_mps: float = 0.0
    states: list[tuple[float, ...]] = field(default_factory=list)
    inputs: list[tuple[float, float]] = field(default_factory=list)
    lateral: list[float] = field(default_factory=list)
    turning: list[tuple[float, ...]] = field(default_factory=list)  # sideslip, yaw rate, friction found; what the observer has of it
    turns: list[int] = field(default_factory=list)  # the first step of each
    cycles: list[Cycle] = field(default_factory=list)
    took_ms: list[float] = field(default_factory=list)

    def __post_init__(self) -> None:
        self._remember(self.car.state)

    def _remember(self, state: HostState) -> None:
        self.states.append(_numbers(state))
        aside, yaw_rate = state.turning(self.scene.vehicle.wheelbase_m)
        slip, known = self.host.slip, self.host.state
        told = (0.0, 0.0, math.nan) if slip is None else (slip.lateral_speed_mps, slip.lateral_speed_sd_mps, slip.friction)
        sideslip, sd = math.atan2(told[0], known.speed_mps), told[1] / max(known.speed_mps, 1.0)
        self.turning.append((math.atan2(aside, state.speed_mps), yaw_rate, self.monitor.friction, sideslip, sd, told[2]))

    def note(self, now: float, plan: Plan, tracks: tuple[Track, ...], took_ms: float) -> None:
        """A plan, the tracks that it was made with, and how long it took."""
        self.cycles.append(Cycle(time_s=now, host=self.car.state, tracks=tracks, plan=plan, took_ms=took_ms))
        self.took_ms.append(took_ms)

    def advance(self, plan: Plan, controller: Controller, steps: int, perception: Perception) -> None:
        """Moves the plant, then the traffic, through one turn. Stops at the first contact or departure from the road.

        Raises the plant's `PlantError` once everybody has been driven up to it.
        """
        first, state = len(self.states) - 1, self.car.state
        jerk = 0.0
        been, fault = [(state, self.host.state)], None
        self.turns.append(first)
        for k in range(steps):
            asked = plan.trajectory
            known, slip = self.host.state, self.host.slip
            braking = 0.0  # asked for; feedback may ask for less than the plan
            if slip is None or jerk < -_HARDER_MPS3:
                braking = float(np.interp(k * STEP_S, asked.t_s, asked.acceleration_mps2))
            self.monitor.note(known, braking, slip, self.host.measured_if_slips)
            jerk, rate = controller.command(asked, k * STEP_S, self.car.ahead(known, self.monitor.friction))
            try:
                applied = self.car.step(jerk, rate)
            except PlantError as error:
                fault = error
                break
            state = self.car.state
            self.host.look(state, applied)
            self.inputs.append((applied.jerk_mps3, applied.steering_rate_radps))
            self.lateral.append(applied.lateral_acceleration_mps2)
            self._remember(state)
            been.append((state, self.host.state))
        host = np.array(self.states[first:])
        self.traffic.advance(host_motion(host[:-1], self.traffic.road))
        others = self.traffic.motions_of_steps(first, len(host))
        end = self._check(host, others)
        for k, time_s in enumerate(step_times(first, end + 1).tolist()):
            if k == 0 or not perception.is_due(time_s):
                continue
            perception.look(time_s, *been[k], self.traffic.bodies_as([motion.part(k) for motion in others], time_s))
        if fault is not None and self.outcome is Outcome.SAFE:
            raise fault

    def _check(self, host: Array, others: tuple[BodyMotion, ...]) -> int:
        """Index of the last instant driven; sets the outcome and cuts the history where the drive ends within this turn."""
        vehicle, road, sizes = self.scene.vehicle, self.traffic.road, self.traffic.sizes
        if is_free(host, others, sizes, vehicle, road):
            return len(host) - 1
        around = surroundings(host, others, sizes, vehicle, road)
        touched = np.asarray(around.touching.any(axis=0))
        off = around.beyond_edge_m > EDGE_SLACK_M
        ends = np.flatnonzero(touched | off)
        end = int(ends[0]) if ends.size else len(host) - 1
        if ends.size and touched[end]:
            struck = int(np.flatnonzero(around.touching[:, end])[0])
            self.outcome, self.collided_with = Outcome.COLLISION, self.traffic.names[struck]
            self.impact_speed_mps = relative_speed(host[end], others[struck].part(end), vehicle, road)
        elif ends.size:
            self.outcome = Outcome.LEFT_ROAD
        cut = len(host) - 1 - end
        if cut:
            del self.states[-cut:], self.turning[-cut:], self.inputs[-cut:], self.lateral[-cut:]
        return end

    def summary(self, *, planner: str, seed: int, error: str = "") -> Simulation:
        scene, road, sizes = self.scene, self.traffic.road, self.traffic.sizes
        states = np.array(self.states)
        others = self.traffic.motions_of_steps(0, len(states))
        nearest = clearances(states, self.turns, others, sizes, scene.vehicle, road)
        sideslip, yaw_rate, friction, estimated, sd, felt = np.array(self.turning).T
        history = History(
            states=states,
            inputs=np.array(self.inputs).reshape(-1, 2),
            lateral_acceleration_mps2=np.array(self.lateral),
            clearance_m=nearest,
            sideslip_rad=sideslip,
            yaw_rate_radps=yaw_rate,
            friction=friction,
            sideslip_estimate_rad=estimated,
            sideslip_sd_rad=sd,
            friction_estimate=felt,
        )
        trajectory = driven(history)
        front, rear = times_to_collision(states, others, sizes, scene.vehicle, road)
        plans = [cycle.plan for cycle in self.cycles]
        reached = self._destination_reached_s(history)
        return Simulation(
            name=scene.name,
            planner=planner,
            plant=self.car.name,
            solver=next((plan.solver for plan in plans if plan.solver), ""),
            seed=seed,
            duration_s=float(history.t_s[-1]),
            outcome=self.outcome,
            collided_with=self.collided_with,
            impact_speed_mps=self.impact_speed_mps,
            min_clearance_m=float(nearest.min()) if self.traffic.names else None,
            min_ttc_front_s=front,
            min_ttc_rear_s=rear,
            max_lateral_acceleration_mps2=float(np.abs(history.lateral_acceleration_mps2).max(initial=0.0)),
            max_jerk_mps3=float(np.abs(history.inputs[:, 0]).max(initial=0.0)),
            max_steering_rate_radps=float(np.abs(history.inputs[:, 1]).max(initial=0.0)),
            lane_change_completed=lane_changed(history.states, road),
            lane_changes=len(settled_lanes(history.states, road)) - 1,
            modes=self._modes(),
            plans=len(plans),
            fallbacks=sum(plan.status is Status.FALLBACK for plan in plans),
            unavoidable=sum(plan.status is Status.UNAVOIDABLE for plan in plans),
            unverified_plans=sum(plan.status is not Status.UNAVOIDABLE and not plan.verdict.passed for plan in plans),
            cycle_ms=CycleTimes.of(self.took_ms),
            trajectory=trajectory,
            destination=plans[-1].destination if reached is None else "reached",
            destination_reached_s=reached,
            error=error,
            neighbours=self._neighbours(trajectory.t_s),
            scene=scene,
            cycles=tuple(self.cycles),
            history=history,
        )

    def _destination_reached_s(self, history: History) -> float | None:
        """When the host was first where it was to be, while it drove safely."""
        destination, road = self.scene.destination_to_reach, self.traffic.road
        if destination is None:
            return None
        for t, state in zip(history.t_s.tolist(), history.states, strict=True):
            if destination.is_reached(HostState.from_vector(state), t, road):
                return float(t)
        return None

    def _modes(self) -> tuple[tuple[float, str], ...]:
        """(time, mode) where the mode changes."""
        modes: list[tuple[float, str]] = []
        for cycle in self.cycles:
            if not modes or modes[-1][1] != cycle.plan.mode.value:
                modes.append((cycle.time_s, cycle.plan.mode.value))
        return tuple(modes)

    def _neighbours(self, t_s: Array) -> tuple[NeighbourHistory, ...]:
        rows = zip(self.traffic.names, self.traffic.sizes, self.traffic.motions(t_s), strict=True)
        return tuple(
            NeighbourHistory(
                name=name,
                length_m=length,
                width_m=width,
                s_m=motion.s_m,
                d_m=motion.d_m,
                heading_rad=motion.heading_rad,
                speed_mps=motion.speed_s_mps,
            )
            for name, (length, width), motion in rows
        )


def _numbers(state: HostState) -> tuple[float, ...]:
    return (state.s_m, state.d_m, state.heading_rad, state.speed_mps, state.acceleration_mps2, state.steering_rad)
