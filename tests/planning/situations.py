"""Situations for the tests of planning: random ones from a seed, and their mirror images."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.prediction import Prediction
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.situation import Situation
from mcdas_opt.domain.track import Coverage, Track
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.domain.vocabulary import Side
from mcdas_opt.planning.cycle import Cycle

_OTHER_SIDE = {Side.LEFT: Side.RIGHT, Side.RIGHT: Side.LEFT, Side.NONE: Side.NONE}


def under(prediction: Prediction, vehicle: Vehicle, road: Road) -> Cycle:
    """A cycle on this road with this prediction."""
    return replace(Cycle.of(Situation(host=HostState(), road=road, coverage=Coverage()), vehicle), prediction=prediction)


def car(name: str, s: float, d: float, v: float, **more: float) -> Track:
    return Track(id=name, s_m=s, d_m=d, speed_s_mps=v, **more)


def sandwich(offset_m: float = 0.0, *, front_gap_m: float = 25.0, rear_gap_m: float = 25.0) -> Situation:
    """The paper's: host and front at 40 km/h, rear at 60 km/h."""
    tracks = (car("front", front_gap_m + 4.5, offset_m, 40 / 3.6), car("rear", -rear_gap_m - 4.5, 0.0, 60 / 3.6))
    return Situation(host=HostState(speed_mps=40 / 3.6), tracks=tracks, road=Road(lanes_left=1, lanes_right=1), coverage=Coverage())


def random_sandwich(seed: int) -> Situation:
    """Boxed in, at any speed, on any friction, with or without side lanes and cars in them."""
    r = np.random.default_rng(seed)
    v = r.uniform(5.0, 33.0)
    front, rear = r.uniform(5.0, 60.0) + 4.5, -r.uniform(3.0, 40.0) - 4.5
    tracks = [
        car("front", front, r.uniform(-0.6, 0.6), max(v - r.uniform(0.0, 15.0), 0.0)),
        car("rear", rear, r.uniform(-0.3, 0.3), v + r.uniform(0, 12)),
    ]
    lanes = (int(r.integers(0, 2)), int(r.integers(0, 2)))
    for name, d, there in (("left", 3.7, lanes[0]), ("right", -3.7, lanes[1])):
        if there and r.random() < 0.6:
            tracks.append(car(name, r.uniform(-30.0, 30.0), d, v * r.uniform(0.7, 1.2)))
    road = Road(lanes_left=lanes[0], lanes_right=lanes[1], friction=float(r.choice([0.9, 0.5, 0.25])))
    host = HostState(speed_mps=v, d_m=r.uniform(-0.3, 0.3), acceleration_mps2=r.uniform(-0.5, 0.5))
    return Situation(host=host, tracks=tuple(tracks), road=road, coverage=Coverage())


def mirrored(situation: Situation) -> Situation:
    """Left and right exchanged."""
    host, road, seen = situation.host, situation.road, situation.coverage
    return replace(
        situation,
        host=replace(host, d_m=-host.d_m, heading_rad=-host.heading_rad, steering_rad=-host.steering_rad),
        tracks=tuple(mirrored_track(track) for track in situation.tracks),
        coverage=Coverage(front=seen.front, rear=seen.rear, left=seen.right, right=seen.left),
        road=mirrored_road(road),
    )


def mirrored_track(track: Track) -> Track:
    """Left and right exchanged."""
    path = track.lane_path_m and tuple((s, -d) for s, d in track.lane_path_m)
    heading = None if track.heading_rad is None else -track.heading_rad
    return replace(track, d_m=-track.d_m, speed_d_mps=-track.speed_d_mps, heading_rad=heading, lane_path_m=path)


def mirrored_road(road: Road) -> Road:
    """Left and right exchanged."""
    return replace(
        road,
        lanes_left=road.lanes_right,
        lanes_right=road.lanes_left,
        shoulder_left_m=road.shoulder_right_m,
        shoulder_right_m=road.shoulder_left_m,
        curvature=tuple((s, -kappa) for s, kappa in road.curvature),
        lanes=tuple(replace(lane, lane=-lane.lane, merges=_OTHER_SIDE[lane.merges]) for lane in reversed(road.lanes)),
    )
