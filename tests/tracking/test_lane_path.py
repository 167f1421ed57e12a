"""Who does not follow the host's road, and whose lane is known, is predicted along it."""

from __future__ import annotations

import math
import os
from dataclasses import replace
from operator import attrgetter
from unittest.mock import patch

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.prediction import CruisingBody, FreeBody
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.rules import Array
from mcdas_opt.domain.situation import Situation
from mcdas_opt.domain.track import Coverage, Places, Track
from mcdas_opt.domain.variant import Variant
from mcdas_opt.domain.vocabulary import Status
from mcdas_opt.errors import ParameterError
from mcdas_opt.geometry.window import frame_near
from mcdas_opt.native.form import SWITCH
from mcdas_opt.planning.cycle import Cycle
from mcdas_opt.planning.planner import Planner
from mcdas_opt.planning.proposals.yielding import yielding
from mcdas_opt.tracking import prediction
from mcdas_opt.tracking.lane_path import along_lane
from mcdas_opt.tracking.prediction import predict

STRAIGHT = Road(lanes_left=1, lanes_right=1)
CORNER = Road(lanes_left=1, curvature=((0.0, 0.0), (20.0, 0.0), (25.0, 0.08), (38.0, 0.08), (43.0, 0.0)))
TIMES = np.linspace(0.0, 4.0, 81)
MOTION = ("s_m", "d_m", "heading_rad", "speed_s_mps", "speed_d_mps")
RADIUS_M = 12.0


def arc(turns_left: bool, radius_m: float = RADIUS_M) -> Array:
    """(n, 2) of a quarter circle in a plane, from its origin on along x, then 30 m straight on."""
    angles = np.linspace(0.0, 0.5 * math.pi, 41)
    side = 1.0 if turns_left else -1.0
    circle = np.column_stack([radius_m * np.sin(angles), side * radius_m * (1.0 - np.cos(angles))])
    return np.concatenate([circle, circle[-1] + np.column_stack([np.zeros(6), side * np.arange(5.0, 31.0, 5.0)])])


def on_it(road: Road, at: tuple[float, float, float], speed: float, beside_m: float = 0.0, turns_left: bool = True) -> Track:
    """Somebody who begins such an arc at (s, d), turned by an angle from the road, and is so far to the left of it."""
    frame = frame_near(road, at[0])
    x, y, yaw = (float(q[0]) for q in frame.to_plane(*(np.array([q]) for q in at)))
    c, s = math.cos(yaw), math.sin(yaw)
    points = arc(turns_left)
    px, py = x + c * points[:, 0] - s * points[:, 1], y + s * points[:, 0] + c * points[:, 1]
    its_s, its_d, _ = frame.to_road(px, py, np.zeros(len(points)), near_s_m=at[0])
    here = frame.to_road(*(np.array([q]) for q in (x - s * beside_m, y + c * beside_m, yaw)), near_s_m=at[0])
    s_m, d_m, psi = (float(q[0]) for q in here)
    stretch = 1.0 - d_m * float(road.curvature_at(s_m))
    moving = {"speed_s_mps": speed * math.cos(psi) / stretch, "speed_d_mps": speed * math.sin(psi), "heading_rad": psi}
    path: Places = tuple(zip(its_s.tolist(), its_d.tolist(), strict=True))
    return replace(Track(id="1", s_m=s_m, d_m=d_m, speed_s_mps=0.0), lane_path_m=path, **moving)


@given(st.sampled_from([STRAIGHT, CORNER]), st.floats(0.0, 60.0), st.floats(-6.0, 4.0), st.floats(-math.pi, math.pi), st.floats(0.0, 14.0))
def test_both_forms_say_the_same(road: Road, s_m: float, d_m: float, heading: float, speed: float) -> None:
    one = on_it(road, (s_m, d_m, heading), speed)
    compiled = along_lane(one, road)
    with patch.dict(os.environ, {SWITCH: "0"}):
        interpreted = along_lane(one, road)
    assert compiled is not None
    assert interpreted is not None
    for ours, theirs in zip(attrgetter(*MOTION)(compiled(TIMES)), attrgetter(*MOTION)(interpreted(TIMES)), strict=True):
        np.testing.assert_allclose(ours, theirs, atol=1e-8)


