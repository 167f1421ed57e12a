"""The witness half of the oracle: was there a drive that avoided everything and needed no knowledge of the future?"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from mcdas_opt.catalogue.neighbour_tables import NeighbourPart
from mcdas_opt.catalogue.scenes import Scene
from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.prediction import BodyMotion, KnownBody, PredictedBody, Prediction
from mcdas_opt.domain.rules import Array
from mcdas_opt.domain.trajectory import Trajectory
from mcdas_opt.errors import ParameterError
from mcdas_opt.evaluation.evasive_profiles import drive_profiles, evasive_profiles, lane_keeping
from mcdas_opt.evaluation.library import library
from mcdas_opt.manoeuvres.clearance import clearance
from mcdas_opt.manoeuvres.driven import driven
from mcdas_opt.manoeuvres.family import Demand, roll_out
from mcdas_opt.simulation.neighbours import known_bodies
from mcdas_opt.verification.judge import judge

REACTION_S = 0.2
TTC_S = 4.0
_COARSE_S, _FINE_S = 0.1, 0.05
_NEVER_BRAKES = " (never brakes)"
_DRIVEN_AT_ONCE = 8
_DRIVEN_AT_MOST = 24
_HOPEFUL_M = -0.15  # a coarse separation under this is not driven
_HOPELESS_M = -0.02  # the same where the members are driven already


def onset_s(scene: Scene) -> float:
    """The first instant at which a neighbour's acceleration changes, its move aside begins, or a time to collision in the host's lane
    falls under 4 s; the scene's end when there is none. The host keeps its lane and speed until then."""
    found = scene.duration_s
    for part in scene.neighbour:
        starts = [piece.start_s for piece in part.motion if piece.acceleration_mps2 or piece.lateral_to_m is not None]
        found = min([found, *starts])
    times = np.arange(0.0, scene.duration_s + 1e-9, 0.02)
    vehicle, host = scene.vehicle, scene.host_state
    for body in known_bodies(scene):
        motion = body.at(times)
        in_way = np.abs(motion.d_m - host.d_m) < 0.5 * (body.width_m + vehicle.width_m)
        apart = motion.s_m - host.s_m - host.speed_mps * times
        gap = np.abs(apart) - 0.5 * (body.length_m + vehicle.length_m)
        closing = np.sign(apart) * (host.speed_mps - motion.speed_s_mps)
        soon = in_way & (closing > 1e-9) & (gap < TTC_S * closing)
        if soon.any():
            found = min(found, float(times[int(soon.argmax())]))
    return found


def unbraked(scene: Scene) -> tuple[PredictedBody, ...]:
    """The cars behind the host in its lane that brake in the scene, as they would go on if they never did."""
    changed: list[KnownBody] = []
    parts: list[NeighbourPart] = list(scene.neighbour)
    for index, part in enumerate(scene.neighbour):
        s, d, _, _ = part.initial
        behind = s < 0.0 and abs(d - scene.host.d_m) < 0.5 * scene.road.lane_width_m
        if behind and any((piece.acceleration_mps2 or 0.0) < 0.0 for piece in part.motion):
            calm = [piece for piece in part.motion if (piece.acceleration_mps2 or 0.0) >= 0.0]
            parts[index] = part.model_copy(update={"motion": calm})
    if parts == list(scene.neighbour):
        return ()
    twin = scene.model_copy(update={"neighbour": parts})
    for index, body in enumerate(known_bodies(twin)):
        if parts[index] is not scene.neighbour[index]:
            changed.append(replace(body, id=body.id + _NEVER_BRAKES))
    return tuple(changed)


def refuse_reacting(scene: Scene) -> None:
    """Raises `ParameterError` when a neighbour reacts to the host: what would have happened is not known then."""
    if any(part.behaviour == "idm" for part in scene.neighbour):
        raise ParameterError("neighbour.behaviour", "idm", "the oracle knows scripted neighbours only")


def start_s(scene: Scene, onset: float, reaction_s: float) -> float:
    """The first instant on the grid of drives at which somebody who needs `reaction_s` may act."""
    return min(round(math.ceil((onset + reaction_s) / _FINE_S - 1e-9) * _FINE_S, 9), scene.duration_s)


def witness(scene: Scene) -> Trajectory | None:
    """A drive from the library, from the scene's start, that is safe whether the rear car brakes later or not; None where it holds none.

    Raises `ParameterError` when a neighbour reacts to the host.
    """
    refuse_reacting(scene)
    return witness_from(scene, start_s(scene, onset_s(scene), REACTION_S), (*known_bodies(scene), *unbraked(scene)))[0]


