"""What every candidate of the library needs from a few starts, and so, roughly, until when it can still be started."""

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
from mcdas_opt.dynamics.axle_limits import available_mps2
from mcdas_opt.geometry.edges import beyond_edges
from mcdas_opt.manoeuvres.starts import Starts
from mcdas_opt.time_to_react.compiled_case import Nodes
from mcdas_opt.time_to_react.constant_input import EVERY, constant_input
from mcdas_opt.time_to_react.effort import ANCHORS, APART_S, LEAST_ANCHORS, STARTS
from mcdas_opt.time_to_react.evasive_profiles import EDGE_M, Motions, evasive_motions
from mcdas_opt.time_to_react.library import CLEAR_S, LATEST_S, SIDEWAYS, EscapeSettings, Members, members
from mcdas_opt.time_to_react.predicted_traffic import LATTICE_S, PredictedTraffic, Rows, lattice_s
from mcdas_opt.time_to_react.separation import (
    ABILITY_M,
    ARRIVED_M,
    NOWHERE_M,
    blocked,
    blocked_in_lane,
    inevitable_collision,
    touched,
)

GUESS_NODES = Nodes(np.concatenate([np.arange(0, 75, 3), np.arange(75, 180, 20), [200]]))  # on the lattice: 0.06 s apart, later 0.3 s
EXACT_NODES = Nodes(np.arange(0, 201, 2))  # 0.04 s apart: steering turns fast and briefly
KEPT_TIMES_S = np.ascontiguousarray(lattice_s(round(LATEST_S / LATTICE_S) + 1)[::EVERY])  # when a host that keeps its inputs is looked at


class _Needs(NamedTuple):
    """Of members from anchors: below and above which distances (J, K, M) bodies are met; room to the edges, ability, ease (3, K, M)."""

    low_m: Array
    high_m: Array
    slack: Array


@dataclass(frozen=True, slots=True, kw_only=True)
class Guess:
    """For starts (N,) and members (M,): the last start [s] at which a member is open, and open and comfortable (M,), -1 without; by how
    many metres it is open now. And what that was made from: needs at anchors, weights (N, K), distances (J, N)."""

    starts_s: Array
    last_s: tuple[Array, Array]
    open_now_m: Array
    needs: _Needs
    weights: Array
    apart_m: Array

    def misses(self, start: int, member: Any) -> Array:
        """By how many metres these members (m,) miss everybody (J, m), negative where they do not."""
        w, apart = self.weights[start], self.apart_m[:, start, None]
        return np.asarray(np.maximum(w @ self.needs.low_m[..., member] - apart, apart - w @ self.needs.high_m[..., member]))

    def slack(self, start: int, member: Any) -> Array:
        """(3, m): room to the edges [m], the share of the car's limits and of what is comfortable [m/s^2] that is left."""
        return np.asarray(self.weights[start] @ self.needs.slack[..., member])


