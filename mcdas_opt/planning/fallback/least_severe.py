"""Nothing passes: the least severe drive, or one that relies on a follower's reaction."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from mcdas_opt.domain.vocabulary import Side
from mcdas_opt.planning.candidate import Checked
from mcdas_opt.planning.candidates.collision_check import exact
from mcdas_opt.planning.cycle import Cycle
from mcdas_opt.planning.deadline import Stage
from mcdas_opt.planning.fallback.follower_reaction import with_follower_reaction
from mcdas_opt.planning.fallback.severity import severities, severity_in_words
from mcdas_opt.planning.memory import FollowerReaction
from mcdas_opt.planning.proposals.unwatched import begins_unwatched, unwatched
from mcdas_opt.planning.reporting.reported_mode import REPORTED_S
from mcdas_opt.planning.rungs.corrected_sigmoid import NAME as CORRECTED_SIGMOID

_STEERING_OUT_MPS = 0.5  # by which steering out must be less severe than staying in the lane
_WEAVING_PER_S = 1.0  # for each metre that it goes to and fro across the road
_UNWATCHED_MPS = 3.0  # more, where nobody watches who comes there from behind: as if three in ten met somebody 10 m/s faster
_TURNING_ROUND_MPS = 0.5  # and accelerating than braking that is reported for less than a second, or the other way round


class LeastSevere(NamedTuple):
    """The drive with the judge's own verdict, why it is the one, and on whom it relies."""

    checked: Checked
    reason: str
    reaction: FollowerReaction | None


def least_severe(driven: Sequence[Checked], optimised: Sequence[Checked], cycle: Cycle) -> LeastSevere:
    """Of what the fallback drove, and of what the optimiser drove and the judge failed for a collision alone.

    Nobody is relied on in a drive that, should that fail, is more severe than the closed form, which relies on nobody. Steering out must be
    better than staying in the lane by a margin, unless it has begun, and so must be what turns round what began a moment ago: dithering is
    worst of all. The margin is wider where nobody watches behind: what steers there hits nobody that is known of, and may have passed.
    """
    options = [*driven, *(one for one in optimised if one.verdict.only_collides)]
    hurt = severities([option.trajectory for option in options], cycle)
    forms = [speed for one, (speed, _) in zip(options, hurt, strict=True) if one.proposed.name == CORRECTED_SIGMOID]
    most = min(forms, default=math.inf) + _STEERING_OUT_MPS
    late = cycle.is_late_for(Stage.FOLLOWER)
    relying = [one for one, (speed, _) in zip(options, hurt, strict=True) if speed <= most and not one.verdict.passed]
    found = None if late else with_follower_reaction(relying, cycle)
    if found is not None:
        one, reaction = found
        asked = cycle.settings.safe_end.attentive_braking_mps2
        why = f"nothing passes unless {reaction} brakes; {one.proposed.name} asks less than {asked:.1f} m/s^2 of it"
        return LeastSevere(exact(one, cycle), why, reaction)

    reported = cycle.memory.reported
    begun = reported.mode if reported is not None and reported.age_s < REPORTED_S else None

    def rank(i: int) -> tuple[float, float]:
        (speed, when), one = hurt[i], options[i]
        if one.proposed.side not in (Side.NONE, cycle.memory.side):
            speed += _STEERING_OUT_MPS + (_UNWATCHED_MPS if begins_unwatched(cycle, one.proposed.side) else 0.0)
        if begun is not None and one.driven_mode is not begun:
            speed += _TURNING_ROUND_MPS
        speed += _WEAVING_PER_S * _weaving_m(one)
        return (speed, when)

    order = sorted(range(len(options)), key=rank)
    judged = ((i, options[i] if cycle.is_late_for(Stage.EXACT_VERDICT) else exact(options[i], cycle)) for i in order)
    least, one = next((i, one) for i, one in judged if i < len(driven) or one.verdict.only_collides)
    why = unwatched(cycle.situation, one.proposed.side) or begins_unwatched(cycle, one.proposed.side)
    told = f"{one.proposed.name} ({severity_in_words(hurt[least][0])}){f', where {why}' if why else ''}"
    return LeastSevere(one, f"nothing passes; least severe is {told}", None)


def _weaving_m(one: Checked) -> float:
    """How much farther it goes across the road than it gets: an optimiser that finds no way out weaves between two that it would hit."""
    d = one.trajectory.d_m
    return float(np.abs(np.diff(d)).sum() - abs(d[-1] - d[0]))