def witness_from(scene: Scene, start_s: float, bodies: tuple[PredictedBody, ...]) -> tuple[Trajectory | None, int]:
    """A drive that keeps its lane and speed until `start_s`, then does what the library has, and passes the judge; how many were tried."""
    road, vehicle, begin = scene.true_road, scene.vehicle, lane_kept_until(scene, start_s)
    left = max(scene.duration_s - start_s, 2.0 * _COARSE_S)
    coarse = _grid(left, _COARSE_S)
    later = seen_from(bodies, start_s)
    demand = Demand(friction=1.0, steering=1.0)
    tried = 0
    for phases, steps in library(road, vehicle, begin.d_m):
        rolled = roll_out(phases, steps, coarse, begin, vehicle, road, demand)
        tried += rolled.possible.size
        least = clearance(rolled.paths, coarse, later, vehicle, road).separation_m.min(-1)
        least = np.where(rolled.possible & rolled.on_road, least, -np.inf)
        order = np.argsort(-least, axis=None, kind="stable")[:_DRIVEN_AT_MOST]
        order = order[least.reshape(-1)[order] > _HOPEFUL_M]
        for part in range(0, order.size, _DRIVEN_AT_ONCE):
            chosen = order[part : part + _DRIVEN_AT_ONCE]
            p, q = np.unravel_index(chosen, least.shape)
            fine = roll_out(phases[p, 0], steps[0, q], _grid(left, _FINE_S), begin, vehicle, road, demand)
            for one in driven(fine, begin, vehicle, road):
                drive = passed(scene, one, start_s, bodies)
                if drive is not None:
                    return drive, tried
    return None, tried


def finer_witness_from(scene: Scene, start_s: float, bodies: tuple[PredictedBody, ...]) -> tuple[Trajectory | None, int]:
    """The same from the finer library of evasive profiles, those with the most room first."""
    road, vehicle, begin = scene.true_road, scene.vehicle, lane_kept_until(scene, start_s)
    grid = _grid(max(scene.duration_s - start_s, 2.0 * _COARSE_S), _FINE_S)
    members = evasive_profiles(road, vehicle, begin.d_m)
    tried = drive_profiles(members, grid, begin, vehicle, road)
    least = clearance(tried.paths(), grid, seen_from(bodies, start_s), vehicle, road).separation_m.min(-1)
    least = np.where(tried.on_road(vehicle, road), least, -np.inf)
    for member in np.argsort(-least, kind="stable")[:_DRIVEN_AT_MOST]:
        if least[member] > _HOPELESS_M:
            drive = passed(scene, tried.trajectory(int(member)), start_s, bodies)
            if drive is not None:
                return drive, len(least)
    return None, len(least)


def lane_kept_until(scene: Scene, start_s: float) -> HostState:
    """The host at `start_s`, having kept its lane and speed."""
    return HostState.from_vector(_lane_kept(scene, start_s)[0][-1])


def _lane_kept(scene: Scene, start_s: float) -> tuple[Array, Array]:
    """States (n + 1, 6) and inputs (n, 2) of a host that keeps its lane and speed until `start_s`: driven, where the road bends."""
    host, road, vehicle = scene.host_state, scene.true_road, scene.vehicle
    times = np.round(np.arange(round(start_s / _FINE_S) + 1) * _FINE_S, 9)
    if road.is_straight and not host.heading_rad and not host.acceleration_mps2:
        steady = HostState(s_m=host.s_m, d_m=host.d_m, speed_mps=host.speed_mps)
        states = np.tile(steady.to_vector(), (len(times), 1))
        states[:, 0] += host.speed_mps * times
        return states, np.zeros((len(times) - 1, 2))
    kept = drive_profiles(lane_keeping(host.d_m), times, host, vehicle, road)
    return kept.states[0], kept.inputs[0]


def passed(scene: Scene, drive: Trajectory, start_s: float, bodies: tuple[PredictedBody, ...]) -> Trajectory | None:
    """The whole drive, lane and speed kept until `start_s`, if the judge passes it."""
    whole = _after_keeping_lane(drive, scene, start_s)
    verdict = judge(whole, scene.host_state, scene.vehicle, scene.true_road, Prediction(name="scene", bodies=bodies))
    return whole if verdict.passed else None


def _grid(duration_s: float, step_s: float) -> Array:
    return np.round(np.arange(max(math.floor(duration_s / step_s + 1e-9), 2) + 1) * step_s, 9)


def seen_from(bodies: tuple[PredictedBody, ...], start_s: float) -> tuple[KnownBody, ...]:
    """The bodies with their clocks set to 0 at `start_s`."""
    return tuple(_later(body, start_s) for body in bodies)


def _later(body: PredictedBody, start_s: float) -> KnownBody:
    def motion(t_s: Array) -> BodyMotion:
        return body.at(t_s + start_s)

    return KnownBody(id=body.id, length_m=body.length_m, width_m=body.width_m, motion=motion)


def _after_keeping_lane(drive: Trajectory, scene: Scene, start_s: float) -> Trajectory:
    """The drive, preceded by lane and speed kept from time 0."""
    before, inputs_before = _lane_kept(scene, start_s)
    count = len(inputs_before)
    t = np.round(np.concatenate([np.arange(count) * _FINE_S, start_s + drive.t_s]), 9)
    states = np.vstack([before[:-1], drive.states])
    inputs = np.vstack([inputs_before, drive.inputs])
    return Trajectory.from_states(t, states, inputs)
