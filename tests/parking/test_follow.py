"""Parking in closed loop: parked in spite of noise and delay, a sound stop in every cycle, never into what was seen in time."""

import json
from dataclasses import replace
from functools import lru_cache

import numpy as np
import pytest

from mcdas_opt.domain.parking import ParkingCase, ParkingTrajectory
from mcdas_opt.errors import ParameterError
from mcdas_opt.geometry.clearance import Body, PolygonField
from mcdas_opt.parking.case_file import slot_case
from mcdas_opt.parking.case_variants import shorter_slot
from mcdas_opt.parking.closed_loop.follow import CYCLE_S, follow
from mcdas_opt.parking.closed_loop.record import ParkingDrive, ParkingOutcome
from mcdas_opt.parking.closed_loop.replanning import MARGINS_M, STEERING_RATE_SHARE, STEERING_SHARE, plan_from
from mcdas_opt.parking.closed_loop.settings import FollowSettings, ParkingNoise
from mcdas_opt.parking.closed_loop.sight import Visitor
from mcdas_opt.verification.parking_judge import judge_parking

CASE = slot_case(7.6)
ONCE = FollowSettings(replans=0)
SILENCE = ParkingNoise(position_m=0.0, heading_rad=0.0, speed_mps=0.0, steering_rad=0.0, speed_scale=0.0, steering_offset_rad=0.0)


@lru_cache
def the_plan() -> ParkingTrajectory:
    plan, refusal = plan_from(CASE, CASE.start, 0.0, "search")
    assert plan is not None, refusal
    return plan


@lru_cache
def seeded(seed: int) -> ParkingDrive:
    return follow(CASE, "search", seed, plan=the_plan(), settings=ONCE)


def mirrored(case: ParkingCase) -> ParkingCase:
    flip = np.array([1.0, -1.0, -1.0])
    outlines = tuple(outline[::-1] * [1.0, -1.0] for outline in case.obstacles)
    return replace(case, start=case.start * flip, goal=case.goal * flip, obstacles=outlines, slot=None)


def mirrored_plan(plan: ParkingTrajectory) -> ParkingTrajectory:
    return ParkingTrajectory.from_controls(plan.t_s, plan.poses * [1.0, -1.0, -1.0], plan.speed_mps, -plan.steering_rad)


def in_the_way(time_s: float, ahead_s: float) -> Visitor:
    """Somebody who stands, from `time_s` on, where the end of the body that leads will touch about `ahead_s` later."""
    plan, car = the_plan(), CASE.vehicle
    x, y, psi = (float(np.interp(time_s + ahead_s, plan.t_s, q)) for q in plan.poses.T)
    forward = float(np.interp(time_s + ahead_s, plan.t_s, plan.speed_mps)) > 0.0
    end = car.wheelbase_m + car.front_overhang_m + 0.3 if forward else -car.rear_overhang_m - 0.3
    return Visitor(x_m=x + end * float(np.cos(psi)), y_m=y + end * float(np.sin(psi)), from_s=time_s)


def apart_at(visitor: Visitor) -> float:
    """Distance of the body to the visitor at the moment of appearance [m]."""
    pose = np.array([[float(np.interp(visitor.from_s, the_plan().t_s, q)) for q in the_plan().poses.T]])
    return float(PolygonField.of([visitor.outline()]).clearance(pose, Body.of(CASE.vehicle))[0])


def test_plans_keep_a_reserve_and_pass_the_judge():
    plan = the_plan()
    found = judge_parking(CASE, plan)
    assert found.verdict.passed
    assert found.min_clearance_m is not None
    assert found.min_clearance_m >= CASE.limits.clearance_m + MARGINS_M[0] - 1e-3
    assert np.abs(plan.steering_rad).max() <= STEERING_SHARE * CASE.vehicle.steering_max_rad * 1.001
    assert np.abs(plan.steering_rate_radps).max() <= STEERING_RATE_SHARE * CASE.vehicle.steering_rate_max_radps * 1.001


@pytest.mark.parametrize("seed", range(6))
def test_parked_for_every_noise_with_a_sound_stop_in_every_cycle(seed):
    drive = seeded(seed)
    assert drive.outcome is ParkingOutcome.PARKED, drive.reason
    assert drive.end_position_error_m <= CASE.tolerance.position_m
    assert drive.end_heading_error_rad <= CASE.tolerance.heading_rad
    assert drive.min_clearance_m is not None
    assert drive.min_clearance_m >= CASE.limits.clearance_m
    assert drive.max_across_m < 0.02
    assert drive.stops_unsound == drive.stops_driven == 0
    assert drive.stops_judged >= int(the_plan().duration_s / CYCLE_S)
    assert drive.trajectory.speed_mps[-1] == 0.0


def test_the_car_driven_keeps_its_limits():
    driven = seeded(0).trajectory
    assert np.abs(driven.steering_rate_radps).max() <= CASE.vehicle.steering_rate_max_radps + 1e-9
    assert np.abs(driven.steering_rad).max() <= CASE.vehicle.steering_max_rad + 1e-9
    assert driven.speed_mps.max() <= CASE.limits.forward_mps + 1e-9
    assert driven.speed_mps.min() >= -CASE.limits.reverse_mps - 1e-9


