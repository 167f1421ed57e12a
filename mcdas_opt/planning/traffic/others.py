"""Everybody who is predicted, at some times: where they are along the road and in the plane, and how much room they take."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mcdas_opt.domain.prediction import BodyMotion, Prediction
from mcdas_opt.domain.rules import Array
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.geometry.frenet import FrenetFrame
from mcdas_opt.planning.traffic.separations import Rectangles


@dataclass(frozen=True, slots=True)
class Others:
    """Motions as rows, the same bodies in the plane of a frame; half of the host's body and each of theirs together, along and across
    (J, 2); at the end of each half of both widths together, s, d and speed."""

    motion: BodyMotion
    frame: FrenetFrame
    rectangles: Rectangles
    halves_m: Array
    ends: tuple[tuple[float, float, float, float], ...]

    @classmethod
    def of(cls, prediction: Prediction, rows: BodyMotion, frame: FrenetFrame, vehicle: Vehicle) -> Others:
        """Who is beyond the frame is put at its end: far enough away there too."""
        bodies, places = prediction.bodies, rows.s_m
        if not frame.road.is_straight:
            places = np.clip(places, frame.s_min_m, frame.s_max_m)
        sizes = np.array([(body.length_m, body.width_m) for body in bodies]).reshape(-1, 2)
        halves = 0.5 * (sizes + (vehicle.length_m, vehicle.width_m))
        last = (rows.s_m[:, -1].tolist(), rows.d_m[:, -1].tolist(), rows.speed_s_mps[:, -1].tolist())
        return cls(
            motion=rows,
            frame=frame,
            rectangles=Rectangles.of(*frame.to_plane(places, rows.d_m, rows.heading_rad), 0.5 * sizes),
            halves_m=halves,
            ends=tuple(zip(halves[:, 1].tolist(), *last, strict=True)),
        )
