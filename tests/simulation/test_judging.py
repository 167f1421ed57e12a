"""Anybody's trajectory against a scene or a situation."""

from __future__ import annotations

import numpy as np
import pytest

from mcdas_opt.domain.situation import Coverage, Situation
from mcdas_opt.domain.trajectory import Trajectory
from mcdas_opt.errors import ParameterError
from mcdas_opt.simulation.judging import exact_tracks, foresee, verify
from tests.simulation.fake_driver import plan_of
from tests.simulation.scene_maker import make_scene

BRAKING_FRONT = {"name": "front", "s_m": 24.5, "speed_mps": 11.1, "motion": [{"start_s": 0.0, "acceleration_mps2": -8.0}]}


def straight_on(seconds: float = 4.0) -> Trajectory:
    return plan_of(make_scene().host_state, [(0.0, 0.0)] * round(10 * seconds)).trajectory


def test_the_script_convicts_what_constant_velocity_lets_pass() -> None:
    scene = make_scene(BRAKING_FRONT)
    assert verify(straight_on(), scene, "constant-velocity").passed
    verdict = verify(straight_on(), scene)
    assert [v.name for v in verdict.violations] == ["collision with front"]
    # 20 m and what the front car still goes against 11.1 m/s
    t = verdict.violations[0].t_s
    gone = 11.1**2 / 16.0 if t > 11.1 / 8.0 else 11.1 * t - 4.0 * t**2
    assert 11.1 * t == pytest.approx(20.0 + gone, abs=11.1 * 0.02)


def test_a_follower_reacts_to_the_trajectory_that_is_judged() -> None:
    rear = {"name": "rear", "s_m": -16.0, "speed_mps": 13.0, "behaviour": "idm"}
    assert verify(straight_on(), make_scene(rear)).passed
    assert not verify(straight_on(), make_scene({**rear, "behaviour": "scripted", "speed_mps": 16.0})).passed


def test_friction_is_the_assumed_one() -> None:
    x = make_scene().host_state
    turning = plan_of(x, [(0.0, 0.1)] * 5).trajectory
    assert verify(turning, make_scene(road={"friction": 0.2}, host={"assumed_friction": 0.9})).passed
    assert not verify(turning, make_scene(road={"friction": 0.9}, host={"assumed_friction": 0.2})).passed


def test_a_situation_is_judged_by_its_tracks() -> None:
    scene = make_scene({**BRAKING_FRONT, "speed_mps": 5.0})
    situation = Situation(host=scene.host_state, tracks=exact_tracks(scene), road=scene.assumed_road, coverage=Coverage())
    assert foresee(straight_on(), situation).name == "constant-velocity"
    by_situation = verify(straight_on(), situation)
    assert by_situation == verify(straight_on(), scene, "constant-velocity")
    assert not by_situation.passed
    with pytest.raises(ParameterError, match="prediction"):
        verify(straight_on(), situation, "scene")


def test_predictions_are_named() -> None:
    scene = make_scene(BRAKING_FRONT)
    assert foresee(straight_on(), scene).name == "scene"
    assert foresee(straight_on(), scene, "constant-velocity").name == "constant-velocity"
    with pytest.raises(ParameterError, match="constant-velocity"):
        verify(straight_on(), scene, "constant velocity")


def test_the_start_must_be_the_scenes() -> None:
    verdict = verify(straight_on(), make_scene(speed_mps=12.0))
    assert not verdict.passed
    assert np.isfinite([v.value for v in verdict.violations]).all()
