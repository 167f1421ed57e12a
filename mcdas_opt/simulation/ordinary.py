"""What ordinary driving is measured by: headway, time to collision, ISO 15622, and what followers had to brake.

Every figure is made of `Instant`s, evenly spaced, whoever drives and whatever simulates: our own loop (`instants_of`) or another.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np

from mcdas_opt.domain.plan import Plan
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.rules import Array
from mcdas_opt.domain.vocabulary import BodyKind
from mcdas_opt.dynamics.car_following import iso_15622_limits
from mcdas_opt.simulation.metrics import BESIDE_M
from mcdas_opt.simulation.record import Simulation

HEADWAYS_S = (0.3, 0.5, 0.8)  # ISO 15622 asks for at least 0.8 s
FOLLOWING_S = 4.0  # behind somebody is who has a shorter time gap
OWED_S = 10.0  # so long a time gap that a cut-in has shortened counts as made by others
NEAR_MISS_S = 1.5
HARD_MPS2 = 4.0  # that a follower brakes
WATCHED_S = (-2.0, 3.0)  # around the host's centre crossing the line: in which a follower's braking counts (its body enters before)
MOVING_MPS = 3.0  # below this speed a time gap says nothing
_CLOSING_MPS = 0.05
ISO_TOLERANCE = 0.05  # m/s^2, m/s^3
_STEP_S = 0.1


@dataclass(frozen=True, slots=True, kw_only=True)
class Placed:
    """A body in the road's frame at an instant: its centre, its heading relative to the road, its speed and acceleration along it."""

    id: str
    s_m: float
    d_m: float
    heading_rad: float = 0.0
    speed_mps: float
    acceleration_mps2: float = 0.0
    length_m: float
    width_m: float
    lane: int  # counted to the left
    kind: BodyKind | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Snapshot:
    """The host and everybody near at `time_s`, on the road as it is there, and the plan that is driven (None: nobody of ours drives)."""

    time_s: float
    road: Road
    host: Placed
    others: tuple[Placed, ...]
    plan: Plan | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Leader:
    """Who is next ahead in the host's lane: the gap bumper to bumper and the speed along the road."""

    id: str
    gap_m: float
    speed_mps: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Instant:
    """The host at `time_s` among those who count for it."""

    time_s: float
    speed_mps: float
    acceleration_mps2: float
    lane: int
    leader: Leader | None = None
    follower: str | None = None
    accelerations_mps2: Mapping[str, float] = field(default_factory=dict)

    @property
    def headway_s(self) -> float | None:
        """Time gap to the leader; None without one, or where the host hardly moves."""
        if self.leader is None or self.speed_mps < MOVING_MPS:
            return None
        return max(self.leader.gap_m, 0.0) / self.speed_mps

    @property
    def time_to_collision_s(self) -> float | None:
        """With the leader; None without one, or where the host does not close in."""
        if self.leader is None or self.speed_mps - self.leader.speed_mps <= _CLOSING_MPS or self.leader.gap_m <= 0.0:
            return None
        return self.leader.gap_m / (self.speed_mps - self.leader.speed_mps)


def instant(time_s: float, host: Placed, others: Iterable[Placed]) -> Instant:
    """Ahead in the host's lane is whose centre is in it, or whose body reaches over the host's width, but not who is beside its way by
    `BESIDE_M`, as a cyclist whom it passes, nor who will be so when the host comes there, as an oncoming car that keeps to its own road
    where the host's turns off; behind whose centre is in it: who is left behind in another lane follows no more."""
    leader: Leader | None = None
    behind: tuple[float, str] | None = None
    accelerations = {}
    for other in others:
        accelerations[other.id] = other.acceleration_mps2
        beside_m = abs(other.d_m - host.d_m) - 0.5 * (other.width_m + host.width_m)
        if other.lane != host.lane and beside_m >= 0.0:
            continue
        gap = abs(other.s_m - host.s_m) - 0.5 * (other.length_m + host.length_m)
        if other.s_m > host.s_m:
            nearest = leader is None or gap < leader.gap_m
            if nearest and beside_m < BESIDE_M and not _clears(host, other, gap):
                leader = Leader(id=other.id, gap_m=gap, speed_mps=other.speed_mps)
        elif other.lane == host.lane and (behind is None or gap < behind[0]):
            behind = gap, other.id
    return Instant(
        time_s=time_s,
        speed_mps=host.speed_mps,
        acceleration_mps2=host.acceleration_mps2,
        lane=host.lane,
        leader=leader,
        follower=None if behind is None else behind[1],
        accelerations_mps2=accelerations,
    )