def test_a_seed_repeats_to_the_byte_and_another_does_not():
    again = follow(CASE, "search", 3, plan=the_plan(), settings=ONCE)
    assert json.dumps(again.to_dict()) == json.dumps(seeded(3).to_dict())
    assert json.dumps(seeded(4).to_dict()) != json.dumps(seeded(3).to_dict())


def test_without_noise_the_mirrored_case_is_driven_as_the_mirror_image():
    silent = replace(ONCE, noise=SILENCE)
    plain = follow(CASE, plan=the_plan(), settings=silent)
    other = follow(mirrored(CASE), plan=mirrored_plan(the_plan()), settings=silent)
    assert plain.outcome is other.outcome is ParkingOutcome.PARKED
    np.testing.assert_allclose(other.trajectory.poses, plain.trajectory.poses * [1.0, -1.0, -1.0], atol=1e-6)
    assert plain.max_across_m < 0.002
    assert plain.max_along_m < 0.03
    assert seeded(0).max_across_m > plain.max_across_m


def test_a_slot_that_turns_out_shorter_is_planned_anew():
    truth = shorter_slot(CASE, 0.4)
    drive = follow(CASE, "search", 1, plan=the_plan(), truth=truth)
    assert drive.outcome is ParkingOutcome.PARKED, drive.events
    assert drive.replans == 1
    assert drive.stops_driven == 1
    assert drive.stops_unsound == 0
    assert drive.min_clearance_m is not None
    assert drive.min_clearance_m >= 0.04
    end = drive.trajectory.poses[-1] - truth.goal
    assert float(np.hypot(end[0], end[1])) <= truth.tolerance.position_m


def test_a_slot_that_turns_out_too_short_ends_at_rest():
    drive = follow(CASE, "search", 1, plan=the_plan(), truth=shorter_slot(CASE, 3.05))
    assert drive.outcome is ParkingOutcome.STOPPED
    assert "impossible" in drive.reason
    assert drive.trajectory.speed_mps[-1] == 0.0
    assert drive.min_clearance_m is not None
    assert drive.min_clearance_m > 0.0


def test_nobody_is_run_over_who_was_seen_in_time():
    plan, sound, late = the_plan(), 0, 0
    for seed, time_s in enumerate(np.arange(1.0, plan.duration_s - 1.0, 2.0)):
        for ahead in (0.3, 0.8):
            visitor = in_the_way(float(time_s), ahead)
            if apart_at(visitor) < 0.02:
                continue
            drive = follow(CASE, "search", seed, plan=plan, visitors=(visitor,), settings=ONCE)
            unsound = any("clearance: " in event.text for event in drive.events)
            late += unsound
            speed = abs(float(np.interp(time_s, plan.t_s, plan.speed_mps)))
            if not unsound:
                assert drive.outcome is not ParkingOutcome.COLLISION, (time_s, ahead, drive.events)
                sound += drive.stops_driven
            else:  # then it was truly too late: nearer than hard braking needs, and its margin
                assert apart_at(visitor) < 0.35 * speed + speed**2 / (2.0 * ONCE.hard_braking_mps2) + 0.08
            assert drive.trajectory.speed_mps[-1] == 0.0 or drive.outcome is ParkingOutcome.COLLISION
    assert sound >= 5
    assert late <= sound


def test_who_walks_away_is_waited_for():
    on_the_goal = CASE.goal[0] + CASE.vehicle.centre_m
    visitor = Visitor(x_m=float(on_the_goal), y_m=float(CASE.goal[1]), from_s=1.0, until_s=9.0)
    drive = follow(CASE, "search", 2, plan=the_plan(), visitors=(visitor,))
    assert drive.outcome is ParkingOutcome.PARKED, drive.events
    assert drive.replans >= 2  # the first ones are refused: somebody stands on the goal
    assert [event.text for event in drive.events if "is gone" in event.text]
    assert drive.duration_s > 9.0


def test_records_refuse_what_makes_no_sense():
    with pytest.raises(ParameterError, match="until_s"):
        Visitor(x_m=0.0, y_m=0.0, from_s=3.0, until_s=2.0)
    with pytest.raises(ParameterError, match="truth"):
        follow(CASE, plan=the_plan(), truth=replace(CASE, obstacles=CASE.obstacles[:2], names=CASE.names[:2], slot=None))
    with pytest.raises(ParameterError, match="slot"):
        shorter_slot(mirrored(CASE), 0.1)


@pytest.mark.parametrize(
    ("strict", "why"), [({"tracked_m": 0.004}, "the path is lost"), ({"stop_clearance_m": 0.12}, "no stop after this cycle")]
)
def test_a_car_that_loses_its_path_or_its_stop_comes_to_rest(strict, why):
    drive = follow(CASE, "search", 5, plan=the_plan(), settings=replace(ONCE, **strict))
    assert drive.outcome is ParkingOutcome.STOPPED
    assert drive.stops_driven == 1
    assert [event.text for event in drive.events if event.text.startswith(why)]
    assert drive.trajectory.speed_mps[-1] == 0.0
    assert drive.duration_s < seeded(5).duration_s
    assert drive.min_clearance_m is not None
    assert drive.min_clearance_m >= CASE.limits.clearance_m
