"""Of a drive that was lost among others who do not react: what could still have been done by somebody who knew what they would do."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.prediction import KnownBody
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.rules import Array
from mcdas_opt.domain.trajectory import Trajectory
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.evaluation.evasive_profiles import EvasiveProfiles, bend_profiles, drive_profiles, evasive_profiles
from mcdas_opt.evaluation.oracle import seen_from
from mcdas_opt.geometry.frenet import FrenetFrame
from mcdas_opt.geometry.rectangle import corners, half_extent
from mcdas_opt.manoeuvres.clearance import clearance
from mcdas_opt.simulation.contact import EDGE_SLACK_M
from mcdas_opt.simulation.idm import STEP_S
from mcdas_opt.simulation.neighbours import known_bodies
from mcdas_opt.simulation.record import Simulation

BEFORE_S = (0.5, 1.0, 1.5, 2.0, 3.0, 4.0, 6.0, 9.0, 14.0, math.inf)  # the loss: from when on something else is done, at last from the start
AFTER_S = 2.0  # the loss: until then it has to go well, as far as the recording goes
_GRID_S = 0.1
_FINE_S = 0.05
_HOPELESS_M = -0.6  # a member whose separation in the road's frame is less; in tight bends that says little
_LOOKED_AT = 60


_ATTENTIVE_S, _ATTENTIVE_MPS2 = 1.0, 4.0  # an attentive driver's response, and braking
_CLOSES_MPS, _CLOSES_S = 0.5, 6.0  # who closes in so fast, and would be there so soon, is one who has to respond


class Chance(NamedTuple):
    """How long before the loss [s] a drive begins that goes well, and that drive, its time counted from its beginning."""

    before_s: float
    drive: Trajectory


def last_chance(drive: Simulation) -> Chance | None:
    """The latest that something could still have been done, out of some thousands of profiles of braking, accelerating and steering that
    the bicycle drives at the limits of tyres and steering, and of ordinary ones that slow down for bends, along what everybody did; None
    where none of them goes well from any moment since the start, which does not prove that nothing would have.

    A drive goes well whose footprint touches nobody's and stays on the road, in the plane, until `AFTER_S` after the loss. Needs shapely.
    Raises `ParameterError` where a neighbour reacts to the host.
    """
    scene, lost_s = drive.scene, drive.duration_s
    bodies = known_bodies(scene)
    for before_s in BEFORE_S:
        begins_s = max(lost_s - before_s, 0.0)
        begun = HostState.from_vector(drive.history.states[round(begins_s / STEP_S)])
        lasts_s = min(lost_s + AFTER_S, max(scene.duration_s, lost_s)) - begins_s
        found = _found(begun, lasts_s, seen_from(bodies, begins_s), scene.vehicle, scene.true_road)
        if found is not None:
            return Chance(lost_s - begins_s, found)
        if begins_s == 0.0:
            return None
    return None


def would_have_braked(drive: Simulation) -> bool:
    """Whether who struck the host from behind would not have done so, had he been attentive: braking by 4 m/s^2 from 1 s after the host was
    in his way and he closed in on it, along the path that he is recorded on."""
    other = next((one for one in drive.neighbours if one.name == drive.collided_with), None)
    if other is None:
        return False
    car, host, t = drive.scene.vehicle, drive.trajectory, drive.trajectory.t_s
    gap = host.s_m - other.s_m - 0.5 * (car.length_m + other.length_m)
    in_way = np.abs(host.d_m - other.d_m) < 0.5 * (car.width_m + other.width_m)
    apart = np.flatnonzero(~in_way)
    since = int(apart[-1]) + 1 if apart.size else 0
    closing = other.speed_mps - host.speed_mps
    meets = np.flatnonzero((closing[since:] > _CLOSES_MPS) & (gap[since:] < _CLOSES_S * np.maximum(closing[since:], _CLOSES_MPS)))
    if not meets.size or gap[since] <= 0.0:
        return False
    begins = int(np.searchsorted(t, t[since + meets[0]] + _ATTENTIVE_S))
    if begins >= t.size:
        return False
    after = t[begins:] - t[begins]
    v = max(float(other.speed_mps[begins]), 0.0)
    stops = np.minimum(after, v / _ATTENTIVE_MPS2)
    way = other.s_m[begins] + v * stops - 0.5 * _ATTENTIVE_MPS2 * stops**2
    return bool((host.s_m[begins:] - way > 0.5 * (car.length_m + other.length_m)).all())


def _found(begun: HostState, lasts_s: float, bodies: tuple[KnownBody, ...], vehicle: Vehicle, road: Road) -> Trajectory | None:
    found = _goes_well(evasive_profiles(road, vehicle, begun.d_m, begun.s_m), begun, lasts_s, bodies, vehicle, road, _HOPELESS_M)
    if found is not None or road.is_straight:
        return found
    return _goes_well(bend_profiles(road, vehicle, begun.d_m), begun, lasts_s, bodies, vehicle, road, -math.inf)


def _goes_well(
    members: EvasiveProfiles,
    begun: HostState,
    lasts_s: float,
    bodies: tuple[KnownBody, ...],
    vehicle: Vehicle,
    road: Road,
    hopeless_m: float,
) -> Trajectory | None:
    coarse = np.linspace(0.0, lasts_s, max(math.ceil(lasts_s / _GRID_S), 2) + 1)
    tried = drive_profiles(members, coarse, begun, vehicle, road)
    far_m = 50.0 + vehicle.speed_max_mps * lasts_s
    near = tuple(body for body in bodies if np.abs(body.at(coarse).s_m - begun.s_m).min() < far_m)
    least = clearance(tried.paths(), coarse, near, vehicle, road).separation_m.min(-1)
    inside = _inside(tried.states, vehicle, road)
    order = np.argsort(-np.where(inside, least, -np.inf), kind="stable")[:_LOOKED_AT]
    for member in order:
        if not inside[member] or least[member] < hopeless_m:
            return None
        one = tried.trajectory(int(member))
        if is_free(one, near, vehicle, road):
            return one
    return None


def _inside(states: Array, vehicle: Vehicle, road: Road) -> Array:
    """(n,): which members (n, T, 6) keep between the road's edges where they are, by the corners' shadows."""
    s, d, psi = (states[..., k] for k in (0, 1, 2))
    _, aside = half_extent(psi, vehicle.length_m, vehicle.width_m)
    left, right = np.broadcast_to(road.left_edge_at(s), s.shape), np.broadcast_to(road.right_edge_at(s), s.shape)
    return np.asarray(((d + aside <= left + EDGE_SLACK_M) & (d - aside >= right - EDGE_SLACK_M)).all(-1))


def is_free(drive: Trajectory, bodies: tuple[KnownBody, ...], vehicle: Vehicle, road: Road) -> bool:
    """Whether the drive's footprints touch nobody's, in the plane, every 0.05 s."""
    t = np.linspace(0.0, float(drive.t_s[-1]), max(math.ceil(float(drive.t_s[-1]) / _FINE_S), 1) + 1)
    s, d, psi = (np.interp(t, drive.t_s, column) for column in (drive.s_m, drive.d_m, drive.heading_rad))
    motions = [(body, body.at(t)) for body in bodies]
    places = np.concatenate([s, *(motion.s_m for _, motion in motions)])
    frame = FrenetFrame(road=road, s_min_m=float(places.min()) - 1.0, s_max_m=float(places.max()) + 1.0)
    own = _footprints(frame, s, d, psi, vehicle.length_m, vehicle.width_m)
    import shapely

    return not any(
        bool(shapely.intersects(own, _footprints(frame, motion.s_m, motion.d_m, motion.heading_rad, body.length_m, body.width_m)).any())
        for body, motion in motions
    )


def _footprints(frame: FrenetFrame, s: Array, d: Array, psi: Array, length_m: float, width_m: float) -> Any:
    import shapely

    x, y, yaw = frame.to_plane(s, d, psi)
    return shapely.polygons(corners(x, y, yaw, length_m, width_m))
