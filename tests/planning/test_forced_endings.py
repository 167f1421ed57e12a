"""However the engines end, in closed loop: a judged, finite, labelled plan leaves every cycle; 10^3 cycles a kind are a benchmark."""

from __future__ import annotations

import pytest

from benchmarks.forced_endings import ENGINES, KINDS, LIBRARY, MUTE, force


@pytest.mark.parametrize("kind", KINDS)
def test_every_cycle_ends_with_a_judged_and_labelled_plan(kind: str) -> None:
    cycles = 4 if kind in LIBRARY else 12
    found = force(kind, cycles, seed=3)
    assert found.faults == 0, found.told
    assert found.counts["cycles"] == cycles
    if kind in MUTE:
        assert found.counts["planned"] == 0


def test_mute_engines_are_among_the_forced_ones() -> None:
    assert set(ENGINES) >= MUTE


def test_a_fault_would_be_seen(monkeypatch: pytest.MonkeyPatch) -> None:
    """The check itself: an answer that the guard does not catch is counted."""
    monkeypatch.setattr("mcdas_opt.planning.lane_problem.lane_mpc_solver.ask", lambda engine, *rest: engine.solve(*rest))
    found = force("exception", 2, seed=3)
    assert found.faults == 2