@given(
    st.sampled_from([STRAIGHT, CORNER]), st.floats(0.0, 60.0), st.floats(-6.0, 4.0), st.floats(-math.pi, math.pi), st.floats(1.0, 14.0),
    st.floats(-0.5, 0.5), st.booleans(),
)  # fmt: skip
def test_it_stays_beside_the_middle_of_its_lane_at_its_speed(
    road: Road, s_m: float, d_m: float, heading: float, speed: float, beside_m: float, turns_left: bool
) -> None:
    one = on_it(road, (s_m, d_m, heading), speed, beside_m, turns_left)
    motion = along_lane(one, road)
    assert motion is not None
    at = motion(TIMES)
    assert (at.s_m[0], at.d_m[0]) == pytest.approx((one.s_m, one.d_m), abs=1e-6)
    frame = frame_near(road, s_m)
    x, y, yaw = (q[0] for q in frame.to_plane(*(np.array([q]) for q in (s_m, d_m, heading))))
    px, py, _ = frame.to_plane(at.s_m, at.d_m, at.heading_rad)
    along, left = np.cos(yaw) * (px - x) + np.sin(yaw) * (py - y), np.cos(yaw) * (py - y) - np.sin(yaw) * (px - x)
    side = 1.0 if turns_left else -1.0
    turning = speed * TIMES < 0.45 * math.pi * RADIUS_M
    radii = np.hypot(along, left - side * RADIUS_M)[turning]
    np.testing.assert_allclose(radii, RADIUS_M - side * beside_m, atol=0.15)
    gone = np.arctan2(along, side * (side * RADIUS_M - left))[turning] * RADIUS_M
    np.testing.assert_allclose(gone, speed * TIMES[turning], atol=0.15 + 0.02 * speed)


@pytest.mark.parametrize("beside_m", [-2.5, 2.5])
def test_who_cuts_a_turn_comes_back_to_its_lane(beside_m: float) -> None:
    motion = along_lane(on_it(STRAIGHT, (30.0, -4.0, 1.2), 8.0, beside_m=beside_m), STRAIGHT)
    middle = along_lane(on_it(STRAIGHT, (30.0, -4.0, 1.2), 8.0), STRAIGHT)
    assert motion is not None
    assert middle is not None
    at, there = motion(TIMES), middle(TIMES)
    off_m = np.hypot(at.s_m - there.s_m, at.d_m - there.d_m)
    assert off_m[0] == pytest.approx(2.5, abs=0.1)
    assert float(off_m[-1]) == pytest.approx(0.5, abs=0.1)


@pytest.mark.parametrize("road", [STRAIGHT, CORNER])
def test_who_is_not_in_it_does_not_follow_it(road: Road) -> None:
    one = on_it(road, (30.0, -4.0, 1.2), 8.0)
    assert along_lane(one, road) is not None
    assert along_lane(replace(one, lane_path_m=None), road) is None
    assert along_lane(on_it(road, (30.0, -4.0, 1.2), 8.0, beside_m=3.5), road) is None
    assert one.heading_rad is not None
    assert along_lane(replace(one, heading_rad=one.heading_rad + 1.4), road) is None


def test_behind_the_end_of_its_lane_it_goes_straight_on() -> None:
    one = replace(
        Track(id="1", s_m=30.0, d_m=-20.0, speed_s_mps=0.0, speed_d_mps=8.0, heading_rad=0.5 * math.pi),
        lane_path_m=((30.0, -25.0), (30.0, -12.0)),
    )
    motion = along_lane(one, STRAIGHT)
    assert motion is not None
    at = motion(TIMES)
    np.testing.assert_allclose(at.s_m, 30.0, atol=1e-6)
    np.testing.assert_allclose(at.d_m, -20.0 + 8.0 * TIMES, atol=1e-6)


def test_of_a_lane_that_leads_far_no_more_is_looked_at_than_matters() -> None:
    near, far = ((30.0, -25.0), (30.0, 80.0)), ((30.0, -1e6), (30.0, 1e6))
    crossing = Track(id="1", s_m=30.0, d_m=-20.0, speed_s_mps=0.0, speed_d_mps=8.0, heading_rad=0.5 * math.pi)
    motions = [along_lane(replace(crossing, lane_path_m=path), STRAIGHT) for path in (near, far)]
    assert all(motion is not None for motion in motions)
    there, same = (motion(TIMES) for motion in motions if motion is not None)
    np.testing.assert_allclose(same.d_m, there.d_m, atol=1e-6)


def turning_off(side: float, known: bool) -> Situation:
    """The host waits in a queue; somebody comes straight at it, from ahead to the left (1) or the right, and turns off before it."""
    comes = on_it(STRAIGHT, (24.0, 14.0 * side, side * math.atan2(-14.0, -24.0)), 9.0, turns_left=side > 0.0)
    leader = Track(id="leader", s_m=8.0, d_m=0.0, speed_s_mps=0.0)
    tracks = (comes if known else replace(comes, lane_path_m=None), leader)
    return Situation(host=HostState(), road=STRAIGHT, coverage=Coverage(), desired_speed_mps=13.9, tracks=tracks)


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_a_standing_host_does_not_flee_from_who_turns_off_before_it(side: float) -> None:
    plan = Planner().plan(turning_off(side, known=True))
    assert plan.status is Status.PLANNED
    assert plan.trajectory.states[-1, 0] < 1.5
    assert Planner().plan(turning_off(side, known=False)).status is Status.UNAVOIDABLE


