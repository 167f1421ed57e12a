"""A path of arcs with stops for steering, and the timed trajectory that drives it."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from mcdas_opt.domain.parking import ParkingCase, ParkingTrajectory
from mcdas_opt.domain.rules import Array
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.dynamics.rollout import roll_out
from mcdas_opt.errors import ParameterError

SAMPLE_S = 0.05
_LONGEST_S = 600.0  # nobody parks for longer


class Arc(NamedTuple):
    """A piece of constant curvature [1/m], driven over a signed length [m] (negative in reverse)."""

    curvature: float
    length: float

    @property
    def gear(self) -> float:
        """+1 forward, -1 in reverse."""
        return 1.0 if self.length > 0.0 else -1.0


def along_arc(pose: Array, curvature: Array, distance: Array) -> Array:
    """(..., 3): poses after signed `distance` [m] along arcs of `curvature` [1/m] from poses (..., 3); exact also for straight lines."""
    turn = curvature * distance
    half = 0.5 * turn
    chord = distance * np.sinc(half / np.pi)
    heading = pose[..., 2] + half
    return np.stack([pose[..., 0] + chord * np.cos(heading), pose[..., 1] + chord * np.sin(heading), pose[..., 2] + turn], axis=-1)


@dataclass(frozen=True, slots=True)
class ArcPath:
    """Arcs from the case's start to its goal."""

    start: Array
    arcs: tuple[Arc, ...]

    @property
    def gear_changes(self) -> int:
        return sum(a.gear != b.gear for a, b in pairwise(self.arcs))

    @property
    def gear_length_m(self) -> float:
        """Metres driven in a gear, on average."""
        return sum(abs(arc.length) for arc in self.arcs) / (self.gear_changes + 1)

    @property
    def poses(self) -> Array:
        """(n + 1, 3): the start and the end of every arc."""
        poses = [np.asarray(self.start, dtype=np.float64)]
        for arc in self.arcs:
            poses.append(along_arc(poses[-1], np.asarray(arc.curvature), np.asarray(arc.length)))
        return np.array(poses)


def merged(arcs: list[Arc]) -> tuple[Arc, ...]:
    """Without empty arcs; neighbours of one gear and one curvature become one."""
    kept: list[Arc] = []
    for arc in arcs:
        if abs(arc.length) < 1e-6:
            continue
        if kept and abs(kept[-1].curvature - arc.curvature) < 1e-12 and kept[-1].length * arc.length > 0.0:
            kept[-1] = Arc(arc.curvature, kept[-1].length + arc.length)
        else:
            kept.append(arc)
    return tuple(kept)


def backwards(arcs: tuple[Arc, ...]) -> tuple[Arc, ...]:
    """The arcs driven from the last one's end to the first one's start."""
    return tuple(Arc(arc.curvature, -arc.length) for arc in reversed(arcs))


def reversed_path(path: ArcPath) -> ArcPath:
    """The same path driven from its end to its start."""
    return ArcPath(path.poses[-1], backwards(path.arcs))


def top_curvature(vehicle: Vehicle) -> float:
    """The largest curvature [1/m] that the steering angle allows."""
    return float(np.tan(vehicle.steering_max_rad)) / vehicle.wheelbase_m


def steering_on(case: ParkingCase, arc: Arc) -> float:
    """The steering angle [rad] of an arc, within the vehicle's limit."""
    car = case.vehicle
    return float(np.clip(np.arctan(arc.curvature * car.wheelbase_m), -car.steering_max_rad, car.steering_max_rad))


def reached_mps(case: ParkingCase, arc: Arc) -> float:
    """The highest speed on an arc that is driven from rest to rest."""
    limit = case.limits.forward_mps if arc.gear > 0.0 else case.limits.reverse_mps
    return min(limit, float(np.sqrt(case.limits.acceleration_mps2 * abs(arc.length))))


def knots_of(case: ParkingCase, path: ArcPath) -> tuple[Array, Array, Array]:
    """(t, speed, steering) at the corners of the profiles: every arc from rest to rest at the acceleration limit, steering between."""
    a, rate = case.limits.acceleration_mps2, case.vehicle.steering_rate_max_radps
    t, v, delta = [0.0], [0.0], [case.start_steering_rad]

    def add(dt: float, speed: float, steering: float) -> None:
        t.append(t[-1] + dt)
        v.append(speed)
        delta.append(steering)

    for arc in path.arcs:
        wanted = steering_on(case, arc)
        if abs(wanted - delta[-1]) > 1e-12:
            add(abs(wanted - delta[-1]) / rate, 0.0, wanted)
        length, top = abs(arc.length), reached_mps(case, arc)
        add(top / a, arc.gear * top, wanted)
        if length - top * top / a > 1e-9:
            add((length - top * top / a) / top, arc.gear * top, wanted)
        add(top / a, 0.0, wanted)
    if len(t) == 1:
        add(SAMPLE_S, 0.0, delta[-1])
    return np.array(t), np.array(v), np.array(delta)


def sampled(case: ParkingCase, t: Array, v: Array, delta: Array) -> ParkingTrajectory:
    """The trajectory that is linear in speed and steering between the knots, sampled at most 0.05 s apart, knots included. Raises
    `ParameterError` where it lasts for longer than anybody parks."""
    if not t[-1] <= _LONGEST_S:
        rule = f"the drive must last no longer than {_LONGEST_S:g} s: they are too low for this case"
        raise ParameterError("limits", float(t[-1]), rule, "s")
    keep = np.concatenate([[True], np.diff(t) > 1e-7])
    keep[-1] = True
    t, v, delta = t[keep], v[keep], delta[keep]
    fine_t, poses, _ = roll_out(case.start, t, v, delta, case.vehicle.wheelbase_m, 0.005)
    counts = np.maximum(1, np.ceil(np.diff(t) / 0.005 - 1e-9).astype(np.int64))
    ends = np.concatenate([[0], np.cumsum(counts)])
    picked = [np.arange(a, b, 10) for a, b in pairwise(ends)]
    index = np.concatenate([*picked, ends[-1:]])
    at = fine_t[index]
    return ParkingTrajectory.from_controls(at, poses[index], np.interp(at, t, v), np.interp(at, t, delta))


def drive(case: ParkingCase, path: ArcPath) -> ParkingTrajectory:
    """The path driven with a stop for every change of steering: complete, and judged like any other answer."""
    return sampled(case, *knots_of(case, path))


def counted(gear_changes: int) -> str:
    return f"{gear_changes} gear change{'' if gear_changes == 1 else 's'}"
