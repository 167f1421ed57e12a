"""The competent driver against the published reference of 528 cut-ins, and against its own arithmetic."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mcdas_opt.baselines.competent_driver import (
    BRAKING_MPS2,
    CRITICAL_TTC_S,
    JERK_MPS3,
    REACTION_S,
    RELEASE_MPS2,
    CompetentDriverMethod,
    ReactionLaw,
)
from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.plan import Plan
from mcdas_opt.domain.situation import Situation
from mcdas_opt.domain.track import Track
from mcdas_opt.domain.vehicle import Vehicle

CAR = Vehicle()
REFERENCE = Path(__file__).resolve().parents[2].parent / "shared" / "data" / "protocols" / "r157_cutin_reference_528.csv"
STEP_S, LENGTH_M, WIDTH_M, BETWEEN_M = 0.1, 4.3, 1.9, 1.6  # of the reference's own simulation


def crashes(ego_mps: float, other_mps: float, gap_m: float, sideways_mps: float) -> bool:
    """The reference's cut-in: the risk is perceived when the bodies overlap sideways. Who is then further away than the critical time
    to collision is no cut-in any more, and the reference stops there."""
    t, x, v = 0.0, 0.0, ego_mps
    law: ReactionLaw | None = None
    while t < 35.0:
        ahead = gap_m + LENGTH_M + other_mps * t - x
        overlapping = BETWEEN_M - sideways_mps * t <= 1e-9
        if overlapping and abs(ahead) < LENGTH_M:
            return True
        if overlapping and law is None and v > other_mps:
            if ahead < 0.0 or (ahead - LENGTH_M) / (v - other_mps) > CRITICAL_TTC_S:
                return False
            law = ReactionLaw(since_s=-t, until_mps=other_mps, strength_mps2=BRAKING_MPS2)
        v = max(v + STEP_S * (0.0 if law is None else law.wanted_mps2(t, x, v)), 0.0)
        x, t = x + STEP_S * v, round(t + STEP_S, 9)
    return False


def way_m(closing_mps: float) -> float:
    """How much nearer the driver comes: 0.75 s with the throttle released, 0.6 s of build-up, then 0.774 g until as fast as the other."""
    reaction, release, jerk, braking = REACTION_S, RELEASE_MPS2, JERK_MPS3, BRAKING_MPS2
    rest = closing_mps - release * reaction
    way = closing_mps * reaction - 0.5 * release * reaction**2
    rise = min(braking / jerk, np.sqrt(2.0 * rest / jerk))
    way += rest * rise - jerk * rise**3 / 6.0
    return float(way + max(rest - 0.5 * jerk * rise**2, 0.0) ** 2 / (2.0 * braking))


def test_crashes_where_the_arithmetic_says() -> None:
    """Cut-ins whose bodies overlap sideways after one step of the reference, 0.1 s, over the range in which the driver reacts."""
    rng = np.random.default_rng(4)
    found = []
    for closing, share in zip(rng.uniform(3.0, 20.0, 400).tolist(), rng.uniform(0.6, 1.0, 400).tolist(), strict=True):
        gap, way = share * CRITICAL_TTC_S * closing, way_m(closing)
        left = gap - STEP_S * closing
        if abs(left - way) > STEP_S * closing + 0.1:  # how far its steps may be from the integral
            crashed = crashes(30.0, 30.0 - closing, gap, BETWEEN_M / STEP_S)
            assert crashed == (way > left), (closing, left, way)
            found.append(crashed)
    assert 50 < sum(found) < len(found) - 30


@pytest.mark.published(REFERENCE)
def test_crashes_where_the_published_reference_driver_does() -> None:
    with REFERENCE.open() as file:
        cases = list(csv.DictReader(file))
    assert len(cases) == 528
    kept = ("ego_kph", "cutin_kph", "front_distance_m", "lateral_speed_mps")
    numbers = np.array([[float(case[key]) for key in kept] for case in cases]) / [3.6, 3.6, 1.0, 1.0]
    ours = np.array([crashes(*row) for row in numbers.tolist()])
    theirs = np.array([case["CC_human_driver_crash"] == "1" for case in cases])
    other = np.array([case["Reg157_crash"] == "1" for case in cases])
    assert (ours == theirs).sum() >= 522
    assert (ours == theirs).sum() > (ours == other).sum() + 30  # and not where another of the four drivers does


@given(closing=st.floats(3.0, 20.0), headroom=st.floats(0.0, 1.0))
@settings(max_examples=40, deadline=None)
def test_comes_as_near_as_its_reaction_its_jerk_and_its_brakes_say(closing: float, headroom: float) -> None:
    """The other keeps its speed."""
    speed, gap = 22.0, headroom * CRITICAL_TTC_S * closing
    front = Track(id="front", s_m=gap + CAR.length_m, d_m=0.0, speed_s_mps=speed - closing)
    plan = CompetentDriverMethod(CAR).plan(Situation(host=HostState(speed_mps=speed), tracks=(front,)), None)
    assert isinstance(plan, Plan)
    t, s = plan.trajectory.t_s, plan.trajectory.s_m
    way = float((s - (speed - closing) * t).max())
    assert way == pytest.approx(way_m(closing), abs=0.05 * closing + 0.1)
    assert plan.verdict.passed == (way < gap) or abs(way - gap) < 0.1
