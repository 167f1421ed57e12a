"""What every manoeuvre of the library needs from a few starts, and so, roughly, until when it can still be started."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from mcdas_opt.domain.escapes import Closer
from mcdas_opt.domain.prediction import Prediction
from mcdas_opt.domain.rules import Array
from mcdas_opt.domain.situation import Situation
from mcdas_opt.domain.vehicle import GRAVITY_MPS2, Vehicle
from mcdas_opt.manoeuvres.escape_library import SIDEWAYS, EscapeSettings, members
from mcdas_opt.manoeuvres.family import EDGE_M
from mcdas_opt.manoeuvres.held import held
from mcdas_opt.manoeuvres.parting import LATTICE_S, NOWHERE_M, Company, Rows, blocked, blocked_in_lane, doomed, touched
from mcdas_opt.manoeuvres.sidesteps import Starts
from mcdas_opt.manoeuvres.swerves import Motions, swerve

_HELD_STEPS = 2  # of the lattice
_ANCHORS = 3
_STARTS = 41
_GUESS_NODES = np.concatenate([np.arange(0, 75, 3), np.arange(75, 201, 15)])  # on the lattice: 0.06 s apart, later 0.3 s
_EXACT_NODES = np.concatenate([np.arange(0, 99, 3), np.arange(99, 200, 6), [200]])  # 0.06 s, later 0.12 s
_ABILITY_M = 10.0  # a share of the car's limits as a distance: only where it changes sign matters


class _Needs(NamedTuple):
    """Of members from anchors: below and above which distances (J, K, M) bodies are met; room to the edges, ability, ease (3, K, M)."""

    low_m: Array
    high_m: Array
    slack: Array


@dataclass(frozen=True, slots=True, kw_only=True)
class Guess:
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


class Case:
    """One situation, with what is needed again and again."""

    def __init__(self, situation: Situation, vehicle: Vehicle, prediction: Prediction, chosen: EscapeSettings) -> None:
        self.situation, self.vehicle, self.chosen = situation, vehicle, chosen
        self.comfort_mps2 = chosen.comfort_on(situation.road.friction)
        self.company = Company.of(prediction.bodies, chosen.latest_s + chosen.clear_s, chosen.margins)
        self.times_s = _seconds(np.arange(0, round(chosen.latest_s / LATTICE_S) + 1, _HELD_STEPS))
        path = held(situation.host, self.times_s, vehicle, situation.road)
        columns = (path.s_m, path.d_m, path.heading_rad, path.speed_mps, path.acceleration_mps2, path.steering_rad)
        self.path, self.table = path, np.array(columns)
        self.members = members(situation, vehicle, prediction, chosen)

    def at(self, starts: Rows) -> Starts:
        """The host after keeping on until these steps (R,) of the lattice."""
        before = np.minimum(starts // _HELD_STEPS, self.table.shape[1] - 2)
        begin = self.table[:, before]
        s, d, heading, speed, acceleration, steering = begin + (starts / _HELD_STEPS - before) * (self.table[:, before + 1] - begin)
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
        leaves = float(self.times_s[max(int(off.argmax()) - 1, 0)]) if off.any() else np.inf
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

    def guess(self, end_s: float) -> Guess:
        """Every member from a few starts, all other starts in between by the gaps that it needs."""
        anchors = np.unique(np.rint(np.linspace(0.0, end_s, _ANCHORS) / LATTICE_S).astype(np.intp))
        moments = np.linspace(0.0, end_s, _STARTS)
        weights = _hats(moments, _seconds(anchors))
        steered, lone = self._sideways(anchors)
        in_lane = self._in_lane(anchors, lone)
        low, high, slack = (weights @ np.concatenate(part, axis=-1) for part in zip(in_lane, steered, strict=True))
        k = np.rint(moments / LATTICE_S).astype(np.intp)
        apart = (self.company.s_m[:, k] - np.interp(_seconds(k), self.times_s, self.path.s_m))[..., None]
        free = np.maximum(low - apart, apart - high)
        edge, ability, ease = slack
        nearest = free.argmin(0) if free.shape[0] else np.zeros(edge.shape, dtype=np.intp)
        free_m = free.min(0, initial=NOWHERE_M)
        return Guess(starts_s=moments, free_m=free_m, nearest=nearest, edge_m=edge, ability=ability, ease_mps2=ease)

    def _sideways(self, anchors: Rows) -> tuple[_Needs, Motions]:
        """Of the members that steer, from the anchors: what they need. Behind them, what a car does that keeps its speed and its lane."""
        mine = np.flatnonzero(self.members.kind >= SIDEWAYS)
        starts = np.concatenate([np.repeat(anchors, mine.size), anchors])
        begin = self.at(starts)
        steered, acts = self.members.rows(np.tile(mine, anchors.size), begin.speed_mps[: mine.size * anchors.size])
        rows = steered.and_straight(anchors.size, self.members.straightening_mps2)
        motions = swerve(rows, _seconds(_GUESS_NODES), begin, self.vehicle, self.situation.road, self.chosen.demand)
        low, high = blocked(motions, starts[:, None] + _GUESS_NODES, self.company, self.vehicle, self.situation.road)
        slack = np.array([motions.edge_m, motions.ability, self.comfort_mps2 - motions.demand_mps2])
        shape = anchors.size, mine.size
        return _Needs(*(q[:, : acts.size].reshape(len(q), *shape) for q in (low, high, slack))), motions

    def _in_lane(self, anchors: Rows, alone: Motions) -> _Needs:
        """The same of the members that keep the lane: across, all of them do as the one that keeps its speed, the last rows of `alone`."""
        mine = np.flatnonzero(self.members.kind < SIDEWAYS)
        road, chosen = self.situation.road, self.chosen
        starts = np.repeat(anchors, mine.size)
        begin = self.at(starts)
        rows, acts = self.members.rows(np.tile(mine, anchors.size), begin.speed_mps)
        low, high = blocked_in_lane(rows, begin, starts, chosen.clear_s, self.company, self.vehicle, road)
        shape = anchors.size, mine.size
        level = rows.level_mps2.reshape(shape)
        across, ability, edge = (q[-anchors.size :, None] for q in (alone.demand_mps2, alone.ability, alone.edge_m))
        if not road.is_straight:  # faster, the same bend asks for more
            speed = begin.speed_mps.reshape(level.shape)
            gained = level * np.minimum(rows.until_s, chosen.clear_s).reshape(level.shape)
            across = across * np.maximum(1.0 + gained / np.maximum(speed, 1.0), 1.0) ** 2
        effort = np.hypot(level, across)
        left = np.minimum(ability, 1.0 - effort / (chosen.demand.friction * road.friction * GRAVITY_MPS2))
        slack = np.array([np.broadcast_to(edge, level.shape), np.where(acts.reshape(level.shape), left, -1.0), self.comfort_mps2 - effort])
        return _Needs(low.reshape(len(low), *shape), high.reshape(len(high), *shape), slack)

    def sound(self, member: Rows, starts: Rows) -> tuple[NDArray[np.bool_], Array]:
        """Exactly: which members from these starts are ways out, and what they ask of the tyres [m/s^2]."""
        motions, clock, acts = self.driven(member, starts, _EXACT_NODES)
        step, _ = touched(motions, clock, self.company, self.vehicle, self.situation.road, self.chosen.clear_m)
        ends = doomed(motions, clock, self.company, self.vehicle, self.situation.road, self.chosen.clear_m)
        return acts & motions.possible & motions.on_road & (step < 0) & (ends < 0), motions.demand_mps2


def _hats(at: Array, knots: Array) -> Array:
    """Weights (N, K) of linear interpolation."""
    return np.stack([np.interp(at, knots, row) for row in np.eye(knots.size)], axis=1)


def _seconds(steps: Rows) -> Array:
    """Steps of the lattice as times [s]."""
    return np.asarray(LATTICE_S * steps, dtype=np.float64)
