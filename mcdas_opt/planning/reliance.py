"""On whom a plan relies: named in its end, and said in its reason."""

from __future__ import annotations

from dataclasses import replace

from mcdas_opt.domain.prediction import Prediction
from mcdas_opt.domain.safe_end import SafeEnd
from mcdas_opt.domain.variant import names_of
from mcdas_opt.manoeuvres.safe_end import last_end
from mcdas_opt.planning.candidate import Continuation
from mcdas_opt.planning.continuation import is_in_the_way
from mcdas_opt.planning.cycle import Cycle
from mcdas_opt.tracking.follower_prediction import predicted_to_brake
from mcdas_opt.verification.judge import judge


def told_of_followers(found: Continuation, cycle: Cycle) -> Continuation:
    """Its end says on whom it relies of those who are expected to brake before: whom it would hit, or ask too much of, if they did not."""
    if found.end is None or found.end.relies_on is not None or not found.verdict.passed:
        return found
    drive, situation, vehicle = found.trajectory, cycle.situation, cycle.vehicle
    names = [one for one in predicted_to_brake(cycle.prediction) if one in cycle.observed.attentive and is_in_the_way(drive, one, cycle)]
    if not names:
        return found
    theirs = frozenset(name for one in names for name in names_of(one))
    unaided = Prediction(name=cycle.unaided.name, bodies=tuple(body for body in cycle.unaided.bodies if body.id in theirs))
    end = last_end(drive, situation.host, vehicle, situation.road, unaided, cycle.settings.safe_end, cycle.owed_m)
    if not end.follower_fails and judge(drive, situation.host, vehicle, situation.road, unaided).passed:
        return found
    return found._replace(end=replace(found.end, relies_on=" and ".join(names)))


def reliance_in_words(end: SafeEnd | None, cycle: Cycle) -> str:
    """Said of followers who are expected to brake, and of an end that a follower makes safe; empty where there are none."""
    slow = [one for one in predicted_to_brake(cycle.prediction) if one not in cycle.observed.attentive]
    if slow:
        return f"; {' and '.join(slow)} behind in slow traffic {'is' if len(slow) == 1 else 'are'} expected to brake"
    if end is None or end.relies_on is None:
        return ""
    if cycle.observed.attentive.issuperset(end.relies_on.split(" and ")):
        return f"; {end.relies_on} keeps its distance behind and is expected to brake"
    return f"; {end.relies_on} too close behind {'are' if ' and ' in end.relies_on else 'is'} expected to brake, as no lane beside is open"
