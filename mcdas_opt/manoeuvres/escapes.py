"""The escape map: for each way out, the last moment at which it still can be started, and what ends it."""

from __future__ import annotations

import math

from mcdas_opt.domain.escapes import Closer, Escape, Escapes
from mcdas_opt.domain.prediction import Prediction
from mcdas_opt.domain.situation import Situation
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.domain.vocabulary import Sector
from mcdas_opt.manoeuvres.compiled_escapes import compiled_escapes
from mcdas_opt.manoeuvres.escape_answer import answered
from mcdas_opt.manoeuvres.escape_guess import Case
from mcdas_opt.manoeuvres.escape_library import KINDS, EscapeSettings
from mcdas_opt.manoeuvres.escape_search import found
from mcdas_opt.manoeuvres.parting import LATTICE_S


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
    latest = math.floor(end_s / LATTICE_S + 1e-9)
    answers: dict[str, Escape] = {}
    for kind, name in enumerate(KINDS):
        refusal, start = _refusal(name, situation), last[kind]
        if refusal is not None or start < 0:
            answers[name] = Escape(closed_by=refusal or closers[kind])
            continue
        ended = ender if latest * LATTICE_S < chosen.latest_s - 1e-9 else None
        answers[name] = Escape(
            open=True,
            last_moment_s=round(LATTICE_S * start, 4),
            closed_by=closers[kind] if start < latest else ended,
            demand_mps2=now[kind],
            last_comfortable_s=round(LATTICE_S * comfortable[kind], 4) if comfortable[kind] >= 0 else None,
        )
    return Escapes(**answers, keeping_on_s=round(end_s, 4) if ender is not None else None)


def _refusal(name: str, situation: Situation) -> Closer | None:
    """A way into a direction that nobody watches is closed."""
    into = _INTO.get(name)
    return None if into is None or situation.coverage.sees(into[0]) else into[1]


_DEFAULT = EscapeSettings()
_INTO = {"accelerate": (Sector.FRONT, Closer.FRONT), "left": (Sector.LEFT, Closer.SIDE), "right": (Sector.RIGHT, Closer.SIDE)}
