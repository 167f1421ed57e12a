"""A manoeuvre as the program sees it: nodes, interval lengths, and which gear each interval is driven in."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from mcdas_opt.domain.parking import ParkingCase, ParkingTrajectory, reversals
from mcdas_opt.domain.rules import Array
from mcdas_opt.dynamics.rollout import roll_out
from mcdas_opt.parking.path import ArcPath, reached_mps, sampled, steering_on

SIZES = (24, 36, 48, 60, 72, 84, 96, 120, 144, 168, 192, 224, 256, 320, 400)  # intervals: few sizes, so that solvers are used again
INTERVAL_S = 0.28
PIECE = 6  # intervals of one length
_FEWEST, _MOST = 4, 20  # intervals of an arc, before spare ones are given out


@dataclass(frozen=True, slots=True)
class Manoeuvre:
    """`gears` holds +1, -1, or 0 for steering at standstill; `segments` numbers runs of intervals of one length."""

    nodes: Array  # (n + 1, 5): x, y, heading, speed, steering
    steps: Array  # (n,) [s]
    gears: Array  # (n,)
    segments: Array  # (n,)

    @property
    def times(self) -> Array:
        return np.concatenate([[0.0], np.cumsum(self.steps)])

    @property
    def duration_s(self) -> float:
        return float(self.steps.sum())

    @property
    def distances(self) -> Array:
        """(n,) metres driven in each interval."""
        speed = np.abs(self.nodes[:, 3])
        return np.asarray(0.5 * (speed[1:] + speed[:-1]) * self.steps)

    @property
    def gear_changes(self) -> int:
        """As `ParkingTrajectory` counts them: phases shorter than `LEAST_LEG_M` do not count."""
        moving = np.flatnonzero(self.gears)
        if not moving.size:
            return 0
        gears = self.gears[moving]
        first = np.flatnonzero(np.append(True, gears[1:] != gears[:-1]))
        return reversals(np.add.reduceat((self.gears * self.distances)[moving], first))

    def trajectory(self, case: ParkingCase) -> ParkingTrajectory:
        return sampled(case, self.times, self.nodes[:, 3], self.nodes[:, 4])


def from_path(case: ParkingCase, path: ArcPath, interval_s: float = INTERVAL_S) -> Manoeuvre:
    """A path of arcs as a manoeuvre that a program can start from: feasible as it stands, up to the corners of the speed profile."""
    limits, rate = case.limits, case.vehicle.steering_rate_max_radps
    durations = []
    for arc in path.arcs:
        reached = reached_mps(case, arc)
        durations.append(2.0 * reached / limits.acceleration_mps2 + (abs(arc.length) - reached**2 / limits.acceleration_mps2) / reached)
    counts, spare = _interval_counts(np.array(durations), interval_s)
    nodes, steps, gears, segments = [], [], [], []
    delta = case.start_steering_rad
    poses = path.poses
    for k, (arc, count, duration) in enumerate(zip(path.arcs, counts, durations, strict=True)):
        wanted = steering_on(case, arc)
        stands = 2 if k == 0 and spare else 1
        turn_by = (wanted - delta) / stands
        for _ in range(stands):
            nodes.append([*poses[k], 0.0, delta])
            steps.append(max(abs(turn_by) / rate, 1e-3))
            gears.append(0.0)
            segments.append(2 * k)
            delta += turn_by
        h = duration / count
        t = h * np.arange(count + 1)
        v = np.minimum(reached_mps(case, arc), limits.acceleration_mps2 * np.minimum(t, duration - t))
        distance = np.concatenate([[0.0], np.cumsum(0.5 * (v[1:] + v[:-1]) * h)])
        distance *= abs(arc.length) / distance[-1]
        turn = arc.curvature * arc.gear * distance
        heading = poses[k][2] + 0.5 * turn
        chord = arc.gear * distance * np.sinc(0.5 * turn / np.pi)
        for i in range(count):
            pose = [poses[k][0] + chord[i] * np.cos(heading[i]), poses[k][1] + chord[i] * np.sin(heading[i]), poses[k][2] + turn[i]]
            nodes.append([*pose, arc.gear * v[i], wanted])
            steps.append(h)
            gears.append(arc.gear)
            segments.append(2 * k + 1)
    nodes.append([*poses[-1], 0.0, delta])
    return Manoeuvre(np.array(nodes), np.array(steps), np.array(gears), np.array(segments))


def _interval_counts(durations: Array, interval_s: float) -> tuple[Array, int]:
    """(intervals of each arc, an even number; how many of the size that they are rounded up to are left over)."""
    counts = np.array([max(_FEWEST, 2 * int(np.ceil(0.5 * d / interval_s))) for d in durations])
    counts = np.minimum(counts, _MOST)
    wanted = int(counts.sum()) + len(counts)
    spare = next((s for s in SIZES if s >= wanted), wanted) - wanted
    while spare >= 2:  # the longest intervals are cut first
        counts[int(np.argmax(durations / counts))] += 2
        spare -= 2
    return counts, spare


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
