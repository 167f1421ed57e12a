"""Who stands at the side of the lane is passed within it where there is room, people beside it with as much as there is; nobody else."""

from __future__ import annotations

from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from mcdas_opt.catalogue.vehicles import load_vehicle
from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.situation import Coverage, Situation
from mcdas_opt.domain.track import Track
from mcdas_opt.domain.vocabulary import BodyKind
from mcdas_opt.situation.passed_in_lane import passed_in_lane

CAR = load_vehicle("sedan")
HALF_M = 0.5 * 3.5
SPEED_MPS = 12.0


def standing(d_m: float, s_m: float = 50.0, **more: float | BodyKind) -> Track:
    return Track(**{"id": f"at {s_m:g}", "s_m": s_m, "d_m": d_m, "speed_s_mps": 0.0, **more})


def situation(*tracks: Track, speed_mps: float = SPEED_MPS) -> Situation:
    host, road = HostState(speed_mps=speed_mps), Road(lane_width_m=2.0 * HALF_M)
    return Situation(host=host, tracks=tracks, road=road, coverage=Coverage())


@given(
    st.lists(
        st.tuples(st.floats(-4.0, 4.0), st.floats(5.0, 90.0), st.floats(0.5, 2.5), st.floats(-1.0, 1.0)),
        max_size=4,
    )
)
def test_the_host_has_room_at_both_sides(bodies: list[tuple[float, float, float, float]]) -> None:
    """Whoever is passed stands beyond the border, and there are 0.5 m between the bodies; the host is within its lane."""
    tracks = [Track(id=str(i), s_m=s, d_m=d, speed_s_mps=speed, width_m=width) for i, (d, s, width, speed) in enumerate(bodies)]
    found = passed_in_lane(situation(*tracks), CAR)
    assert abs(found.goal_m) + 0.5 * CAR.width_m < HALF_M
    for one in found.bodies:
        away_m = abs(one.track.d_m - found.goal_m) - 0.5 * (CAR.width_m + one.track.width_m)
        assert away_m == pytest.approx(one.gap_m)
        assert one.gap_m >= 0.5 - 1e-9
        assert abs(one.track.d_m) + 0.5 * one.track.width_m >= HALF_M
        assert abs(one.track.speed_s_mps) <= 0.4
    nearer = [one.track.s_m for one in found.bodies]
    assert nearer == sorted(nearer)


@given(st.floats(-3.0, 3.0), st.floats(-3.0, 3.0))
def test_the_mirrored_lane_has_the_mirrored_offset(one: float, other: float) -> None:
    here = passed_in_lane(situation(standing(one), standing(other, 65.0)), CAR)
    there = passed_in_lane(situation(standing(-one), standing(-other, 65.0)), CAR)
    assert there.goal_m == -here.goal_m
    assert there.ids == here.ids


@pytest.mark.parametrize(
    "track",
    [
        standing(-0.6),  # wholly within the lane, as in a queue
        standing(-1.9, speed_s_mps=1.0),
        standing(-1.9, speed_d_mps=1.0),
        standing(-1.3),  # leaves too little
        standing(-1.9, kind=BodyKind.PEDESTRIAN, speed_d_mps=0.7),  # on his way into the lane
        standing(-1.9, kind=BodyKind.MOTORCYCLE),
        standing(-3.0),  # not in the lane
        standing(-1.9, s_m=-5.0),  # passed already
        standing(-1.9, s_m=150.0),
    ],
)
def test_nobody_else_is_passed(track: Track) -> None:
    assert not passed_in_lane(situation(track), CAR).bodies
    assert passed_in_lane(situation(standing(-1.9)), CAR).bodies


def test_who_is_met_later_and_cannot_be_passed_with_the_others_is_left() -> None:
    narrow = passed_in_lane(situation(standing(-1.9), standing(1.9, 60.0)), CAR)
    assert narrow.ids == {"at 50"}
    assert narrow.goal_m > 0.0


def test_who_was_passed_is_passed_at_a_little_less_room() -> None:
    less = situation(standing(-1.9, s_m=40.0), standing(-1.46, s_m=42.0))
    before = replace(passed_in_lane(less, CAR), bodies=())
    assert "at 42" not in passed_in_lane(less, CAR, before).ids
    wider = passed_in_lane(situation(standing(-1.6, s_m=42.0)), CAR)
    assert "at 42" in passed_in_lane(situation(standing(-1.46, s_m=42.0)), CAR, wider).ids


