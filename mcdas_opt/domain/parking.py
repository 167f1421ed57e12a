"""Parking: the case, the trajectory, the answer. Poses are (x, y, heading) of the rear axle's midpoint, metres and radians."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, fields, replace
from operator import attrgetter
from typing import Any, ClassVar, NamedTuple

import numpy as np

from mcdas_opt.domain.equality import EqualByValue
from mcdas_opt.domain.result import Columns, Result
from mcdas_opt.domain.rules import (
    FARTHEST_M,
    Array,
    all_of,
    angle,
    floats,
    measurable,
    non_negative,
    require,
    require_type,
    require_type_if_given,
    vector,
    within,
)
from mcdas_opt.domain.trajectory import Vectors
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.domain.verdict import Verdict
from mcdas_opt.errors import ParameterError

LARGEST_SLOT_M = 1000.0
FARTHEST_ORIGIN_M = 1e10  # of surveyed coordinates: there micrometres are still told apart, and answers are judged as they are read
FARTHEST_APART_M = 1000.0  # start and goal: nobody parks from farther away
LEAST_LEG_M = 1e-3  # what is shorter is no leg; zigzags in the narrowest slots have legs of 3 mm, and need them


@dataclass(frozen=True, slots=True, kw_only=True)
class ParkingLimits:
    """What the judge enforces besides the vehicle's steering angle and rate. No jerk limit; steering at standstill is allowed."""

    clearance_m: float = 0.05  # body to every obstacle, at all times
    forward_mps: float = 2.5
    reverse_mps: float = 2.0
    acceleration_mps2: float = 1.5  # both signs, may step

    def __post_init__(self) -> None:
        non_negative("clearance_m", self.clearance_m, "m")
        require(self, measurable, "forward_mps", "reverse_mps", "acceleration_mps2")


@dataclass(frozen=True, slots=True, kw_only=True)
class ParkingTolerance:
    """How near the end pose must be to the goal; the start is held to the same."""

    position_m: float = 0.02
    heading_rad: float = 0.01

    def __post_init__(self) -> None:
        require(self, measurable, "position_m", "heading_rad")


@dataclass(frozen=True, slots=True, kw_only=True)
class ParallelSlot:
    """The contract's slot: 0 <= x <= length, -depth <= y <= 0, parked cars before and behind, kerb below, opposite side above."""

    length_m: float
    depth_m: float = 2.1
    street_m: float = 4.5

    def __post_init__(self) -> None:
        require(self, measurable, "length_m", "depth_m", "street_m")
        for name in ("length_m", "depth_m", "street_m"):
            within(name, attrgetter(name)(self), 0.0, LARGEST_SLOT_M, "m")

    @property
    def obstacles(self) -> tuple[Array, ...]:
        """Rear car, front car, kerb, opposite side; counter-clockwise rectangles."""
        end, beyond = self.length_m, 6.0
        boxes = (
            (-beyond, 0.0, -self.depth_m, 0.0),
            (end, end + beyond, -self.depth_m, 0.0),
            (-beyond, end + beyond, -self.depth_m - 0.5, -self.depth_m),
            (-beyond, end + beyond, self.street_m, self.street_m + 0.5),
        )
        return tuple(np.array([[x0, y0], [x1, y0], [x1, y1], [x0, y1]]) for x0, x1, y0, y1 in boxes)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ParkingCase(EqualByValue):
    """A parking problem. Coordinates are relative to `origin_m`, which the files' and the answers' coordinates include.

    `obstacles` are simple counter-clockwise polygons (n, 2), `names` their names in messages.
    """

    name: str = "case"
    vehicle: Vehicle = field(default_factory=Vehicle)
    start: Array
    goal: Array
    obstacles: tuple[Array, ...] = ()
    names: tuple[str, ...] = ()
    start_steering_rad: float = 0.0
    limits: ParkingLimits = field(default_factory=ParkingLimits)
    tolerance: ParkingTolerance = field(default_factory=ParkingTolerance)
    slot: ParallelSlot | None = None
    origin_m: tuple[float, float] = (0.0, 0.0)
    notes: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        require_type("name", self.name, str)
        for key, value, kind in (
            ("vehicle", self.vehicle, Vehicle),
            ("limits", self.limits, ParkingLimits),
            ("tolerance", self.tolerance, ParkingTolerance),
        ):
            require_type(key, value, kind)
        require_type_if_given("slot", self.slot, ParallelSlot)
        for key, texts in (("names", self.names), ("notes", self.notes)):
            object.__setattr__(self, key, all_of(key, texts, str))
        object.__setattr__(self, "start", vector("start", self.start, length=3))
        object.__setattr__(self, "goal", vector("goal", self.goal, length=3))
        for name, pose in (("start", self.start), ("goal", self.goal)):
            for k, value in enumerate(pose.tolist()):
                within(f"{name}[{k}]", value, -FARTHEST_M, FARTHEST_M)
            angle(f"{name}[2]", float(pose[2]), turns=2)  # on the way a car may have turned on, beyond one
        apart_m = math.dist(self.start[:2], self.goal[:2])
        if apart_m > FARTHEST_APART_M:
            raise ParameterError("goal", apart_m, f"must lie within {FARTHEST_APART_M:g} m of the start", "m")
        top = self.vehicle.steering_max_rad
        within("start_steering_rad", self.start_steering_rad, -top, top, "rad")
        object.__setattr__(self, "origin_m", tuple(vector("origin_m", self.origin_m, "m", length=2).tolist()))
        for k, place in enumerate(self.origin_m):
            within(f"origin_m[{k}]", place, -FARTHEST_ORIGIN_M, FARTHEST_ORIGIN_M, "m")
        require_type("obstacles", self.obstacles, list, tuple)
        obstacles = []
        for k, outline in enumerate(self.obstacles):
            array = floats(f"obstacles[{k}]", outline, "must be vertices (x, y)", "m")
            if array.ndim != 2 or array.shape[0] < 3 or array.shape[1] != 2 or not np.all(np.isfinite(array)):
                raise ParameterError(f"obstacles[{k}]", f"shape {array.shape}", "must be at least three finite vertices (x, y)", "m")
            if np.abs(array).max() > FARTHEST_M:
                raise ParameterError(f"obstacles[{k}]", float(np.abs(array).max()), f"must lie within {FARTHEST_M:g} of 0", "m")
            array.setflags(write=False)
            obstacles.append(array)
        object.__setattr__(self, "obstacles", tuple(obstacles))
        if len(self.names) != len(obstacles):
            object.__setattr__(self, "names", tuple(f"obstacle[{k}]" for k in range(len(obstacles))))


