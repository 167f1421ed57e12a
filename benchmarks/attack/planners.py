"""Cars and settings that nobody would have, in traffic: refused at the door, or planned with, and the plan judged."""

from __future__ import annotations

import contextlib
import dataclasses
from functools import partial
from operator import attrgetter
from typing import TypeVar

from hypothesis import strategies as st

from benchmarks.attack.campaign import examples
from benchmarks.attack.strategies import EXTREMES, situations
from benchmarks.attack.tally import Tally
from mcdas_opt import Planner, Settings, Situation, Vehicle
from mcdas_opt.errors import McdasError

R = TypeVar("R")
_CHANGED = 8  # fields of a record, at most
_FACTORS = (0.0, 1e-9, 1e-3, 0.1, 0.5, 2.0, 10.0, 1e3, 1e9)
_WHOLE = (0, 1, 2, 1000, 10**9)
_EACH = 4  # situations of a planner


def attack(tally: Tally, count: int, seed: int) -> None:
    """So many calls, about: one in five builds a planner."""

    def ask(asked: tuple[Vehicle, Settings, tuple[Situation, ...]]) -> None:
        vehicle, settings, traffic = asked
        shown = f"{vehicle}, {settings}, "
        planner = tally.ask(partial(Planner, vehicle, settings=settings), lambda: shown)
        for situation in traffic[:_EACH] if planner is not None else ():
            plan = tally.ask(partial(planner.plan, situation), lambda s=situation: shown + s.to_json(), may_refuse=False)
            if plan is not None:
                tally.check_plan(plan, situation, vehicle, settings.prediction)

    cars = st.one_of(st.just(Vehicle()), _changed(Vehicle()))
    wishes = st.one_of(st.just(Settings()), _changed(Settings()))
    examples(st.tuples(cars, wishes, situations()), ask, max(count // (_EACH + 1), 1), seed)


@st.composite
def _changed(draw: st.DrawFn, record: R) -> R:
    """The record with some of its numbers a factor away, or at an extreme, and so with the records in it."""
    assert dataclasses.is_dataclass(record)
    names = [field.name for field in dataclasses.fields(record) if field.init]
    for name in draw(st.lists(st.sampled_from(names), max_size=_CHANGED, unique=True)):
        value = attrgetter(name)(record)
        if dataclasses.is_dataclass(value):
            value = draw(_changed(value))
        elif isinstance(value, bool):
            value = not value
        elif isinstance(value, float):
            value = draw(st.one_of(st.sampled_from([factor * value for factor in _FACTORS]), st.sampled_from(EXTREMES)))
        elif isinstance(value, int):
            value = draw(st.sampled_from(_WHOLE))
        with contextlib.suppress(McdasError):
            record = dataclasses.replace(record, **{name: value})
    return record