def _clears(host: Placed, other: Placed, gap_m: float) -> bool:
    """Whether somebody ahead, as he moves along and across, is beside the host's way when the host has closed the gap."""
    closing_mps = host.speed_mps - other.speed_mps
    if closing_mps <= _CLOSING_MPS or gap_m <= 0.0:
        return False
    across_mps = other.speed_mps * math.tan(other.heading_rad)
    then_m = other.d_m + across_mps * gap_m / closing_mps - host.d_m
    return abs(then_m) - 0.5 * (other.width_m + host.width_m) >= BESIDE_M


@dataclass(frozen=True, slots=True, kw_only=True)
class NearMiss:
    """The least time to collision of a stretch under NEAR_MISS_S, with whom, and whether the gap had been taken by a cut-in."""

    time_s: float
    other: str
    time_to_collision_s: float
    made_by_others: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class LaneChange:
    """The host's centre is in another lane from the instant `index` on; who is next behind there, and whether he brakes by more than
    HARD_MPS2."""

    index: int
    follower: str | None
    follower_braked: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class OrdinaryDriving:
    """Sums over a drive; shares are made of them, so that drives can be put together.

    `short_headway_s`: seconds at a time gap under each of HEADWAYS_S that no cut-in had made; `short_headway_any_s`: under the last of
    them, whoever made it. `followers_braked` of `lane_changes`: whoever is next behind in the new lane brakes by more than
    HARD_MPS2, for whatever reason.
    `outside_iso_s`: seconds beyond what ISO 15622 allows of acceleration, braking (means over 2 s) and jerk (mean over 1 s).
    """

    duration_s: float = 0.0
    distance_m: float = 0.0
    following_s: float = 0.0
    short_headway_s: tuple[float, ...] = (0.0,) * len(HEADWAYS_S)
    short_headway_any_s: float = 0.0
    least_headway_s: float | None = None
    least_time_to_collision_s: float | None = None
    near_misses: tuple[NearMiss, ...] = ()
    lane_changes: int = 0
    followers_braked: int = 0
    outside_iso_s: float = 0.0

    @property
    def mean_speed_mps(self) -> float:
        return self.distance_m / self.duration_s if self.duration_s > 0.0 else 0.0


def ordinary_driving(instants: Sequence[Instant]) -> OrdinaryDriving:
    """The measures of a drive; of one with fewer than two instants they are those of none."""
    if len(instants) < 2:
        return OrdinaryDriving()
    t = np.array([one.time_s for one in instants])
    v = np.array([one.speed_mps for one in instants])
    step = float(np.median(np.diff(t)))
    owed = made_by_others(instants)
    gaps = np.array([np.inf if one.headway_s is None else one.headway_s for one in instants])
    closing = [one.time_to_collision_s for one in instants]
    own = np.where(owed, np.inf, gaps)
    changes = list(lane_changes(instants))
    return OrdinaryDriving(
        duration_s=float(t[-1] - t[0]),
        distance_m=float(np.sum(0.5 * (v[1:] + v[:-1]) * np.diff(t))),
        following_s=step * float(np.count_nonzero(gaps < FOLLOWING_S)),
        short_headway_s=tuple(step * float(np.count_nonzero(own < limit)) for limit in HEADWAYS_S),
        short_headway_any_s=step * float(np.count_nonzero(gaps < HEADWAYS_S[-1])),
        least_headway_s=float(own.min()) if np.isfinite(own.min()) else None,
        least_time_to_collision_s=min((time for time in closing if time is not None), default=None),
        near_misses=tuple(_near_misses(instants, owed)),
        lane_changes=len(changes),
        followers_braked=sum(one.follower_braked for one in changes),
        outside_iso_s=step * float(np.count_nonzero(outside_iso(t, v, np.array([one.acceleration_mps2 for one in instants])))),
    )


