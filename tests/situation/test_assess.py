"""Situations: roles, gaps, open sides, memory and symmetry."""

from __future__ import annotations

import dataclasses
import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mcdas_opt.domain.assessment import Assessment
from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.settings import SelectorSettings
from mcdas_opt.domain.situation import Situation
from mcdas_opt.domain.track import Coverage, Track
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.domain.vocabulary import Mode, Request, Role, Sector, Side
from mcdas_opt.situation.assess import assess

SETTINGS = SelectorSettings()
ROAD = Road(lanes_left=1, lanes_right=1)
VEHICLE = Vehicle()


def sandwich(front_d: float = 0.0, **changes: object) -> Situation:
    front = Track(id="front", s_m=29.5, d_m=front_d, speed_s_mps=11.1)
    rear = Track(id="rear", s_m=-29.5, d_m=0.0, speed_s_mps=16.7)
    return Situation(**{"host": HostState(speed_mps=11.1), "road": ROAD, "tracks": (front, rear), "coverage": Coverage(), **changes})


def judge(situation: Situation, previous: Assessment | None = None) -> Assessment:
    return assess(situation, VEHICLE, SETTINGS, previous)


def test_the_sandwich_of_the_paper() -> None:
    a = judge(sandwich())
    assert (a.front_id, a.rear_id) == ("front", "rear")
    assert a.roles == {"front": Role.FRONT, "rear": Role.REAR}
    assert a.front_gap_m == pytest.approx(25.0)
    assert a.rear_gap_m == pytest.approx(25.0)
    assert a.ttc_front_s == math.inf
    assert a.ttc_rear_s == pytest.approx(25.0 / 5.6)
    assert a.threats == {Sector.REAR}
    assert (a.mode, a.side, a.warning) == (Mode.EVADE, Side.LEFT, True)
    assert a.literal_mode is None
    assert a.occupied == {Sector.FRONT, Sector.REAR}


@pytest.mark.parametrize(("front_d", "side"), [(2.0, Side.RIGHT), (-2.0, Side.LEFT), (0.05, Side.LEFT)])
def test_the_evasion_goes_where_it_has_less_to_move(front_d: float, side: Side) -> None:
    a = judge(sandwich(front_d))
    assert a.offset_m == front_d
    assert a.side is side


def test_tie_break_is_a_setting() -> None:
    a = assess(sandwich(), VEHICLE, dataclasses.replace(SETTINGS, tie_break=Side.RIGHT))
    assert a.side is Side.RIGHT


tracks = st.lists(
    st.builds(
        Track,
        id=st.just("?"),
        s_m=st.floats(-80, 80),
        d_m=st.floats(-7, 7),
        speed_s_mps=st.floats(0, 35),
        speed_d_mps=st.floats(-1, 1),
        length_m=st.floats(3, 12),
        width_m=st.floats(1.5, 2.5),
    ),
    max_size=6,
).map(lambda found: tuple(dataclasses.replace(t, id=f"t{i}") for i, t in enumerate(found)))
situations = st.builds(
    Situation,
    host=st.builds(HostState, d_m=st.floats(-5, 5), speed_mps=st.floats(0, 35)),
    road=st.builds(Road, lanes_left=st.integers(0, 2), lanes_right=st.integers(0, 2)),
    tracks=tracks,
    coverage=st.builds(Coverage, front=st.booleans(), rear=st.booleans(), left=st.booleans(), right=st.booleans()),
    desired_speed_mps=st.floats(0, 35),
    request=st.sampled_from(Request),
)


@given(situations)
@settings(max_examples=150, deadline=None)
def test_mirrored_situation_mirrored_assessment(situation: Situation) -> None:
    road, seen, host = situation.road, situation.coverage, situation.host
    mirrored = dataclasses.replace(
        situation,
        host=dataclasses.replace(host, d_m=-host.d_m),
        road=dataclasses.replace(road, lanes_left=road.lanes_right, lanes_right=road.lanes_left),
        tracks=tuple(dataclasses.replace(t, d_m=-t.d_m, speed_d_mps=-t.speed_d_mps) for t in situation.tracks),
        coverage=dataclasses.replace(seen, left=seen.right, right=seen.left),
    )
    a = judge(situation)
    b = assess(mirrored, VEHICLE, dataclasses.replace(SETTINGS, tie_break=Side.RIGHT))
    swap = {"left": "right", "right": "left"}
    assert {k: swap.get(v.value, v.value) for k, v in a.roles.items()} == {k: v.value for k, v in b.roles.items()}
    assert {swap.get(s.value, s.value) for s in a.occupied} == {s.value for s in b.occupied}
    assert swap.get(a.side.value, a.side.value) == b.side.value
    for name in ("mode", "warning", "threats", "front_id", "rear_id", "ttc_front_s", "ttc_rear_s", "literal_mode"):
        assert getattr(a, name) == getattr(b, name)
    assert a.offset_m == -b.offset_m


@given(situations)
@settings(max_examples=150, deadline=None)
def test_every_situation_is_assessed_without_contradiction(situation: Situation) -> None:
    a = judge(situation)
    assert set(a.roles) == {t.id for t in situation.tracks}
    assert sum(r is Role.FRONT for r in a.roles.values()) == (a.front_id is not None)
    assert sum(r is Role.REAR for r in a.roles.values()) == (a.rear_id is not None)
    assert (a.side is Side.NONE) == (a.mode is not Mode.EVADE)
    if a.side is not Side.NONE:
        assert Sector(a.side.value) not in a.occupied
        assert situation.road.has_lane(a.lane + (1 if a.side is Side.LEFT else -1), situation.host.s_m)
    assert not a.threats or a.warning
    for sector in Sector:
        if not situation.coverage.sees(sector):
            assert sector in a.occupied
    assert a.reason


