"""The trajectory as a record: finite, in time order, densely sampled, beginning where the host is."""

from __future__ import annotations

import math
from dataclasses import fields

import numpy as np

from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.rules import Array
from mcdas_opt.domain.trajectory import Trajectory
from mcdas_opt.domain.verdict import Violation
from mcdas_opt.verification.finding import above
from mcdas_opt.verification.tolerances import Tolerances


def unreadable(trajectory: Trajectory, tolerances: Tolerances) -> list[Violation]:
    """Faults that leave nothing to drive: too few samples, numbers that are none or absurd, time that stands or runs back.

    A violation's own floats are always finite: what is not finite is counted, not quoted.
    """
    if len(trajectory) < 2:
        return [Violation(name="sampling", t_s=0.0, value=float(len(trajectory)), limit=2.0, unit="samples")]
    table = np.stack([getattr(trajectory, field.name) for field in fields(trajectory)])
    t = table[0]
    size = np.abs(table)
    if not size.max() <= tolerances.largest_number:  # NaN compares false
        bad = ~np.isfinite(table)
        if bad.any():
            when = t[int(np.flatnonzero(bad.any(axis=0))[0])]
            first = float(when) if math.isfinite(when) else 0.0
            return [Violation(name="not finite", t_s=first, value=float(bad.sum()), limit=0.0, unit="values")]
        worst = int(size.max(axis=0).argmax())
        return [Violation(name="out of range", t_s=float(t[worst]), value=float(size.max()), limit=tolerances.largest_number, unit="SI")]
    steps = np.diff(t)
    if steps.min() <= 0.0:
        k = int(np.flatnonzero(steps <= 0.0)[0])
        return [Violation(name="time not monotone", t_s=float(t[k + 1]), value=float(steps[k]), limit=0.0, unit="s")]
    return []


def sampling(t: Array, steps: Array, tolerances: Tolerances) -> list[Violation]:
    """Time begins at 0 and no step is longer than the contract allows."""
    found = above("start time", t[:1], np.abs(t[:1]), 0.0, tolerances.start_time_s, "s")
    longest = tolerances.longest_step_s
    return found + above("sampling", t, steps, longest, longest + tolerances.step_rounding_s, "s")


def started_elsewhere(states: Array, measured: HostState, tolerances: Tolerances) -> list[Violation]:
    """Faults of a first sample that is not the measured state."""
    s, d, psi, v, a, delta = (float(q) for q in states[0] - measured.to_vector())
    rules = (
        ("start position", math.hypot(s, d), tolerances.start_position_m, "m"),
        ("start heading", abs(math.remainder(psi, math.tau)), tolerances.start_heading_rad, "rad"),
        ("start speed", abs(v), tolerances.start_speed_mps, "m/s"),
        ("start acceleration", abs(a), tolerances.start_acceleration_mps2, "m/s^2"),
        ("start steering", abs(delta), tolerances.start_steering_rad, "rad"),
    )
    return [Violation(name=name, t_s=0.0, value=value, limit=limit, unit=unit) for name, value, limit, unit in rules if value > limit]
