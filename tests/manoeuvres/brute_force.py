"""The truth about a way out: a much finer library, driven by the bicycle and judged, start by start."""

from __future__ import annotations

from itertools import product

import numpy as np
from numpy.typing import NDArray

from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.prediction import KnownBody, PredictedBody, Prediction
from mcdas_opt.domain.rules import Array
from mcdas_opt.domain.situation import Situation
from mcdas_opt.domain.trajectory import Trajectory
from mcdas_opt.domain.vehicle import GRAVITY_MPS2, Vehicle
from mcdas_opt.domain.vocabulary import Side
from mcdas_opt.manoeuvres.clearance import clearance
from mcdas_opt.manoeuvres.driven import driven
from mcdas_opt.manoeuvres.escapes import EscapeSettings
from mcdas_opt.manoeuvres.family import Demand, Rolled, roll_out
from mcdas_opt.manoeuvres.held import held
from mcdas_opt.manoeuvres.kinds import next_lane_m
from mcdas_opt.manoeuvres.phases import Phases
from mcdas_opt.manoeuvres.sidesteps import Sidesteps
from mcdas_opt.verification.judge import judge

CLEAR_S = 4.0
TIMES = np.round(np.arange(81) * 0.05, 9)


def later(body: PredictedBody, start_s: float) -> KnownBody:
    return KnownBody(id=body.id, length_m=body.length_m, width_m=body.width_m, motion=lambda t: body.at(t + start_s))


def host_at(situation: Situation, vehicle: Vehicle, start_s: float) -> HostState:
    """The host after keeping its acceleration and steering for `start_s`."""
    times = np.linspace(0.0, max(start_s, 1e-3), 2001)
    path = held(situation.host, times, vehicle, situation.road)
    row = [float(q[-1 if start_s > 0.0 else 0]) for q in (path.s_m, path.d_m, path.heading_rad, path.speed_mps)]
    return HostState.from_vector(np.array([*row, float(path.acceleration_mps2[-1]), situation.host.steering_rad]))


def rows_of(kind: str, situation: Situation, vehicle: Vehicle, speed: float, bodies: tuple[PredictedBody, ...]) -> Array:
    """(M, 7): first, until, then, target, lateral, b."""
    host, road = situation.host, situation.road
    grip = road.friction * GRAVITY_MPS2
    brake, accelerate = min(-vehicle.acceleration_min_mps2, grip), min(vehicle.acceleration_max_mps2, grip)
    keep = road.lane_centre_m(road.lane_of(host.d_m))
    if kind in ("brake", "accelerate"):
        most = -brake if kind == "brake" else accelerate
        rows = []
        for share in (*np.linspace(0.12, 1.0, 23), *EscapeSettings().levels):
            level = share * most
            ends = [99.0, 0.5, 1.0, 1.5, 2.0, 3.0, *EscapeSettings().phases_s]
            for body in bodies:
                ends.append(max((float(body.at(np.zeros(1)).speed_s_mps[0]) - speed) / level, 0.0))
            rows += [(level, end, 0.0, keep, push, 50.0) for end in ends if end >= 0.5 for push in (min(1.0, 0.2 * grip),)]
        return np.array(rows)
    target = next_lane_m(situation, vehicle, Side.LEFT if kind == "left" else Side.RIGHT)
    if target is None:
        return np.zeros((0, 6))
    laterals = [share * grip for share in (0.15, 0.25, 0.35, 0.45, 0.55, 0.65, 0.72, 0.8, 0.86, 0.9, 0.94, 0.98)]
    paces = [(0.0, 9.0)] + [(x * accelerate, t) for x in (0.4, 0.9) for t in (1.0, 9.0)]
    paces += [(-x * brake, t) for x in (0.2, 0.4, 0.6, 0.75, 0.9) for t in (0.8, 1.5, 9.0)]
    rows = [(a, t, 0.0, target, push, b) for push, b, (a, t) in product(laterals, (50.0, 20.0, 12.0, 8.0, 5.0), paces)]
    for share, b, pace, until in EscapeSettings().sideways:
        rows.append((pace * (accelerate if pace > 0.0 else brake), until, 0.0, target, share * grip, b))
    return np.array(rows)


def sound(kind: str, situation: Situation, vehicle: Vehicle, prediction: Prediction, start_s: float) -> Trajectory | None:
    """A drive of that kind from `start_s` on that the judge passes and that ends with room; None when the library holds none."""
    begin = host_at(situation, vehicle, start_s)
    bodies = tuple(later(body, start_s) for body in prediction.bodies)
    rows = rows_of(kind, situation, vehicle, begin.speed_mps, bodies)
    if not len(rows):
        return None
    first, until, then, target, push, b = rows.T
    phases = Phases(first_mps2=first, switch_s=until, then_mps2=then)
    steps = Sidesteps(target_d_m=target, lateral_mps2=push, delay_s=np.zeros(len(rows)), b=b)
    road = situation.road
    rolled = roll_out(phases, steps, TIMES, begin, vehicle, road, Demand(friction=1.02, steering=1.4))
    least = clearance(rolled.ways, TIMES, bodies, vehicle, road).separation_m.min(-1)
    least = np.where(rolled.possible & rolled.on_road, least, -np.inf)
    least = np.where(room_at_end(rolled, situation, vehicle, bodies), least, -np.inf)
    order = np.argsort(-least, kind="stable")
    order = order[least[order] > -0.1][:24]
    for i in range(0, order.size, 8):
        some = order[i : i + 8]
        fine = roll_out(phases[some], steps[some], TIMES, begin, vehicle, road, Demand(friction=1.02))
        for one in driven(fine, begin, vehicle, road):
            passed = judge(one, begin, vehicle, road, Prediction(name="truth", bodies=bodies)).passed
            if passed and ends_with_room(one, situation, vehicle, bodies):
                return one
    return None


def room_at_end(rolled: Rolled, situation: Situation, vehicle: Vehicle, bodies: tuple[PredictedBody, ...]) -> NDArray[np.bool_]:
    """(M,) The same as `ends_with_room`, of the family's own motions: which are worth driving."""
    ends = zip(rolled.ways.s_m[:, -1], rolled.ways.d_m[:, -1], rolled.speeds.speed_mps[:, -1], strict=True)
    return np.array([has_room(s, d, v, CLEAR_S, situation, vehicle, bodies) for s, d, v in ends])


def ends_with_room(drive: Trajectory, situation: Situation, vehicle: Vehicle, bodies: tuple[PredictedBody, ...]) -> bool:
    return has_room(drive.s_m[-1], drive.d_m[-1], drive.speed_mps[-1], CLEAR_S, situation, vehicle, bodies)


def has_room(s: float, d: float, v: float, end_s: float, situation: Situation, vehicle: Vehicle, bodies: tuple[PredictedBody, ...]) -> bool:
    """Nobody in the way closes in faster than braking, or accelerating, can end."""
    grip = situation.road.friction * GRAVITY_MPS2
    for body in bodies:
        motion = body.at(np.array([end_s]))
        apart = float(motion.s_m[0]) - s
        if abs(float(motion.d_m[0]) - d) >= 0.5 * (body.width_m + vehicle.width_m):
            continue
        closing = (v - float(motion.speed_s_mps[0])) * np.sign(apart)
        most = min(-vehicle.acceleration_min_mps2 if apart > 0.0 else vehicle.acceleration_max_mps2, grip)
        if closing > 0.0 and closing**2 > 2.0 * most * max(abs(apart) - 0.5 * (vehicle.length_m + body.length_m), 0.0):
            return False
    return True
