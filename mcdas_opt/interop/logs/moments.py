"""A drive as moments in the plane: what every log writes, whatever its format."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np

from mcdas_opt.domain.plan import Plan
from mcdas_opt.domain.rules import Array
from mcdas_opt.geometry.frenet import FrenetFrame
from mcdas_opt.simulation.record import Simulation

PERIOD_S = 0.05  # between two moments of the bodies
HEIGHT_M = 1.5  # that boxes are drawn with; nobody has measured it
_BEHIND_M, _AHEAD_M = 60.0, 150.0  # of the road, from what was driven


@dataclass(frozen=True, slots=True, kw_only=True)
class Box:
    """A body: centre and heading in the plane (x forward along the road at s = 0, y left), its size."""

    name: str
    x_m: float
    y_m: float
    yaw_rad: float
    length_m: float
    width_m: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Moment:
    """`t_s` from the drive's start. `plan` where one was made at that time, with its `path` (n, 2) in the plane; `host` are its numbers."""

    t_s: float
    bodies: tuple[Box, ...]
    host: dict[str, float]
    plan: Plan | None = None
    path: Array = field(default_factory=lambda: np.zeros((0, 2)))
    tracks: tuple[Box, ...] = ()


def moments(drive: Simulation) -> Iterator[Moment]:
    """Every 0.05 s, linear between the drive's samples; the host's box is called "host" and stands first."""
    frame = FrenetFrame(road=drive.scene.true_road)
    driven, vehicle = drive.trajectory, drive.scene.vehicle
    plans = {round(cycle.time_s / PERIOD_S): cycle for cycle in drive.cycles}
    columns = {
        "s_m": driven.s_m,
        "d_m": driven.d_m,
        "heading_rad": driven.heading_rad,
        "speed_mps": driven.speed_mps,
        "acceleration_mps2": driven.acceleration_mps2,
        "steering_rad": driven.steering_rad,
        "jerk_mps3": driven.jerk_mps3,
        "steering_rate_radps": driven.steering_rate_radps,
    }
    for k in range(int(np.floor(float(driven.t_s[-1]) / PERIOD_S + 1e-9)) + 1):
        t = k * PERIOD_S

        def at(column: Array, t: float = t) -> float:
            return float(np.interp(t, driven.t_s, column))

        numbers = {name: at(column) for name, column in columns.items()}
        own = _box(frame, "host", numbers["s_m"], numbers["d_m"], numbers["heading_rad"], vehicle.length_m, vehicle.width_m)
        others = [_box(frame, n.name, at(n.s_m), at(n.d_m), at(n.heading_rad), n.length_m, n.width_m) for n in drive.neighbours]
        cycle = plans.get(k)
        if cycle is None:
            yield Moment(t_s=t, bodies=(own, *others), host=numbers)
            continue
        planned = cycle.plan.trajectory
        x, y, _ = frame.to_plane(planned.s_m, planned.d_m, planned.heading_rad)
        seen = [_box(frame, f"track {q.id}", q.s_m, q.d_m, 0.0, q.length_m, q.width_m) for q in cycle.tracks]
        path = np.column_stack([x, y])
        yield Moment(t_s=t, bodies=(own, *others), host=numbers, plan=cycle.plan, path=path, tracks=tuple(seen))


def lines(drive: Simulation) -> dict[str, Array]:
    """The road's edges and the borders between its lanes as polylines (n, 2), as far as the drive went and a little more."""
    road = drive.scene.true_road
    frame = FrenetFrame(road=road)
    low, high = float(drive.trajectory.s_m.min()) - _BEHIND_M, float(drive.trajectory.s_m.max()) + _AHEAD_M
    high = high if road.road_end_s_m is None else min(high, road.road_end_s_m)
    s = np.arange(max(low, frame.s_min_m), min(high, frame.s_max_m), 2.0)
    offsets = {"left edge": road.left_edge_at(s), "right edge": road.right_edge_at(s)}
    offsets |= {f"border {k - road.lanes_right}": d for k, d in enumerate(road.markings_at(s))}
    found = {}
    for name, across in offsets.items():
        d = np.broadcast_to(across, s.shape)
        there = np.isfinite(d)
        x, y, _ = frame.to_plane(s[there], d[there], np.zeros(int(there.sum())))
        found[name] = np.column_stack([x, y])
    return found


def _box(frame: FrenetFrame, name: str, s: float, d: float, psi: float, length: float, width: float) -> Box:
    x, y, yaw = (float(q) for q in frame.to_plane(np.array(float(s)), np.array(float(d)), np.array(float(psi))))
    return Box(name=name, x_m=x, y_m=y, yaw_rad=yaw, length_m=length, width_m=width)
