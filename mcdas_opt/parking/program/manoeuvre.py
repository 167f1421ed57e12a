"""A manoeuvre as the program sees it: nodes, interval lengths, and which gear each interval is driven in."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from mcdas_opt.domain.parking import ParkingCase, ParkingTrajectory
from mcdas_opt.domain.rules import Array
from mcdas_opt.dynamics.rollout import roll_out
from mcdas_opt.parking.path import ArcPath, sampled

SIZES = (24, 36, 48, 60, 72, 84, 96, 120, 144, 168, 192, 224, 256, 320, 400)
INTERVAL_S = 0.28
PIECE = 6  # intervals of one length


@dataclass(frozen=True, slots=True)
class Manoeuvre:
    """`gears` holds +1, -1, or 0 for steering at standstill; `segments` numbers runs of intervals of one length."""

    nodes: Array  # (n + 1, 5): x, y, heading, speed, steering
    steps: Array  # (n,)
    gears: Array  # (n,)
    segments: Array  # (n,)
    name: str = ""

    @property
    def times(self) -> Array:
        return np.concatenate([[0.0], np.cumsum(self.steps)])

    @property
    def duration_s(self) -> float:
        return float(self.steps.sum())

    @property
    def gear_changes(self) -> int:
        moving = self.gears[self.gears != 0.0]
        return int(np.sum(moving[1:] != moving[:-1]))

    def trajectory(self, case: ParkingCase) -> ParkingTrajectory:
        return sampled(case, self.times, self.nodes[:, 3], self.nodes[:, 4])


def standing_start(case: ParkingCase, path: ArcPath, interval_s: float = INTERVAL_S) -> Manoeuvre:
    """The path of arcs as a manoeuvre that a program can start from: feasible as it stands, up to the corners of the speed profile."""
    limits, car = case.limits, case.vehicle
    durations = []
    for arc in path.arcs:
        top = limits.forward_mps if arc.length > 0.0 else limits.reverse_mps
        reached = min(top, float(np.sqrt(limits.acceleration_mps2 * abs(arc.length))))
        durations.append(2.0 * reached / limits.acceleration_mps2 + (abs(arc.length) - reached**2 / limits.acceleration_mps2) / reached)
    counts = np.array([max(4, 2 * int(np.ceil(0.5 * d / interval_s))) for d in durations])
    counts = np.minimum(counts, 20)
    wanted = int(counts.sum()) + len(counts)
    size = next((s for s in SIZES if s >= wanted), wanted)
    spare = size - wanted
    while spare >= 2:  # the longest intervals are cut first
        counts[int(np.argmax(np.array(durations) / counts))] += 2
        spare -= 2
    nodes, steps, gears, segments = [], [], [], []
    delta = case.start_steering_rad
    poses = path.poses
    for k, (arc, count, duration) in enumerate(zip(path.arcs, counts, durations, strict=True)):
        wanted_delta = float(np.clip(np.arctan(arc.curvature * car.wheelbase_m), -car.steering_max_rad, car.steering_max_rad))
        stands = 2 if k == 0 and spare else 1
        turn_by = (wanted_delta - delta) / stands
        for _ in range(stands):
            nodes.append([*poses[k], 0.0, delta])
            steps.append(max(abs(turn_by) / car.steering_rate_max_radps, 1e-3))
            gears.append(0.0)
            segments.append(2 * k)
            delta += turn_by
        sign = 1.0 if arc.length > 0.0 else -1.0
        h = duration / count
        t = h * np.arange(count + 1)
        top = min(limits.forward_mps if sign > 0.0 else limits.reverse_mps, float(np.sqrt(limits.acceleration_mps2 * abs(arc.length))))
        v = np.minimum(top, limits.acceleration_mps2 * np.minimum(t, duration - t))
        way = np.concatenate([[0.0], np.cumsum(0.5 * (v[1:] + v[:-1]) * h)])
        way *= abs(arc.length) / way[-1]
        turn = arc.curvature * sign * way
        heading = poses[k][2] + 0.5 * turn
        chord = sign * way * np.sinc(0.5 * turn / np.pi)
        for i in range(count):
            pose = [poses[k][0] + chord[i] * np.cos(heading[i]), poses[k][1] + chord[i] * np.sin(heading[i]), poses[k][2] + turn[i]]
            nodes.append([*pose, sign * v[i], wanted_delta])
            steps.append(h)
            gears.append(sign)
            segments.append(2 * k + 1)
    nodes.append([*poses[-1], 0.0, delta])
    return Manoeuvre(np.array(nodes), np.array(steps), np.array(gears), np.array(segments), path.name)


def node_poses(case: ParkingCase, manoeuvre: Manoeuvre, per_interval: int) -> tuple[Array, Array]:
    """(poses (n, per_interval + 1, 3), fractions): the roll-out from the first node, at even fractions of every interval."""
    fractions = np.linspace(0.0, 1.0, per_interval + 1)
    t = manoeuvre.times
    fine = np.concatenate([(t[:-1, None] + manoeuvre.steps[:, None] * fractions[:-1]).ravel(), t[-1:]])
    fine = np.maximum.accumulate(fine + 1e-12 * np.arange(fine.size))
    v, d = np.interp(fine, t, manoeuvre.nodes[:, 3]), np.interp(fine, t, manoeuvre.nodes[:, 4])
    _, poses, _ = roll_out(manoeuvre.nodes[0, :3], fine, v, d, case.vehicle.wheelbase_m, 1e9)
    index = per_interval * np.arange(len(manoeuvre.steps))[:, None] + np.arange(per_interval + 1)
    return poses[index], fractions


def with_solution(manoeuvre: Manoeuvre, nodes: Array, steps: Array) -> Manoeuvre:
    return replace(manoeuvre, nodes=nodes, steps=np.maximum(steps, 0.0))
