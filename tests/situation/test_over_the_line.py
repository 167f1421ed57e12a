"""Who leaves too little room within the lane is passed a little over the line where the lane beside is one of oncoming traffic and nobody
is in it until the host is back; else the host waits, with room to go round him."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from mcdas_opt.catalogue.vehicles import load_vehicle
from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.lane import Lane
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.situation import Coverage, Situation
from mcdas_opt.domain.track import Track
from mcdas_opt.domain.vocabulary import BodyKind
from mcdas_opt.situation.passed_in_lane import PassedInLane, passed_in_lane

CAR = load_vehicle("sedan")
HALF_M = 0.5 * 3.5
TWO_WAY = Road(lane_width_m=2.0 * HALF_M, lanes_left=1, lanes=(Lane(lane=1, oncoming=True),), shoulder_right_m=1.0, speed_limit_mps=14.0)
PARKED = Track(id="parked", s_m=35.0, d_m=-1.2, speed_s_mps=0.0)
CYCLIST = Track(id="cyclist", s_m=20.0, d_m=-1.1, speed_s_mps=4.0, kind=BodyKind.BICYCLE, length_m=1.8, width_m=0.6)
KINDS = st.sampled_from([PARKED, CYCLIST])


def coming(s_m: float, mps: float = 12.0, d_m: float = 2.0 * HALF_M, **more: float) -> Track:
    return Track(**{"id": f"coming {s_m:g}", "s_m": s_m, "d_m": d_m, "speed_s_mps": -mps, "heading_rad": math.pi, **more})


def situation(*tracks: Track, mps: float = 9.0, road: Road = TWO_WAY) -> Situation:
    return Situation(host=HostState(speed_mps=mps), desired_speed_mps=13.0, tracks=tracks, road=road, coverage=Coverage())


def is_passed(track: Track, *others: Track, before: PassedInLane | None = None, **more: float) -> bool:
    return track.id in passed_in_lane(situation(track, *others, **more), CAR, before).ids


@given(KINDS, st.floats(-2.1, -0.3), st.floats(0.0, 13.0))
def test_nobody_comes_and_the_middle_of_the_car_stays_in_its_lane(track: Track, d_m: float, mps: float) -> None:
    """However far in he is: where he is passed there is the room that is asked for, and the host is at most 0.7 m over the line."""
    found = passed_in_lane(situation(track.moved_to(track.s_m, d_m), mps=mps), CAR)
    assert found.goal_m + 0.5 * CAR.width_m <= HALF_M + 0.7 + 1e-9
    for one in found.bodies:
        assert one.gap_m >= (0.5 if one.stands else 1.0) - 1e-9


def test_who_leaves_too_little_within_the_lane_is_passed_over_the_line() -> None:
    for track in (PARKED, CYCLIST):
        found = passed_in_lane(situation(track), CAR)
        assert found.ids == {track.id}
        assert found.goal_m + 0.5 * CAR.width_m > HALF_M
        one_way = replace(TWO_WAY, lanes_left=0, lanes=())
        assert not passed_in_lane(situation(track, road=one_way), CAR).bodies
        two_lanes = replace(TWO_WAY, lanes=())  # of the host's direction: it changes lanes
        assert not passed_in_lane(situation(track, road=two_lanes), CAR).bodies
        unseen = replace(situation(track), coverage=Coverage(left=False))
        assert not passed_in_lane(unseen, CAR).bodies


@given(KINDS, st.floats(0.0, 13.0), st.floats(25.0, 300.0), st.floats(0.0, 20.0), st.floats(1.0, 200.0))
def test_who_comes_later_or_not_at_all_is_never_in_the_way(track: Track, mps: float, s_m: float, its_mps: float, later_m: float) -> None:
    alone, then, now = (is_passed(track, *some, mps=mps) for some in ((), (coming(s_m + later_m, its_mps),), (coming(s_m, its_mps),)))
    assert alone >= then >= now


@pytest.mark.parametrize(
    "other",
    [
        coming(75.0),
        coming(45.0, 0.0, d_m=3.0),  # stands in that lane, near the line
        Track(id="queue", s_m=47.0, d_m=0.0, speed_s_mps=0.0),
        Track(id="overtakes", s_m=-15.0, d_m=3.5, speed_s_mps=14.0),
        Track(id="beside", s_m=-3.0, d_m=3.0, speed_s_mps=0.0),
        Track(id="walks", s_m=47.0, d_m=5.0, speed_s_mps=0.0, speed_d_mps=-1.5, kind=BodyKind.PEDESTRIAN, width_m=0.5, length_m=0.5),
    ],
)
def test_who_is_in_the_way(other: Track) -> None:
    found = passed_in_lane(situation(PARKED, other), CAR)
    assert "parked" not in found.ids
    assert found.waits_s_m < PARKED.s_m - 0.5 * PARKED.length_m - 5.0


@given(KINDS, st.floats(0.0, 13.0), st.floats(25.0, 300.0), st.floats(0.0, 20.0))
def test_left_hand_traffic_is_the_mirror(track: Track, mps: float, s_m: float, its_mps: float) -> None:
    mirrored = replace(
        TWO_WAY, lanes_left=0, lanes_right=1, lanes=(Lane(lane=-1, oncoming=True),), shoulder_right_m=0.0, shoulder_left_m=1.0
    )
    car = coming(s_m, its_mps)
    here = passed_in_lane(situation(track, car, mps=mps), CAR)
    there = passed_in_lane(situation(*(one.moved_to(one.s_m, -one.d_m) for one in (track, car)), mps=mps, road=mirrored), CAR)
    assert (there.goal_m, there.waits_s_m, there.ids) == (-here.goal_m, here.waits_s_m, here.ids)


def test_once_beside_him_the_host_goes_on() -> None:
    """Who comes into sight then is met by driving on; before, the host lets him through."""
    begun = passed_in_lane(situation(PARKED), CAR)
    assert begun.ids == {"parked"}
    beside, before = (replace(PARKED, s_m=s_m) for s_m in (3.0, 25.0))
    assert is_passed(beside, coming(70.0, d_m=3.2), before=begun)
    assert not is_passed(before, coming(70.0, d_m=3.2), before=begun)


def test_what_was_begun_is_not_given_up_for_noise() -> None:
    """Between what is asked to begin and what is asked to go on lie 2 s and 0.4 m: nobody who comes flickers across that."""
    begun = passed_in_lane(situation(PARKED), CAR)
    limits = []
    for before in (None, begun):
        free = [s_m for s_m in range(60, 300) if is_passed(PARKED, coming(s_m), before=before)]
        limits.append(min(free))
    assert limits[0] > limits[1] + 2.0 * 12.0 * 0.9


def test_round_a_bend_it_is_not_begun_though_nobody_is_seen() -> None:
    """A radar that looks far ahead, and near beside, does not see who comes round it."""
    for side_of_bend in (1.0, -1.0):
        gentle, tight = (replace(TWO_WAY, curvature=((0.0, 0.0), (30.0, 0.0), (50.0, side_of_bend * kappa))) for kappa in (0.0005, 0.01))
        assert is_passed(PARKED, road=gentle)
        assert not is_passed(PARKED, road=tight)
