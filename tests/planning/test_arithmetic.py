"""Whoever has numpy raise at each underflow, to find a fault of his own, is planned for all the same."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import mcdas_opt as mo
from mcdas_opt.domain.arithmetic import usual_arithmetic
from mcdas_opt.native import binding

LEAST = 5e-324  # whatever it is multiplied with that is less than 1 is nothing


def begun() -> mo.Situation:
    return mo.load_situation("sandwich-60-40")


@pytest.mark.parametrize("field", ["d_m", "heading_rad", "acceleration_mps2", "speed_d_mps"])
def test_an_underflow_is_no_fault(field: str) -> None:
    situation = begun()
    if field == "speed_d_mps":
        situation = replace(situation, tracks=tuple(replace(track, speed_d_mps=LEAST) for track in situation.tracks))
    else:
        situation = replace(situation, host=replace(situation.host, **{field: LEAST}))
    usual = mo.plan(situation)
    with np.errstate(all="raise"):
        planner = mo.Planner()
        for plan in (mo.plan(situation), planner.plan(situation)):
            assert np.array_equal(plan.trajectory.table, usual.trajectory.table)
            assert (plan.reason, plan.candidates) == (usual.reason, usual.candidates)
        assert planner.plan(replace(situation, time_s=0.1)).verdict.passed
        assert mo.escapes(situation) == usual.escapes
        assert set(np.geterr().values()) == {"raise"}  # as it was


def test_what_the_caller_has_set_is_there_again_after_a_fault() -> None:
    @usual_arithmetic
    def faulty() -> None:
        assert np.geterr()["under"] == "ignore"
        raise LookupError

    with np.errstate(all="raise"):
        with pytest.raises(LookupError):
            faulty()
        assert set(np.geterr().values()) == {"raise"}


def test_an_interrupt_while_c_takes_an_array_leaves_the_cycle(monkeypatch: pytest.MonkeyPatch) -> None:
    """ctypes makes an `ArgumentError` of it: it was answered by the fallback."""

    class Pressed(dict[int, object]):
        def get(self, *key: object) -> object:
            raise KeyboardInterrupt

    planner = mo.Planner()
    planner.plan(begun())
    monkeypatch.setattr(binding, "_read_only", Pressed())
    with pytest.raises(KeyboardInterrupt):
        planner.plan(replace(begun(), time_s=0.1))
    monkeypatch.undo()
    assert planner.plan(replace(begun(), time_s=0.2)).verdict.passed
