"""Figures of a drive, from its fine history."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mcdas_opt.domain.prediction import BodyMotion
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.rules import Array
from mcdas_opt.domain.trajectory import Trajectory
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.simulation.idm import STEP_S, step_times
from mcdas_opt.simulation.recorded import GONE_M

SETTLED_M, SETTLED_RAD = 0.3, 0.03
_CLOSING_MPS = 0.05
BESIDE_M = 0.3  # who is farther to the side of the host's way is not met
_LOOKS_S = 0.1


@dataclass(frozen=True, slots=True, kw_only=True)
class History:
    """A drive in steps of STEP_S: states (n + 1, 6), applied inputs (n, 2), lateral acceleration of the path (n,), the distance to the
    nearest other body (n + 1,), infinite where there is none; sideslip of the rear axle [rad], yaw rate, and the friction that plans were
    to be made with by then (n + 1,). Besides the true sideslip there is the observer's with its standard deviation, and its estimate of the
    friction (n + 1,): 0, 0 and NaN of a car whose tyres do not slip."""

    states: Array
    inputs: Array
    lateral_acceleration_mps2: Array
    clearance_m: Array
    sideslip_rad: Array
    yaw_rate_radps: Array
    friction: Array
    sideslip_estimate_rad: Array
    sideslip_sd_rad: Array
    friction_estimate: Array

    @property
    def t_s(self) -> Array:
        return step_times(0, len(self.states))


def times_to_collision(
    host: Array, neighbours: tuple[BodyMotion, ...], sizes: tuple[tuple[float, float], ...], vehicle: Vehicle, road: Road
) -> tuple[float | None, float | None]:
    """Least time to collision [s] with anybody ahead and with anybody behind; None where nobody ever closes in.

    Gap from bumper to bumper over closing speed, both along the road, with whoever reaches over the host's width or to within 0.3 m of it.
    Somebody alongside does not count, nor does closing in by less than 0.05 m/s.
    """
    s, d, psi, v = (host[:, k] for k in (0, 1, 2, 3))
    speed = v * np.cos(psi) / (1.0 - d * road.curvature_at(s))
    least = [np.inf, np.inf]
    for motion, (length, width) in zip(neighbours, sizes, strict=True):
        sharing = np.abs(motion.d_m - d) < 0.5 * (width + vehicle.width_m) + BESIDE_M
        gap = np.abs(motion.s_m - s) - 0.5 * (length + vehicle.length_m)
        ahead = motion.s_m > s
        closing = np.where(ahead, speed - motion.speed_s_mps, motion.speed_s_mps - speed)
        counts = sharing & (motion.d_m < GONE_M) & (gap > 0.0) & (closing > _CLOSING_MPS)
        time = np.where(counts, gap / np.where(counts, closing, 1.0), np.inf)
        for k, side in enumerate((ahead, ~ahead)):
            least[k] = min(least[k], float(time[side].min(initial=np.inf)))
    front, rear = (value if np.isfinite(value) else None for value in least)
    return front, rear


def settled_lanes(host: Array, road: Road) -> list[int]:
    """The lanes that the host began in and has settled in since, one after another: within 0.3 m of the middle and 0.03 rad of the lane's
    direction."""
    every = round(_LOOKS_S / STEP_S)
    lanes = [road.lane_of(float(host[0, 1]), float(host[0, 0]))]
    for s, d, psi in (*host[::every, :3].tolist(), host[-1, :3].tolist()):
        lane = road.lane_of(d, s)
        if lane != lanes[-1] and abs(psi) < SETTLED_RAD and abs(d - road.lane_centre_m(lane, s)) < SETTLED_M:
            lanes.append(lane)
    return lanes


def lane_changed(host: Array, road: Road) -> bool:
    """Whether the drive ended settled in another lane than it began in."""
    s, d, psi = host[-1, :3].tolist()
    first, last = road.lane_of(float(host[0, 1]), float(host[0, 0])), road.lane_of(d, s)
    return first != last and abs(d - road.lane_centre_m(last, s)) < SETTLED_M and abs(psi) < SETTLED_RAD


def driven(history: History, sample_s: float = 0.1) -> Trajectory:
    """The drive as a trajectory: a sample where an applied input changes or a state jumps, and at least every `sample_s`."""
    x, u = history.states, history.inputs
    if len(u) == 0:
        return Trajectory.from_states(history.t_s, x, np.zeros((1, 2)))
    every = round(sample_s / STEP_S)
    keep = [0]
    for k in range(1, len(u)):
        jumped = abs(x[k, 4] - x[k - 1, 4] - u[k - 1, 0] * STEP_S) > 1e-6
        if k % every == 0 or jumped or np.abs(u[k] - u[keep[-1]]).max() > 1e-9:
            keep.append(k)
    rows = [*keep, len(u)]
    return Trajectory.from_states(history.t_s[rows], x[rows], u[keep])
