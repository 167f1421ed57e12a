"""A sector that nobody watches: what is not done there, and what is said of it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.lane import Lane
from mcdas_opt.domain.measurement import Mounting, RadarDetection, Scan
from mcdas_opt.domain.plan import Plan
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.safe_end import EndKind
from mcdas_opt.domain.situation import MOST_TRACKS, Coverage, Situation
from mcdas_opt.domain.track import Track
from mcdas_opt.domain.vocabulary import Alert, Mode, Side, Status
from mcdas_opt.errors import ParameterError, PlannerFaultWarning
from mcdas_opt.planning import cycle
from mcdas_opt.planning.planner import Planner
from mcdas_opt.situation.doubts import Believed
from mcdas_opt.time_to_react.escapes import escapes
from tests.planning.situations import car, mirrored

NO_REAR = Coverage(rear=False)
ENDING = Road(lanes_left=1, lanes=(Lane(lane=0, width_m=((100.0, 3.7), (160.0, 0.0)), merges="left"),))
TWO_LANES = Road(lanes_left=1)


def driven(plans: Planner, road: Road, coverage: Coverage, until_s: float, speed_mps: float = 14.0) -> list[Plan]:
    """A car alone that does what its plans say, every 0.5 s."""
    found, host = [], HostState(speed_mps=speed_mps)
    for k in range(int(until_s / 0.5)):
        found.append(plans.plan(Situation(time_s=0.5 * k, host=host, coverage=coverage, road=road, desired_speed_mps=14.0)))
        drive = found[-1].trajectory
        s, d, psi, v, steering, a = (
            float(np.interp(0.5, drive.t_s, column))
            for column in (drive.s_m, drive.d_m, drive.heading_rad, drive.speed_mps, drive.steering_rad, drive.acceleration_mps2)
        )
        host = HostState(s_m=s, d_m=d, heading_rad=psi, speed_mps=max(v, 0.0), steering_rad=steering, acceleration_mps2=a)
    return found


def test_a_lane_that_ends_is_stopped_in_where_nobody_watches_behind() -> None:
    plans = driven(Planner(), ENDING, NO_REAR, 16.0)
    assert all(plan.side is Side.NONE for plan in plans)
    assert all(plan.verdict.passed for plan in plans)
    assert "nobody watches behind: stays in its lane, though its own ends" in plans[0].reason
    assert plans[-1].trajectory.speed_mps[0] < 0.5
    assert plans[-1].trajectory.s_m[0] < 130.0
    assert driven(Planner(), ENDING, Coverage(), 4.0)[-1].side is Side.LEFT


def test_out_of_a_lane_of_oncoming_traffic_it_goes_though_nobody_watches_behind() -> None:
    road = Road(lanes_left=1, lanes=(Lane(lane=1, oncoming=True),))
    plan = Planner().plan(Situation(host=HostState(d_m=3.7, speed_mps=14.0), coverage=NO_REAR, road=road))
    assert plan.side is Side.RIGHT


def test_a_lane_change_is_given_up_where_nobody_watches_behind_any_more() -> None:
    planner, road = Planner(), Road(lanes_left=1, lanes=(Lane(lane=0, width_m=((200.0, 3.7), (260.0, 0.0)), merges="left"),))
    first = Situation(host=HostState(speed_mps=14.0), coverage=Coverage(), road=road)
    assert planner.plan(first).side is Side.LEFT
    then = Situation(time_s=0.1, host=HostState(s_m=1.4, speed_mps=14.0), coverage=NO_REAR, road=road)
    assert planner.plan(then).side is Side.NONE


@pytest.mark.parametrize("gap_m", [20.0, 25.0, 30.0, 35.0])
def test_who_can_brake_does_not_steer_into_a_lane_that_nobody_watches_from_behind(gap_m: float) -> None:
    tracks = (car("stands", gap_m, 0.0, 0.0),)
    plan = Planner().plan(Situation(host=HostState(speed_mps=14.0), tracks=tracks, coverage=NO_REAR, road=TWO_LANES))
    assert (plan.mode, plan.side, plan.status) == (Mode.BRAKE, Side.NONE, Status.PLANNED)
    assert next(row for row in plan.candidates if row.name == "left").refusal == "nobody watches behind"


def test_the_last_resort_is_named_and_goes_on_once_it_has_begun() -> None:
    """Braking would hit at some 7 m/s; of 2 m/s it is not worth it."""
    planner, plans = Planner(), []
    for k in range(3):
        tracks = (car("stands", 15.5 - 1.4 * k, 0.0, 0.0),)
        plans.append(
            planner.plan(Situation(time_s=0.1 * k, host=HostState(speed_mps=14.0), tracks=tracks, coverage=NO_REAR, road=TWO_LANES))
        )
    assert [(plan.side, plan.alert) for plan in plans] == [(Side.LEFT, Alert.ACT)] * 3
    assert plans[0].status is Status.FALLBACK
    assert all("nobody watches behind" in plan.reason for plan in plans)
    braking = Planner().plan(
        Situation(host=HostState(speed_mps=14.0), tracks=(car("stands", 18.0, 0.0, 0.0),), coverage=NO_REAR, road=TWO_LANES)
    )
    assert braking.side is Side.NONE


@pytest.mark.parametrize("gap_m", [13.0, 15.5, 16.5, 18.0, 25.0])
def test_it_mirrors(gap_m: float) -> None:
    situation = Situation(host=HostState(speed_mps=14.0), tracks=(car("stands", gap_m, 0.0, 0.0),), coverage=NO_REAR, road=TWO_LANES)
    plan, other = Planner().plan(situation), Planner().plan(mirrored(situation))
    assert (plan.status, plan.alert, -plan.side.sign) == (other.status, other.alert, other.side.sign)
    np.testing.assert_array_equal(plan.trajectory.d_m, -other.trajectory.d_m)


def test_both_sides_are_closed_to_the_time_to_react() -> None:
    found = escapes(Situation(host=HostState(speed_mps=14.0), coverage=NO_REAR, road=Road(lanes_left=1, lanes_right=1)))
    assert found.brake.open
    assert not found.left.open
    assert not found.right.open


NO_FRONT = Coverage(front=False)


def drive(
    until_s: float, blind_s: tuple[float, float], braking_mps2: float = 0.0, gap_m: float = 40.0, told_s: float = 1.4
) -> tuple[list[Plan], float]:
    """At 14 m/s behind a car that may brake to a stop from 1 s on, told of for so long once nobody watches. (plans, the least gap [m])"""
    planner, plans, s, v, a, nearest = Planner(), [], 0.0, 14.0, 0.0, gap_m
    its_s, its_v = gap_m + 4.5, 14.0
    for k in range(round(until_s / 0.1)):
        t = round(0.1 * k, 6)
        is_blind = blind_s[0] <= t < blind_s[1]
        tracks = () if is_blind and t >= blind_s[0] + told_s else (car("lead", its_s, 0.0, its_v),)
        host = HostState(s_m=s, speed_mps=v, acceleration_mps2=a)
        coverage = NO_FRONT if is_blind else Coverage()
        plans.append(planner.plan(Situation(time_s=t, host=host, tracks=tracks, coverage=coverage, road=Road(), desired_speed_mps=14.0)))
        a = plans[-1].command_at(0.1).acceleration_mps2
        s, v = s + 0.1 * v, max(v + 0.1 * a, 0.0)
        a = a if v > 0.0 else 0.0
        its_s, its_v = its_s + 0.1 * its_v, max(its_v - (0.1 * braking_mps2 if t >= 1.0 else 0.0), 0.0)
        nearest = min(nearest, its_s - s - 4.5)
    return plans, nearest


@pytest.mark.parametrize("speed_mps", [5.0, 14.0, 33.0])
def test_where_nobody_watches_ahead_the_plan_is_a_comfortable_stop(speed_mps: float) -> None:
    plan = Planner().plan(Situation(host=HostState(speed_mps=speed_mps), coverage=NO_FRONT, road=TWO_LANES, desired_speed_mps=33.0))
    assert plan.reason.startswith("nobody watches ahead: slows down")
    assert (plan.mode, plan.side, plan.status, plan.alert) == (Mode.BRAKE, Side.NONE, Status.PLANNED, Alert.WARN)
    assert plan.safe_end is not None
    assert plan.safe_end.kind is EndKind.STOPPED
    assert plan.trajectory.speed_mps[-1] < 0.1
    assert plan.trajectory.acceleration_mps2.min() > -3.6


@pytest.mark.parametrize(("braking_mps2", "gap_m"), [(0.0, 30.0), (6.0, 30.0), (8.0, 40.0)])
@pytest.mark.parametrize("told_s", [0.0, 1.4])
def test_who_was_ahead_when_the_sensor_died_is_not_driven_into(braking_mps2: float, gap_m: float, told_s: float) -> None:
    plans, nearest_m = drive(8.0, (1.0, 99.0), braking_mps2, gap_m, told_s)
    assert nearest_m > 0.0
    assert plans[-1].trajectory.speed_mps[0] < 1.0
    assert {plan.alert for plan in plans[45:60]} >= {Alert.WARN, Alert.ACT}
    assert all(plan.safe_end is None or plan.safe_end.kind is not EndKind.CLEAR for plan in plans[14:])


@pytest.mark.parametrize("blip_s", [0.1, 0.2])
def test_a_blip_of_a_sensor_brakes_nobody(blip_s: float) -> None:
    plans, _ = drive(3.0, (1.0, 1.0 + blip_s))
    assert min(float(plan.trajectory.acceleration_mps2.min()) for plan in plans) > -0.2


def test_once_somebody_watches_again_it_drives_on() -> None:
    plans, _ = drive(6.0, (1.0, 3.0), gap_m=60.0)
    assert plans[29].mode is Mode.BRAKE
    assert plans[-1].trajectory.speed_mps[-1] > plans[-1].trajectory.speed_mps[0]


def test_nobody_is_braked_for_behind_a_follower_who_would_not_have_the_time() -> None:
    tracks = (car("behind", -10.5, 0.0, 14.0),)
    plan = Planner().plan(Situation(host=HostState(speed_mps=14.0), tracks=tracks, coverage=NO_FRONT, road=TWO_LANES))
    assert (plan.side, plan.verdict.passed) == (Side.NONE, True)
    assert plan.safe_end is not None
    assert plan.safe_end.kind is EndKind.HELD


def test_a_radar_that_says_that_it_does_not_work_slows_the_car_down() -> None:
    planner, s, v, a, gap_m = Planner(road=Road()), 0.0, 14.0, 0.0, 30.0
    sides = ("rear", "left", "right")
    for k in range(60):
        t = 0.1 * k
        works = k < 15
        seen = (RadarDetection(range_m=gap_m, azimuth_rad=0.0, range_rate_mps=14.0 - v),) if works else ()
        scans = [Scan(sensor="front", sector="front", t_s=t, mounting=Mounting(x_m=2.25), radar=seen, working=works)]
        scans += [Scan(sensor=side, sector=side, t_s=t) for side in sides]
        plan = planner.step(scans, HostState(s_m=s, speed_mps=v, acceleration_mps2=a), t, desired_speed_mps=14.0)
        a = plan.command_at(0.1).acceleration_mps2
        v = max(v + 0.1 * a, 0.0)
        s, gap_m = s + 0.1 * v, gap_m + 0.1 * (14.0 - v)
    assert v < 7.0
    assert "nobody watches ahead" in plan.reason


def test_more_than_a_situation_holds_are_not_supposed_ahead() -> None:
    def many(name: str) -> tuple[Track, ...]:
        return tuple(car(f"{name}{k}", 20.0 + 10.0 * k, 3.7, 14.0) for k in range(MOST_TRACKS - 50))

    planner, host = Planner(), HostState(speed_mps=14.0)
    planner.plan(Situation(host=host, coverage=Coverage(), road=TWO_LANES, tracks=many("a")))
    blind = Situation(time_s=0.1, host=replace(host, s_m=1.4), coverage=Coverage(front=False), road=TWO_LANES, tracks=many("b"))
    assert planner.plan(blind).verdict.passed


def test_who_is_told_of_twice_is_supposed_ahead_once() -> None:
    """Of two equal tracks one is planned around; the other is no less told of. Then nobody is: both were supposed, one of them twice."""
    planner, host = Planner(), HostState(speed_mps=14.0)
    asked = (
        (True, (car("a", 40.0, 0.0, 14.0), car("b", 60.0, 0.0, 14.0))),
        (False, (car("a", 41.4, 0.0, 14.0), car("b", 41.4, 0.0, 14.0))),
        (False, ()),
    )
    for k, (front, tracks) in enumerate(asked):
        now = replace(host, s_m=1.4 * k)
        plan = planner.plan(Situation(time_s=0.1 * k, host=now, coverage=Coverage(front=front), road=TWO_LANES, tracks=tracks))
    believed = {track.id: track.s_m for track in plan.believed.tracks} if plan.believed else {}
    assert believed["a"] == believed["b"] == pytest.approx(42.8)
    assert plan.verdict.passed


def test_what_was_remembered_is_forgotten_where_nothing_can_be_asked_for_it(monkeypatch: pytest.MonkeyPatch) -> None:
    planner, host = Planner(), HostState(speed_mps=14.0)
    first = Situation(host=host, coverage=Coverage(), road=TWO_LANES, tracks=(car("a", 40.0, 0.0, 14.0),))
    planner.plan(first)
    begins = cycle.believed

    def faulty(situation: Situation, before: Sequence[Track], *rest: Any) -> Believed:
        if before:
            raise ParameterError("tracks.id", "a", "must be unique")
        return begins(situation, before, *rest)

    monkeypatch.setattr(cycle, "believed", faulty)
    later = replace(first, time_s=0.1)
    with pytest.warns(PlannerFaultWarning, match="what was remembered is forgotten: ParameterError"):
        plan = planner.plan(later)
    assert plan.verdict.passed
    assert np.array_equal(plan.trajectory.table, Planner().plan(later).trajectory.table)
