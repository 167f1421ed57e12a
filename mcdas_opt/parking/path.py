"""A path of arcs with stops for steering, and the timed trajectory that drives it."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from mcdas_opt.domain.parking import ParkingCase, ParkingTrajectory
from mcdas_opt.domain.rules import Array
from mcdas_opt.dynamics.rollout import roll_out
from mcdas_opt.parking.search.reeds_shepp import along_arc

SAMPLE_S = 0.05


class Arc(NamedTuple):
    """A piece of constant curvature [1/m], driven over a signed length [m] (negative in reverse)."""

    curvature: float
    length: float


@dataclass(frozen=True, slots=True)
class ArcPath:
    """Arcs from the case's start to its goal."""

    start: Array
    arcs: tuple[Arc, ...]
    name: str = "search"

    @property
    def gear_changes(self) -> int:
        signs = [arc.length > 0.0 for arc in self.arcs]
        return sum(a != b for a, b in pairwise(signs))

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


def reversed_path(path: ArcPath) -> ArcPath:
    """The same path driven from its end to its start."""
    return ArcPath(path.poses[-1], tuple(Arc(arc.curvature, -arc.length) for arc in reversed(path.arcs)), path.name)


def knots_of(case: ParkingCase, path: ArcPath) -> tuple[Array, Array, Array]:
    """(t, speed, steering) at the corners of the profiles: every arc from rest to rest at the acceleration limit, steering between."""
    limits, car = case.limits, case.vehicle
    t, v, delta = [0.0], [0.0], [case.start_steering_rad]

    def add(dt: float, speed: float, steering: float) -> None:
        t.append(t[-1] + dt)
        v.append(speed)
        delta.append(steering)

    a = limits.acceleration_mps2
    for arc in path.arcs:
        wanted = float(np.clip(np.arctan(arc.curvature * car.wheelbase_m), -car.steering_max_rad, car.steering_max_rad))
        if abs(wanted - delta[-1]) > 1e-12:
            add(abs(wanted - delta[-1]) / car.steering_rate_max_radps, 0.0, wanted)
        sign = 1.0 if arc.length > 0.0 else -1.0
        length = abs(arc.length)
        top = min(limits.forward_mps if sign > 0.0 else limits.reverse_mps, float(np.sqrt(a * length)))
        add(top / a, sign * top, wanted)
        if length - top * top / a > 1e-9:
            add((length - top * top / a) / top, sign * top, wanted)
        add(top / a, 0.0, wanted)
    if len(t) == 1:
        add(SAMPLE_S, 0.0, delta[-1])
    return np.array(t), np.array(v), np.array(delta)


def sampled(case: ParkingCase, t: Array, v: Array, delta: Array) -> ParkingTrajectory:
    """The trajectory that is linear in speed and steering between the knots, sampled at most 0.05 s apart, knots included."""
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


def way_per_gear(path: ArcPath) -> float:
    """Metres driven in a gear, on average."""
    return sum(abs(arc.length) for arc in path.arcs) / (path.gear_changes + 1)


def counted(gear_changes: int) -> str:
    return f"{gear_changes} gear change{'' if gear_changes == 1 else 's'}"
