"""The compiled search for the steepest bent path finds what the array operations find, to either side alike."""

from __future__ import annotations

from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mcdas_opt.native.form import SWITCH
from mcdas_opt.reference.offset_path import corrected

BENT: dict[str, Any] = {
    "start_s_m": st.floats(-50, 200),
    "start_d_m": st.floats(-4, 4),
    "target_d_m": st.floats(-8, 8),
    "speed_mps": st.floats(0, 45),
    "lateral_acceleration_mps2": st.floats(0.5, 8),
    "b": st.sampled_from([5.0, 12.0, 50.0, 300.0]),
    "bend_m": st.floats(-2, 2),
    "bend_s_m": st.floats(-20, 200),
    "bend_width_m": st.floats(1, 40),
}


@given(given_=st.fixed_dictionaries(BENT))
@settings(max_examples=150, deadline=None)
def test_compiled_and_interpreted_find_the_same(given_: dict[str, float]) -> None:
    path = corrected(**given_)
    with pytest.MonkeyPatch.context() as patched:
        patched.setenv(SWITCH, "0")
        assert corrected(**given_).a_per_m == pytest.approx(path.a_per_m, rel=1e-12, abs=0.0)


@given(given_=st.fixed_dictionaries(BENT))
@settings(max_examples=50, deadline=None)
def test_left_and_right_are_alike_to_the_bit(given_: dict[str, float]) -> None:
    lateral = ("start_d_m", "target_d_m", "bend_m")
    image = corrected(**{name: -value if name in lateral else value for name, value in given_.items()})
    assert image.a_per_m == corrected(**given_).a_per_m
