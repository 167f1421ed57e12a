"""The remainder of the previous plan, driven from where the car is now."""

from __future__ import annotations

import numpy as np

from mcdas_opt.domain.grid import TimeGrid
from mcdas_opt.domain.situation import Situation
from mcdas_opt.domain.trajectory import Trajectory
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.planning.lane_problem.roll_out import roll_out
from mcdas_opt.planning.memory import PreviousPlan

_INSTANT_S = 2e-3  # a sample that is to come so soon has come: no step of the drive is next to nothing


def remainder(previous: PreviousPlan | None, situation: Situation, vehicle: Vehicle) -> Trajectory | None:
    """The previous plan's inputs from now on, through the equations of motion from the measured state; None where none are left, or
    they are sampled more finely than a grid may be.

    It is a new drive, to be judged anew: the car may be elsewhere, and so may the others.
    """
    if previous is None:
        return None
    drive, now = previous.trajectory, previous.age_s
    first = int(np.searchsorted(drive.t_s, now + _INSTANT_S, side="right"))  # the first sample that is still to come
    left = len(drive) - first
    if left < 2:
        return None
    now = max(now, float(drive.t_s[first - 1]))
    steps = np.diff(np.concatenate([[now], drive.t_s[first:]]))
    if not TimeGrid.holds(steps):
        return None
    inputs = drive.inputs[first - 1 : len(drive) - 1]
    speeds = np.concatenate([[situation.host.speed_mps], drive.speed_mps[first:]])
    return roll_out(situation.host, speeds, inputs, TimeGrid(steps_s=steps), vehicle, situation.road)
