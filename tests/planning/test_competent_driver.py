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
from mcdas_opt.domain.situation import Coverage, Situation
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
    plan = CompetentDriverMethod(CAR).plan(Situation(host=HostState(speed_mps=speed), tracks=(front,), coverage=Coverage()), None)
    assert isinstance(plan, Plan)
    t, s = plan.trajectory.t_s, plan.trajectory.s_m
    way = float((s - (speed - closing) * t).max())
    assert way == pytest.approx(way_m(closing), abs=0.05 * closing + 0.1)
    assert plan.verdict.passed == (way < gap) or abs(way - gap) < 0.1


@pytest.mark.parametrize(("gap_s", "braking_mps2", "impact_mps"), [(2.0, 7.5, 0.0), (2.0, 4.9, None), (1.4, 8.0, 8.35)])
def test_who_brakes_hard_ahead_is_answered_after_evaluation_and_reaction(
    gap_s: float, braking_mps2: float, impact_mps: float | None
) -> None:
    """Annex 4, appendix 3: 0.4 s, 0.75 s and 0.6 s of build-up; from 2.0 s nobody is hit.

    From 1.4 s the way is 3.4 to 5.9 m short by hand: 7.2 to 9.5 m/s.
    """
    method, step = CompetentDriverMethod(CAR), 0.1
    host, lead_v, gap = HostState(speed_mps=25.0), 25.0, gap_s * 25.0
    before: Plan | None = None
    began: float | None = None
    for k in range(80):
        braking = braking_mps2 if lead_v > 0.0 else 0.0
        ahead = Track(
            id="a", s_m=host.s_m + gap + 4.5, d_m=0.0, speed_s_mps=lead_v, acceleration_s_mps2=-braking, acceleration_s_sd_mps2=0.1
        )
        plan = method.plan(Situation(time_s=round(step * k, 9), host=host, tracks=(ahead,), coverage=Coverage()), before)
        assert isinstance(plan, Plan)
        then = HostState.from_vector(plan.trajectory.states[int(np.searchsorted(plan.trajectory.t_s, step - 1e-9))])
        began = step * k if began is None and then.acceleration_mps2 < -0.5 else began
        slower = max(lead_v - step * braking, 0.0)
        gap += 0.5 * step * (lead_v + slower) - (then.s_m - host.s_m)
        host, lead_v, before = then, slower, plan
        if gap <= 0.0:
            break
    assert began is not None
    if impact_mps is None:  # nobody brakes hard: the critical time to collision decides
        assert began > 1.5
    else:
        assert began == pytest.approx(0.1 + 0.4 + 0.75, abs=0.15)
        assert (host.speed_mps - lead_v if gap <= 0.0 else 0.0) == pytest.approx(impact_mps, abs=1.2)
