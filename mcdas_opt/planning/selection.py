"""What a plan is worth, in one currency for every way, and how bad an unavoidable one is."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from mcdas_opt.domain.prediction import CruisingBody, PredictedBody, Prediction
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.rules import Array
from mcdas_opt.domain.trajectory import Trajectory
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.domain.vocabulary import Side
from mcdas_opt.dynamics.bicycle import lateral_acceleration
from mcdas_opt.geometry.window import frame_near
from mcdas_opt.planning.separations import separations


@dataclass(frozen=True, slots=True, kw_only=True)
class WorthSettings:
    """Prices per second of plan, except where noted."""

    acceleration: float = 0.04  # per (m/s^2)^2
    lateral_acceleration: float = 0.08  # per (m/s^2)^2
    jerk: float = 0.001  # per (m/s^3)^2
    speed: float = 0.03  # per (m/s)^2 off the desired speed
    lane_change: float = 2.0  # once
    other_side: float = 0.3  # once, for steering to the side that the front vehicle's offset leans to
    waiting: float = 1.5  # once, for a way that begins later: what is left open now may close
    needless: float = 1.5  # once, for steering out where the selector finds braking or accelerating enough
    nearness: float = 6.0  # per exp(-gap / 0.7 m)
    end_closing: float = 4.0  # once, per (m/s)^2 of closing speed at the end, over the gap then in metres
    end_room_m: float = 0.5  # whoever ends less than this beside the host's flank counts as before or behind it
    persistence: float = 0.5  # factor on what was chosen before
    risen: float = 1.25  # a manoeuvre under way goes on alone until its price is so many times what it was when ways were compared
    notable: float = 0.04  # where nothing threatens, what is driven without an optimiser must be cheaper by so much


@dataclass(frozen=True, slots=True)
class Nearness:
    """Of so many drives: their tables (drives, 9, n), signed separations (drives, bodies, n) of the host's body from every predicted one
    [m], the deepest of each (drives, bodies), and where those bodies are at the end: s, d, speed."""

    tables: Array
    separation_m: Array
    deepest_m: Array
    ends: tuple[tuple[float, float, float], ...]


def nearness(trajectories: Sequence[Trajectory], vehicle: Vehicle, road: Road, prediction: Prediction) -> Nearness:
    """Of at least one trajectory; all are sampled at the same times."""
    tables = trajectories[0].table[None] if len(trajectories) == 1 else np.array([one.table for one in trajectories])
    return nearness_of(tables, trajectories[0].t_s, vehicle, road, prediction)


def nearness_of(tables: Array, t_s: Array, vehicle: Vehicle, road: Road, prediction: Prediction) -> Nearness:
    """`nearness` of drives that are tables (drives, 9, n) at these times."""
    bodies, rows = prediction.bodies, prediction.rows_on(t_s)
    places = rows.s_m
    frame = frame_near(road, float(tables[0, 1, 0]))
    if not road.is_straight:  # who is beyond the frame is far enough away there too
        places = np.clip(places, frame.s_min_m, frame.s_max_m)
    x, y, yaw = frame.to_plane(places, rows.d_m, rows.heading_rad)
    hosts = frame.to_plane(tables[:, 1], tables[:, 2], tables[:, 3])
    halves = np.array([(0.5 * body.length_m, 0.5 * body.width_m) for body in bodies]).reshape(-1, 2)
    separation = separations(hosts, (x, y, yaw), (0.5 * vehicle.length_m, 0.5 * vehicle.width_m), halves)
    ends = tuple(zip(rows.s_m[:, -1].tolist(), rows.d_m[:, -1].tolist(), rows.speed_s_mps[:, -1].tolist(), strict=True))
    deepest = np.minimum.reduce(separation, axis=-1) if bodies else np.zeros((len(tables), 0))
    return Nearness(tables, separation, deepest, ends)


def worth(
    trajectory: Trajectory,
    *,
    vehicle: Vehicle,
    road: Road,
    prediction: Prediction,
    desired_speed_mps: float,
    side: Side,
    leaning: Side,
    needless: bool,
    settings: WorthSettings,
) -> float:
    """The price of a plan: what it is worth as it is driven, and what it costs to leave the lane to `side`."""
    near = nearness((trajectory,), vehicle, road, prediction)
    (driven,) = worths(near, vehicle=vehicle, prediction=prediction, desired_speed_mps=desired_speed_mps, settings=settings)
    return driven + steering_price(side, leaning, needless, settings)


def worths(near: Nearness, *, vehicle: Vehicle, prediction: Prediction, desired_speed_mps: float, settings: WorthSettings) -> list[float]:
    """Of each of the drives the price of discomfort, departure from the desired speed, nearness to others, and how it leaves things at
    its end; without the price of steering."""
    drives = near.tables
    t, v, a = drives[0, 0], drives[:, 4], drives[:, 5]
    lateral = lateral_acceleration(v, drives[:, 6], vehicle.wheelbase_m, np)
    rate = settings.acceleration * a**2 + settings.lateral_acceleration * lateral**2 + settings.jerk * drives[:, 8] ** 2
    rate = rate + settings.speed * (v - desired_speed_mps) ** 2
    if near.ends:
        closest = np.minimum.reduce(near.separation_m, axis=1)
        rate = rate + settings.nearness * np.exp(-np.maximum(closest, 0.0) / 0.7)
    totals: list[float] = np.add.reduce(0.5 * (rate[:, 1:] + rate[:, :-1]) * (t[1:] - t[:-1]), axis=1).tolist()
    if not near.ends:
        return totals
    widths = [0.5 * (body.width_m + vehicle.width_m) for body in prediction.bodies]
    ends, gaps = drives[:, 1:5, -1].tolist(), near.separation_m[:, :, -1].tolist()
    for i, ((end_s, end_d, _, end_v), its_gaps) in enumerate(zip(ends, gaps, strict=True)):
        for width, (s, d, speed), gap in zip(widths, near.ends, its_gaps, strict=True):
            if abs(d - end_d) - width > settings.end_room_m:
                continue
            closing = max(end_v - speed if s > end_s else speed - end_v, 0.0)
            totals[i] += settings.end_closing * closing**2 / max(gap, 1.0)
    return totals


def steering_price(side: Side, leaning: Side, needless: bool, settings: WorthSettings) -> float:
    """What leaving the lane to `side` costs beside what is driven; nothing for keeping it."""
    if side is Side.NONE:
        return 0.0
    other = leaning is not Side.NONE and side is not leaning
    return settings.lane_change + (settings.other_side if other else 0.0) + (settings.needless if needless else 0.0)


_OFF_THE_ROAD, _THIRD_VEHICLE = 1e3, 1e2  # m/s added: worse than any impact with the vehicles that threaten
_ON_THE_EDGE_M = 0.02  # a corner so far over the road's edge is rounding
_LEAST_SHARE = 0.5
_SHARES = (1.0, 0.75, 0.5, 0.25, 0.0)  # of a lane change foretold


def severity(trajectory: Trajectory, vehicle: Vehicle, road: Road, prediction: Prediction) -> tuple[float, float]:
    """(equivalent impact speed [m/s], minus the time [s]) of the first overlap; (0, -inf) when there is none. Leaving the road is
    worst, the farther the worse.

    The equivalent speed is the relative speed times the square root of the share of the narrower body's width that overlaps: the energy is
    taken as absorbed over that share. At least a half counts: a graze is not to be bought with braking that a moment later is missed.
    Whoever was not in the host's lane is a third vehicle, not to be hit to spare oneself; the road's end is a wall.

    Who may be changing lanes is foretold to come as fast as is believed of anybody, while who brakes or accelerates is foretold to do what
    he shows. So the speed is the mean over lane changes of all shares of that one: what fails only if he comes that fast is less severe
    than what fails in any case, as braking beside him. A model of this project, to rank ways out, not to predict injuries.
    """
    return severities((trajectory,), vehicle, road, prediction)[0]


def severity_in_words(speed_mps: float) -> str:
    """What a severity stands for."""
    if speed_mps >= _OFF_THE_ROAD:
        return "leaves the road"
    if speed_mps >= _THIRD_VEHICLE:
        return f"hits a third vehicle, equivalent to {speed_mps - _THIRD_VEHICLE:.1f} m/s"
    return f"equivalent to {speed_mps:.1f} m/s"


def severities(trajectories: Sequence[Trajectory], vehicle: Vehicle, road: Road, prediction: Prediction) -> list[tuple[float, float]]:
    """`severity` of each; those that are sampled at the same times in one go."""
    groups: dict[bytes, list[int]] = {}
    for i, trajectory in enumerate(trajectories):
        groups.setdefault(trajectory.t_s.tobytes(), []).append(i)
    found: dict[int, list[tuple[float, float]]] = {}
    for supposed in _slower_changes(prediction):
        for group in groups.values():
            near = nearness([trajectories[i] for i in group], vehicle, road, supposed)
            for i, separation in zip(group, near.separation_m, strict=True):
                found.setdefault(i, []).append(_severity(trajectories[i], vehicle, road, supposed, separation))
    each = (found[i] for i in range(len(trajectories)))
    return [(sum(speed for speed, _ in of) / len(of), of[0][1]) for of in each]


def _slower_changes(prediction: Prediction) -> list[Prediction]:
    """The prediction, and the same with everybody who may be changing lanes coming only some share as far, down to hardly at all."""
    if not any(isinstance(body, CruisingBody) and body.lateral_swell > 0.0 for body in prediction.bodies):
        return [prediction]
    return [Prediction(name=prediction.name, bodies=tuple(_slower(body, share) for body in prediction.bodies)) for share in _SHARES]


def _slower(body: PredictedBody, share: float) -> PredictedBody:
    return replace(body, lateral_swell=share * body.lateral_swell) if isinstance(body, CruisingBody) else body


def _severity(trajectory: Trajectory, vehicle: Vehicle, road: Road, prediction: Prediction, separations: Array) -> tuple[float, float]:
    reach = 0.5 * (vehicle.width_m * np.cos(trajectory.heading_rad) + vehicle.length_m * np.abs(np.sin(trajectory.heading_rad)))
    beyond = float(np.maximum(trajectory.d_m + reach - road.left_edge_m, road.right_edge_m - trajectory.d_m + reach).max())
    if beyond > _ON_THE_EDGE_M:
        return (_OFF_THE_ROAD + beyond, 0.0)
    hits = [(int(np.argmax(row <= 0.0)), i) for i, row in enumerate(separations) if np.any(row <= 0.0)]
    if road.road_end_s_m is not None:
        over = trajectory.s_m + 0.5 * vehicle.length_m > road.road_end_s_m
        k = int(np.argmax(over))
        if over.any() and (not hits or k <= min(hits)[0]):  # the road's end is a wall
            return (float(trajectory.speed_mps[k]), -float(trajectory.t_s[k]))
    if not hits:
        return (0.0, float("-inf"))
    k, index = min(hits)
    body = prediction.bodies[index]
    motion = body.at(trajectory.t_s[k : k + 1])
    psi, v = float(trajectory.heading_rad[k]), float(trajectory.speed_mps[k])
    ds = v * np.cos(psi) - float(motion.speed_s_mps[0])
    dd = v * np.sin(psi) - float(motion.speed_d_mps[0])
    overlap = 0.5 * (vehicle.width_m + body.width_m) - abs(float(trajectory.d_m[k]) - float(motion.d_m[0]))
    share = min(max(overlap / min(vehicle.width_m, body.width_m), _LEAST_SHARE), 1.0)
    beside = abs(float(body.at(np.zeros(1)).d_m[0]) - float(trajectory.d_m[0])) - 0.5 * body.width_m
    third = _THIRD_VEHICLE if beside > 0.5 * road.lane_width_m - 0.2 else 0.0
    return (third + float(np.hypot(ds, dd)) * share**0.5, -float(trajectory.t_s[k]))
