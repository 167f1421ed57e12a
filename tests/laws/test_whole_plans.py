"""Laws over whole plans, of every family of random traffic: what must not matter changes no decision, and no plan beyond its tolerance.

What is changed, and what each law promises, stands in `benchmarks/laws.py`, which counts them over thousands of situations. Here a sample
is asked; `MCDAS_OPT_LAWS_PLANS` sets how many plans of each family.
"""

from __future__ import annotations

import os
from functools import cache

import numpy as np
import pytest

from benchmarks.laws import LAWS, QUICK, Kept, Moment, examine, examine_forms, shift_m, usual
from benchmarks.random_traffic import KINDS, Episode, episodes

PLANS = int(os.environ.get("MCDAS_OPT_LAWS_PLANS", "40"))
PLANS_IN_BOTH_FORMS = max(PLANS // 5, 1)  # the interpreted form takes its time

BROKEN: dict[str, str] = {}  # laws that do not hold yet, and why


def _laws(*names: str) -> list[object]:
    marks = {name: pytest.mark.xfail(strict=True, reason=why) for name, why in BROKEN.items()}
    return [pytest.param(name, marks=marks.get(name, ())) for name in names]


@cache
def _asked() -> tuple[tuple[Episode, list[Moment]], ...]:
    """Every sequence, with what a planner answers when nothing is changed."""
    return tuple((one, usual(one)) for family in KINDS for one in episodes(family, PLANS))


@pytest.mark.parametrize("name", _laws(*QUICK))
def test_law_holds(name: str) -> None:
    law = LAWS[name]
    broken = []
    for one, moments in _asked():
        if law.single or one.cycles > 1:
            least, words = examine(one, law, moments)
            if least < law.least:
                broken.append(f"{one.name} keeps {least.name}: {words}")
    assert not broken, "\n".join(broken)


@pytest.mark.parametrize("name", _laws("forms"))
def test_both_forms_decide_alike(name: str) -> None:
    some = [one for family in KINDS for one in episodes(family, PLANS_IN_BOTH_FORMS)]
    broken = [f"{one.name} keeps {least.name}: {words}" for one, least, words in examine_forms(some) if least < LAWS[name].least]
    assert not broken, "\n".join(broken)


def test_every_law_changes_something() -> None:
    """None of the changes leaves every sequence as it was: a law that changes nothing would hold of anything."""
    some = [one for one in episodes("dense", 40) if one.cycles > 1]
    for name in ("permuted", "renamed", "clock", "moved", "jitter"):
        for one in some:
            asked = [one.first, one.first]
            assert LAWS[name].change(one, asked)[1] != asked[1]


def test_a_moved_answer_comes_back() -> None:
    one = next(iter(episodes("wide", 1)))
    answer = {"trajectory": {"s_m": [shift_m(one), shift_m(one) + 5.0]}}
    np.testing.assert_allclose(LAWS["moved"].back(one, answer)["trajectory"]["s_m"], [0.0, 5.0])


def test_levels_are_ordered() -> None:
    assert Kept.NOTHING < Kept.DECISION < Kept.STATES < Kept.BITS
