"""Who drives or walks around a SUMO vehicle, in the frame of its road."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from mcdas_opt.domain.rules import Array
from mcdas_opt.domain.track import ALIGNED_RAD, Places, Track
from mcdas_opt.domain.vocabulary import BodyKind
from mcdas_opt.geometry.frenet import LEAST_STRETCH_MEASURED
from mcdas_opt.interop.sumo.connection import (
    ABOARD,
    ACCELERATION,
    ANGLE,
    LANE_ID,
    LENGTH,
    PERSONS,
    POSITION_3D,
    SPEED,
    SUBSCRIBED,
    VEHICLES,
    WIDTH,
    Connection,
)
from mcdas_opt.interop.sumo.lane_paths import LanePaths
from mcdas_opt.interop.sumo.levels import Levels
from mcdas_opt.interop.sumo.road_frame import RoadFrame
from mcdas_opt.simulation.ordinary import Placed
from mcdas_opt.tracking.acceleration import AccelerationFilter
from mcdas_opt.tracking.lane_path import leads_off
from mcdas_opt.tracking.turn_rate import TurnRateFilter

_LEVEL_M = 3.0  # who is farther above or below is on another road
_BESIDE_M = 80.0  # of our lanes' middles: who is on other edges is seen as far as that to the sides
_KINDS = {"bicycle": BodyKind.BICYCLE, "motorcycle": BodyKind.MOTORCYCLE, "moped": BodyKind.MOTORCYCLE}  # of SUMO's vehicle classes
_SPEED_SD_MPS = 0.1  # of an exact speed, for the filter that learns the acceleration from it


@dataclass(slots=True)
class Traffic:
    """What SUMO says of everybody within `look_m` (ahead, behind) of the host, step by step."""

    sumo: Connection
    host: str
    look_m: tuple[float, float]
    levels: Levels
    lane_paths: LanePaths
    _seen: dict[str, _Seen] = field(default_factory=dict)

    def subscribe(self) -> None:
        """Asks SUMO for everybody near the host, from the next step on."""
        for domain, facts in ((VEHICLES, SUBSCRIBED), (PERSONS, (ABOARD,))):
            self.sumo.vehicle.subscribeContext(self.host, domain, max(self.look_m) + 20.0, facts)

    def forget(self) -> None:
        """Positions across another frame cannot be compared with those before."""
        self._seen.clear()

    def around(self, frame: RoadFrame, s_m: float, time_s: float) -> tuple[Placed, ...]:
        """Everybody near on the host's road, or over it: bodies in the frame, speeds along it."""
        found = self._found()
        level = float(self.sumo.vehicle.getPosition3D(self.host)[2])
        near = {name: facts for name, facts in found.items() if name != self.host and abs(facts[POSITION_3D][2] - level) < _LEVEL_M}
        if not near:
            self._seen.clear()
            return ()
        x, y, yaw = centres(near.values())
        s, d, psi = frame.to_road(x, y, yaw, near_s_m=s_m, length_m=np.array([float(facts[LENGTH]) for facts in near.values()]))
        bodies, kept = [], {}
        for k, (name, facts) in enumerate(near.items()):
            at_m, across_m, heading = float(s[k]), float(d[k]), math.remainder(float(psi[k]), 2.0 * math.pi)
            stretch = 1.0 - across_m * frame.curvature_at(at_m)
            if (
                not -self.look_m[1] <= at_m - s_m <= self.look_m[0]
                or stretch < LEAST_STRETCH_MEASURED
                or not _is_near(frame, at_m, across_m, facts)
                or (
                    _edge(facts) != frame.section_at(at_m).edge.id
                    and self.levels.on_another(str(facts[LANE_ID]), np.array([x[k], y[k]]), s_m, frame.sections)
                )
            ):
                continue
            seen = self._seen.get(name) or _Seen(first_s=time_s, kind=self._kind(name, facts))
            seen.is_on_route = seen.kind is not BodyKind.PEDESTRIAN and _edge(facts) == frame.section_at(at_m).edge.id
            column_at = frame.column_at if seen.is_on_route else frame.column_beside
            body = Placed(
                id=name,
                s_m=at_m,
                d_m=across_m,
                heading_rad=heading,
                speed_mps=float(facts[SPEED]) * math.cos(heading) / stretch,
                acceleration_mps2=float(facts[ACCELERATION]),
                length_m=float(facts[LENGTH]),
                width_m=float(facts[WIDTH]),
                lane=column_at(at_m, across_m),
                kind=seen.kind,
            )
            seen.lane, seen.place, seen.speed_mps = str(facts[LANE_ID]), np.array([x[k], y[k]]), float(facts[SPEED])
            seen.take(time_s, body, float(facts[SPEED]), float(yaw[k]))
            bodies.append(body)
            kept[name] = seen
        self._seen = kept
        return tuple(bodies)

    def tracks(self, frame: RoadFrame, bodies: tuple[Placed, ...], time_s: float, host_lane: int) -> Iterator[Track]:
        """As a planner is told of them: exact places, headings and speeds, the acceleration and the turn rate that these have shown. Who
        drives along the host's route has no heading, unless it is clearly turned from it: it follows the road. Who does not, and who is
        beside the host in a lane that leads elsewhere, drives along its lane."""
        for body in bodies:
            seen = self._seen[body.id]
            acceleration, sd = seen.speed.at(time_s)
            path = None if seen.is_on_route and body.lane == host_lane else self._lane_path_m(frame, body, seen)
            follows = seen.is_on_route and path is None and abs(body.heading_rad) <= ALIGNED_RAD
            turn_rate, turn_sd = (0.0, None) if follows else seen.turning.at(time_s)
            yield Track(
                id=body.id,
                s_m=body.s_m,
                d_m=body.d_m,
                speed_s_mps=body.speed_mps,
                speed_d_mps=seen.across_mps,
                length_m=body.length_m,
                width_m=body.width_m,
                age_s=time_s - seen.first_s,
                acceleration_s_mps2=acceleration * math.cos(body.heading_rad),
                acceleration_s_sd_mps2=sd,
                acceleration_d_mps2=acceleration * math.sin(body.heading_rad),
                acceleration_d_sd_mps2=sd,
                heading_rad=None if follows else body.heading_rad,
                kind=body.kind,
                turn_rate_radps=turn_rate,
                turn_rate_sd_radps=turn_sd,
                lane_path_m=path,
            )

    def _lane_path_m(self, frame: RoadFrame, body: Placed, seen: _Seen) -> Places | None:
        """Places (s, d) along the lane of a vehicle; on the host's route where it leads elsewhere."""
        if seen.kind is BodyKind.PEDESTRIAN:
            return None
        path = self.lane_paths.of(body.id, seen.lane, seen.place, seen.speed_mps)
        if path is None:
            return None
        s, d, _ = frame.to_road(path[:, 0], path[:, 1], np.zeros(len(path)), near_s_m=body.s_m)
        places = tuple(zip(s.tolist(), d.tolist(), strict=True))
        return places if not seen.is_on_route or leads_off(places, body.d_m) else None

    def _kind(self, name: str, facts: Mapping[int, Any]) -> BodyKind | None:
        return BodyKind.PEDESTRIAN if ABOARD in facts else _KINDS.get(self.sumo.vehicle.getVehicleClass(name))

    def _found(self) -> dict[str, Mapping[int, Any]]:
        """What SUMO says of each. People are told apart by name: a vehicle may be called alike, and SUMO answers for both in one."""
        found: dict[str, Mapping[int, Any]] = {}
        for name, facts in self.sumo.vehicle.getContextSubscriptionResults(self.host).items():
            if POSITION_3D in facts:
                found[name] = {key: facts[key] for key in SUBSCRIBED}
            if facts.get(ABOARD) == "":
                found[f"person {name}"] = self._on_foot(name)
        return found

    def _on_foot(self, name: str) -> Mapping[int, Any]:
        """Asked one by one: libsumo 1.28 gives the size of its type in place of a person's."""
        person = self.sumo.person
        return {
            ABOARD: "",
            LANE_ID: person.getLaneID(name),
            POSITION_3D: person.getPosition3D(name),
            ANGLE: person.getAngle(name),
            SPEED: person.getSpeed(name),
            LENGTH: person.getLength(name),
            WIDTH: person.getWidth(name),
            ACCELERATION: 0.0,
        }