def reversals(lengths_m: Sequence[float] | Array) -> int:
    """Changes of sign between signed lengths [m] driven one after the other; those shorter than `LEAST_LEG_M` are left out."""
    lengths = np.asarray(lengths_m, dtype=np.float64)
    return int(np.sum(np.diff(np.sign(lengths[np.abs(lengths) >= LEAST_LEG_M])) != 0.0))


class Leg(NamedTuple):
    """Driven in one direction, rests included: from when until when [s], and how far [m], negative in reverse."""

    from_s: float
    until_s: float
    length_m: float


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ParkingTrajectory(Vectors):
    """Poses of the rear axle's midpoint; speed negative in reverse.

    Speed and steering are linear in between, and poses are their integral. `acceleration_mps2` and `steering_rate_radps` at k hold over
    [t_k, t_k+1).
    """

    t_s: Array
    x_m: Array
    y_m: Array
    heading_rad: Array
    speed_mps: Array
    acceleration_mps2: Array
    steering_rad: Array
    steering_rate_radps: Array

    @property
    def poses(self) -> Array:
        """(n, 3): x, y, heading."""
        return np.column_stack([self.x_m, self.y_m, self.heading_rad])

    @property
    def duration_s(self) -> float:
        return float(self.t_s[-1] - self.t_s[0]) if len(self) else 0.0

    @property
    def path_m(self) -> float:
        """Distance driven, forward and in reverse added: the integral of |speed|, exact for speed linear in between."""
        v, dt = self.speed_mps, np.diff(self.t_s)
        a, b = v[:-1], v[1:]
        crossing = a * b < 0.0
        plain = 0.5 * np.abs(a + b)
        gap = np.where(crossing, np.abs(b - a), 1.0)
        return float(np.sum(np.where(crossing, 0.5 * (a * a + b * b) / gap, plain) * dt))

    @property
    def legs(self) -> tuple[Leg, ...]:
        """The motion cut where its direction changes, also between two samples; of any length."""
        t, v = self.t_s, self.speed_mps
        turns = np.flatnonzero(v[:-1] * v[1:] < 0.0)
        share = v[turns] / (v[turns] - v[turns + 1])
        t = np.insert(t, turns + 1, t[turns] + share * (t[turns + 1] - t[turns]))
        v = np.insert(v, turns + 1, 0.0)
        twice = v[:-1] + v[1:]
        moving = np.flatnonzero(twice)
        if not moving.size:
            return ()
        sign = np.sign(twice[moving])
        first = np.flatnonzero(np.append(True, sign[1:] != sign[:-1]))
        last = np.append(first[1:], moving.size) - 1
        lengths = np.add.reduceat((0.5 * twice * np.diff(t))[moving], first)
        return tuple(map(Leg, t[moving[first]].tolist(), t[moving[last] + 1].tolist(), lengths.tolist()))

    @property
    def gear_changes(self) -> int:
        """Reversals of the direction of travel; rests and legs shorter than `LEAST_LEG_M` do not count."""
        return reversals([leg.length_m for leg in self.legs])

    @property
    def gears(self) -> Array:
        """+1 forward or -1 in reverse at every sample; a rest, and a leg shorter than `LEAST_LEG_M`, counts to the leg that follows."""
        legs = [leg for leg in self.legs if abs(leg.length_m) >= LEAST_LEG_M]
        if not legs:
            return np.ones(len(self))
        at = np.searchsorted([leg.until_s for leg in legs], self.t_s, side="right").clip(0, len(legs) - 1)
        gears: Array = np.array([np.sign(leg.length_m) for leg in legs])[at]
        return gears

    @classmethod
    def from_controls(cls, t_s: Array, poses: Array, speed_mps: Array, steering_rad: Array) -> ParkingTrajectory:
        """From times, poses (n, 3), speeds and steering angles; acceleration and steering rate are their slopes."""
        dt = np.diff(t_s)
        slopes = [np.diff(q) / np.maximum(dt, 1e-12) for q in (speed_mps, steering_rad)]
        slopes = [np.append(s, s[-1:] if s.size else [0.0]) for s in slopes]
        x, y, psi = np.asarray(poses).T
        return cls(
            t_s=t_s,
            x_m=x,
            y_m=y,
            heading_rad=psi,
            speed_mps=speed_mps,
            acceleration_mps2=slopes[0],
            steering_rad=steering_rad,
            steering_rate_radps=slopes[1],
        )

    def moved(self, dx: float, dy: float) -> ParkingTrajectory:
        """The same trajectory in coordinates shifted by (dx, dy) [m]."""
        return replace(self, x_m=self.x_m + dx, y_m=self.y_m + dy)

    @classmethod
    def from_columns(cls, columns: dict[str, Any]) -> ParkingTrajectory:
        """From a mapping of columns; acceleration and steering rate are made from the slopes where they are missing."""
        t, v, delta = (np.asarray(columns[k], dtype=np.float64) for k in ("t_s", "speed_mps", "steering_rad"))
        made = cls.from_controls(t, np.column_stack([columns[k] for k in ("x_m", "y_m", "heading_rad")]), v, delta)
        given: dict[str, Any] = {k: columns[k] for k in ("acceleration_mps2", "steering_rate_radps") if k in columns}
        return replace(made, **given)


