"""Where the browser takes hold of a scene: everybody's place in the plane, and the road's line to say where a pointer is on it."""

from __future__ import annotations

from typing import Any

import numpy as np

from mcdas_opt.catalogue.scenes import Scene
from mcdas_opt.plotting.outlook import AHEAD_M, BEHIND_M
from mcdas_opt.plotting.plane import Ground, rounded

_EVERY_M = 2.0


def handles(scene: Scene) -> dict[str, Any]:
    """`handles`: a pose (x, y, yaw) for everybody, by `key`; `axis`: (s, x, y, yaw) of the road's line, of a straight road nothing.

    `lanes`: d of the lanes' middles at the host; a car is dragged into them.
    """
    road = scene.true_road
    ground = Ground(road, -BEHIND_M, AHEAD_M)
    host = (0.0, scene.host.d_m, scene.host.heading_rad)
    bodies = [("host", "host", host, scene.vehicle.length_m, scene.vehicle.width_m, False)]
    for index, car in enumerate(scene.neighbour):
        key, recorded = f"neighbour[{index}]", car.trajectory is not None
        bodies.append((key, scene.neighbour_name(index), car.initial[:3], car.length_m, car.width_m, recorded))
    places = ground.place(*np.array([pose for _, _, pose, *_ in bodies]).T)
    s = np.arange(-BEHIND_M, AHEAD_M, _EVERY_M)
    axis = [] if road.is_straight else rounded(np.column_stack([s, ground.place(s, 0.0)]), 4)
    return {
        "handles": [
            {"key": key, "name": name, "pose": rounded(place, 3), "length": length, "width": width, "fixed": fixed}
            for place, (key, name, _, length, width, fixed) in zip(places, bodies, strict=True)
        ],
        "axis": axis,
        "lanes": rounded([road.lane_width_m * k for k in range(-road.lanes_right, road.lanes_left + 1)], 3),
    }
