"""On whom a plan relies: named in its end, and said in its reason."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from mcdas_opt.domain.prediction import PredictedBody, Prediction
from mcdas_opt.domain.safe_end import SafeEnd, in_one_text, named_in
from mcdas_opt.domain.trajectory import Trajectory
from mcdas_opt.domain.variant import names_of
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.manoeuvres.safe_end import last_end
from mcdas_opt.planning.candidate import Continuation
from mcdas_opt.planning.candidates.continuation import is_in_the_way
from mcdas_opt.planning.cycle import Cycle
from mcdas_opt.tracking.follower_prediction import predicted_to_brake
from mcdas_opt.verification.judge import judge

_PLAINLY_M = 1.0  # a gap at a drive's samples that nothing closes between them
_HARDLY_RAD, _DEEP_M = 0.1, 0.1  # of a heading; of an overlap beyond what turning by so little takes from it


def told_of_followers(found: Continuation, cycle: Cycle) -> Continuation:
    """Its end says on whom it relies of those who are expected to brake before: whom it would hit, or ask too much of, if they did not."""
    if found.end is None or found.end.relies_on is not None or not found.verdict.passed:
        return found
    drive, situation, vehicle = found.trajectory, cycle.situation, cycle.vehicle
    expected = [one for one in predicted_to_brake(cycle.prediction) if one in cycle.observed.attentive]
    if not expected or (situation.road.is_straight and _falls_behind(drive, _unaided(expected, cycle), vehicle)):
        return found
    names = [one for one in expected if is_in_the_way(drive, one, cycle)]
    if not names:
        return found
    bodies = _unaided(names, cycle)
    if not (situation.road.is_straight and _is_run_into(drive, bodies, vehicle)):
        unaided = Prediction(name=cycle.unaided.name, bodies=bodies)
        end = last_end(drive, situation.host, vehicle, situation.road, unaided, cycle.settings.safe_end, cycle.owed_m)
        if not end.follower_fails and judge(drive, situation.host, vehicle, situation.road, unaided).passed:
            return found
    return found._replace(end=replace(found.end, relies_on=in_one_text(names)))


def _unaided(names: Sequence[str], cycle: Cycle) -> tuple[PredictedBody, ...]:
    """Their bodies, as they go on who never brake."""
    theirs = frozenset(variant for one in names for variant in names_of(one))
    return tuple(body for body in cycle.unaided.bodies if body.id in theirs)


def _falls_behind(drive: Trajectory, bodies: Sequence[PredictedBody], vehicle: Vehicle) -> bool:
    """Whether all of them keep plainly clear of the drive and close in no more at its end: then nobody is relied on, which the judge need
    not be asked."""
    for body in bodies:
        motion = body.at(drive.t_s)
        gap_m = drive.s_m - motion.s_m - 0.5 * (body.length_m + vehicle.length_m)
        if gap_m.min() < _PLAINLY_M or motion.speed_s_mps[-1] > drive.speed_mps[-1]:
            return False
    return True


def _is_run_into(drive: Trajectory, bodies: Sequence[PredictedBody], vehicle: Vehicle) -> bool:
    """Whether one of them overlaps the drive at a sample, though both are turned a little: then it is relied on, which the judge need not
    be asked."""
    for body in bodies:
        motion = body.at(drive.t_s)
        length_m, width_m = 0.5 * (body.length_m + vehicle.length_m), 0.5 * (body.width_m + vehicle.width_m)
        along_m = length_m - _HARDLY_RAD * width_m - np.abs(drive.s_m - motion.s_m)
        across_m = width_m - _HARDLY_RAD * length_m - np.abs(drive.d_m - motion.d_m)
        turned = np.maximum(np.abs(drive.heading_rad), np.abs(motion.heading_rad))
        if bool(((turned < _HARDLY_RAD) & (along_m > _DEEP_M) & (across_m > _DEEP_M)).any()):
            return True
    return False


def reliance_in_words(end: SafeEnd | None, cycle: Cycle) -> str:
    """Said of followers who are expected to brake, and of an end that a follower makes safe; empty where there are none."""
    slow = [one for one in predicted_to_brake(cycle.prediction) if one not in cycle.observed.attentive]
    if not slow and (end is None or end.relies_on is None):
        slow = list(predicted_to_brake(cycle.unaided))  # who brakes there does so attentive or not
    if slow:
        return f"; {' and '.join(slow)} behind in slow traffic {'is' if len(slow) == 1 else 'are'} expected to brake"
    if end is None or end.relies_on is None:
        return ""
    names = named_in(end.relies_on, [track.id for track in cycle.situation.tracks])
    are, keep = ("is", "keeps its") if len(names) == 1 else ("are", "keep their")
    if cycle.observed.attentive.issuperset(names):
        return f"; {end.relies_on} {keep} distance behind and {are} expected to brake"
    return f"; {end.relies_on} too close behind {are} expected to brake, as no lane beside is open"
