"""Our planner at the wheel of one of SUMO's vehicles, or SUMO's own driver watched in the same way."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np

from mcdas_opt.domain.arithmetic import usual_arithmetic
from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.plan import Plan
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.rules import positive
from mcdas_opt.domain.settings import Settings
from mcdas_opt.domain.situation import MOST_TRACKS, Situation
from mcdas_opt.domain.track import Coverage
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.domain.vocabulary import Side, Status
from mcdas_opt.errors import InputError, ParameterError
from mcdas_opt.geometry.rectangle import corners, separation
from mcdas_opt.interop.sumo.columns import column_past_others, main_column
from mcdas_opt.interop.sumo.connection import ANGLE, LENGTH, POSITION_3D, Connection, asking
from mcdas_opt.interop.sumo.lane_paths import LanePaths
from mcdas_opt.interop.sumo.levels import Levels
from mcdas_opt.interop.sumo.record import Contact, SumoSummary, caused_by
from mcdas_opt.interop.sumo.road_frame import RoadFrame
from mcdas_opt.interop.sumo.route import keeps_left, read_route
from mcdas_opt.interop.sumo.stop_lines import next_stop_line_m
from mcdas_opt.interop.sumo.traffic import Traffic, centres
from mcdas_opt.planning.method import Method
from mcdas_opt.planning.planner import Planner
from mcdas_opt.simulation.controller import FeedForward
from mcdas_opt.simulation.idm import STEP_S
from mcdas_opt.simulation.kinematic_plant import KinematicPlant
from mcdas_opt.simulation.ordinary import Placed, Snapshot, instant, ordinary_driving

SUMO = "sumo"  # the method that leaves the vehicle to SUMO
FASTEST_MPS = 70.0
_SETTLED_M = 0.3  # from the middle of its lane
_STOP_SHORT_M = 3.0  # of the route's end, where SUMO takes the vehicle away
_ALONG = 5  # places between two steps at which a contact is looked for
_NEAR_M = 30.0


class SumoDriver:
    """Drives the vehicle `ego` of a running SUMO by `method` ("sumo" leaves it to SUMO and only measures); `step` is SUMO's step too.

    `connection` is the module libsumo, or a connection of traci. `desired_mps` defaults to the speed limit, which binds in any case.
    `look_m`: how far ahead and behind others are seen, exactly; lanes, their ends and limits come from the network. The vehicle is as large
    as in SUMO, accelerates as its type does and brakes as in its emergencies; or it is `vehicle`, which must be as long and as wide.
    In a network whose traffic keeps left so does the planner, whatever the `settings` say.
    Raises `InputError` for an `ego` that is not there, `ParameterError` for steps that do not make up the planner's cycle.
    """

    @usual_arithmetic
    def __init__(
        self,
        connection: Connection,
        ego: str,
        method: str | Method = "mpc",
        *,
        desired_mps: float | None = None,
        look_m: tuple[float, float] = (150.0, 100.0),
        vehicle: Vehicle | None = None,
        settings: Settings | None = None,
        friction: float = 0.9,
    ) -> None:
        if desired_mps is not None:
            positive("desired_mps", desired_mps, "m/s")
        for value in look_m:
            positive("look_m", value, "m")
        self._sumo, self.ego, self._desired_mps = connection, ego, desired_mps
        self._friction = friction
        with asking("the vehicle was looked for"):
            if ego not in connection.vehicle.getIDList():
                raise InputError("SUMO", "ego", ego, "is not on the road (it drives from the step after its departure until it arrives)")
            settings = _as_traffic_keeps(settings or Settings(), keeps_left(connection, connection.vehicle.getRoute(ego)))
            self._step_s = float(connection.simulation.getDeltaT())
            self.vehicle = vehicle or vehicle_of(connection, ego)
            every = settings.cycle_s / self._step_s
            if abs(every - round(every)) > 1e-6 or abs(self._step_s / STEP_S - round(self._step_s / STEP_S)) > 1e-6:
                rule = f"must divide the planner's cycle of {settings.cycle_s:g} s: start SUMO with --step-length {settings.cycle_s:g}"
                raise ParameterError("step-length", self._step_s, rule, "s")
            self._every = round(every)
            self._frame = self._begun()
            self._traffic = Traffic(connection, ego, look_m, Levels(connection, self._edges), LanePaths(connection))
            self._traffic.subscribe()
        self.planner = None if method == SUMO else Planner(self.vehicle, method, settings=settings)
        self.name = SUMO if self.planner is None else self.planner.name
        self._tracking, self._since, self._taken = FeedForward(), 0, False
        self._plan: Plan | None = None
        self._state = self._read_state(None)
        self.ended = ""
        self.snapshots: list[Snapshot] = []
        self.contacts: list[Contact] = []
        self._touching: set[str] = set()
        self._counts = dict.fromkeys(Status, 0)
        self._unverified = 0

    @property
    def frame(self) -> RoadFrame:
        """The road as it is seen from the lane that is lane 0 now."""
        return self._frame

    @property
    def plan(self) -> Plan | None:
        """What is driven now; None where SUMO drives, or before the first step."""
        return self._plan

    @usual_arithmetic
    def step(self) -> bool:
        """One step of SUMO, with the vehicle where the plan has it; false once the vehicle has arrived or vanished.

        Raises `SumoError` where SUMO ends or refuses; what was driven so far stays in the summary.
        """
        if self.ended:
            return False
        with asking(f"{self.ego} was driven"):
            if self.planner is not None:
                self._drive(self.planner)
            self._sumo.simulationStep()
            if self.ego not in self._sumo.vehicle.getIDList():
                self.ended = "arrived" if self._left_m() < 3.0 * max(self._state.speed_mps, 5.0) else "vanished"
                return False
            self._look()
        if self._left_m() < _STOP_SHORT_M + self._state.speed_mps * self._step_s:
            self.ended = "arrived"
        return not self.ended

    @property
    def summary(self) -> SumoSummary:
        """Of the drive so far. The gap in which SUMO put the vehicle on the road is nobody's doing: it counts as one that others made."""
        instants = [instant(one.time_s, one.host, one.others) for one in self.snapshots]
        if instants:
            instants[0] = replace(instants[0], leader=None)
        return SumoSummary(
            driver=self.name,
            ended=self.ended or "driving",
            contacts=tuple(self.contacts),
            ordinary=ordinary_driving(instants),
            plans=sum(self._counts.values()),
            fallbacks=self._counts[Status.FALLBACK],
            unavoidable=self._counts[Status.UNAVOIDABLE],
            unverified_plans=self._unverified,
        )

    def situation(self) -> Situation:
        """What a planner is told at this moment."""
        frame, state, now = self._frame, self._state, self._time_s()
        line_m = next_stop_line_m(self._sumo, frame, self.ego, state.s_m + 0.5 * self.vehicle.length_m, state.speed_mps)
        road = self._road()
        others = self._traffic.around(frame, state.s_m, now)
        if len(others) > MOST_TRACKS:
            others = tuple(sorted(others, key=lambda body: abs(body.s_m - state.s_m))[:MOST_TRACKS])
        return Situation(
            time_s=now,
            host=state,
            coverage=Coverage(),
            tracks=tuple(self._traffic.tracks(frame, others, now, frame.column_at(state.s_m, state.d_m))),
            road=road,
            vehicle=self.vehicle.name,
            desired_speed_mps=road.speed_limit_mps if self._desired_mps is None else self._desired_mps,
            stop_line_s_m=line_m,
        )

    def _drive(self, planner: Planner) -> None:
        """Plans where a cycle begins, moves the car by one step of SUMO, and puts the vehicle there."""
        if not self._taken:
            self._sumo.vehicle.setSpeedMode(self.ego, 0)
            self._sumo.vehicle.setLaneChangeMode(self.ego, 0)
            self._taken = True
        if self._plan is None or self._since >= self._every:
            self._move_base(planner)
            self._plan, self._since = planner.plan(self.situation()), 0
            self._counts[self._plan.status] += 1
            self._unverified += self._plan.status is not Status.UNAVOIDABLE and not self._plan.verdict.passed
        car = KinematicPlant(self.vehicle, self._road(), self._state)
        inside = round(self._step_s / STEP_S)
        for k in range(inside):
            car.step(*self._tracking.command(self._plan.trajectory, (self._since * inside + k) * STEP_S, car.state))
        self._since += 1
        self._state = car.state
        x, y, yaw = self._frame.to_plane(self._state.s_m, self._state.d_m, self._state.heading_rad)
        front = 0.5 * self.vehicle.length_m
        at = (x + front * math.cos(yaw), y + front * math.sin(yaw))
        self._sumo.vehicle.moveToXY(self.ego, "", -1, *at, 90.0 - math.degrees(yaw), keepRoute=1, matchThreshold=100.0)

    def _move_base(self, planner: Planner) -> None:
        """Lane 0 of the road moves to the host's lane where there is none of the old one's any more, and to the lane that leads on where
        that lies beyond another that ends, once the host is settled: then everything begins anew."""
        frame, state = self._frame, self._state
        column = frame.column_at(state.s_m, state.d_m)
        gone = frame.base not in frame.section_at(state.s_m).edge.columns
        base = column_past_others(frame.edges_from(state.s_m), column if gone else frame.base)
        calm = self._plan is None or self._plan.side is Side.NONE
        if base != frame.base and calm and abs(state.d_m - frame.centre_m(column, state.s_m)) < _SETTLED_M:
            x, y, yaw = frame.to_plane(state.s_m, state.d_m, state.heading_rad)
            self._frame = RoadFrame(self._sumo.lane, self._edges, base, self._friction)
            s, d, psi = self._frame.to_road(np.array([x]), np.array([y]), np.array([yaw]), near_s_m=state.s_m)
            self._state = replace(state, s_m=float(s[0]), d_m=float(d[0]), heading_rad=math.remainder(float(psi[0]), 2.0 * math.pi))
            planner.reset()
            self._traffic.forget()

    def _look(self) -> None:
        """Notes where everybody is after the step, and who touches the host."""
        if self.planner is None:
            self._state = self._read_state(self._state.s_m)
        frame, state, now = self._frame, self._state, self._time_s()
        others = self._traffic.around(frame, state.s_m, now)
        snapshot = Snapshot(time_s=now, road=self._road(), host=self._placed(state), others=others, plan=self._plan)
        before = self.snapshots[-1] if self.snapshots else snapshot
        self.snapshots.append(snapshot)
        touching = {other.id: speed for other, speed in self._touched(before, snapshot)}
        for name, speed in touching.items():
            if name not in self._touching:
                cause, why = caused_by(self.snapshots, name)
                self.contacts.append(Contact(time_s=now, other=name, speed_mps=speed, cause=cause, why=why))
        self._touching = set(touching)

    def _touched(self, before: Snapshot, now: Snapshot) -> Iterator[tuple[Placed, float]]:
        """Who overlaps the host at, or on the straight way to, where both are now; and how fast they meet."""
        old = {other.id: other for other in before.others}
        for other in now.others:
            if abs(other.s_m - now.host.s_m) > _NEAR_M:
                continue
            first = old.get(other.id, other)
            own, theirs = self._between(before.host, now.host), self._between(first, other)
            if float(separation(own, theirs).min()) <= 0.0:
                yield other, self._relative_speed(now.host, first, other, before)

    def _between(self, first: Placed, last: Placed) -> Any:
        """Corners of a body at several places from one pose to another, in the plane of the road."""
        poses = [self._frame.to_plane_without_steps(one.s_m, one.d_m, one.heading_rad) for one in (first, last)]
        share = np.linspace(0.0, 1.0, _ALONG)
        turn = math.remainder(poses[1][2] - poses[0][2], 2.0 * math.pi)
        x, y = (poses[0][k] + share * (poses[1][k] - poses[0][k]) for k in (0, 1))
        return corners(x, y, poses[0][2] + share * turn, last.length_m, last.width_m)

    def _relative_speed(self, host: Placed, first: Placed, other: Placed, before: Snapshot) -> float:
        across = ((other.d_m - first.d_m) - (host.d_m - before.host.d_m)) / self._step_s
        return math.hypot(other.speed_mps - host.speed_mps, across)

    def _placed(self, state: HostState) -> Placed:
        return Placed(
            id=self.ego,
            s_m=state.s_m,
            d_m=state.d_m,
            heading_rad=state.heading_rad,
            speed_mps=state.speed_mps,
            acceleration_mps2=state.acceleration_mps2,
            length_m=self.vehicle.length_m,
            width_m=self.vehicle.width_m,
            lane=self._frame.column_at(state.s_m, state.d_m),
        )

    def _begun(self) -> RoadFrame:
        """The frame along the lanes of the vehicle's route."""
        vehicle = self._sumo.vehicle
        route = list(vehicle.getRoute(self.ego))[max(vehicle.getRouteIndex(self.ego), 0) :]
        lane = vehicle.getLaneID(self.ego)
        edge, _, index = lane.rpartition("_")
        if not route or edge != route[0]:
            raise InputError("SUMO", "ego", self.ego, f"is not on an edge of its route yet, but on {lane or 'none'}")
        self._edges = read_route(self._sumo, route, int(index), vehicle.getVehicleClass(self.ego))
        return RoadFrame(self._sumo.lane, self._edges, column_past_others(self._edges, main_column(self._edges)), self._friction)

    def _road(self) -> Road:
        """As it is where the host is now."""
        return self._frame.road_at(self._state.s_m)

    def _read_state(self, near_s_m: float | None) -> HostState:
        """The vehicle as SUMO has it; its wheels as the road bends."""
        vehicle = self._sumo.vehicle
        facts = {
            POSITION_3D: vehicle.getPosition3D(self.ego),
            ANGLE: vehicle.getAngle(self.ego),
            LENGTH: vehicle.getLength(self.ego),
        }
        s, d, psi = self._frame.to_road(*centres([facts]), near_s_m=near_s_m, length_m=self.vehicle.length_m)
        low, high = self.vehicle.acceleration_min_mps2, self.vehicle.acceleration_max_mps2
        return HostState(
            s_m=float(s[0]),
            d_m=float(d[0]),
            heading_rad=math.remainder(float(psi[0]), 2.0 * math.pi),
            speed_mps=max(float(vehicle.getSpeed(self.ego)), 0.0),
            acceleration_mps2=min(max(float(vehicle.getAcceleration(self.ego)), low), high),
            steering_rad=math.atan(self.vehicle.wheelbase_m * self._frame.curvature_at(float(s[0]))),
        )

    def _left_m(self) -> float:
        """Of the route, ahead of the front bumper."""
        return self._frame.end_m - self._state.s_m - 0.5 * self.vehicle.length_m

    def _time_s(self) -> float:
        return round(float(self._sumo.simulation.getTime()), 9)


def _as_traffic_keeps(settings: Settings, left: bool) -> Settings:
    return replace(settings, manners=replace(settings.manners, drives_on=Side.LEFT)) if left else settings


def vehicle_of(sumo: Connection, ego: str) -> Vehicle:
    """A vehicle as large as SUMO's, with axles at three fifths of its length from one another, and its type's acceleration and brakes."""
    length = float(sumo.vehicle.getLength(ego))
    return Vehicle(
        name="sumo",
        wheelbase_m=0.6 * length,
        front_overhang_m=0.2 * length,
        rear_overhang_m=0.2 * length,
        width_m=float(sumo.vehicle.getWidth(ego)),
        acceleration_min_mps2=-float(sumo.vehicle.getEmergencyDecel(ego)),
        acceleration_max_mps2=float(sumo.vehicle.getAccel(ego)),
        speed_max_mps=min(float(sumo.vehicle.getMaxSpeed(ego)), FASTEST_MPS),
    )