class Case:
    """One situation, with what is needed again and again. `among`: other manoeuvres than the library's."""

    def __init__(
        self,
        situation: Situation,
        vehicle: Vehicle,
        prediction: Prediction,
        chosen: EscapeSettings,
        among: Members | None = None,
    ) -> None:
        self.situation, self.vehicle, self.chosen = situation, vehicle, chosen
        self.brake_mps2, self.accelerate_mps2 = available_mps2(vehicle, situation.road.friction)
        self.comfort_mps2 = chosen.comfort_on(situation.road.friction)
        self.traffic = PredictedTraffic.of(prediction.bodies, LATEST_S + CLEAR_S, chosen.margins)
        self.times_s = KEPT_TIMES_S
        self.members = members(situation, vehicle, self.traffic, chosen) if among is None else among
        self.path = constant_input(situation.host, self.times_s, vehicle, situation.road)  # of the host, at these times (H,)
        path = self.path
        self.table = np.array((path.s_m, path.d_m, path.heading_rad, path.speed_mps, path.acceleration_mps2, path.steering_rad))

    def at(self, starts: Rows) -> Starts:
        """The host that has kept its inputs until these steps (R,) of the lattice."""
        before = np.minimum(starts // EVERY, self.table.shape[1] - 2)
        begin = self.table[:, before]
        s, d, heading, speed, acceleration, steering = begin + (starts / EVERY - before) * (self.table[:, before + 1] - begin)
        return Starts(s_m=s, d_m=d, heading_rad=heading, speed_mps=speed, acceleration_mps2=acceleration, steering_rad=steering)

    def driven(self, member: Any, starts: Rows, nodes: Rows, among: Members | None = None) -> tuple[Motions, Rows, NDArray[np.bool_]]:
        """Members from starts (R,), on the nodes (T,) of the lattice; their clocks (R, T); which of them do anything."""
        begin = self.at(starts)
        rows, acts = (among or self.members).rows(member, begin.speed_mps)
        motions = evasive_motions(rows, _seconds(nodes), begin, self.vehicle, self.situation.road, self.chosen.demand)
        return motions, starts[:, None] + nodes, acts

    def end_of_constant_input(self) -> tuple[float, Closer | None]:
        """When the constant-input prediction ends, and by what; the latest start that is sought when it does not."""
        path, road, vehicle = self.path, self.situation.road, self.vehicle
        sine, cosine = np.sin(path.heading_rad), np.cos(path.heading_rad)
        step, who = self._met(sine, cosine)
        moment = self.times_s[step] if step >= 0 else np.inf
        room = 0.5 * (vehicle.width_m * cosine + vehicle.length_m * np.abs(sine)) + EDGE_M
        off = beyond_edges(path.s_m, path.d_m - room, path.d_m + room, vehicle, road) > 0.0
        if road.road_end_s_m is not None:
            off |= path.s_m + 0.5 * vehicle.length_m + EDGE_M > road.road_end_s_m
        leaves = float(self.times_s[max(int(off.argmax()) - 1, 0)]) if off.any() else np.inf
        if min(moment, leaves) >= LATEST_S:
            return LATEST_S, None
        if leaves < moment:
            return leaves, Closer.EDGE
        return float(moment), self.closer(who, float(moment))

    def _met(self, sine: Array, cosine: Array) -> tuple[int, int]:
        """At which of its times a host that keeps its inputs first meets somebody, and whom; -1 without."""
        path, nothing = self.path, np.zeros(1)
        clock = EVERY * np.arange(self.times_s.size)
        keeping = Motions(
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
        step, who = touched(keeping, clock[None], self.traffic, self.vehicle, self.situation.road, 0.0)
        return int(step[0]), int(who[0])

    def closer(self, who: int, moment_s: float) -> Closer:
        """Front or rear for bodies in the host's way then, else a side car."""
        k = min(round(moment_s / LATTICE_S), self.traffic.s_m.shape[1] - 1)
        if abs(self.traffic.d_m[who, k] - self.situation.host.d_m) > 0.5 * self.situation.road.lane_width_m + 0.5:
            return Closer.SIDE
        return Closer.FRONT if self.traffic.s_m[who, k] > np.interp(moment_s, self.times_s, self.path.s_m) else Closer.REAR

    def guess(self, end_s: float) -> Guess:
        """Every member from a few starts, all other starts in between by the gaps that it needs."""
        count = min(max(LEAST_ANCHORS, 1 + int(np.ceil(end_s / APART_S))), ANCHORS)
        anchors = np.unique(np.rint(np.linspace(0.0, end_s, count) / LATTICE_S).astype(np.intp))
        moments = np.linspace(0.0, end_s, STARTS)
        weights = _hats(moments, _seconds(anchors))
        k = np.rint(moments / LATTICE_S).astype(np.intp)
        apart = self.traffic.s_m[:, k] - np.interp(_seconds(k), self.times_s, self.path.s_m)
        steered, lone = self._sideways(anchors)
        needs = _Needs(*(np.concatenate(part, axis=-1) for part in zip(self._in_lane(anchors, lone), steered, strict=True)))
        low, high, slack = (weights @ part for part in needs)
        free = np.maximum(low - apart[..., None], apart[..., None] - high).min(0, initial=NOWHERE_M)
        opened = np.minimum(np.minimum(free, slack[0]), ABILITY_M * slack[1])
        last = _last(opened, moments), _last(np.minimum(opened, slack[2]), moments)
        return Guess(starts_s=moments, last_s=last, open_now_m=opened[0], needs=needs, weights=weights, apart_m=apart)

    def _sideways(self, anchors: Rows) -> tuple[_Needs, Motions]:
        """Of the members that steer, from the anchors: what they need. Behind them, what a car does that keeps its speed and its lane."""
        mine = np.flatnonzero(self.members.kind >= SIDEWAYS)
        starts = np.concatenate([np.repeat(anchors, mine.size), anchors])
        begin = self.at(starts)
        steered, acts = self.members.rows(np.tile(mine, anchors.size), begin.speed_mps[: mine.size * anchors.size])
        rows = steered.and_straight(anchors.size, self.members.straightening_mps2)
        motions = evasive_motions(rows, GUESS_NODES.times_s, begin, self.vehicle, self.situation.road, self.chosen.demand)
        low, high = blocked(motions, starts[:, None] + GUESS_NODES.steps, self.traffic, self.vehicle, self.situation.road)
        steers = slice(acts.size)
        arrives = (ARRIVED_M - np.abs(motions.d_m[steers, -1] - steered.target_d_m)) / ABILITY_M
        ability = np.minimum(motions.ability[steers], arrives)
        slack = np.array([motions.edge_m[steers], ability, self.comfort_mps2 - motions.demand_mps2[steers]])
        shape = anchors.size, mine.size
        return _Needs(*(q[:, steers].reshape(len(q), *shape) for q in (low, high, slack))), motions

    def _in_lane(self, anchors: Rows, alone: Motions) -> _Needs:
        """The same of the members that keep the lane: across, all of them do as the one that keeps its speed, the last rows of `alone`; but
        for who brakes before a bend that is too fast for that one."""
        mine = np.flatnonzero(self.members.kind < SIDEWAYS)
        road, chosen = self.situation.road, self.chosen
        starts = np.repeat(anchors, mine.size)
        begin = self.at(starts)
        rows, acts = self.members.rows(np.tile(mine, anchors.size), begin.speed_mps)
        low, high = blocked_in_lane(rows, begin, starts, CLEAR_S, self.traffic, self.vehicle, road)
        shape = anchors.size, mine.size
        level = rows.level_mps2.reshape(shape)
        sideways = np.abs(alone.speed_mps**2 * alone.curvature_1pm)[-anchors.size :]
        across, ability, edge = sideways.max(-1)[:, None], alone.ability[-anchors.size :, None], alone.edge_m[-anchors.size :, None]
        if not road.is_straight:  # faster, the same bend asks for more
            speed = begin.speed_mps.reshape(level.shape)
            gained = level * np.minimum(rows.until_s, CLEAR_S).reshape(level.shape)
            faster = np.maximum(1.0 + gained / np.maximum(speed, 1.0), 1.0)
            across = np.where(faster > 1.0, np.maximum(across, sideways[:, -1:] * faster**2), across)
        effort = np.hypot(level, across)
        left = np.minimum(ability, 1.0 - effort / (chosen.demand.friction * road.friction * GRAVITY_MPS2))
        slack = np.array([np.broadcast_to(edge, level.shape), np.where(acts.reshape(level.shape), left, -1.0), self.comfort_mps2 - effort])
        brakes = acts.reshape(level.shape) & (level < 0.0) & (slack[1] < 0.0)
        if not road.is_straight and brakes.any():  # before a bend that is too fast for a car that keeps its speed
            driven = evasive_motions(rows, GUESS_NODES.times_s, begin, self.vehicle, road, chosen.demand)
            own = np.array([driven.edge_m, driven.ability, self.comfort_mps2 - driven.demand_mps2]).reshape(slack.shape)
            slack = np.where(brakes, own, slack)
        return _Needs(low.reshape(len(low), *shape), high.reshape(len(high), *shape), slack)

    def sound(self, member: Rows, starts: Rows, nodes: Nodes = EXACT_NODES) -> tuple[NDArray[np.bool_], Array]:
        """Exactly: which members from these starts are escapes, and what they ask of the tyres [m/s^2]."""
        return self.sound_among(self.members, member, starts, nodes)

    def sound_among(self, among: Members, member: Rows, starts: Rows, nodes: Nodes = EXACT_NODES) -> tuple[NDArray[np.bool_], Array]:
        """The same of other members."""
        motions, clock, acts = self.driven(member, starts, nodes.steps, among)
        step, _ = touched(motions, clock, self.traffic, self.vehicle, self.situation.road, self.chosen.clear_m)
        ends = inevitable_collision(motions, clock, self.traffic, self.vehicle, self.situation.road, self.chosen.clear_m)
        arrives = ~(np.abs(motions.d_m[:, -1] - among.target_d_m[member]) > ARRIVED_M)
        return acts & arrives & motions.possible & motions.on_road & (step < 0) & (ends < 0), motions.demand_mps2


def _last(open_m: Array, moments_s: Array) -> Array:
    """(M,) The last start [s] at which this (N, M) is positive; -1 without."""
    opened = open_m > 0.0
    last = opened.shape[0] - 1 - opened[::-1].argmax(0)
    after = np.minimum(last + 1, opened.shape[0] - 1)
    columns = np.arange(opened.shape[1])
    here, there = open_m[last, columns], open_m[after, columns]
    share = here / np.maximum(here - there, 1e-9)
    moment = moments_s[last] + share * (moments_s[after] - moments_s[last])
    return np.where(opened.any(0), moment, -1.0)


def _hats(at: Array, knots: Array) -> Array:
    """Weights (N, K) of linear interpolation."""
    return np.stack([np.interp(at, knots, row) for row in np.eye(knots.size)], axis=1)


def _seconds(steps: Rows) -> Array:
    """Steps of the lattice as times [s]."""
    return np.asarray(LATTICE_S * steps, dtype=np.float64)
