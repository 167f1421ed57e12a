"""Followers in slow traffic: predicted to brake gently, as long as that is enough for them, and nobody in an emergency."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.lane import Lane
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.situation import Coverage, Situation
from mcdas_opt.domain.variant import Variant
from mcdas_opt.domain.vocabulary import Side, Status
from mcdas_opt.planning.planner import Planner
from mcdas_opt.tracking.follower_prediction import predicted_to_brake
from mcdas_opt.tracking.prediction import predict, predict_for
from mcdas_opt.tracking.slow_traffic import (
    ATTENTIVE_MPS2,
    BRAKING_MPS2,
    RESPONSE_S,
    SLOW_MPS,
    TOWARDS_A_TURN_MPS,
    is_beside_oncoming,
)
from tests.planning.situations import car

TIMES = np.linspace(0.0, 8.0, 81)


def queue(front_mps: float, follower_mps: float, behind_m: float, host_mps: float = 6.0) -> Situation:
    return Situation(
        host=HostState(speed_mps=host_mps),
        road=Road(lane_width_m=3.0, lanes_left=1),
        tracks=(car("front", 14.0, 0.0, front_mps), car("behind", -behind_m, 0.0, follower_mps)),
        desired_speed_mps=10.0,
        coverage=Coverage(),
    )


@pytest.mark.parametrize(
    ("front_mps", "follower_mps", "behind_m", "brakes"),
    [(3.0, 6.0, 12.0, True), (3.0, 8.0, 12.0, True), (3.0, 9.5, 9.0, False), (3.0, 14.0, 40.0, False), (14.0, 6.0, 12.0, False)],
)
def test_who_brakes(front_mps: float, follower_mps: float, behind_m: float, brakes: bool) -> None:
    """Not who is faster than a queue, nor who would have to brake hard, nor where nobody slow is ahead."""
    assert predicted_to_brake(predict_for(queue(front_mps, follower_mps, behind_m))) == (("behind",) if brakes else ())


@settings(max_examples=200, deadline=None)
@given(
    front_mps=st.floats(0.0, 20.0),
    follower_mps=st.floats(0.0, 20.0),
    behind_m=st.floats(4.6, 60.0),
    host_mps=st.floats(0.0, 20.0),
)
def test_whoever_is_relied_on_is_slow_and_stays_behind(front_mps: float, follower_mps: float, behind_m: float, host_mps: float) -> None:
    """Of all queues: who is predicted to brake is slow, brakes gently and late, and so stays behind a host that goes on."""
    situation = queue(front_mps, follower_mps, behind_m, host_mps)
    prediction = predict_for(situation)
    if not predicted_to_brake(prediction):
        assert prediction == predict(situation.tracks, None, situation.road, situation.host.s_m)
        return
    assert max(follower_mps, front_mps) <= SLOW_MPS
    (body,) = (one for one in prediction.bodies if one.id == "behind")
    motion = body.at(TIMES)
    assert np.all(motion.speed_s_mps[TIMES <= RESPONSE_S] == follower_mps)
    assert np.diff(motion.speed_s_mps).min() >= -BRAKING_MPS2 * 0.1 - 1e-9
    assert np.all(motion.s_m + 4.5 <= host_mps * TIMES + 1e-9)


@pytest.mark.parametrize(("who", "rate_mps2"), [("front", -4.0), ("behind", 3.0)])
def test_nobody_is_relied_on_in_an_emergency(who: str, rate_mps2: float) -> None:
    """Where somebody ahead brakes hard, and of whoever accelerates."""
    situation = queue(3.0, 6.0, 12.0)
    seen = tuple(
        replace(track, acceleration_s_mps2=rate_mps2 if track.id == who else 0.0, acceleration_s_sd_mps2=0.3) for track in situation.tracks
    )
    assert predicted_to_brake(predict_for(situation)) == ("behind",)
    assert predicted_to_brake(predict_for(replace(situation, tracks=seen))) == ()


@pytest.mark.parametrize(
    ("heading_rad", "steering_rad", "relied"), [(0.0, 0.0, True), (0.12, 0.0, False), (-0.12, 0.0, False), (-0.12, 0.24, True)]
)
def test_nobody_is_relied_on_by_a_host_that_steers_out(heading_rad: float, steering_rad: float, relied: bool) -> None:
    """In a bend it is turned by its sideslip, and steers out as little as on a straight."""
    situation = queue(3.0, 6.0, 12.0)
    host = replace(situation.host, heading_rad=heading_rad, steering_rad=steering_rad)
    assert predicted_to_brake(predict_for(replace(situation, host=host))) == (("behind",) if relied else ())


def test_a_queue_that_slows_down_is_followed_in_the_lane_and_the_plan_says_on_whom_it_counts() -> None:
    plan = Planner().plan(queue(2.0, 6.0, 11.0))
    assert plan.status is Status.PLANNED
    assert plan.side is Side.NONE
    assert plan.safe_end is not None
    assert plan.safe_end.safe
    assert "behind behind in slow traffic is expected to brake" in plan.reason


@pytest.mark.parametrize(
    ("starts_m", "radius_m", "brakes"), [(15.0, 8.0, True), (-3.0, 8.0, True), (15.0, 40.0, False), (60.0, 8.0, False)]
)
def test_who_follows_before_a_tight_turn_brakes_for_it(starts_m: float, radius_m: float, brakes: bool) -> None:
    """Nobody is ahead: the turn is the reason, where it is tight and near."""
    situation = queue(3.0, 6.0, 12.0)
    ends_m = starts_m + 10.0
    bend = ((starts_m, 0.0), (starts_m + 2.0, 1.0 / radius_m), (ends_m, 1.0 / radius_m), (ends_m + 2.0, 0.0))
    road = replace(situation.road, curvature=bend)
    alone = replace(situation, road=road, tracks=situation.tracks[1:])
    assert predicted_to_brake(predict_for(alone)) == (("behind",) if brakes else ())


@pytest.mark.parametrize(("follower_mps", "behind_m", "brakes"), [(13.0, 45.0, True), (13.0, 20.0, False), (14.5, 60.0, False)])
def test_who_follows_towards_a_tight_turn_may_be_faster_than_a_queue(follower_mps: float, behind_m: float, brakes: bool) -> None:
    """He brakes for the turn himself; not who would have to brake hard, nor where the road goes straight on behind somebody slow."""
    turn = Road(lane_width_m=3.0, lanes_left=1, curvature=((10.0, 0.0), (12.0, 0.12), (22.0, 0.12), (24.0, 0.0)))
    situation = queue(3.0, follower_mps, behind_m)
    assert predicted_to_brake(predict_for(situation)) == ()
    assert predicted_to_brake(predict_for(replace(situation, road=turn, tracks=situation.tracks[1:]))) == (("behind",) if brakes else ())


def test_who_brakes_before_a_turn_is_not_too_fast_for_it() -> None:
    """Nor does he go straight on there; whoever is not relied on may."""
    turn = Road(lane_width_m=3.0, lanes_left=1, curvature=((10.0, 0.0), (12.0, 0.12), (22.0, 0.12), (24.0, 0.0)))
    situation = replace(queue(3.0, 6.5, 12.0), road=turn)
    known = tuple(replace(track, heading_rad=0.0) for track in situation.tracks[1:])
    relied = predict_for(replace(situation, tracks=known))
    assert [body.id for body in relied.bodies] == ["behind"]
    assert predicted_to_brake(relied) == ("behind",)
    fast = tuple(replace(track, speed_s_mps=9.5) for track in known)
    assert [body.id for body in predict_for(replace(situation, tracks=fast)).bodies] == [Variant.STRAIGHT_ON.of("behind"), "behind"]


def test_without_a_queue_nothing_changes() -> None:
    situation = queue(3.0, 6.0, 12.0)
    alone = replace(situation, tracks=situation.tracks[1:])
    assert predict_for(alone) == predict(alone.tracks, None, alone.road, alone.host.s_m)


TWO_WAY = Road(lane_width_m=3.0, lanes_left=1, lanes=(Lane(lane=1, oncoming=True),))


@pytest.mark.parametrize(
    ("lanes", "right", "beside"),
    [
        ((Lane(lane=1, oncoming=True),), 0, True),
        ((Lane(lane=1, oncoming=True, shoulder=True),), 0, True),
        ((Lane(lane=1, shoulder=True),), 0, False),
        ((), 0, False),
        ((Lane(lane=1, oncoming=True),), 1, False),
        ((Lane(lane=1, oncoming=True), Lane(lane=-1, width_m=((0.0, 0.4),), shoulder=True)), 1, True),
        ((Lane(lane=1, oncoming=True, width_m=((-50.0, 0.0), (20.0, 0.0), (22.0, 3.0))),), 0, False),
    ],
)
def test_a_lane_with_oncoming_traffic_beside_it_and_nothing_else(lanes: tuple[Lane, ...], right: int, beside: bool) -> None:
    """A lane of its own direction, a shoulder that a car can drive on, or no oncoming lane where the host is: not so."""
    road = Road(lane_width_m=3.0, lanes_left=1, lanes_right=right, lanes=lanes)
    assert is_beside_oncoming(replace(queue(3.0, 6.0, 12.0), road=road)) is beside


@pytest.mark.parametrize(
    ("follower_mps", "behind_m", "rate_mps2", "brakes"),
    [
        (11.0, 20.0, 0.0, True),
        (11.0, 20.0, -4.0, True),
        (13.5, 40.0, 0.0, True),
        (11.0, 20.0, 3.0, True),
        (11.0, 12.0, 0.0, True),
        (11.0, 12.0, 3.0, False),
        (11.0, 7.0, 0.0, False),
        (15.0, 60.0, 0.0, False),
    ],
)
def test_beside_a_lane_of_oncoming_traffic_who_follows_is_expected_to_brake(
    follower_mps: float, behind_m: float, rate_mps2: float, brakes: bool
) -> None:
    """Also where the front car brakes hard; not who accelerates too near, is too near or too fast. With a lane beside he is not."""
    situation = queue(5.0, follower_mps, behind_m, 10.0)
    rates = {"front": -4.5, "behind": rate_mps2}
    seen = tuple(replace(track, acceleration_s_mps2=rates[track.id], acceleration_s_sd_mps2=0.3) for track in situation.tracks)
    assert predicted_to_brake(predict_for(replace(situation, tracks=seen))) == ()
    assert predicted_to_brake(predict_for(replace(situation, tracks=seen, road=TWO_WAY))) == (("behind",) if brakes else ())


@settings(max_examples=100, deadline=None)
@given(follower_mps=st.floats(0.0, 20.0), behind_m=st.floats(4.6, 60.0), host_mps=st.floats(0.0, 20.0))
def test_whoever_is_relied_on_beside_oncoming_traffic_stays_behind_a_host_that_goes_on(
    follower_mps: float, behind_m: float, host_mps: float
) -> None:
    prediction = predict_for(replace(queue(3.0, follower_mps, behind_m, host_mps), road=TWO_WAY))
    if not predicted_to_brake(prediction):
        return
    assert follower_mps <= TOWARDS_A_TURN_MPS
    (body,) = (one for one in prediction.bodies if one.id == "behind")
    motion = body.at(TIMES)
    assert np.all(motion.speed_s_mps[TIMES <= RESPONSE_S] == follower_mps)
    assert np.diff(motion.speed_s_mps).min() >= -ATTENTIVE_MPS2 * 0.1 - 1e-9
    assert np.all(motion.s_m + 4.5 <= host_mps * TIMES + 1e-9)


@pytest.mark.parametrize(
    ("follower_mps", "behind_m", "rate_mps2", "brakes"),
    [(9.5, 9.0, 0.0, False), (9.5, 9.0, -2.5, True), (9.5, 6.0, -2.5, False), (16.0, 30.0, -3.0, True), (9.5, 9.0, -0.5, False)],
)
def test_who_is_seen_to_brake_hard_enough_is_expected_to_go_on(
    follower_mps: float, behind_m: float, rate_mps2: float, brakes: bool
) -> None:
    """However near or fast he is: he brakes by what is seen, at once."""
    situation = queue(3.0, follower_mps, behind_m)
    seen = tuple(
        replace(track, acceleration_s_mps2=rate_mps2 if track.id == "behind" else 0.0, acceleration_s_sd_mps2=0.25)
        for track in situation.tracks
    )
    prediction = predict_for(replace(situation, tracks=seen))
    assert predicted_to_brake(prediction) == (("behind",) if brakes else ())
    unsure = tuple(replace(track, acceleration_s_sd_mps2=0.8) for track in seen)
    assert predicted_to_brake(predict_for(replace(situation, tracks=unsure))) == ()
    if brakes:
        (body,) = (one for one in prediction.bodies if one.id == "behind")
        np.testing.assert_allclose(body.at(TIMES).speed_s_mps, np.maximum(follower_mps + rate_mps2 * TIMES, 0.0))


def test_a_queue_that_stops_is_not_left_into_oncoming_traffic() -> None:
    """The front car brakes by 4.5 m/s^2 to a standstill, somebody follows at 1.5 s: the host stops in its lane."""
    front = replace(car("front", 22.0, 0.0, 4.9), acceleration_s_mps2=-4.5, acceleration_s_sd_mps2=0.25)
    behind = replace(car("behind", -20.8, 0.0, 10.6), acceleration_s_mps2=0.0, acceleration_s_sd_mps2=0.25)
    situation = Situation(
        host=HostState(speed_mps=9.7, acceleration_mps2=-1.0),
        road=TWO_WAY,
        tracks=(front, behind),
        desired_speed_mps=10.3,
        coverage=Coverage(),
    )
    plan = Planner().plan(situation)
    assert plan.status is Status.PLANNED
    assert plan.side is Side.NONE
    assert plan.safe_end is not None
    assert plan.safe_end.safe


@pytest.mark.parametrize(
    ("s_m", "front_mps", "host_mps", "foreseen"),
    [(-20.0, 3.0, 4.0, False), (-20.0, 3.0, 14.0, True), (-20.0, 14.0, 4.0, True), (-2.0, 3.0, 4.0, True)],
)
def test_nobody_behind_is_expected_to_change_into_a_queue(s_m: float, front_mps: float, host_mps: float, foreseen: bool) -> None:
    """Who is beside or ahead may, and whoever changes behind a host that is in no queue."""
    changes = replace(car("beside", s_m, -2.5, 12.0), speed_d_mps=0.8)
    situation = replace(queue(front_mps, 3.0, 40.0, host_mps), road=Road(lane_width_m=3.0, lanes_left=1, lanes_right=1))
    seen = replace(situation, tracks=(*situation.tracks, changes))
    assert (Variant.CHANGING.of("beside") in {body.id for body in predict_for(seen).bodies}) is foreseen
    farther = replace(situation, road=Road(lane_width_m=3.0, lanes_right=2), tracks=(*situation.tracks, replace(changes, d_m=-5.5)))
    assert Variant.CHANGING.of("beside") in {body.id for body in predict_for(farther).bodies}  # into the lane beside
