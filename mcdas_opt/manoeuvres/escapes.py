"""The escape map: for each way out, the last moment at which it still can be started, and what ends it."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mcdas_opt.domain.escapes import Closer, Escape, Escapes
from mcdas_opt.domain.prediction import Prediction
from mcdas_opt.domain.rules import Array
from mcdas_opt.domain.situation import Situation
from mcdas_opt.domain.vehicle import GRAVITY_MPS2, Vehicle
from mcdas_opt.domain.vocabulary import Sector
from mcdas_opt.manoeuvres.escape_library import KINDS, SIDEWAYS, EscapeSettings, members
from mcdas_opt.manoeuvres.family import EDGE_M
from mcdas_opt.manoeuvres.held import held
from mcdas_opt.manoeuvres.parting import LATTICE_S, NOWHERE_M, Company, Rows, blocked, blocked_in_lane, doomed, touched
from mcdas_opt.manoeuvres.sidesteps import Starts
from mcdas_opt.manoeuvres.swerves import Motions, swerve

_HELD_STEPS = 5  # of the lattice
_ANCHORS = 3
_STARTS = 41
_GUESS_NODES = np.concatenate([np.arange(0, 75, 3), np.arange(75, 201, 15)])  # on the lattice: 0.06 s apart, later 0.3 s
_EXACT_NODES = np.concatenate([np.arange(0, 100, 2), np.arange(100, 201, 5)])  # 0.04 s, later 0.1 s
_BEST = 4  # members of each kind that are looked at exactly ...
_TRIED = (3, 1, 0, -2, -5)  # ... at these steps of the lattice from where their last start was guessed
_DOWN, _UP, _CLOSE, _ROUNDS = (6, 15, 40, 100), (4, 10), 2, 4
_GENTLEST = 3
_ABILITY_M = 10.0  # a share of the car's limits as a distance: only where it changes sign matters


@dataclass(frozen=True, slots=True, kw_only=True)
class _Guess:
    """Starts (N,) by members (N, M): by how many metres a start misses everybody, negative when it does not, and whom it misses least; the
    room to the road's edges, the share of the car's limits and of what is comfortable [m/s^2] that it leaves."""

    starts_s: Array
    free_m: Array
    nearest: Rows
    edge_m: Array
    ability: Array
    ease_mps2: Array

    @property
    def open_m(self) -> Array:
        return np.minimum(np.minimum(self.free_m, self.edge_m), _ABILITY_M * self.ability)

    def last(self, open_m: Array) -> Array:
        """(M,) The last start [s] at which this (N, M) is positive; -1 without."""
        opened = open_m > 0.0
        last = opened.shape[0] - 1 - opened[::-1].argmax(0)
        after = np.minimum(last + 1, opened.shape[0] - 1)
        columns = np.arange(opened.shape[1])
        here, there = open_m[last, columns], open_m[after, columns]
        share = here / np.maximum(here - there, 1e-9)
        moment = self.starts_s[last] + share * (self.starts_s[after] - self.starts_s[last])
        return np.where(opened.any(0), moment, -1.0)


class _Case:
    """One situation, with what is needed again and again."""

    def __init__(self, situation: Situation, vehicle: Vehicle, prediction: Prediction, chosen: EscapeSettings) -> None:
        self.situation, self.vehicle, self.chosen = situation, vehicle, chosen
        self.comfort_mps2 = chosen.comfort_on(situation.road.friction)
        self.company = Company.of(prediction.bodies, chosen.latest_s + chosen.clear_s, chosen.margins)
        self.times_s = _seconds(np.arange(0, round(chosen.latest_s / LATTICE_S) + 1, _HELD_STEPS))
        self.path = held(situation.host, self.times_s, vehicle, situation.road)
        self.members = members(situation, vehicle, prediction, chosen)

    def at(self, starts: Rows) -> Starts:
        """The host after keeping on until these steps (R,) of the lattice."""
        moments = _seconds(starts)
        path = self.path
        columns = (path.s_m, path.d_m, path.heading_rad, path.speed_mps, path.acceleration_mps2, path.steering_rad)
        s, d, heading, speed, acceleration, steering = (np.interp(moments, self.times_s, q) for q in columns)
        return Starts(s_m=s, d_m=d, heading_rad=heading, speed_mps=speed, acceleration_mps2=acceleration, steering_rad=steering)

    def driven(self, member: Any, starts: Rows, nodes: Rows) -> tuple[Motions, Rows, NDArray[np.bool_]]:
        """Members from starts (R,), on the nodes (T,) of the lattice; their clocks (R, T); which of them do anything."""
        begin = self.at(starts)
        rows, acts = self.members.rows(member, begin.speed_mps)
        motions = swerve(rows, _seconds(nodes), begin, self.vehicle, self.situation.road, self.chosen.demand)
        return motions, starts[:, None] + nodes, acts

    def end_of_keeping_on(self) -> tuple[float, Closer | None]:
        """When keeping on ends, and by what; the latest start that is sought when it does not."""
        path, road, vehicle = self.path, self.situation.road, self.vehicle
        sine, cosine = np.sin(path.heading_rad), np.cos(path.heading_rad)
        nothing = np.zeros(1)
        way = Motions(
            s_m=path.s_m[None],
            d_m=path.d_m[None],
            sine=sine[None],
            cosine=cosine[None],
            speed_mps=path.speed_mps[None],
            acceleration_mps2=path.acceleration_mps2[None],
            curvature_1pm=sine[None],
            demand_mps2=nothing,
            ability=nothing,
            edge_m=nothing,
        )
        clock = np.rint(self.times_s / LATTICE_S).astype(np.intp)
        step, who = (int(q[0]) for q in touched(way, clock[None], self.company, vehicle, road, 0.0))
        moment = self.times_s[step] if step >= 0 else np.inf
        room = 0.5 * (vehicle.width_m * cosine + vehicle.length_m * np.abs(sine)) + EDGE_M
        off = (path.d_m + room > road.left_edge_m) | (path.d_m - room < road.right_edge_m)
        if road.road_end_s_m is not None:
            off |= path.s_m + 0.5 * vehicle.length_m + EDGE_M > road.road_end_s_m
        leaves = float(self.times_s[int(off.argmax())]) if off.any() else np.inf
        if min(moment, leaves) >= self.chosen.latest_s:
            return self.chosen.latest_s, None
        if leaves < moment:
            return leaves, Closer.EDGE
        return float(moment), self.closer(who, float(moment))

    def closer(self, who: int, moment_s: float) -> Closer:
        """Front or rear for bodies in the host's way then, else a side car."""
        k = min(round(moment_s / LATTICE_S), self.company.s_m.shape[1] - 1)
        if abs(self.company.d_m[who, k] - self.situation.host.d_m) > 0.5 * self.situation.road.lane_width_m + 0.5:
            return Closer.SIDE
        return Closer.FRONT if self.company.s_m[who, k] > np.interp(moment_s, self.times_s, self.path.s_m) else Closer.REAR

    def guess(self, end_s: float) -> _Guess:
        """Every member from a few starts, all other starts in between by the gaps that it needs."""
        anchors = np.unique(np.rint(np.linspace(0.0, end_s, _ANCHORS) / LATTICE_S).astype(np.intp))
        moments = np.linspace(0.0, end_s, _STARTS)
        weights = _hats(moments, _seconds(anchors))
        parts = [self._in_lane(anchors)]
        if self.members.kind[-1] >= SIDEWAYS:
            parts.append(self._sideways(anchors))
        low, high, slack = (weights @ np.concatenate(part, axis=-1) for part in zip(*parts, strict=True))
        k = np.rint(moments / LATTICE_S).astype(np.intp)
        apart = (self.company.s_m[:, k] - np.interp(_seconds(k), self.times_s, self.path.s_m))[..., None]
        free = np.maximum(low - apart, apart - high)
        edge, ability, ease = slack
        nearest = free.argmin(0) if free.shape[0] else np.zeros(edge.shape, dtype=np.intp)
        free_m = free.min(0, initial=NOWHERE_M)
        return _Guess(starts_s=moments, free_m=free_m, nearest=nearest, edge_m=edge, ability=ability, ease_mps2=ease)

    def _sideways(self, anchors: Rows) -> tuple[Array, Array, Array]:
        """Of the members that steer, from the anchors: below and above which distances (J, K, M) bodies are met; the slacks (3, K, M)."""
        mine = np.flatnonzero(self.members.kind >= SIDEWAYS)
        motions, clock, acts = self.driven(np.tile(mine, anchors.size), np.repeat(anchors, mine.size), _GUESS_NODES)
        low, high = blocked(motions, clock, self.company, self.vehicle, self.situation.road)
        slack = np.stack([motions.edge_m, np.where(acts, motions.ability, -1.0), self.comfort_mps2 - motions.demand_mps2])
        shape = (-1, anchors.size, mine.size)
        return low.reshape(shape), high.reshape(shape), slack.reshape(shape)

    def _in_lane(self, anchors: Rows) -> tuple[Array, Array, Array]:
        """The same of the members that keep the lane: across, all of them do as one that keeps its speed."""
        mine = np.flatnonzero(self.members.kind < SIDEWAYS)
        road, chosen = self.situation.road, self.chosen
        starts = np.repeat(anchors, mine.size)
        begin = self.at(starts)
        rows, acts = self.members.rows(np.tile(mine, anchors.size), begin.speed_mps)
        low, high = blocked_in_lane(rows, begin, starts, chosen.clear_s, self.company, self.vehicle, road)
        each = np.arange(anchors.size) * mine.size
        straight = replace(rows[each], level_mps2=np.zeros(each.size))
        lone = swerve(straight, _seconds(_GUESS_NODES), self.at(anchors), self.vehicle, road, chosen.demand)
        shape = (-1, anchors.size, mine.size)
        level = rows.level_mps2.reshape(shape[1:])
        across = lone.demand_mps2[:, None]
        if not road.is_straight:  # faster, the same bend asks for more
            speed = begin.speed_mps.reshape(level.shape)
            gained = level * np.minimum(rows.until_s, chosen.clear_s).reshape(level.shape)
            across = across * np.maximum(1.0 + gained / np.maximum(speed, 1.0), 1.0) ** 2
        effort = np.hypot(level, across)
        left = np.minimum(lone.ability[:, None], 1.0 - effort / (chosen.demand.friction * road.friction * GRAVITY_MPS2))
        edge = np.broadcast_to(lone.edge_m[:, None], level.shape)
        slack = np.stack([edge, np.where(acts.reshape(shape[1:]), left, -1.0), self.comfort_mps2 - effort])
        return low.reshape(shape), high.reshape(shape), slack

    def sound(self, member: Rows, starts: Rows) -> tuple[NDArray[np.bool_], Array]:
        """Exactly: which members from these starts are ways out, and what they ask of the tyres [m/s^2]."""
        motions, clock, acts = self.driven(member, starts, _EXACT_NODES)
        step, _ = touched(motions, clock, self.company, self.vehicle, self.situation.road, self.chosen.clear_m)
        ends = doomed(motions, clock, self.company, self.vehicle, self.situation.road, self.chosen.clear_m)
        return acts & motions.possible & motions.on_road & (step < 0) & (ends < 0), motions.demand_mps2


