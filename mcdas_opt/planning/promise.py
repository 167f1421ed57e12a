"""What a way out promises before it is solved: the price of its guess, by which the few that are solved first are picked."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from mcdas_opt.domain.assessment import Assessment
from mcdas_opt.domain.prediction import Prediction
from mcdas_opt.domain.settings import Settings
from mcdas_opt.domain.situation import Situation
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.domain.vocabulary import Mode
from mcdas_opt.planning.glance import PLAINLY_M
from mcdas_opt.planning.lane_parameters import guessed_states
from mcdas_opt.planning.selection import WorthSettings, nearness_of, steering_price, worths
from mcdas_opt.planning.ways import Way, shorter_side


class Promising(NamedTuple):
    """Ways to solve first, the others, and the least price that one of those promises."""

    first: tuple[Way, ...]
    others: tuple[Way, ...]
    least: float


def by_promise(
    ways: Sequence[Way],
    most: int,
    before: str | None,
    situation: Situation,
    assessment: Assessment,
    prediction: Prediction,
    vehicle: Vehicle,
    settings: Settings,
    worth: WorthSettings,
) -> Promising:
    """The `most` that promise most, with what was chosen before and what is refused anyway; and the others. Each with its guess, in the
    order given.

    A way promises the price of its guess, with what it costs beside; who plainly hits somebody there comes last. Equal promises (to 1e-5
    of each other) go to the tie-break side. Where fewer than `most` guesses hit nobody, it is too tight to tell, and there are no others.
    """
    times_s, tie_break = settings.grid.times_s, settings.selector.tie_break
    asked = [i for i, way in enumerate(ways) if not way.refusal]
    if len(asked) <= most:
        return Promising(tuple(ways), (), math.inf)
    guessed = list(ways)
    tables = np.zeros((len(asked), 9, times_s.size))
    tables[:, 0] = times_s
    for row, i in enumerate(asked):
        if ways[i].guess is None:
            guessed[i] = replace(ways[i], guess=guessed_states(situation, ways[i], vehicle, times_s))
        tables[row, 1:7] = np.asarray(guessed[i].guess).T
    tables[:, 8, :-1] = (tables[:, 5, 1:] - tables[:, 5, :-1]) / (times_s[1:] - times_s[:-1])
    near = nearness_of(tables, times_s, vehicle, situation.road, prediction)
    prices = worths(near, vehicle=vehicle, prediction=prediction, desired_speed_mps=situation.wanted_speed_mps, settings=worth)
    leaning, needless = shorter_side(assessment), assessment.mode in (Mode.BRAKE, Mode.ACCELERATE)
    hits: list[bool] = (near.deepest_m.min(axis=-1, initial=np.inf) < -PLAINLY_M).tolist()
    for row, i in enumerate(asked):
        prices[row] += steering_price(ways[i].side, leaning, needless, worth) + (worth.waiting if ways[i].waits else 0.0)
    if hits.count(False) < most:
        return Promising(tuple(guessed), (), math.inf)

    def rank(row: int) -> tuple[bool, float, int]:
        return hits[row], round(prices[row], 5), 0 if ways[asked[row]].side is tie_break else 1

    rest = {asked[row]: prices[row] for row in sorted(range(len(asked)), key=rank)[most:] if ways[asked[row]].name != before}
    first = tuple(way for i, way in enumerate(guessed) if i not in rest)
    return Promising(first, tuple(guessed[i] for i in sorted(rest)), min(rest.values(), default=math.inf))
