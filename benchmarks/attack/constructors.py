"""Every record's constructor, given anything: a record, or one sentence of our own."""

from __future__ import annotations

from typing import Any

import numpy as np

from benchmarks.attack.campaign import examples
from benchmarks.attack.records import fields, needed, records
from benchmarks.attack.strategies import anything
from benchmarks.attack.tally import Tally

_USES = 50  # of a value, by different fields: to make one takes longer than to try it
_MOST_FIELDS = 3


def attack(tally: Tally, count: int, seed: int) -> None:
    """One to three fields of a record may be anything."""
    values: list[Any] = []
    examples(anything, values.append, max(count // _USES, 100), seed)
    r = np.random.default_rng(seed)
    known = [(record, [field.name for field in fields(record)]) for record in records()]
    for _ in range(count):
        record, of = known[int(r.integers(len(known)))]
        names = {of[int(r.integers(len(of)))] for _ in range(int(r.integers(1, _MOST_FIELDS + 1)))}
        given = {**needed(record), **{name: values[int(r.integers(len(values)))] for name in sorted(names)}}
        tally.ask(lambda record=record, given=given: record(**given), lambda record=record, given=given: f"{record.__name__}(**{given!r})")