def escapes(situation: Situation, vehicle: Vehicle, prediction: Prediction, settings: EscapeSettings | None = None) -> Escapes:
    """The four ways out, each the best of some dozens of manoeuvres of its kind, for all starts at once.

    Each manoeuvre from a few starts says which gaps it needs, and so until when each gap lasts; the best few are then driven from
    about that moment and parted from everybody exactly, so that a way called open is one.
    """
    chosen = settings or EscapeSettings()
    case = _Case(situation, vehicle, prediction, chosen)
    end_s, ender = case.end_of_keeping_on()
    guess = case.guess(end_s)
    opened = guess.open_m
    last, gentle = guess.last(opened), guess.last(np.minimum(opened, guess.ease_mps2))
    kinds = [np.flatnonzero(case.members.kind == kind) for kind in range(len(KINDS))]
    latest = int(np.floor(end_s / LATTICE_S + 1e-9))
    found = _last_sound(case, kinds, (last, gentle), latest)
    now = _gentlest_now(case, guess, opened[0] > 0.0, kinds)
    answers: dict[str, Escape] = {}
    for kind, name in enumerate(KINDS):
        refusal = _refusal(name, situation)
        start = found[0][kind]
        if refusal is not None or start < 0:
            closer = refusal or (_closer(case, guess, kinds[kind], 0) if kinds[kind].size else Closer.EDGE)
            answers[name] = Escape(closed_by=closer)
            continue
        closed_by = None
        if start < latest:
            after = int(np.searchsorted(guess.starts_s, LATTICE_S * start, side="right"))
            closed_by = _closer(case, guess, kinds[kind], min(after, _STARTS - 1))
        elif latest * LATTICE_S < chosen.latest_s - 1e-9:
            closed_by = ender
        answers[name] = Escape(
            open=True,
            last_moment_s=round(LATTICE_S * start, 4),
            closed_by=closed_by,
            demand_mps2=now[kind],
            last_comfortable_s=round(LATTICE_S * found[1][kind], 4) if found[1][kind] >= 0 else None,
        )
    return Escapes(**answers)


