"""The compiled members are the interpreted ones; and what is looked at no further could not have been the best of its kind."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.lane import Lane
from mcdas_opt.domain.prediction import BodyMotion, KnownBody, Prediction
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.situation import Coverage, Situation
from mcdas_opt.domain.track import Track
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.manoeuvres.clearance import Margins
from mcdas_opt.manoeuvres.compiled_family import CompiledMembers
from mcdas_opt.manoeuvres.family import Scoring, best_of_each
from mcdas_opt.manoeuvres.kinds import best_of_kind
from mcdas_opt.manoeuvres.lane_change_profiles import LaneChangeProfiles
from mcdas_opt.manoeuvres.members import InterpretedMembers
from mcdas_opt.manoeuvres.phases import Phases
from mcdas_opt.native.form import SWITCH
from mcdas_opt.native.library import library
from mcdas_opt.tracking.prediction import predict, predict_for

SEDAN = Vehicle()
needs_compiler = pytest.mark.skipif(library() is None, reason="no native library")
BENDS = (((0.0, 0.0),), ((0.0, 0.004), (40.0, -0.008), (90.0, 0.0)), ((0.0, -0.02),))
NAMES = ("separation_m", "contact_s", "contact_with", "possible", "on_road", "feasible", "cost")


def random_situation(rng: np.random.Generator) -> Situation:
    """Anything from standstill to top speed, dense traffic, bends, ends of the road."""
    v = float(rng.choice([0.0, rng.uniform(0.0, 6.0), rng.uniform(6.0, 33.0), rng.uniform(45.0, 50.0)]))
    tracks = tuple(
        Track(
            id=f"car {k}",
            s_m=rng.uniform(-40.0, 60.0),
            d_m=rng.uniform(-4.0, 4.0),
            speed_s_mps=v * rng.uniform(0.5, 1.3),
            speed_d_mps=rng.uniform(-1.0, 1.0),
            covariance=np.diag(rng.uniform(0.0, 0.3, 4)),
            acceleration_s_mps2=float(rng.choice([0.0, -5.0, 3.0])),
            acceleration_s_sd_mps2=0.5,
        )
        for k in range(int(rng.integers(0, 5)))
    )
    road = Road(
        lanes_left=1,
        lanes_right=1,
        friction=float(rng.choice([0.9, 0.5, 0.2])),
        curvature=BENDS[int(rng.integers(0, 3))],
        road_end_s_m=float(rng.choice([1e4, 80.0])),
    )
    if rng.random() < 0.4:
        own = Lane(lane=0, width_m=((-10.0, rng.uniform(2.5, 6.0)), (20.0, rng.uniform(2.5, 6.0))))
        road = replace(road, lanes=(Lane(lane=-1, width_m=((10.0, 3.7), (60.0, 0.0))), own, Lane(lane=1, closed_m=((30.0, 50.0),))))
    host = HostState(
        s_m=rng.uniform(-5.0, 5.0),
        d_m=rng.uniform(-0.6, 0.6),
        heading_rad=rng.uniform(-0.06, 0.06),
        speed_mps=v,
        acceleration_mps2=rng.uniform(-3.0, 2.0) if v > 0.0 else 0.0,
        steering_rad=rng.uniform(-0.02, 0.02),
    )
    return Situation(host=host, tracks=tracks, road=road, desired_speed_mps=float(rng.uniform(5.0, 35.0)), coverage=Coverage())


def compiled(*given_to_both: Any) -> CompiledMembers:
    compiled = library()
    assert compiled is not None
    return CompiledMembers(compiled, *given_to_both)


def members(rng: np.random.Generator) -> tuple[Phases, LaneChangeProfiles]:
    count, sides = 6, 12
    phases = Phases(
        first_mps2=rng.uniform(-8.0, 3.0, (count, 1)),
        switch_s=rng.uniform(0.0, 3.0, (count, 1)),
        then_mps2=rng.uniform(-8.0, 3.0, (count, 1)),
    )
    profiles = LaneChangeProfiles(
        target_d_m=rng.uniform(-4.5, 4.5, (1, sides)),
        lateral_mps2=rng.uniform(0.3, 8.0, (1, sides)),
        delay_s=rng.uniform(0.0, 2.0, (1, sides)),
        b=rng.uniform(8.0, 60.0, (1, sides)),
    )
    return phases, profiles


def scoring(rng: np.random.Generator) -> Scoring:
    share = float(rng.choice([0.0, 1.0]))
    margins = Margins(along_m=rng.uniform(0.0, 0.6), across_m=rng.uniform(0.0, 0.3), share_of_prediction=share)
    return Scoring(margins=margins, clear_m=rng.uniform(0.0, 0.1))


@needs_compiler
@settings(max_examples=60, deadline=None)
@given(seed=st.integers(0, 2**32 - 1), samples=st.sampled_from([41, 40, 8, 61]))
def test_compiled_members_are_the_interpreted_ones(seed: int, samples: int) -> None:
    rng = np.random.default_rng(seed)
    situation, (phases, profiles), wanted = random_situation(rng), members(rng), scoring(rng)
    times, prediction = np.round(0.1 * np.arange(samples), 9), predict_for(situation, None)
    given_to_both = (phases, profiles, times, situation, SEDAN, prediction)
    reference, ours = InterpretedMembers(*given_to_both), compiled(*given_to_both)
    mine, theirs = ours.scored(wanted), reference.scored(wanted)
    for name in NAMES:
        assert np.allclose(getattr(mine, name), getattr(theirs, name), rtol=1e-9, atol=1e-9), name
    assert np.allclose(ours.end_speed_mps, reference.end_speed_mps, rtol=0.0, atol=1e-9)
    for p, q in ((0, 0), (3, 7), (5, 11)):
        assert np.allclose(ours.states(p, q), reference.states(p, q), rtol=0.0, atol=1e-9)
    kinds = rng.integers(0, 9, mine.cost.shape)
    assert ours.best(wanted, kinds) == best_of_each(np.where(mine.feasible, mine.cost, np.inf), mine, kinds)
    for one, other in zip(ours.best(wanted, kinds), reference.best(wanted, kinds), strict=True):
        assert (one.phase, one.profile) == (other.phase, other.profile)
        assert abs(one.cost - other.cost) < 1e-9 * max(1.0, other.cost)
        assert abs(one.separation_m - other.separation_m) < 1e-9


@needs_compiler
@pytest.mark.parametrize("seed", range(20))
def test_without_a_compiler_the_choices_are_the_same(seed: int, monkeypatch: pytest.MonkeyPatch) -> None:
    situation = random_situation(np.random.default_rng(seed))
    choices = best_of_kind(situation, SEDAN, predict(situation.tracks), most=9)
    monkeypatch.setenv(SWITCH, "0")
    others = best_of_kind(situation, SEDAN, predict(situation.tracks), most=9)
    assert len(choices) == len(others)
    for one, other in zip(choices, others, strict=True):
        assert (one.side, one.early, one.pace) == (other.side, other.early, other.pace)
        assert (one.target_d_m, one.lateral_mps2, one.delay_s) == (other.target_d_m, other.lateral_mps2, other.delay_s)
        mine, its = one.member, other.member
        assert (mine.phase, mine.profile, mine.contact_with, mine.feasible) == (its.phase, its.profile, its.contact_with, its.feasible)
        assert np.allclose(one.states, other.states, rtol=0.0, atol=1e-9)


@needs_compiler
@pytest.mark.parametrize("seed", range(20))
def test_mirrored_members_are_the_same_to_the_bit(seed: int) -> None:
    rng = np.random.default_rng(seed)
    situation, (phases, profiles), wanted = random_situation(rng), members(rng), scoring(rng)
    host, road = situation.host, situation.road
    other = replace(
        situation,
        host=replace(host, d_m=-host.d_m, heading_rad=-host.heading_rad, steering_rad=-host.steering_rad),
        tracks=tuple(replace(t, d_m=-t.d_m, speed_d_mps=-t.speed_d_mps) for t in situation.tracks),
        road=replace(
            road,
            curvature=tuple((s, -kappa) for s, kappa in road.curvature),
            lanes=tuple(replace(lane, lane=-lane.lane) for lane in road.lanes),
        ),
    )
    times = np.round(0.1 * np.arange(41), 9)
    one = compiled(phases, profiles, times, situation, SEDAN, predict(situation.tracks))
    across = replace(profiles, target_d_m=-profiles.target_d_m)
    two = compiled(phases, across, times, other, SEDAN, predict(other.tracks))
    mine, theirs = one.scored(wanted), two.scored(wanted)
    for name in NAMES:
        assert np.array_equal(getattr(mine, name), getattr(theirs, name)), name
    turned = np.array([1.0, -1.0, -1.0, 1.0, 1.0, -1.0])
    assert np.array_equal(one.states(2, 5), two.states(2, 5) * turned)


@needs_compiler
def test_bodies_of_any_motion_are_met() -> None:
    """A script is sampled one by one, cruising bodies all at once: together they are who they are alone."""
    rng = np.random.default_rng(3)
    situation, (phases, profiles) = random_situation(rng), members(rng)
    track = Track(id="car", s_m=20.0, d_m=0.2, speed_s_mps=8.0, covariance=np.diag([0.2, 0.1, 0.05, 0.02]))

    def stands(t: np.ndarray) -> BodyMotion:
        here = np.zeros_like(t)
        return BodyMotion(s_m=here + 45.0, d_m=here - 1.0, heading_rad=here + 0.3, speed_s_mps=here, speed_d_mps=here)

    script = KnownBody(id="script", length_m=6.0, width_m=2.2, motion=stands)
    prediction = Prediction(name="both", bodies=(*predict((track,)).bodies, script))
    times = np.round(0.1 * np.arange(41), 9)
    given_to_both = (phases, profiles, times, situation, SEDAN, prediction)
    mine = compiled(*given_to_both).scored(Scoring())
    theirs = InterpretedMembers(*given_to_both).scored(Scoring())
    for name in NAMES:
        assert np.allclose(getattr(mine, name), getattr(theirs, name), rtol=1e-9, atol=1e-9), name