def test_translation_along_the_road_changes_nothing() -> None:
    there = sandwich(
        host=HostState(s_m=640.0, speed_mps=11.1),
        tracks=tuple(dataclasses.replace(t, s_m=t.s_m + 640.0) for t in sandwich().tracks),
    )
    assert judge(there) == judge(sandwich())


def test_uncovered_sides_are_occupied() -> None:
    a = judge(sandwich(coverage=Coverage(left=False, right=False)))
    assert {Sector.LEFT, Sector.RIGHT} <= a.occupied
    assert a.side is Side.NONE
    assert a.mode is Mode.ACCELERATE  # closes up behind the front vehicle


def test_blind_situation_holds_and_the_literal_table_would_reverse() -> None:
    a = judge(Situation(host=HostState(speed_mps=20.0), road=ROAD, coverage=Coverage(front=False, rear=False, left=False, right=False)))
    assert a.mode is Mode.HOLD
    assert a.literal_mode == "CCM (Reverse direction)"


def test_a_car_alongside_blocks_its_side_only() -> None:
    beside = Track(id="beside", s_m=1.0, d_m=3.7, speed_s_mps=11.1)
    a = judge(sandwich(tracks=(*sandwich().tracks, beside)))
    assert a.roles["beside"] is Role.LEFT
    assert Sector.LEFT in a.occupied
    assert a.side is Side.RIGHT


def test_a_car_about_to_come_alongside_blocks_its_side() -> None:
    fast = Track(id="fast", s_m=-20.0, d_m=3.7, speed_s_mps=30.0)
    slow = dataclasses.replace(fast, speed_s_mps=12.0)
    assert Sector.LEFT in judge(sandwich(tracks=(*sandwich().tracks, fast))).occupied
    assert Sector.LEFT not in judge(sandwich(tracks=(*sandwich().tracks, slow))).occupied


@pytest.mark.parametrize(
    ("d", "role"), [(0.0, Role.FRONT), (2.0, Role.FRONT), (2.4, Role.FRONT), (2.6, Role.LEFT), (3.7, Role.LEFT), (7.4, Role.OTHER)]
)
def test_role_by_how_far_the_body_reaches_into_the_lane(d: float, role: Role) -> None:
    road = Road(lanes_left=2, lanes_right=2)
    a = judge(
        Situation(
            host=HostState(speed_mps=20.0), road=road, tracks=(Track(id="x", s_m=30.0, d_m=d, speed_s_mps=20.0),), coverage=Coverage()
        )
    )
    assert a.roles["x"] is role


def test_only_the_nearest_is_front() -> None:
    near, far = Track(id="near", s_m=30.0, d_m=0.0, speed_s_mps=11.0), Track(id="far", s_m=50.0, d_m=0.0, speed_s_mps=1.0)
    a = judge(Situation(host=HostState(speed_mps=11.0), road=ROAD, tracks=(far, near), coverage=Coverage()))
    assert a.roles == {"near": Role.FRONT, "far": Role.OTHER}


def test_an_evasion_keeps_its_lane_and_side_until_it_arrives() -> None:
    """The host moves left through the lane marking with the rear car still behind it: the side stays, and ends with the threat."""
    a = judge(sandwich())
    sides, d, t = [], 0.0, 0.0
    while d < 3.7:
        t, d = t + 0.1, d + 0.12
        s = 11.1 * t
        host = HostState(s_m=s, d_m=d, speed_mps=11.1)
        rear = Track(id="rear", s_m=-29.5 + 16.7 * t, d_m=0.0, speed_s_mps=16.7)
        front = Track(id="front", s_m=29.5 + 11.1 * t, d_m=0.0, speed_s_mps=11.1)
        a = judge(sandwich(host=host, tracks=(front, rear), time_s=t), a)
        if a.mode is Mode.EVADE:
            sides.append((a.side, a.lane))
    assert set(sides) == {(Side.LEFT, 0)}
    assert a.mode is Mode.HOLD
    assert a.lane == 1
    assert not a.threats


def test_mode_age_is_kept() -> None:
    first = judge(sandwich(time_s=3.0))
    again = judge(sandwich(time_s=3.1), first)
    assert (first.since_s, again.since_s) == (3.0, 3.0)


def test_the_end_of_the_road_is_a_wall() -> None:
    road = dataclasses.replace(ROAD, road_end_s_m=60.0)
    a = judge(Situation(host=HostState(speed_mps=20.0), road=road, coverage=Coverage()))
    assert a.front_id is None
    assert a.front_gap_m == pytest.approx(60.0 - 2.25)
    assert a.mode is Mode.BRAKE
    assert {Sector.LEFT, Sector.RIGHT, Sector.FRONT} <= a.occupied


def test_park_on_request_at_standstill() -> None:
    standing = Situation(host=HostState(speed_mps=0.0), road=ROAD, request=Request.PARK, coverage=Coverage())
    assert judge(standing).mode is Mode.PARK
    assert judge(dataclasses.replace(standing, host=HostState(speed_mps=3.0))).mode is not Mode.PARK
    assert judge(dataclasses.replace(standing, request=Request.DRIVE)).mode is Mode.HOLD
