"""A plan continued to a safe end: beyond its horizon it brakes behind the front car, or to a stop, or away from the follower."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from mcdas_opt.actuation.path_following import SpeedLaw
from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.prediction import Prediction, responding
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.safe_end import EndKind, SafeEndSettings, in_one_text
from mcdas_opt.domain.trajectory import Trajectory
from mcdas_opt.domain.variant import names_of
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.domain.verdict import Verdict
from mcdas_opt.dynamics.axle_limits import driving_mps2
from mcdas_opt.manoeuvres.safe_end import IN_THE_WAY_M, ends, last_end
from mcdas_opt.planning.candidate import Continuation, Costed, Ended
from mcdas_opt.planning.candidates.collision_check import hits, judged
from mcdas_opt.planning.candidates.path_driving import follow
from mcdas_opt.planning.cycle import Cycle
from mcdas_opt.planning.deadline import Stage
from mcdas_opt.planning.proposals.expected_followers import expected_followers
from mcdas_opt.reference.lane_centre import LaneCentre

_COMFORT_MPS2 = 3.0
_PIECE_S = 3.0  # continued so far at a time, so that little is driven beyond the end that is found


def ended(candidate: Costed, cycle: Cycle) -> Ended:
    """The candidate, continued to a safe end where there is one."""
    plan, verdict, relies = candidate.trajectory, candidate.checked.verdict, candidate.proposed.relies_on_followers
    return Ended(candidate=candidate, continuation=to_safe_end(plan, verdict, cycle, relies_on_followers=relies))


def to_safe_end(plan: Trajectory, verdict: Verdict, cycle: Cycle, *, relies_on_followers: bool = False) -> Continuation:
    """The plan as it is where it failed or its end is safe, else continued to the first safe end that the judge passes.

    Its end is safe, too, where it would be but for followers who are expected to brake by then, and is if they do. Where nobody watches
    ahead it is continued to a stop, where who is behind lets it. Where no such end is found, or the deadline leaves no time to look: as it
    is, with its own end. The continuation keeps the lane that the plan ends in (or its offset, on a shoulder), gently first.
    """
    situation, vehicle, prediction, settings = cycle.situation, cycle.vehicle, cycle.prediction, cycle.settings.safe_end
    owed_m = cycle.owed_m
    last = last_end(plan, situation.host, vehicle, situation.road, prediction, settings, owed_m)
    if relies_on_followers and verdict.passed and last.follower_fails and not last.front_fails:
        expected = [one for one in expected_followers(cycle) if is_in_the_way(plan, one, cycle)]
        if expected:
            brakes = _behind_which_they_brake(prediction, expected, settings)
            answered = last_end(plan, situation.host, vehicle, situation.road, brakes, settings, owed_m).end
            if answered.safe:
                return Continuation(plan, verdict, replace(answered, relies_on=in_one_text(expected)))
    as_it_is, stops = Continuation(plan, verdict, last.end), cycle.slows_blindly and last.end.kind is not EndKind.STOPPED
    if not verdict.passed or (last.end.safe and not stops) or cycle.is_late_for(Stage.SAFE_END):
        return as_it_is
    for law in _laws(situation.road, vehicle, follower_fails=last.follower_fails, front_fails=last.front_fails or stops):
        pieces, known = [plan], len(plan)
        while float(pieces[-1].t_s[-1] - plan.t_s[-1]) < settings.longest_s:
            piece = _driven(pieces[-1], law, situation.road, vehicle)
            found = ends(piece, 1, situation.host, vehicle, situation.road, prediction, settings, owed_m)
            safe = found.safe & found.standing if stops else found.safe
            is_over = bool(safe.any())
            more = int(np.argmax(safe)) + 1 if is_over else len(piece) - 1
            if hits(piece, cycle, more + 1):
                break
            pieces.append(piece)
            if is_over:
                drive = _joined(pieces, known + more)
                if not _beyond(drive, situation.road):
                    answer = judged(drive, cycle)
                    if answer.passed:
                        return Continuation(drive, answer, found.at(more - 1, float(drive.t_s[-1])))
                break
            if found.standing[-1] or _beyond(piece, situation.road):
                break
            known += more
    return as_it_is


def is_in_the_way(plan: Trajectory, follower: str, cycle: Cycle) -> bool:
    """Whether he may be behind the plan's end, in its way."""
    s, d, theirs = plan.s_m.item(-1), plan.d_m.item(-1), names_of(follower)
    for body in cycle.prediction.bodies:
        if body.id in theirs:
            there = body.at(plan.t_s[-1:])
            if there.s_m.item() < s and abs(there.d_m.item() - d) < 0.5 * (body.width_m + cycle.vehicle.width_m) + IN_THE_WAY_M:
                return True
    return False


