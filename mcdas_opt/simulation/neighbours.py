"""Every neighbour of a scene: scripted, recorded, or following by the Intelligent Driver Model."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np

from mcdas_opt.catalogue.neighbour_tables import NeighbourPart
from mcdas_opt.catalogue.scenes import Scene
from mcdas_opt.domain.body import Body
from mcdas_opt.domain.prediction import BodyMotion, KnownBody
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.rules import Array
from mcdas_opt.domain.trajectory import Trajectory
from mcdas_opt.domain.vocabulary import BodyKind
from mcdas_opt.dynamics.car_following import IdmSettings
from mcdas_opt.errors import ParameterError
from mcdas_opt.simulation.idm import STEP_S, Follower, Presence, step_times
from mcdas_opt.simulation.recorded import RecordedMotion
from mcdas_opt.simulation.scripted import HeadedMotion, ScriptedMotion

Motion = Callable[[Array], BodyMotion]
LONGEST_S = 600.0  # the longest scene there is
_TABLE_STEPS = 1000


def motion_of(neighbour: NeighbourPart, road: Road) -> Motion:
    """The motion of a scripted or recorded neighbour as a function of time."""
    if neighbour.samples is not None:
        return RecordedMotion(samples=neighbour.samples, road=road, leaves=neighbour.leaves)
    s, d, _, speed = neighbour.initial
    if neighbour.heading_rad is not None:
        return HeadedMotion.from_script(
            s_m=s, d_m=d, heading_rad=neighbour.heading_rad, speed_mps=speed, script=neighbour.motion, road=road
        )
    return ScriptedMotion.from_script(s_m=s, d_m=d, speed_mps=speed, script=neighbour.motion, road=road, oncoming=neighbour.oncoming)


def follower_of(neighbour: NeighbourPart, road: Road) -> Follower:
    """An IDM driver: wants the speed that it begins with (from standstill: the speed limit), brakes at most 8 m/s^2 or mu g."""
    s, d, _, speed = neighbour.initial
    return Follower(
        start=Presence(s_m=s, d_m=d, speed_s_mps=speed, length_m=neighbour.length_m, width_m=neighbour.width_m),
        desired_mps=speed if speed > 0.0 else road.speed_limit_mps,
        delay_steps=round(neighbour.reaction_s / STEP_S),
        road=road,
        settings=IdmSettings(braking_limit_mps2=min(8.0, road.grip_mps2)),
    )


class Traffic:
    """All neighbours of a scene over time, in the scene's order. Deterministic; IDM drivers need the host's motion to advance.

    Exact at any time for scripted and recorded neighbours, for followers up to `time_s`. Speeds are speeds along and across the
    road's frame, ds/dt and dd/dt; a `Body` has its speed over ground.
    """

    def __init__(self, scene: Scene) -> None:
        self.road = scene.true_road
        self.names = tuple(scene.neighbour_name(i) for i in range(len(scene.neighbour)))
        self.sizes = tuple((part.length_m, part.width_m) for part in scene.neighbour)  # (length, width) [m]
        self.kinds = tuple(part.kind for part in scene.neighbour)
        self._host_size = (scene.vehicle.length_m, scene.vehicle.width_m)
        self._motions: tuple[Motion, ...] = tuple(
            follower_of(part, self.road) if part.behaviour == "idm" else motion_of(part, self.road) for part in scene.neighbour
        )
        self._followers = tuple(m for m in self._motions if isinstance(m, Follower))
        self._tables: dict[int, BodyMotion] = {}
        self._steps = 0
        self._remember(scene)

    @property
    def reacts(self) -> bool:
        """Whether anybody reacts to the host."""
        return bool(self._followers)

    def motions(self, t_s: Array) -> tuple[BodyMotion, ...]:
        """Motion of each neighbour over a vector of times."""
        return tuple(motion(t_s) for motion in self._motions)

    def motions_of_steps(self, first: int, count: int) -> tuple[BodyMotion, ...]:
        """As `motions`, at `count` steps of STEP_S from step `first` on."""
        part = slice(first, first + count)
        return tuple(
            motion(step_times(first, count)) if isinstance(motion, Follower) else self._table(i, first + count).part(part)
            for i, motion in enumerate(self._motions)
        )

    def _table(self, i: int, steps: int) -> BodyMotion:
        """A motion that nobody changes, tabulated once for at least so many steps."""
        table = self._tables.get(i)
        if table is None or len(table.s_m) < steps:
            table = self._tables[i] = self._motions[i](step_times(0, max(2 * steps, _TABLE_STEPS)))
        return table

    def bodies(self, t_s: float) -> tuple[Body, ...]:
        """Each neighbour at one instant, but for who has left."""
        return self.bodies_as(self.motions(np.array(t_s)), t_s)

    def bodies_as(self, moments: Sequence[BodyMotion], t_s: float) -> tuple[Body, ...]:
        """The same where their motion at that instant is known."""
        rows = zip(self.names, moments, self.sizes, self.kinds, self._motions, strict=True)
        return tuple(
            body_at(name, moment, length, width, self.road, kind)
            for name, moment, (length, width), kind, motion in rows
            if not (isinstance(motion, RecordedMotion) and motion.is_gone(t_s))
        )

    def known(self) -> tuple[KnownBody, ...]:
        """The motions as a prediction for the judge; followers as far as they have moved, then at constant speed."""
        rows = zip(self.names, self._motions, self.sizes, strict=True)
        return tuple(KnownBody(id=name, length_m=length, width_m=width, motion=motion) for name, motion, (length, width) in rows)

    def advance(self, host: BodyMotion) -> None:
        """As many steps of STEP_S, on from the last, as `host` has instants (its motion at the beginning of each step).

        Everybody decides before anybody moves.
        """
        times = step_times(self._steps, len(host.s_m))
        self._steps += len(times)
        if not self._followers:
            return
        fixed = self._presences(times, host)
        for others in fixed:
            now = [follower.now for follower in self._followers]
            for i, follower in enumerate(self._followers):
                follower.look(now[i], [*others, *now[:i], *now[i + 1 :]])
            for follower in self._followers:
                follower.advance()

    def _remember(self, scene: Scene) -> None:
        """Lets followers see what they saw before the scene began."""
        longest = max((follower.delay_steps for follower in self._followers), default=0)
        times = step_times(-longest, longest)
        for t, others in zip(times, self._presences(times, host_before(scene, times)), strict=True):
            then = [follower.before(float(t)) for follower in self._followers]
            for i, follower in enumerate(self._followers):
                if t > -(follower.delay_steps + 0.5) * STEP_S:
                    follower.look(then[i], [*others, *then[:i], *then[i + 1 :]])

    def _presences(self, times_s: Array, host: BodyMotion) -> list[list[Presence]]:
        """At each time, the host and everybody who is not a follower."""
        moved = [(host, self._host_size)] + [
            (motion(times_s), size) for motion, size in zip(self._motions, self.sizes, strict=True) if not isinstance(motion, Follower)
        ]
        columns = [(m.s_m.tolist(), m.d_m.tolist(), m.speed_s_mps.tolist(), size, m.speed_d_mps.tolist()) for m, size in moved]
        return [[Presence(s[k], d[k], v[k], *size, across[k]) for s, d, v, size, across in columns] for k in range(len(times_s))]


def body_at(name: str, moment: BodyMotion, length_m: float, width_m: float, road: Road, kind: BodyKind | None = None) -> Body:
    """The body at a single instant of its motion. Its speed has the sign of the motion along its own heading: who comes towards the host
    drives forwards."""
    s, d, heading = float(moment.s_m), float(moment.d_m), float(moment.heading_rad)
    along = float(moment.speed_s_mps) * (1.0 - d * (0.0 if road.is_straight else float(road.curvature_at(s))))
    across = float(moment.speed_d_mps)
    speed = math.copysign(math.hypot(along, across), along * math.cos(heading) + across * math.sin(heading))
    return Body(name=name, s_m=s, d_m=d, heading_rad=heading, speed_mps=speed, length_m=length_m, width_m=width_m, kind=kind)


def host_motion(states: Array, road: Road) -> BodyMotion:
    """The motion of a host with these states (n, 6)."""
    s, d, psi, v = states[:, 0], states[:, 1], states[:, 2], states[:, 3]
    along = v * np.cos(psi) / (1.0 - d * road.curvature_at(s))
    return BodyMotion(s_m=s, d_m=d, heading_rad=psi, speed_s_mps=along, speed_d_mps=v * np.sin(psi))


def host_before(scene: Scene, t_s: Array) -> BodyMotion:
    """The host before t = 0: it has come along the road at constant speed."""
    t, start = np.asarray(t_s, dtype=np.float64), scene.host_state
    zero = np.zeros_like(t)
    return BodyMotion(
        s_m=start.s_m + start.speed_mps * t,
        d_m=zero + start.d_m,
        heading_rad=zero + start.heading_rad,
        speed_s_mps=zero + start.speed_mps,
        speed_d_mps=zero,
    )


def host_along(trajectory: Trajectory, t_s: Array) -> BodyMotion:
    """The host's motion on a trajectory, linear in between; beyond its end it goes on along the road at the last speed."""
    inside = np.clip(t_s, trajectory.t_s[0], trajectory.t_s[-1])
    columns = (trajectory.s_m, trajectory.d_m, trajectory.heading_rad, trajectory.speed_mps)
    s, d, psi, v = (np.interp(inside, trajectory.t_s, column) for column in columns)
    along = v * np.cos(psi)
    return BodyMotion(s_m=s + (t_s - inside) * along, d_m=d, heading_rad=psi, speed_s_mps=along, speed_d_mps=v * np.sin(psi))


def known_bodies(scene: Scene, host: Trajectory | None = None) -> tuple[KnownBody, ...]:
    """Every neighbour's motion in a scene as the judge's prediction. Followers react to `host`, the trajectory to be judged.

    Raises `ParameterError` when the scene has followers and no host trajectory is given.
    """
    traffic = Traffic(scene)
    if traffic.reacts:
        if host is None:
            raise ParameterError("host", None, "idm neighbours can only be predicted against a host trajectory")
        sound = bool(np.isfinite(host.states).all() and np.isfinite(host.t_s).all() and np.all(np.diff(host.t_s) > 0.0))
        end = min(float(host.t_s[-1]), LONGEST_S) if sound else 0.0  # nobody reacts to a trajectory that is not finite or runs back in time
        traffic.advance(host_along(host, step_times(0, math.ceil(max(end - 1e-9, 0.0) / STEP_S))))
    return traffic.known()