def made_by_others(instants: Sequence[Instant]) -> list[bool]:
    """At each instant, whether the gap is one that somebody took: who came in between, while the host kept its lane, at most OWED_S ago.

    What the host takes by changing lanes nobody has made for it.
    """
    found, until = [False], -np.inf
    for before, now in pairwise(instants):
        if now.lane != before.lane:
            until = -np.inf
        elif now.leader is not None and (before.leader is None or _came_between(before.leader, now.leader)):
            until = now.time_s + OWED_S
        found.append(bool(now.time_s < until))
    return found


def _came_between(before: Leader, now: Leader) -> bool:
    return now.id != before.id and now.gap_m < before.gap_m


def _near_misses(instants: Sequence[Instant], owed: Sequence[bool]) -> Iterator[NearMiss]:
    worst: NearMiss | None = None
    for one, made in zip(instants, owed, strict=True):
        time = one.time_to_collision_s
        if time is None or time >= NEAR_MISS_S or one.leader is None:
            if worst is not None:
                yield worst
            worst = None
        elif worst is None or time < worst.time_to_collision_s:
            worst = NearMiss(time_s=one.time_s, other=one.leader.id, time_to_collision_s=time, made_by_others=made)
    if worst is not None:
        yield worst


def lane_changes(instants: Sequence[Instant]) -> Iterator[LaneChange]:
    """Each lane change of the host, and whether its new follower braked hard."""
    for k, (before, now) in enumerate(pairwise(instants), start=1):
        if now.lane == before.lane:
            continue
        watched = (one for one in instants if WATCHED_S[0] <= one.time_s - now.time_s <= WATCHED_S[1])
        braked = now.follower is not None and any(one.accelerations_mps2.get(now.follower, 0.0) < -HARD_MPS2 for one in watched)
        yield LaneChange(index=k, follower=now.follower, follower_braked=braked)


def beyond_iso(t_s: Array, speed_mps: Array, acceleration_mps2: Array) -> Array:
    """(3, n): by how much the mean acceleration of the next 2 s, its braking [m/s^2], and the mean jerk of the next 1 s [m/s^3] are beyond
    the limits at that speed; negative within."""
    gained = np.concatenate([[0.0], np.cumsum(0.5 * (acceleration_mps2[1:] + acceleration_mps2[:-1]) * np.diff(t_s))])
    mean = (np.interp(t_s + 2.0, t_s, gained) - gained) / 2.0
    jerk = np.interp(t_s + 1.0, t_s, acceleration_mps2) - acceleration_mps2
    most, least, jolt = np.array([iso_15622_limits(v) for v in speed_mps.tolist()]).T
    return np.array([mean - most, -mean - least, -jerk - jolt])


def outside_iso(t_s: Array, speed_mps: Array, acceleration_mps2: Array) -> Array:
    """(n,) true where any of them is beyond its limit, by more than measuring counts for."""
    return np.asarray((beyond_iso(t_s, speed_mps, acceleration_mps2) > ISO_TOLERANCE).any(axis=0))


def instants_of(drive: Simulation) -> tuple[Instant, ...]:
    """A drive of our own loop, every `_STEP_S`."""
    x, road, car = drive.trajectory, drive.scene.true_road, drive.scene.vehicle
    t = np.round(np.arange(0.0, drive.duration_s + 1e-9, _STEP_S), 9)

    def at(column: Array) -> list[float]:
        return [float(value) for value in np.interp(t, x.t_s, column)]

    def track(name: str, s: Array, d: Array, v: Array, length: float, width: float) -> list[Placed]:
        along, across, speed = at(s), at(d), at(v)
        gains = np.gradient(speed, t) if len(t) > 1 else np.zeros(1)
        return [
            Placed(
                id=name,
                s_m=along[k],
                d_m=across[k],
                speed_mps=speed[k],
                acceleration_mps2=float(gains[k]),
                length_m=length,
                width_m=width,
                lane=road.lane_of(across[k], along[k]),
            )
            for k in range(len(t))
        ]

    host = track("host", x.s_m, x.d_m, x.speed_mps, car.length_m, car.width_m)
    others = [track(one.name, one.s_m, one.d_m, one.speed_mps, one.length_m, one.width_m) for one in drive.neighbours]
    return tuple(instant(float(now), host[k], (one[k] for one in others)) for k, now in enumerate(t))
