"""Legal drives to judge: random inputs, kept within a vehicle's limits as they are drawn, integrated by Runge-Kutta along the road."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.lane import Lane
from mcdas_opt.domain.prediction import BodyMotion, KnownBody, Prediction
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.trajectory import Trajectory
from mcdas_opt.domain.vehicle import GRAVITY_MPS2, Vehicle
from mcdas_opt.domain.verdict import Verdict
from mcdas_opt.domain.vocabulary import Side
from mcdas_opt.dynamics.bicycle import road_bicycle
from mcdas_opt.dynamics.integrator import rk4
from mcdas_opt.verification.judge import judge

SEDAN = Vehicle()
NOBODY = Prediction(name="nobody")
WIDE = Road(shoulder_left_m=80.0, shoulder_right_m=80.0)
BENDS = [((0.0, 0.0),), ((0.0, 0.0), (30.0, 0.012), (60.0, -0.01), (140.0, 0.008))]
WIDE_CURVED = Road(shoulder_left_m=60.0, shoulder_right_m=60.0, curvature=BENDS[1])


@dataclass(frozen=True, kw_only=True)
class Drive:
    """A trajectory with everything that it is judged with."""

    trajectory: Trajectory
    start: HostState
    vehicle: Vehicle
    road: Road
    prediction: Prediction = NOBODY

    def verdict(self, **changed) -> Verdict:
        drive = replace(self, **changed)
        return judge(drive.trajectory, drive.start, drive.vehicle, drive.road, drive.prediction)

    def with_columns(self, **columns) -> Drive:
        return replace(self, trajectory=replace(self.trajectory, **columns))


def names(verdict: Verdict) -> list[str]:
    return [violation.name for violation in verdict.violations]


def roll_out(x0, inputs, t, road, vehicle, substeps=8) -> Trajectory:
    """States at t under inputs held over each step; substeps end at a knot's either side closely enough."""
    straight = road.is_straight
    rows = [list(x0)]
    for u, h in zip(inputs, np.diff(t), strict=True):
        x = rows[-1]
        for _ in range(substeps):
            x = rk4(lambda q, u=u: _flow(q, u, road, straight, vehicle), x, h / substeps)
        rows.append(x)
    return Trajectory.from_states(t, np.array(rows), np.array(inputs))


def _flow(x, u, road, straight, vehicle):
    kappa = 0.0 if straight else float(road.curvature_at(x[0]))
    return road_bicycle(x, u, kappa, vehicle.wheelbase_m, vehicle.centre_m, math)


def legal(seed: int, road: Road = WIDE, vehicle: Vehicle = SEDAN, duration_s: float = 3.0) -> Drive:
    """A random legal drive: uneven samples, jerk and steering rate anywhere in their limits, friction used up to 95 %."""
    rng = np.random.default_rng(seed)
    steps = rng.choice([0.1, 0.08, 0.05, 0.02], p=[0.7, 0.1, 0.1, 0.1], size=200)
    steps = steps[: int(np.searchsorted(np.cumsum(steps), duration_s))]
    t = np.round(np.concatenate([[0.0], np.cumsum(steps)]), 9)
    v, a, delta = rng.uniform(0.5, 25.0), 0.0, 0.0
    kappa0 = float(road.curvature_at(0.0))
    start = HostState(
        d_m=rng.uniform(-1.0, 1.0), heading_rad=rng.uniform(-0.1, 0.1), speed_mps=v, steering_rad=math.atan(vehicle.wheelbase_m * kappa0)
    )
    grip = 0.95 * road.friction * GRAVITY_MPS2
    delta = start.steering_rad
    jerks = rng.uniform(vehicle.jerk_min_mps3, vehicle.jerk_max_mps3, len(steps))
    rates = rng.uniform(-1.0, 1.0, len(steps)) * vehicle.steering_rate_max_radps
    inputs = []
    for h, jerk, rate in zip(np.diff(t), jerks, rates, strict=True):
        floor = -math.sqrt(2.0 * vehicle.jerk_max_mps3 * max(v - 0.5, 0.0)) * 0.5  # leaves room to end braking before standstill
        low, high = max(vehicle.acceleration_min_mps2, floor, -0.7 * grip), min(vehicle.acceleration_max_mps2, 0.7 * grip)
        next_a = float(np.clip(a + jerk * h, low, high))
        next_a = float(np.clip(next_a, a + 0.99 * vehicle.jerk_min_mps3 * h, a + 0.99 * vehicle.jerk_max_mps3 * h))
        next_v = v + 0.5 * (a + next_a) * h
        fastest = max(v, next_v, 0.1) + 0.1
        widest = min(math.atan(vehicle.wheelbase_m * 0.65 * grip / fastest**2), vehicle.steering_max_rad)
        next_delta = float(np.clip(delta + rate * h, -widest, widest))
        next_delta = float(
            np.clip(next_delta, delta - 0.99 * vehicle.steering_rate_max_radps * h, delta + 0.99 * vehicle.steering_rate_max_radps * h)
        )
        inputs.append(((next_a - a) / h, (next_delta - delta) / h))
        v, a, delta = next_v, next_a, next_delta
    trajectory = roll_out(start.to_vector(), inputs, t, road, vehicle)
    return Drive(trajectory=trajectory, start=start, vehicle=vehicle, road=road)


def cruising(name, s, d, speed_s, speed_d=0.0, heading=None, length=4.5, width=1.8) -> KnownBody:
    """A body at constant velocity; its heading is its course unless given."""
    yaw = math.atan2(speed_d, speed_s) if heading is None else heading

    def motion(t):
        one = np.ones_like(t)
        return BodyMotion(
            s_m=s + speed_s * t, d_m=d + speed_d * t, heading_rad=yaw * one, speed_s_mps=speed_s * one, speed_d_mps=speed_d * one
        )

    return KnownBody(id=name, length_m=length, width_m=width, motion=motion)


def straight_on(speed=20.0, duration_s=3.0, road=WIDE, vehicle=SEDAN, step_s=0.1) -> Drive:
    """Constant speed along the host's lane of a straight road."""
    t = np.round(np.linspace(0.0, duration_s, round(duration_s / step_s) + 1), 9)
    x = np.zeros((t.size, 6))
    x[:, 0], x[:, 3] = speed * t, speed
    trajectory = Trajectory.from_states(t, x, np.zeros((t.size - 1, 2)))
    return Drive(trajectory=trajectory, start=HostState(speed_mps=speed), vehicle=vehicle, road=road)


def changing(seed: int, bend: tuple[tuple[float, float], ...]) -> Road:
    """A wide road that loses lanes to both sides within the drive."""
    rng = np.random.default_rng(seed)
    width = float(rng.uniform(6.0, 9.0))
    lanes = []
    for lane in (-1, 1):
        begin = float(rng.uniform(0.0, 40.0))
        if rng.random() < 0.5:
            lanes.append(Lane(lane=lane, width_m=((begin, width), (begin + float(rng.uniform(5.0, 40.0)), 0.0))))
        else:
            lanes.append(Lane(lane=lane, closed_m=((begin, begin + float(rng.uniform(1.0, 30.0))),)))
    lanes.append(Lane(lane=0, width_m=((10.0, width), (50.0, float(rng.uniform(2.5, width)))), merges=list(Side)[int(rng.integers(3))]))
    return Road(lane_width_m=width, lanes_left=1, lanes_right=1, lanes=tuple(lanes), curvature=bend)
