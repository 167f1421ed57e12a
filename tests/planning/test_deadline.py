"""What is no longer begun as a deadline comes near."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from mcdas_opt.planning import deadline
from mcdas_opt.planning.deadline import Deadline, Stage


def left_s(length_s: float, stage: Stage, monkeypatch: pytest.MonkeyPatch) -> float:
    """How much of the deadline is left when the stage is last begun, to 10 us."""
    for elapsed in range(round(1e5 * length_s), -1, -1):
        monkeypatch.setattr(deadline.time, "perf_counter", lambda at=1e-5 * elapsed: at)
        if not Deadline(began_s=0.0, length_s=length_s).is_over_for(stage):
            return length_s - 1e-5 * elapsed
    return length_s


@pytest.mark.parametrize("stage", Stage)
@pytest.mark.parametrize("length_s", [0.005, 0.02])
def test_a_short_one_is_shared(stage: Stage, length_s: float, monkeypatch: pytest.MonkeyPatch) -> None:
    assert left_s(length_s, stage, monkeypatch) == pytest.approx((1.0 - stage.value) * length_s, abs=2e-5)


@pytest.mark.parametrize("stage", Stage)
def test_a_long_one_leaves_what_comes_after_as_much_as_twenty_milliseconds_do(stage: Stage, monkeypatch: pytest.MonkeyPatch) -> None:
    """Three quarters of 50 ms went unused, and candidates that would have passed were not tried."""
    assert left_s(0.05, stage, monkeypatch) == pytest.approx((1.0 - stage.value) * 0.02, abs=2e-5)


@given(length_s=st.floats(1e-4, 1.0), elapsed_s=st.floats(0.0, 1.0))
def test_what_comes_later_is_never_over_before_what_comes_first(length_s: float, elapsed_s: float) -> None:
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(deadline.time, "perf_counter", lambda: elapsed_s)
        over = [Deadline(began_s=0.0, length_s=length_s).is_over_for(stage) for stage in sorted(Stage, key=lambda one: one.value)]
    assert over == sorted(over, reverse=True)
