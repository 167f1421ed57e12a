"""The escape map: for each way out, the last moment at which it still can be started, and what ends it."""

from __future__ import annotations

import math

from mcdas_opt.domain.escapes import Closer, Escape, Escapes
from mcdas_opt.domain.prediction import Prediction
from mcdas_opt.domain.situation import Situation
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.time_to_react.compiled_case import compiled_escapes
from mcdas_opt.time_to_react.compiled_map import answered
from mcdas_opt.time_to_react.guess import Case
from mcdas_opt.time_to_react.library import EscapeSettings
from mcdas_opt.time_to_react.search import found
from mcdas_opt.time_to_react.separation import LATTICE_S


def escapes(situation: Situation, vehicle: Vehicle, prediction: Prediction, settings: EscapeSettings | None = None) -> Escapes:
    """The four ways out, each the best of some dozens of manoeuvres of its kind, for all starts at once.

    Each manoeuvre from a few starts says which gaps it needs, and so until when each gap lasts; the best few are then driven from
    about that moment and parted from everybody exactly, so that a way called open is one.
    """
    chosen = settings or _DEFAULT
    library = compiled_escapes()
    if library is None:
        answer = found(Case(situation, vehicle, prediction, chosen))
    else:
        answer = answered(library, situation, vehicle, prediction, chosen)
    end_s, ender, (last, comfortable), now, closers = answer
    latest, coverage = math.floor(end_s / LATTICE_S + 1e-9), situation.coverage
    ended = ender if latest * LATTICE_S < chosen.latest_s - 1e-9 else None
    watched = True, coverage.front, coverage.left, coverage.right  # a way into a direction that nobody watches is closed
    ways: list[Escape] = []
    for kind, seen in enumerate(watched):
        start, easy = last[kind], comfortable[kind]
        if start < 0 or not seen:
            ways.append(Escape(closed_by=closers[kind] if seen else _UNSEEN[kind]))
            continue
        way = Escape(
            open=True,
            last_moment_s=round(LATTICE_S * start, 4),
            closed_by=closers[kind] if start < latest else ended,
            demand_mps2=now[kind],
            last_comfortable_s=round(LATTICE_S * easy, 4) if easy >= 0 else None,
        )
        ways.append(way)
    brake, accelerate, left, right = ways
    keeping_on_s = round(end_s, 4) if ender is not None else None
    return Escapes(brake=brake, accelerate=accelerate, left=left, right=right, keeping_on_s=keeping_on_s)


_DEFAULT = EscapeSettings()
_UNSEEN = (None, Closer.FRONT, Closer.SIDE, Closer.SIDE)  # what then closes it, by kind