def test_the_offset_changes_slowly() -> None:
    seen, nobody = situation(standing(-1.9)), situation()
    begun = passed_in_lane(seen, CAR, passed_in_lane(nobody, CAR), 0.1)
    assert 0.0 < begun.offset_m < 0.1 < begun.goal_m
    assert begun.moving_s > 1.0
    there = passed_in_lane(seen, CAR, begun, 10.0)
    assert there.offset_m == there.goal_m == begun.goal_m
    assert there.moving_s == 0.0
    gone = passed_in_lane(nobody, CAR, there, 0.1)
    assert not gone.bodies
    assert gone.goal_m == 0.0
    assert there.offset_m - 0.1 < gone.offset_m < there.offset_m


@pytest.mark.parametrize("d_m", [-0.3, 0.0, 0.3, 1.5])
def test_without_a_memory_it_begins_where_the_host_is(d_m: float) -> None:
    seen = situation(standing(-1.9))
    found = passed_in_lane(replace(seen, host=replace(seen.host, d_m=d_m)), CAR)
    assert 0.3 < found.goal_m < 1.5
    assert found.offset_m == min(max(d_m, 0.0), found.goal_m)


def test_the_narrower_the_slower() -> None:
    wide, narrow = (passed_in_lane(situation(standing(d_m)), CAR).bodies[0] for d_m in (-2.2, -1.6))
    assert narrow.gap_m < wide.gap_m
    assert narrow.most_mps < wide.most_mps


PEOPLE = st.lists(
    st.tuples(
        st.sampled_from([BodyKind.PEDESTRIAN, BodyKind.BICYCLE]),
        st.floats(-4.0, 4.0),
        st.floats(5.0, 90.0),
        st.floats(-5.0, 5.0),
        st.floats(-1.0, 1.0),
    ),
    max_size=4,
)


def people(rows: list[tuple[BodyKind, float, float, float, float]], side: float = 1.0) -> list[Track]:
    return [
        Track(id=str(i), kind=kind, s_m=s, d_m=side * d, speed_s_mps=along, speed_d_mps=side * across, width_m=0.6, length_m=1.0)
        for i, (kind, d, s, along, across) in enumerate(rows)
    ]


@given(PEOPLE)
def test_people_are_given_room_within_the_lane(rows: list[tuple[BodyKind, float, float, float, float]]) -> None:
    """Whoever reaches into the lane and is passed has 0.4 m at least, and nobody is passed fast with little room."""
    found = passed_in_lane(situation(*people(rows)), CAR)
    assert abs(found.goal_m) + 0.5 * CAR.width_m < HALF_M
    for one in found.bodies:
        assert one.gap_m == pytest.approx(abs(one.track.d_m - found.goal_m) - 0.5 * (CAR.width_m + one.track.width_m))
        assert one.gap_m >= 0.4 - 1e-9 or abs(one.track.d_m) - 0.5 * one.track.width_m > HALF_M - 0.2
        assert one.most_mps <= max(one.track.speed_s_mps, 0.0) + max(3.0, 7.0 * one.gap_m**2) + 1e-9
        assert abs(one.track.speed_d_mps) <= 0.4


@given(PEOPLE)
def test_people_mirrored_are_passed_mirrored(rows: list[tuple[BodyKind, float, float, float, float]]) -> None:
    here, there = (passed_in_lane(situation(*people(rows, side)), CAR) for side in (1.0, -1.0))
    assert there.goal_m == -here.goal_m
    assert [one.most_mps for one in there.bodies] == [one.most_mps for one in here.bodies]


def test_people_in_the_lane_are_passed_closely_only_where_there_is_no_other_way() -> None:
    near = standing(-1.3, kind=BodyKind.PEDESTRIAN, width_m=0.5)
    cyclist = standing(-1.3, kind=BodyKind.BICYCLE, width_m=0.6, speed_s_mps=4.0)
    alone = situation(near)
    assert passed_in_lane(alone, CAR).ids == {near.id}
    assert not passed_in_lane(replace(alone, road=replace(alone.road, lanes_left=1)), CAR).bodies  # it changes lanes
    assert not passed_in_lane(situation(cyclist), CAR).bodies  # is followed
    assert passed_in_lane(situation(replace(cyclist, speed_s_mps=-4.0)), CAR).bodies
