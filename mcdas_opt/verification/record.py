"""The trajectory as a record: finite, in time order, densely sampled, beginning where the host is."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, fields

import numpy as np

from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.rules import Array
from mcdas_opt.domain.trajectory import Trajectory
from mcdas_opt.domain.verdict import Violation, ViolationKind
from mcdas_opt.verification.finding import Findings
from mcdas_opt.verification.tolerances import CONTRACT

_NAMES = tuple(field.name for field in fields(Trajectory))


@dataclass(frozen=True, slots=True, kw_only=True)
class Samples:
    """Trajectories that share their times (n,): a `Trajectory`'s columns, each (trajectories, n)."""

    t_s: Array
    s_m: Array
    d_m: Array
    heading_rad: Array
    speed_mps: Array
    acceleration_mps2: Array
    steering_rad: Array
    steering_rate_radps: Array
    jerk_mps3: Array

    @classmethod
    def of(cls, tables: Sequence[Array]) -> Samples:
        """From tables that share their first row."""
        columns = np.array(tables).swapaxes(0, 1)
        return cls(t_s=tables[0][0], **dict(zip(_NAMES[1:], columns[1:], strict=True)))


def unreadable(table: Array) -> list[Violation]:
    """Faults that leave nothing to drive: too few samples, numbers that are none or absurd, time that stands or runs back.

    A violation's own floats are always finite: what is not finite is counted, not quoted.
    """
    t = table[0]
    if t.size < 2:
        return [Violation(kind=ViolationKind.SAMPLING, t_s=0.0, value=float(t.size), limit=2.0, unit="samples")]
    if not (table.max() <= CONTRACT.largest_number and table.min() >= -CONTRACT.largest_number):  # NaN compares false
        bad = ~np.isfinite(table)
        if bad.any():
            when = t[int(np.flatnonzero(bad.any(axis=0))[0])]
            first = float(when) if math.isfinite(when) else 0.0
            return [Violation(kind=ViolationKind.NOT_FINITE, t_s=first, value=float(bad.sum()), limit=0.0, unit="values")]
        size = np.abs(table)
        when, most = float(t[int(size.max(axis=0).argmax())]), CONTRACT.largest_number
        return [Violation(kind=ViolationKind.OUT_OF_RANGE, t_s=when, value=float(size.max()), limit=most, unit="SI")]
    steps = t[1:] - t[:-1]
    if steps.min() <= 0.0:
        k = int(np.flatnonzero(steps <= 0.0)[0])
        return [Violation(kind=ViolationKind.TIME_ORDER, t_s=float(t[k + 1]), value=float(steps[k]), limit=0.0, unit="s")]
    return []


def sampling(t: Array, found: Findings) -> None:
    """Time begins at 0 and no step is longer than the contract allows."""
    longest, steps = CONTRACT.longest_step_s, t[1:] - t[:-1]
    if abs(t[0]) <= CONTRACT.start_time_s and steps.max() <= longest + CONTRACT.step_rounding_s:
        return
    for which in range(len(found.of)):
        if abs(t[0]) > CONTRACT.start_time_s:
            found.add(which, ViolationKind.START_TIME, t[0], abs(t[0]), 0.0, "s")
        if steps.max() > longest + CONTRACT.step_rounding_s:
            found.add(which, ViolationKind.SAMPLING, t[int(steps.argmax())], steps.max(), longest, "s")


def started_elsewhere(samples: Samples, measured: HostState, found: Findings) -> None:
    """Faults of a first sample that is not the measured state."""
    for which in range(len(found.of)):
        s, d = float(samples.s_m[which, 0]) - measured.s_m, float(samples.d_m[which, 0]) - measured.d_m
        turned = math.remainder(float(samples.heading_rad[which, 0]) - measured.heading_rad, math.tau)
        v, a = float(samples.speed_mps[which, 0]), float(samples.acceleration_mps2[which, 0])
        steering = abs(float(samples.steering_rad[which, 0]) - measured.steering_rad)
        for kind, value, limit, unit in (
            (ViolationKind.START_POSITION, math.hypot(s, d), CONTRACT.start_position_m, "m"),
            (ViolationKind.START_HEADING, abs(turned), CONTRACT.start_heading_rad, "rad"),
            (ViolationKind.START_SPEED, abs(v - measured.speed_mps), CONTRACT.start_speed_mps, "m/s"),
            (ViolationKind.START_ACCELERATION, abs(a - measured.acceleration_mps2), CONTRACT.start_acceleration_mps2, "m/s^2"),
            (ViolationKind.START_STEERING, steering, CONTRACT.start_steering_rad, "rad"),
        ):
            if value > limit:
                found.add(which, kind, 0.0, value, limit, unit)