def _behind_which_they_brake(prediction: Prediction, followers: Sequence[str], settings: SafeEndSettings) -> Prediction:
    """The prediction with followers who brake as attentive drivers do."""
    brakes = partial(responding, response_s=settings.follower_response_s, braking_mps2=settings.attentive_braking_mps2)
    theirs = {name for one in followers for name in names_of(one)}
    return Prediction(name="followers brake", bodies=tuple(brakes(one) if one.id in theirs else one for one in prediction.bodies))


def _laws(road: Road, vehicle: Vehicle, *, follower_fails: bool, front_fails: bool) -> list[SpeedLaw]:
    """Comfortably first. Away from a follower where the front allows, else braking to a stop: whoever is behind a safe gap can too."""
    grip = road.grip_mps2
    laws = []
    if follower_fails and not front_fails:
        most = min(driving_mps2(vehicle, road.friction), 0.9 * grip)
        laws.append(SpeedLaw(speed_mps=0.98 * vehicle.speed_max_mps, acceleration_mps2=most))
    for most in (_COMFORT_MPS2, -vehicle.acceleration_min_mps2):
        laws.append(SpeedLaw(speed_mps=0.0, acceleration_mps2=min(most, 0.9 * grip)))
    return list(dict.fromkeys(laws))  # on a slippery road, comfort is all there is


def _driven(drive: Trajectory, law: SpeedLaw, road: Road, vehicle: Vehicle) -> Trajectory:
    """The next piece along the lane, from the drive's last sample, which is its first."""
    s, d, psi, v, a, delta = drive.table[1:7, -1].tolist()
    lane = road.lane_of(d, s)
    centre = road.lane_centre_m(lane, s)
    if abs(d - centre) > 0.5 * road.lane_width_at(lane, s):
        centre = d  # on a shoulder
    return follow(
        HostState(s_m=s, d_m=d, heading_rad=psi, speed_mps=max(v, 0.0), acceleration_mps2=a, steering_rad=delta),
        LaneCentre(d_m=centre),
        law,
        vehicle=vehicle,
        road=road,
        duration_s=_PIECE_S,
        lateral_acceleration_mps2=0.5 * road.grip_mps2,
        begins_s=drive.t_s.item(-1),
    )


def _beyond(drive: Trajectory, road: Road) -> bool:
    """Past the road's end with its body centre: no judge passes that, nor what comes after."""
    return road.road_end_s_m is not None and float(drive.s_m.max()) > road.road_end_s_m


def _joined(pieces: Sequence[Trajectory], samples: int) -> Trajectory:
    """The first so many samples of pieces, each of which begins with the last of the one before: from there on its inputs hold."""
    first, *others = pieces
    t = np.concatenate([first.t_s, *(piece.t_s[1:] for piece in others)])[:samples]
    states = np.concatenate([first.table[1:7], *(piece.table[1:7, 1:] for piece in others)], axis=1)[:, :samples]
    inputs = np.concatenate([piece.table[8:6:-1, :-1] for piece in pieces], axis=1)[:, : samples - 1]
    return Trajectory.from_states(t, states.T, inputs.T)