@dataclass(slots=True)
class _Seen:
    """What a vehicle's past tells: its speed across the road, its acceleration, and how fast it turns."""

    first_s: float
    kind: BodyKind | None
    is_on_route: bool = True
    lane: str = ""
    place: Array = field(default_factory=lambda: np.zeros(2))  # (2,) in SUMO's plane
    speed_mps: float = 0.0  # there
    across_mps: float = 0.0
    time_s: float = -math.inf
    d_m: float = 0.0
    speed: AccelerationFilter = field(default_factory=AccelerationFilter)
    turning: TurnRateFilter = field(default_factory=TurnRateFilter)

    def take(self, time_s: float, body: Placed, speed_mps: float, yaw_rad: float) -> None:
        """`body`, as fast as that in the plane, where it points to `yaw_rad`."""
        if time_s <= self.time_s:
            return
        if self.is_on_route and math.isfinite(self.time_s):
            self.across_mps = (body.d_m - self.d_m) / (time_s - self.time_s)
        else:
            self.across_mps = speed_mps * math.sin(body.heading_rad)
        self.time_s, self.d_m = time_s, body.d_m
        self.speed.take(time_s, speed_mps, _SPEED_SD_MPS**2)
        self.turning.take(time_s, yaw_rad)


def centres(found: Any) -> tuple[Any, Any, Any]:
    """(x, y, yaw) of body centres: SUMO says where the middle of the front bumper is, and turns clockwise from north."""
    x, y, yaw, length = (
        np.array([float(value) for value in column])
        for column in zip(*((f[POSITION_3D][0], f[POSITION_3D][1], math.radians(90.0 - f[ANGLE]), f[LENGTH]) for f in found), strict=True)
    )
    return x - 0.5 * length * np.cos(yaw), y - 0.5 * length * np.sin(yaw), yaw


def _edge(facts: Mapping[int, Any]) -> str:
    return str(facts[LANE_ID]).rpartition("_")[0]


def _is_near(frame: RoadFrame, s_m: float, d_m: float, facts: Mapping[int, Any]) -> bool:
    """On an edge of the route, or within `_BESIDE_M` of its lanes."""
    section = frame.section_at(s_m)
    columns = section.edge.columns
    return _edge(facts) == section.edge.id or (
        frame.centre_m(columns.start, s_m) - _BESIDE_M <= d_m <= frame.centre_m(columns.stop - 1, s_m) + _BESIDE_M
    )
