"""The follower-reaction assumption: where nothing passes, whoever is behind and slow is expected to brake as an attentive driver does."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import partial

from mcdas_opt.domain.prediction import Prediction, responding
from mcdas_opt.domain.variant import Variant
from mcdas_opt.planning.candidate import Checked
from mcdas_opt.planning.candidates.collision_check import verdicts
from mcdas_opt.planning.candidates.nearness import nearness
from mcdas_opt.planning.cycle import Cycle
from mcdas_opt.planning.memory import FollowerReaction


def with_follower_reaction(options: Sequence[Checked], cycle: Cycle) -> tuple[Checked, FollowerReaction] | None:
    """Of the drives that hit nobody but a follower in a queue, and not even that one should it brake as an attentive driver does, the one
    that then keeps most room to everybody; with whom it relies on. None where there is no such drive.
    """
    settings = cycle.settings.safe_end
    behind = _queued(cycle)
    theirs = {name for one in behind for name in (one, Variant.ACCELERATING.of(one))}
    options = [one for one in options if one.verdict.only_collides and {violation.body for violation in one.verdict.violations} <= theirs]
    if not behind or not options:
        return None
    before = cycle.memory.reaction
    reaction = before if before is not None and before.names == behind else FollowerReaction(names=behind)
    answers = partial(
        responding,
        response_s=max(settings.attentive_response_s - reaction.age_s, 0.0),
        braking_mps2=settings.attentive_braking_mps2,
    )
    bodies = tuple(answers(body) if body.id in theirs else body for body in cycle.prediction.bodies)
    hoped = replace(cycle, prediction=Prediction(name="followers brake", bodies=bodies))
    passing = [one for one in options if verdicts((one.trajectory,), hoped)[0].passed]
    if not passing:
        return None

    def room_m(one: Checked) -> float:
        return float(nearness((one.trajectory,), hoped).separation_m.min())

    return max(passing, key=room_m), reaction


def _queued(cycle: Cycle) -> tuple[str, ...]:
    """Who is behind the host, in its way, and slow."""
    host, at_most_mps = cycle.situation.host, cycle.settings.safe_end.queue_mps
    return tuple(
        track.id
        for track in cycle.situation.tracks
        if track.s_m < host.s_m
        and abs(track.d_m - host.d_m) < 0.5 * (track.across_m + cycle.vehicle.width_m)
        and track.speed_s_mps <= at_most_mps
    )
