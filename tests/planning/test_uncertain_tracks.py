"""What plans take from a track's covariance, age and coasting, as its docstring says."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import mcdas_opt as mo
from mcdas_opt.tracking.prediction import predict

TIMES = np.linspace(0.0, 4.0, 41)
FRONT = mo.Track(id="front", s_m=30.0, d_m=0.0, speed_s_mps=8.0)


def grown(along_sd_m: float, across_sd_m: float) -> tuple[float, float]:
    """By how much the body is grown along and across at most."""
    known = replace(FRONT, covariance=np.diag([along_sd_m**2, 0.0, across_sd_m**2, 0.0]))
    (body,) = predict([known]).bodies
    return float(body.margin_along_m(TIMES).max()), float(body.margin_across_m(TIMES).max())


def test_bodies_are_grown_by_what_is_not_known_up_to_a_bound() -> None:
    assert grown(0.0, 0.0) == (0.0, 0.0)
    assert grown(0.4, 0.1) == pytest.approx((1.0, 0.25))
    assert grown(1.2, 0.2) == pytest.approx((3.0, 0.5))
    assert grown(1000.0, 1000.0) == pytest.approx((3.0, 0.5))


def test_no_plan_depends_on_age_or_coasting() -> None:
    def driven(track: mo.Track) -> bytes:
        situation = mo.Situation(host=mo.HostState(speed_mps=14.0), tracks=(track,), coverage=mo.Coverage(), road=mo.Road(lanes_left=1))
        return mo.plan(situation).trajectory.table.tobytes()

    assert driven(replace(FRONT, age_s=100.0, coasting=True)) == driven(FRONT)
