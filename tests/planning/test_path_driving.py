"""The compiled following of a path against the law as it is written down."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mcdas_opt.actuation import path_following
from mcdas_opt.actuation.path_following import AccelerationLaw, SpeedLaw
from mcdas_opt.baselines.competent_driver import ReactionLaw
from mcdas_opt.baselines.idm_mobil import Following
from mcdas_opt.baselines.lane import SteadyLaw
from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.prediction import Prediction
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.situation import Coverage, Situation
from mcdas_opt.domain.track import Track
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.dynamics.car_following import IdmSettings
from mcdas_opt.native.library import library
from mcdas_opt.planning.candidates.path_driving import follow
from mcdas_opt.reference.lane_centre import LaneCentre
from mcdas_opt.reference.offset_path import corrected
from mcdas_opt.verification.judge import judge

CAR = Vehicle()


@pytest.mark.skipif(library() is None, reason="there is no native library")
@given(
    v=st.floats(0.0, 40.0),
    target=st.floats(-4.0, 4.0),
    aim=st.floats(0.0, 45.0),
    hard=st.floats(0.5, 8.0),
    bend=st.one_of(st.just(0.0), st.floats(-0.6, 0.6)),
    curve=st.floats(-0.004, 0.004),
    friction=st.floats(0.2, 1.0),
    heading=st.floats(-0.05, 0.05),
    late=st.floats(0.0, 1.0),
    lane=st.booleans(),
)
def test_compiled_law_is_the_law(
    v: float, target: float, aim: float, hard: float, bend: float, curve: float, friction: float, heading: float, late: float, lane: bool
) -> None:
    host = HostState(speed_mps=v, d_m=0.2, heading_rad=heading, acceleration_mps2=0.3 if v > 1.0 else 0.0)
    path = LaneCentre(d_m=target) if lane else corrected(0.3, 0.2, target, v, 3.0, bend_m=bend, bend_s_m=25.0)
    road = Road(lanes_left=1, lanes_right=1, friction=friction, curvature=((0.0, 0.0), (40.0, curve), (90.0, -curve)))
    law = SpeedLaw(speed_mps=aim, acceleration_mps2=hard, start_s=late)
    keys = {"vehicle": CAR, "road": road, "duration_s": 3.0, "lateral_acceleration_mps2": 3.0}
    ours, written = follow(host, path, law, **keys), path_following.follow(host, path, law, **keys)
    assert np.array_equal(ours.t_s, written.t_s)
    assert np.abs(ours.states - written.states).max() < 1e-8
    assert np.abs(ours.inputs - written.inputs).max() < 1e-5


@pytest.mark.skipif(library() is None, reason="there is no native library")
@given(
    v=st.floats(0.0, 40.0),
    kind=st.sampled_from(["steady", "reaction", "nobody", "one", "two"]),
    gap=st.floats(-5.0, 80.0),
    theirs=st.floats(0.0, 40.0),
    hard=st.floats(0.0, 9.0),
    since=st.floats(0.0, 2.0),
    curve=st.floats(-0.004, 0.004),
    friction=st.floats(0.2, 1.0),
    target=st.floats(-4.0, 4.0),
)
def test_compiled_baselines_are_the_baselines(
    v: float, kind: str, gap: float, theirs: float, hard: float, since: float, curve: float, friction: float, target: float
) -> None:
    host, road = HostState(speed_mps=v), Road(lanes_left=1, lanes_right=1, friction=friction, curvature=((0.0, 0.0), (60.0, curve)))
    first = Track(id="first", s_m=gap + 4.5, d_m=0.0, speed_s_mps=theirs)
    second = Track(id="second", s_m=40.0, d_m=3.7, speed_s_mps=15.0)
    leaders = {"nobody": (), "one": (first,), "two": (first, second)}
    if kind == "steady":
        law: AccelerationLaw = SteadyLaw(strength_mps2=hard, until_mps=theirs)
    elif kind == "reaction":
        law = ReactionLaw(since_s=since, until_mps=theirs, strength_mps2=hard)
    else:
        situation = Situation(host=host, tracks=leaders[kind], road=road, coverage=Coverage())
        law = Following(situation=situation, vehicle=CAR, leaders=leaders[kind], desired_mps=30.0, idm=IdmSettings())
    path = LaneCentre(d_m=0.0) if kind == "steady" else corrected(0.0, 0.0, target, v, 2.0)
    keys = {"vehicle": CAR, "road": road, "duration_s": 4.0, "lateral_acceleration_mps2": 3.0}
    ours, written = follow(host, path, law, **keys), path_following.follow(host, path, law, **keys)
    assert np.abs(ours.states - written.states).max() < 1e-8
    assert np.abs(ours.inputs - written.inputs).max() < 1e-5


class Pulsing:
    """A driver of somebody's own."""

    def wanted_mps2(self, t_s: float, s_m: float, speed_mps: float) -> float:
        return -2.0 if int(2.0 * t_s) % 2 else 0.5


def test_who_has_a_law_of_its_own_is_asked_step_by_step() -> None:
    keys = {"vehicle": CAR, "road": Road(), "duration_s": 3.0, "lateral_acceleration_mps2": 3.0}
    host, path = HostState(speed_mps=20.0), LaneCentre(d_m=0.0)
    ours, written = follow(host, path, Pulsing(), **keys), path_following.follow(host, path, Pulsing(), **keys)
    assert np.array_equal(ours.states, written.states)
    assert ours.acceleration_mps2.min() < -1.9


@given(v=st.floats(0.0, 40.0), hard=st.floats(0.5, 8.0), friction=st.floats(0.2, 1.0))
def test_braking_to_a_stop_never_rolls_back_and_the_judge_passes_it(v: float, hard: float, friction: float) -> None:
    host, road = HostState(speed_mps=v), Road(friction=friction)
    law = SpeedLaw(speed_mps=0.0, acceleration_mps2=min(hard, 0.9 * friction * 9.8))
    drive = follow(host, LaneCentre(d_m=0.0), law, vehicle=CAR, road=road, duration_s=14.0, lateral_acceleration_mps2=2.0)
    assert drive.speed_mps.min() >= 0.0
    verdict = judge(drive, host, CAR, road, Prediction(name="nobody"))
    assert verdict.passed, verdict.reason
