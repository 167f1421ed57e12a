"""Whether the host's measured state can be true."""

from __future__ import annotations

import math

from mcdas_opt.domain.host import HostState, SlidingState
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.rules import FARTHEST_M
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.errors import degrees_perhaps

JUMP_MPS, HARDEST_MPS2 = 8.0, 12.0  # by so much more than hardest braking, within a cycle, no car's speed changes
_HOST_FASTEST_MPS = 85.0  # and than half as fast again as it can drive
_HOST_HARDEST_MPS2 = 30.0  # three times what tyres hold: a crash, or no acceleration
_HOST_STEERING_RAD = 1.4  # of the wheels of any car
_HOST_LATERAL_MPS2 = 100.0  # that the steering would give: ten times what tyres hold
_HOST_OFF_ROAD_M = 20.0  # beyond the edge
_FOLD = 0.9  # of the radius of the bend: there the road folds over itself
_HOST_SIDEWAYS_MPS, _HOST_TURNING_RADPS = 40.0, 15.0


def host_faults(host: HostState, road: Road, before_mps: tuple[float, ...], elapsed_s: float, vehicle: Vehicle) -> dict[str, str]:
    """Which quantities of the host's state no car can have, each with why, in words.

    `before_mps` are its speeds as they were known `elapsed_s` before: a speed that is far from all of them has jumped.
    """
    faults: dict[str, str] = {}
    speed, fastest = host.speed_mps, min(_HOST_FASTEST_MPS, 1.5 * vehicle.speed_max_mps)
    if abs(host.s_m) > FARTHEST_M:
        faults["s_m"] = f"the host is at {host.s_m:.3g} m along the road"
    if speed < 0.0:
        faults["speed_mps"] = f"the host moves backwards at {-speed:.3g} m/s"
    elif speed > fastest:
        faults["speed_mps"] = f"the host moves at {speed:.0f} m/s, faster than {fastest:.0f}"
    elif before_mps and min(abs(speed - before) for before in before_mps) > JUMP_MPS + HARDEST_MPS2 * elapsed_s:
        faults["speed_mps"] = f"the host's speed jumped by {abs(speed - before_mps[-1]):.1f} m/s in {elapsed_s:.2g} s"
    if abs(host.acceleration_mps2) > _HOST_HARDEST_MPS2:
        faults["acceleration_mps2"] = f"the host accelerates at {host.acceleration_mps2:.3g} m/s^2, beyond {_HOST_HARDEST_MPS2:.0f}"
    if abs(host.heading_rad) > math.pi:
        faults["heading_rad"] = (
            f"the host's heading against the road is {host.heading_rad:.3g} rad, beyond half a turn{degrees_perhaps(host.heading_rad)}"
        )
    steering, slowest = abs(host.steering_rad), min(max(speed, 0.0), fastest)
    if steering > _HOST_STEERING_RAD or slowest**2 * math.tan(steering) > _HOST_LATERAL_MPS2 * vehicle.wheelbase_m:
        faults["steering_rad"] = f"the host's wheels are turned by {host.steering_rad:.3g} rad at {speed:.0f} m/s"
    off_road = max(host.d_m - float(road.left_edge_at(host.s_m)), float(road.right_edge_at(host.s_m)) - host.d_m)
    if off_road > _HOST_OFF_ROAD_M or (off_road > 0.0 and max(kappa * host.d_m for _, kappa in road.curvature) > _FOLD):
        faults["d_m"] = f"the host is {off_road:.3g} m beyond the edge of the road"
    if isinstance(host, SlidingState) and (
        abs(host.lateral_speed_mps) > _HOST_SIDEWAYS_MPS or abs(host.yaw_rate_radps) > _HOST_TURNING_RADPS
    ):
        faults["heading_rad"] = f"the host slides at {host.lateral_speed_mps:.3g} m/s and turns at {host.yaw_rate_radps:.3g} rad/s"
    return faults
