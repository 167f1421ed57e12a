"""Every record's constructor, given anything: a record, or one sentence of our own."""

from __future__ import annotations

from typing import Any

from benchmarks.attack.campaign import examples
from benchmarks.attack.strategies import hostile_fields
from benchmarks.attack.tally import Tally


def attack(tally: Tally, count: int, seed: int) -> None:
    def ask(asked: tuple[type, dict[str, Any]]) -> None:
        record, given = asked
        tally.ask(lambda: record(**given), lambda: f"{record.__name__}(**{given!r})")

    examples(hostile_fields(), ask, count, seed)
