"""Every record's constructor, given anything: a record, or one sentence of our own."""

from __future__ import annotations

from operator import attrgetter
from typing import Any

import numpy as np

from benchmarks.attack.campaign import examples
from benchmarks.attack.records import fields, needed, records
from benchmarks.attack.strategies import EXTREMES, anything
from benchmarks.attack.tally import Tally

_USES = 50  # of a value, by different fields: to make one takes longer than to try it
_MOST_FIELDS = 3
_LIKE = 0.7  # of the numbers stay numbers
_FACTORS = (0.0, -1.0, 1e-9, 1e-3, 0.1, 0.5, 2.0, 10.0, 1e3, 1e9)


def attack(tally: Tally, count: int, seed: int) -> None:
    """One to three fields of a record are anything, or as they might be and a factor away."""
    values: list[Any] = []
    examples(anything, values.append, max(count // _USES, 100), seed)
    r = np.random.default_rng(seed)
    known = [(record, [field.name for field in fields(record)], record(**needed(record))) for record in records()]
    for _ in range(count):
        record, of, sound = known[int(r.integers(len(known)))]
        names = {of[int(r.integers(len(of)))] for _ in range(int(r.integers(1, _MOST_FIELDS + 1)))}
        given = {**needed(record), **{name: _hostile(sound, name, values, r) for name in sorted(names)}}
        tally.ask(lambda record=record, given=given: record(**given), lambda record=record, given=given: f"{record.__name__}(**{given!r})")


def _hostile(sound: object, name: str, values: list[Any], r: np.random.Generator) -> Any:
    value = attrgetter(name)(sound)
    if isinstance(value, (bool, int, float)) and r.random() < _LIKE:
        number = (*(factor * value for factor in _FACTORS), *EXTREMES)[int(r.integers(len(_FACTORS) + len(EXTREMES)))]
        return number if isinstance(value, float) or abs(number) > 1e15 else round(number)
    return values[int(r.integers(len(values)))]
