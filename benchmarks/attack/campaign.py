"""Hypothesis as a source of cases: as many as are asked for, the same for the same seed, none of them kept."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar

from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import seed as seeded
from hypothesis.strategies import SearchStrategy

T = TypeVar("T")


def examples(strategy: SearchStrategy[T], ask: Callable[[T], None], count: int, seed: int) -> None:
    """Calls `ask` with about `count` examples. What it finds it counts, so that a fault does not end the campaign."""

    @seeded(seed)
    @settings(max_examples=count, deadline=None, database=None, phases=[Phase.generate], suppress_health_check=list(HealthCheck))
    @given(strategy)
    def each(example: T) -> None:
        ask(example)

    each()
