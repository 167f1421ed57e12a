"""Trust in a queue: where nothing passes, whoever is behind and slow is expected to brake as an attentive driver does."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

from mcdas_opt.domain.plan import Attempt, Plan
from mcdas_opt.domain.prediction import AnsweringBody, Prediction
from mcdas_opt.domain.safe_end import SafeEndSettings
from mcdas_opt.domain.situation import Situation
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.planning.glance import verdicts
from mcdas_opt.planning.selection import nearness
from mcdas_opt.tracking.prediction import ACCELERATING


@dataclass(frozen=True, slots=True)
class Trust:
    """Who is relied on, and since when: who has had the time to respond has responded. Lives in `Plan.reference` from cycle to cycle."""

    names: tuple[str, ...]
    since_s: float

    def __str__(self) -> str:
        return " and ".join(self.names)


def relying(
    options: Sequence[Attempt],
    situation: Situation,
    previous: Plan | None,
    prediction: Prediction,
    vehicle: Vehicle,
    settings: SafeEndSettings,
) -> tuple[Attempt, Trust] | None:
    """Of the drives that hit nobody but a follower in a queue, and not even that one should it brake as an attentive driver does, the one
    that then keeps most room to everybody; with whom it relies on. None where there is no such drive.
    """
    behind = _queued(situation, vehicle, settings.queue_mps)
    theirs = {name for one in behind for name in (one, f"{one} {ACCELERATING}")}
    options = [one for one in options if one.verdict.only_collides and {violation.body for violation in one.verdict.violations} <= theirs]
    if not behind or not options:
        return None
    before = previous.reference if previous is not None else None
    trust = before if isinstance(before, Trust) and before.names == behind else Trust(behind, situation.time_s)
    answers = partial(
        AnsweringBody,
        response_s=max(settings.attentive_response_s - (situation.time_s - trust.since_s), 0.0),
        braking_mps2=settings.attentive_braking_mps2,
    )
    bodies = tuple(answers(body=body) if body.id in theirs else body for body in prediction.bodies)
    hoped = Prediction(name="followers brake", bodies=bodies)
    passing = [one for one in options if verdicts((one.trajectory,), situation, vehicle, hoped)[0].passed]
    if not passing:
        return None

    def room_m(one: Attempt) -> float:
        return float(nearness((one.trajectory,), vehicle, situation.road, hoped).separation_m.min())

    return max(passing, key=room_m), trust


def _queued(situation: Situation, vehicle: Vehicle, at_most_mps: float) -> tuple[str, ...]:
    """Who is behind the host, in its way, and slow."""
    host = situation.host
    return tuple(
        track.id
        for track in situation.tracks
        if track.s_m < host.s_m and abs(track.d_m - host.d_m) < 0.5 * (track.width_m + vehicle.width_m) and track.speed_s_mps <= at_most_mps
    )