def test_who_comes_through_a_turn_in_a_lane_that_is_known_does_not_go_straight_on() -> None:
    # a car in the lane beside, towards the host, where the road turns as at a crossing
    oncoming = Track(id="1", s_m=60.0, d_m=3.7, speed_s_mps=-10.0, heading_rad=math.pi)
    along = replace(oncoming, lane_path_m=((62.0, 3.7), (20.0, 3.7), (0.0, 3.7)))
    assert {body.id for body in predict([oncoming], road=CORNER).bodies} == {"1", Variant.STRAIGHT_ON.of("1")}
    (body,) = predict([along], road=CORNER).bodies
    assert isinstance(body, CruisingBody)


@pytest.mark.parametrize(("speed", "kind"), [(4.0, FreeBody), (10.0, CruisingBody)])
def test_who_comes_towards_the_host_is_predicted_along_a_lane_that_leads_off_by_bends_that_he_can_drive(speed: float, kind: type) -> None:
    turn = [(50.0 - 6.0 * math.sin(u), -2.3 + 6.0 * math.cos(u)) for u in np.linspace(0.0, 0.5 * math.pi, 9)]
    across = ((62.0, 3.7), *turn, (44.0, -20.0))
    (body,) = predict([Track(id="1", s_m=60.0, d_m=3.7, speed_s_mps=-speed, heading_rad=math.pi, lane_path_m=across)], road=STRAIGHT).bodies
    assert isinstance(body, kind)


def test_who_turns_across_in_a_lane_that_is_known_is_let_through() -> None:
    one = replace(on_it(STRAIGHT, (45.0, 8.0, math.pi), 6.0, turns_left=True), turn_rate_radps=0.5, turn_rate_sd_radps=0.05)
    turned = replace(
        one, heading_rad=-0.8 * math.pi, speed_s_mps=6.0 * math.cos(-0.8 * math.pi), speed_d_mps=6.0 * math.sin(-0.8 * math.pi)
    )
    host = HostState(speed_mps=10.0)
    for track, lets in ((turned, True), (replace(turned, lane_path_m=None), False)):
        situation = Situation(host=host, road=STRAIGHT, coverage=Coverage(), desired_speed_mps=10.0, tracks=(track,))
        assert bool(yielding(Cycle.of(situation, Planner().vehicle), 0.0)) is lets


def goes_straight_on(side: float, x_m: float, across_mps: float = 0.0) -> tuple[Road, Track]:
    """A road that swings out and turns off tightly, to the right (1) or the left; beside it somebody whose lane goes straight on."""
    bends = ((4.0, 0.0), (6.0, 0.05), (9.0, 0.05), (11.0, -0.15), (20.0, -0.15), (23.0, 0.0))
    road = Road(lanes_left=1, lanes_right=1, lane_width_m=3.2, curvature=tuple((s, side * kappa) for s, kappa in bends))
    frame, x = frame_near(road, 0.0), np.arange(-10.0, 60.0, 1.0)
    s, d, _ = frame.to_road(x, np.full_like(x, 3.2 * side), np.zeros_like(x), near_s_m=x_m)
    yaw = math.asin(across_mps / 4.0)
    at, off, psi = (float(q[0]) for q in frame.to_road(*(np.array([q]) for q in (x_m, 3.2 * side, yaw)), near_s_m=x_m))
    moving = {"speed_s_mps": 4.0 * math.cos(psi) / (1.0 - off * float(road.curvature_at(at))), "speed_d_mps": 4.0 * math.sin(psi)}
    path = tuple(zip(s.tolist(), d.tolist(), strict=True))
    return road, Track(id="1", s_m=at, d_m=off, heading_rad=psi, lane_path_m=path, **moving)


@pytest.mark.parametrize("side", [1.0, -1.0])
@pytest.mark.parametrize("x_m", [0.0, 4.0, 7.0])
def test_beside_a_road_that_turns_off_who_keeps_to_a_lane_that_does_not_is_predicted_along_it(side: float, x_m: float) -> None:
    road, track = goes_straight_on(side, x_m)
    (body,) = predict([track], road=road).bodies
    motion = body.at(TIMES)
    _, y, yaw = frame_near(road, 0.0).to_plane(motion.s_m, motion.d_m, motion.heading_rad)
    assert np.abs(y - 3.2 * side).max() < 0.05
    assert np.abs(yaw).max() < 0.02
    # who leaves that lane is predicted as any other
    leaves = goes_straight_on(side, x_m, across_mps=-0.7 * side)[1]
    assert all(isinstance(body, CruisingBody) for body in predict([leaves], road=road).bodies)


