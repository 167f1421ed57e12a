"""Stops from anywhere along a path: at rest in time, on the path, and rejected where they would not be clear."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mcdas_opt.parking.case_file import slot_case
from mcdas_opt.parking.closed_loop.stopping import braking
from mcdas_opt.parking.path import Arc, ArcPath, drive
from mcdas_opt.verification.parking_judge import judge_parking
from mcdas_opt.verification.parking_stop import judge_stop

CASE = replace(slot_case(9.0), start=np.array([9.0, 1.4, 0.0]))
PATH = drive(CASE, ArcPath(CASE.start, (Arc(0.0, -6.0), Arc(-0.1, 2.0), Arc(0.15, -3.0))))


def stop_at(since: float, reaction: float, beside: float = 0.0, faster: float = 0.0):
    t = PATH.t_s + 0.0
    pose = np.array([np.interp(since, t, PATH.poses[:, i]) for i in range(3)]) + [0.0, beside, 0.0]
    v, delta = float(np.interp(since, t, PATH.speed_mps)), float(np.interp(since, t, PATH.steering_rad))
    return braking(CASE, PATH, since, reaction, pose, v + faster, delta), v


@given(share=st.floats(0.0, 1.0), reaction=st.floats(0.0, 0.4), beside=st.floats(-0.02, 0.02), faster=st.floats(-0.05, 0.05))
@settings(max_examples=40, deadline=None)
def test_a_stop_is_always_there_and_sound(share, reaction, beside, faster):
    stop, v = stop_at(share * PATH.duration_s, reaction, beside, faster)
    found = judge_stop(CASE, stop, 0.02)
    assert found.verdict.passed, found.verdict.reason
    assert stop.speed_mps[-1] == 0.0
    most = min(abs(v) + abs(faster) + CASE.limits.acceleration_mps2 * (reaction + 0.025), CASE.limits.forward_mps)
    brake = most / CASE.limits.acceleration_mps2
    assert stop.duration_s <= reaction + brake + 0.1
    assert stop.path_m <= most * (reaction + 0.025) + 0.5 * most * (brake + 0.05) + 1e-6


def test_without_reaction_the_stop_stays_on_the_path():
    for since in np.linspace(0.0, PATH.duration_s, 25):
        stop, _ = stop_at(float(since), 0.2)
        apart = np.hypot(*(stop.poses[:, None, :2] - PATH.poses[None, :, :2]).transpose(2, 0, 1)).min(axis=1)
        assert apart.max() < 0.06  # half the samples' spacing at full speed, and the last step's


def test_an_obstacle_before_the_stop_is_reported_and_one_behind_it_is_not():
    stop, _ = stop_at(2.0, 0.2)
    rear = float(stop.x_m[-1]) - CASE.vehicle.rear_overhang_m
    for gap, passes in ((0.1, True), (0.021, True), (0.01, False), (-0.1, False)):
        x = rear - gap
        box = np.array([[x - 0.5, 1.0], [x, 1.0], [x, 1.8], [x - 0.5, 1.8]])
        blocked = replace(CASE, obstacles=(*CASE.obstacles, box), names=(*CASE.names, "pedestrian"))
        verdict = judge_stop(blocked, stop, 0.02).verdict
        assert verdict.passed == passes
        if not passes:
            assert "pedestrian" in verdict.reason


def test_only_the_start_in_motion_is_forgiven():
    stop, v = stop_at(2.0, 0.2)
    assert abs(v) > 0.5
    here = replace(CASE, start=stop.poses[0], goal=stop.poses[-1])
    assert [found.name for found in judge_parking(here, stop).verdict.violations] == ["start speed"]
    rolling = replace(stop, speed_mps=stop.speed_mps + 0.1)
    assert not judge_stop(CASE, rolling, 0.02).verdict.passed
    harsher = replace(CASE, limits=replace(CASE.limits, acceleration_mps2=0.5))
    assert "acceleration" in judge_stop(harsher, stop, 0.02).verdict.reason


def test_harder_braking_stops_shorter():
    ways = []
    for a in (1.5, 3.0, 6.0):
        case = replace(CASE, limits=replace(CASE.limits, acceleration_mps2=a))
        pose = PATH.poses[40]
        stop = braking(case, PATH, float(PATH.t_s[40]), 0.1, pose, float(PATH.speed_mps[40]), float(PATH.steering_rad[40]))
        assert judge_stop(case, stop, 0.02).verdict.passed
        ways.append(stop.path_m)
    assert ways == sorted(ways, reverse=True)
    assert ways[2] < ways[0] - 0.1
    with pytest.raises(ValueError, match="read-only"):
        stop.speed_mps[0] = 0.0
