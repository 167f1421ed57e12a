"""Followers in slow traffic: predicted to brake gently, as long as that is enough for them, and nobody in an emergency."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.situation import Coverage, Situation
from mcdas_opt.domain.vocabulary import Side, Status
from mcdas_opt.planning.planner import Planner
from mcdas_opt.tracking.prediction import predict, predict_for
from mcdas_opt.tracking.slow_traffic import BRAKING_MPS2, RESPONSE_S, SLOW_MPS, STRAIGHT_ON, relied_on
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
    assert relied_on(predict_for(queue(front_mps, follower_mps, behind_m))) == (("behind",) if brakes else ())


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
    if not relied_on(prediction):
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
    assert relied_on(predict_for(situation)) == ("behind",)
    assert relied_on(predict_for(replace(situation, tracks=seen))) == ()


@pytest.mark.parametrize(
    ("heading_rad", "steering_rad", "relied"), [(0.0, 0.0, True), (0.12, 0.0, False), (-0.12, 0.0, False), (-0.12, 0.24, True)]
)
def test_nobody_is_relied_on_by_a_host_that_steers_out(heading_rad: float, steering_rad: float, relied: bool) -> None:
    """In a bend it is turned by its sideslip, and steers out as little as on a straight."""
    situation = queue(3.0, 6.0, 12.0)
    host = replace(situation.host, heading_rad=heading_rad, steering_rad=steering_rad)
    assert relied_on(predict_for(replace(situation, host=host))) == (("behind",) if relied else ())


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
    assert relied_on(predict_for(alone)) == (("behind",) if brakes else ())


@pytest.mark.parametrize(("follower_mps", "behind_m", "brakes"), [(13.0, 45.0, True), (13.0, 20.0, False), (14.5, 60.0, False)])
def test_who_follows_towards_a_tight_turn_may_be_faster_than_a_queue(follower_mps: float, behind_m: float, brakes: bool) -> None:
    """He brakes for the turn himself; not who would have to brake hard, nor where the road goes straight on behind somebody slow."""
    turn = Road(lane_width_m=3.0, lanes_left=1, curvature=((10.0, 0.0), (12.0, 0.12), (22.0, 0.12), (24.0, 0.0)))
    situation = queue(3.0, follower_mps, behind_m)
    assert relied_on(predict_for(situation)) == ()
    assert relied_on(predict_for(replace(situation, road=turn, tracks=situation.tracks[1:]))) == (("behind",) if brakes else ())


def test_who_brakes_before_a_turn_is_not_too_fast_for_it() -> None:
    """Nor does he go straight on there; whoever is not relied on may."""
    turn = Road(lane_width_m=3.0, lanes_left=1, curvature=((10.0, 0.0), (12.0, 0.12), (22.0, 0.12), (24.0, 0.0)))
    situation = replace(queue(3.0, 6.5, 12.0), road=turn)
    known = tuple(replace(track, heading_rad=0.0) for track in situation.tracks[1:])
    relied = predict_for(replace(situation, tracks=known))
    assert [body.id for body in relied.bodies] == ["behind"]
    assert relied_on(relied) == ("behind",)
    fast = tuple(replace(track, speed_s_mps=9.5) for track in known)
    assert [body.id for body in predict_for(replace(situation, tracks=fast)).bodies] == [f"behind {STRAIGHT_ON}", "behind"]


def test_without_a_queue_nothing_changes() -> None:
    situation = queue(3.0, 6.0, 12.0)
    alone = replace(situation, tracks=situation.tracks[1:])
    assert predict_for(alone) == predict(alone.tracks, None, alone.road, alone.host.s_m)