def _last_sound(case: _Case, kinds: list[Rows], guesses: tuple[Array, Array], latest: int) -> list[list[int]]:
    """The last start (on the lattice, -1 without) of each kind that is found sound: of any demand, and of a comfortable one."""
    tasks = [
        _Search(wanted=g, kind=kind, best=_latest(mine, last))
        for g, last in enumerate(guesses)
        for kind, mine in enumerate(kinds)
        if mine.size and last[mine].max() >= 0.0
    ]
    for task in tasks:
        near = np.floor(guesses[task.wanted][task.best] / LATTICE_S + 1e-9).astype(np.intp)
        task.ask = np.clip(near[:, None] + np.array(_TRIED), 0, latest)
    for _ in range(_ROUNDS):
        pending = [task for task in tasks if task.ask.size]
        if not pending:
            break
        members = np.concatenate([np.repeat(task.best, task.ask.shape[1]) for task in pending])
        starts = np.concatenate([task.ask.reshape(-1) for task in pending])
        sound, demand = case.sound(members, starts)
        begin = 0
        for task in pending:
            rows = slice(begin, begin + task.ask.size)
            good = sound[rows] & (demand[rows] <= case.comfort_mps2) if task.wanted else sound[rows]
            task.learn(good, starts[rows], latest)
            begin = rows.stop
    answer = [[-1] * len(KINDS) for _ in guesses]
    for task in tasks:
        answer[task.wanted][task.kind] = task.sound
    return answer