@dataclass(frozen=True, slots=True, kw_only=True)
class ParkingAttempt:
    """One attempt: how long it drives (None when it has no path) and what the judge or the solver said."""

    name: str
    duration_s: float | None
    gear_changes: int | None
    passed: bool
    note: str = ""
    seconds: float = 0.0  # of computing; does not repeat


@dataclass(frozen=True, slots=True, kw_only=True, repr=False)
class Parking(Result):
    """The answer to a case. `trajectory` is None when not even an infeasible attempt exists; coordinates are the case file's.

    `min_clearance_m` is None without obstacles or trajectory; `asked_clearance_m` is what was asked beside it.
    """

    drawn_by: ClassVar[str] = "mcdas_opt.plotting.parking:sheet"
    moves_by: ClassVar[str] = "mcdas_opt.plotting.parking:film"
    plays_by: ClassVar[str] = "mcdas_opt.plotting.player:parking_page"

    planner: str
    status: str  # planned | refused | budget (refused because a cap on nodes or iterations was reached)
    reason: str
    verdict: Verdict
    duration_s: float | None
    path_m: float | None
    gear_changes: int | None
    min_clearance_m: float | None
    asked_clearance_m: float
    obstacles: tuple[Array, ...]
    trajectory: ParkingTrajectory | None
    attempts: tuple[ParkingAttempt, ...] = ()
    notes: tuple[str, ...] = ()
    timing_ms: dict[str, float] = field(default_factory=dict)
    nodes: int = 0
    iterations: int = 0
    case: ParkingCase | None = field(default=None, repr=False, compare=False)

    @property
    def passed(self) -> bool:
        return self.verdict.passed

    def in_brief(self) -> tuple[str, str, str]:
        least = "" if self.min_clearance_m is None else f", least clearance {self.min_clearance_m:.3f} m"
        driven = "no path"
        if self.trajectory is not None:
            driven = f"{self.duration_s:.1f} s, {self.path_m:.1f} m, {self.gear_changes} gear changes{least}"
        return (f"Parking of {self.planner}: {self.status}, {driven}", f"verdict: {self.verdict.reason}", self.reason)

    def columns(self) -> Columns:
        """The trajectory; empty columns where there is none."""
        return {item.name: () for item in fields(ParkingTrajectory)} if self.trajectory is None else self.trajectory.columns()
