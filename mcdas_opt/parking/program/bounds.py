"""What a program's nodes may be: a trust region around every pose, the gear's speeds, rest where the gear changes, and both ends."""

from __future__ import annotations

import numpy as np

from mcdas_opt.domain.parking import ParkingCase
from mcdas_opt.domain.rules import Array
from mcdas_opt.parking.program.manoeuvre import Manoeuvre

_ROOM_SHARE = 0.7  # of a pose's clearance that it may move, where that is more than the trust region ...
_ROOM_AT_MOST = 4.0  # ... but no more than so many times the trust region


def node_bounds(
    case: ParkingCase, manoeuvre: Manoeuvre, room: Array, trust_region_m: float, trust_region_rad: float, share: float
) -> tuple[Array, Array]:
    """(low, high) (n + 1, 5) of a program around `manoeuvre`, of whose trust region the `share` is used; `room` (n,) is the clearance."""
    limits, top = case.limits, case.vehicle.steering_max_rad
    reach = share * np.append(np.clip(_ROOM_SHARE * room, trust_region_m, _ROOM_AT_MOST * trust_region_m), trust_region_m)[:, None]
    widths = reach * np.array([1.0, 1.0, trust_region_rad / trust_region_m])
    low, high = manoeuvre.nodes.copy(), manoeuvre.nodes.copy()
    low[:, :3] -= widths
    high[:, :3] += widths
    gears = _gear_at_nodes(manoeuvre.gears)
    low[:, 3] = np.where(gears < 0.0, -limits.reverse_mps, 0.0)
    high[:, 3] = np.where(gears > 0.0, limits.forward_mps, 0.0)
    low[:, 4], high[:, 4] = -top, top
    low[0], high[0] = [*case.start, 0.0, case.start_steering_rad], [*case.start, 0.0, case.start_steering_rad]
    turns = np.round((manoeuvre.nodes[-1, 2] - case.goal[2]) / (2.0 * np.pi)) * 2.0 * np.pi
    low[-1, :4] = high[-1, :4] = [case.goal[0], case.goal[1], case.goal[2] + turns, 0.0]
    return low, high


def end_slack(case: ParkingCase) -> Array:
    """(x, y, heading): a box inside the circle of the end tolerance, longer across the goal's heading where that lies along an axis."""
    across, along = 0.95, 0.3
    c, s = abs(float(np.cos(case.goal[2]))), abs(float(np.sin(case.goal[2])))
    shape = (along, across) if s < 0.05 else (across, along) if c < 0.05 else (0.7, 0.7)
    return np.array([*(case.tolerance.position_m * q for q in shape), case.tolerance.heading_rad])


def _gear_at_nodes(gears: Array) -> Array:
    """+1 or -1 where the intervals before and after a node go the same way (standstill looked through), else 0."""
    n = len(gears)
    before, after = np.zeros(n + 1), np.zeros(n + 1)
    for k in range(n):
        before[k + 1] = gears[k] if gears[k] != 0.0 else before[k]
        after[n - 1 - k] = gears[n - 1 - k] if gears[n - 1 - k] != 0.0 else after[n - k]
    return np.where(before == after, before, 0.0)