def _latest(mine: Rows, last_s: Array) -> Rows:
    """The members whose last start was guessed the latest."""
    best = mine[np.argsort(-last_s[mine], kind="stable")[:_BEST]]
    return best[last_s[best] >= 0.0]


@dataclass(slots=True)
class _Search:
    """For the last sound start of a few members: the latest found so far, the earliest after it that was not, and what to try next."""

    wanted: int
    kind: int
    best: Rows
    sound: int = -1
    ask: Rows = field(default_factory=lambda: np.zeros((0, 0), dtype=np.intp))

    def learn(self, good: NDArray[np.bool_], starts: Rows, latest: int) -> None:
        if good.any():
            self.sound = max(self.sound, int(starts[good].max()))
        beyond = starts[starts > self.sound]
        limit = int(beyond.min()) if beyond.size else latest + 1
        if self.sound < 0:
            wanted = limit - np.array(_DOWN)
        elif not beyond.size:
            wanted = self.sound + np.array(_UP)
        elif limit - self.sound > _CLOSE:
            wanted = self.sound + ((limit - self.sound) * np.array([0.25, 0.5, 0.75])).astype(np.intp)
        else:
            wanted = np.zeros(0, dtype=np.intp)
        wanted = np.unique(wanted[(wanted > self.sound) & (wanted >= 0) & (wanted <= latest)])
        self.ask = np.broadcast_to(wanted, (self.best.size, wanted.size)) if wanted.size else self.ask[:, :0]


def _gentlest_now(case: _Case, guess: _Guess, ready: NDArray[np.bool_], kinds: list[Rows]) -> list[float | None]:
    """What each kind asks of the tyres when it begins now; None where it cannot. `ready` (M,): what is worth looking at."""
    chosen = []
    for mine in kinds:
        mine = mine[ready[mine]]
        chosen.append(mine[np.argsort(-guess.ease_mps2[0, mine], kind="stable")[:_GENTLEST]])
    member = np.concatenate(chosen)
    if not member.size:
        return [None] * len(kinds)
    sound, demand = case.sound(member, np.zeros(member.size, dtype=np.intp))
    kind = case.members.kind[member]
    return [float(demand[rows].min()) if (rows := sound & (kind == k)).any() else None for k in range(len(kinds))]


def _closer(case: _Case, guess: _Guess, mine: Rows, n: int) -> Closer:
    """What is in the way of a kind at the start `n`: of its members that car and road allow, the one that comes nearest to being clear."""
    possible = guess.ability[n, mine] >= 0.0
    allowed = possible & (guess.edge_m[n, mine] >= 0.0)
    if not allowed.any() or not case.company.s_m.shape[0]:
        return Closer.EDGE if possible.any() else Closer.FRICTION
    best = mine[int(np.where(allowed, guess.free_m[n, mine], -np.inf).argmax())]
    return case.closer(int(guess.nearest[n, best]), 0.0)


def _refusal(name: str, situation: Situation) -> Closer | None:
    """A way into a direction that nobody watches is closed."""
    sector, closer = {
        "brake": (None, None),
        "accelerate": (Sector.FRONT, Closer.FRONT),
        "left": (Sector.LEFT, Closer.SIDE),
        "right": (Sector.RIGHT, Closer.SIDE),
    }[name]
    return closer if sector is not None and not situation.coverage.sees(sector) else None


def _hats(at: Array, knots: Array) -> Array:
    """Weights (N, K) of linear interpolation."""
    return np.stack([np.interp(at, knots, row) for row in np.eye(knots.size)], axis=1)


def _seconds(steps: Rows) -> Array:
    """Steps of the lattice as times [s]."""
    return np.asarray(LATTICE_S * steps, dtype=np.float64)