@pytest.mark.parametrize("side", [1.0, -1.0])
@pytest.mark.parametrize("host_mps", [0.0, 0.7, 1.5])
@pytest.mark.parametrize("behind_m", [1.0, 2.0])
@pytest.mark.parametrize("host_s_m", [10.0, 11.0])
def test_a_host_that_turns_off_has_a_plan_beside_who_goes_straight_on(
    side: float, host_mps: float, behind_m: float, host_s_m: float
) -> None:
    """The road's line swings out before the turn, so that he seems to change into the host's lane: nothing passed."""
    road, track = goes_straight_on(side, host_s_m - behind_m)
    host = HostState(s_m=host_s_m, speed_mps=host_mps)
    plan = Planner().plan(Situation(host=host, road=road, coverage=Coverage(), desired_speed_mps=8.0, tracks=(track,)))
    assert plan.status is Status.PLANNED


@pytest.mark.parametrize("side", [1.0, -1.0])
@pytest.mark.parametrize(("speed", "stands"), [(5.0, True), (9.0, True), (13.0, True), (9.0, False)])
def test_whose_lane_leads_him_behind_somebody_behind_a_standing_host_does_not_come_to_it(side: float, speed: float, stands: bool) -> None:
    """He turns out of a side street behind a queue: predicted on along his lane he came through the one who stands behind the host."""
    joins = replace(on_it(STRAIGHT, (-26.0, 12.0 * side, -0.5 * side * math.pi), speed, turns_left=side > 0.0), id="joins")
    queue = [Track(id=name, s_m=s, d_m=0.0, speed_s_mps=0.0) for name, s in (("ahead", 8.0), ("behind", -7.5))]
    tracks = (*queue[: 2 if stands else 1], joins)
    there = {body.id for body in predict(tracks, road=STRAIGHT, host_s_m=0.0).bodies}
    assert ("joins" in there) is not stands
    given = {"host": HostState(), "road": STRAIGHT, "coverage": Coverage(), "desired_speed_mps": 13.9}
    plan = Planner().plan(Situation(tracks=tracks, **given))
    assert (plan.status is Status.PLANNED and float(plan.trajectory.states[-1, 0]) < 1.5) is stands


def test_who_joins_a_queue_is_judged_by_the_first_whom_he_meets() -> None:
    """Before the nearest he cannot stop any more: that he could before the next helps nobody, in whichever order they are told."""
    joins = replace(on_it(STRAIGHT, (-26.0, 12.0, -0.5 * math.pi), 9.0), id="joins")
    first, last = (Track(id=f"{s}", s_m=s, d_m=d, speed_s_mps=0.0) for s, d in ((-25.0, 6.0), (-7.5, 0.0)))
    ids = [{body.id for body in predict((*queue, joins), road=STRAIGHT, host_s_m=0.0).bodies} for queue in ((first, last), (last, first))]
    assert ids[0] == ids[1]
    assert "joins" in ids[0]


@pytest.mark.parametrize(
    "path", [(), ((0.0, 0.0),), ((0.0, 0.0, 1.0), (1.0, 0.0, 1.0)), ((0.0, math.nan), (1.0, 0.0)), ((1.0, 0.0), (1.0, 0.0)), "road"]
)
def test_what_is_no_path_is_refused_by_name(path: object) -> None:
    with pytest.raises(ParameterError, match="lane_path_m"):
        Track(id="1", s_m=0.0, d_m=0.0, speed_s_mps=0.0, lane_path_m=path)  # type: ignore[arg-type]


def test_a_path_moves_with_the_origin() -> None:
    one = Track(id="1", s_m=100.0, d_m=0.0, speed_s_mps=0.0, lane_path_m=((100.0, 0.0), (110.0, 5.0)))
    assert one.seen_from(90.0).lane_path_m == ((10.0, 0.0), (20.0, 5.0))


def test_a_lane_is_followed_through_only_where_that_can_change_something(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of those who drive along, or come, in lanes that lead along the road nobody leaves it by his lane, nor joins behind anybody."""
    along: Places = tuple((float(s), 3.5) for s in range(-100, 301, 20))
    beside = [Track(id=str(s), s_m=float(s), d_m=3.5, speed_s_mps=8.0, lane_path_m=along) for s in (10, 40, 70, 100)]
    coming = Track(id="coming", s_m=150.0, d_m=3.5, speed_s_mps=-8.0, lane_path_m=along[::-1])
    follower = Track(id="follower", s_m=-20.0, d_m=0.0, speed_s_mps=8.0)
    asked = list[str]()

    def counted(track: Track, *given: object) -> object:
        asked.append(track.id)
        return along_lane(track, *given)  # type: ignore[arg-type]

    monkeypatch.setattr(prediction, "along_lane", counted)
    found = predict([*beside, coming, follower], road=CORNER, host_s_m=0.0)
    assert [name for name in asked if name != follower.id] == []
    assert {body.id for body in found.bodies} >= {track.id for track in beside}
