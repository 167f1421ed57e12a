"""Lanes are changed as people do it who have time: announced, slowly, past on the one side and back to the other, pressing nobody."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.manners import MannersSettings
from mcdas_opt.domain.plan import Plan
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.settings import SelectorSettings, Settings, WarningSettings
from mcdas_opt.domain.situation import Situation
from mcdas_opt.domain.track import Coverage, Track
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.domain.vocabulary import Mode, Side, Status
from mcdas_opt.errors import ParameterError
from mcdas_opt.planning.cycle import Cycle
from mcdas_opt.planning.lanes.lane_choice import LaneChoice, lane_choice
from mcdas_opt.planning.planner import Planner
from tests.planning.test_comfort import SLACK, beyond

QUIET = Settings(warning=WarningSettings(escapes=False))
MANNERS = MannersSettings()
CAR = Vehicle()
LANE_M = 3.7
OTHER = {Side.LEFT: Side.RIGHT, Side.RIGHT: Side.LEFT, Side.NONE: Side.NONE}


def settled(settings: Settings, drives_on: Side) -> Settings:
    """The same in traffic that keeps to that side, in which ties go to the inside."""
    manners = replace(settings.manners, drives_on=drives_on)
    return replace(settings, manners=manners, selector=SelectorSettings(tie_break=manners.inside))


@dataclass
class Drive:
    """Everybody else holds speed and lane, `cars` being (s, d, speed); d to the inside is positive."""

    cars: list[tuple[float, float, float]]
    speed_mps: float
    wanted_mps: float
    seconds: float
    settings: Settings = QUIET
    drives_on: Side = Side.RIGHT
    inner: int = 1
    outer: int = 0
    hosts: list[HostState] = field(default_factory=list)
    plans: list[Plan] = field(default_factory=list)

    def __post_init__(self) -> None:
        planner = Planner(settings=settled(self.settings, self.drives_on))
        sign = 1.0 if self.drives_on is Side.RIGHT else -1.0
        left, right = (self.inner, self.outer) if sign > 0.0 else (self.outer, self.inner)
        road, host = Road(lanes_left=left, lanes_right=right, speed_limit_mps=60.0), HostState(speed_mps=self.speed_mps)
        for k in range(round(self.seconds / 0.1)):
            t = round(0.1 * k, 1)
            seen = tuple(Track(id=f"{i}", s_m=s + v * t, d_m=sign * d, speed_s_mps=v) for i, (s, d, v) in enumerate(self.cars))
            plan = planner.plan(
                Situation(time_s=t, host=host, tracks=seen, road=road, desired_speed_mps=self.wanted_mps, coverage=Coverage())
            )
            host = HostState.from_vector(plan.trajectory.states[int(np.searchsorted(plan.trajectory.t_s, 0.1 - 1e-9))])
            self.hosts.append(host)
            self.plans.append(plan)

    @property
    def d_m(self) -> np.ndarray:
        return np.array([host.d_m for host in self.hosts])


@pytest.fixture(scope="module")
def overtaking() -> Drive:
    return Drive(cars=[(70.0, 0.0, 22.0)], speed_mps=28.0, wanted_mps=32.0, seconds=27.0)


def test_who_is_slower_is_overtaken_on_the_inside_and_the_outer_lane_is_gone_back_to(overtaking: Drive) -> None:
    assert overtaking.d_m.max() == pytest.approx(LANE_M, abs=0.15)
    assert overtaking.d_m[-1] == pytest.approx(0.0, abs=0.3)
    assert {plan.status for plan in overtaking.plans} == {Status.PLANNED}
    assert {plan.mode for plan in overtaking.plans} <= {Mode.HOLD, Mode.CRUISE}
    assert beyond(overtaking.hosts) <= 1.0 + SLACK


def test_a_lane_change_is_announced_and_takes_its_time(overtaking: Drive) -> None:
    indicated = [plan.indicator for plan in overtaking.plans]
    steered = [plan.side for plan in overtaking.plans]
    for side in (Side.LEFT, Side.RIGHT):
        announced, begun = indicated.index(side), steered.index(side)
        assert MANNERS.announced_s - 1e-6 <= 0.1 * (begun - announced) <= MANNERS.announced_s + 0.2
        assert all(one is side for one in indicated[announced : begun + 1])
    out = overtaking.d_m[: indicated.index(Side.RIGHT)]
    assert 3.5 <= 0.1 * (int(np.argmax(out > LANE_M - 0.15)) - int(np.argmax(out > 0.1))) <= 6.0
    assert indicated[-1] is Side.NONE


def test_left_hand_traffic_is_the_mirror_image_to_the_bit(overtaking: Drive) -> None:
    image = Drive(cars=overtaking.cars, speed_mps=28.0, wanted_mps=32.0, seconds=12.0, drives_on=Side.LEFT)
    n = len(image.hosts)
    assert np.array_equal(image.d_m, -overtaking.d_m[:n])
    assert [host.speed_mps for host in image.hosts] == [host.speed_mps for host in overtaking.hosts[:n]]
    assert [plan.indicator for plan in image.plans] == [OTHER[plan.indicator] for plan in overtaking.plans[:n]]


@pytest.mark.parametrize("passes_inside", [True, False])
def test_nobody_is_passed_on_the_wrong_side_unless_a_setting_says_so(passes_inside: bool) -> None:
    settings = replace(QUIET, manners=replace(MANNERS, passes_inside=passes_inside, changes_lanes=False))
    drive = Drive(cars=[(40.0, LANE_M, 24.0)], speed_mps=28.0, wanted_mps=32.0, seconds=12.0, settings=settings)
    passed = drive.hosts[-1].s_m > 40.0 + 24.0 * 12.0
    assert passed is not passes_inside


def test_in_a_queue_either_side_passes() -> None:
    drive = Drive(cars=[(25.0, LANE_M, 8.0)], speed_mps=14.0, wanted_mps=14.0, seconds=7.0)
    assert drive.hosts[-1].s_m > 25.0 + 8.0 * 7.0


cars = st.lists(
    st.tuples(st.floats(-150.0, 150.0), st.sampled_from([-LANE_M, 0.0, LANE_M]), st.floats(5.0, 45.0), st.floats(3.0, 16.0)), max_size=5
)


@given(
    cars=cars,
    speed=st.floats(3.0, 40.0),
    faster=st.floats(0.0, 10.0),
    passes_inside=st.booleans(),
    lanes=st.tuples(st.booleans(), st.booleans()),
)
def test_a_lane_that_is_wanted_has_room_and_presses_nobody(
    cars: list[tuple[float, float, float, float]], speed: float, faster: float, passes_inside: bool, lanes: tuple[bool, bool]
) -> None:
    settings = replace(QUIET, manners=replace(MANNERS, passes_inside=passes_inside))
    tracks = tuple(Track(id=f"{i}", s_m=s, d_m=d, speed_s_mps=v, length_m=length) for i, (s, d, v, length) in enumerate(cars))
    road = Road(lanes_left=int(lanes[0]), lanes_right=int(lanes[1]), speed_limit_mps=60.0)
    situation = Situation(host=HostState(speed_mps=speed), tracks=tracks, road=road, desired_speed_mps=speed + faster, coverage=Coverage())
    choice = lane_choice(situation, CAR, settings)
    turned = replace(
        situation,
        tracks=tuple(replace(track, d_m=-track.d_m) for track in tracks),
        road=replace(road, lanes_left=road.lanes_right, lanes_right=road.lanes_left),
    )
    assert lane_choice(turned, CAR, settled(settings, Side.LEFT)).side is OTHER[choice.side]
    if choice.side is Side.NONE:
        return
    assert lanes[0 if choice.side is Side.LEFT else 1]
    centre = LANE_M if choice.side is Side.LEFT else -LANE_M
    for track in tracks:
        if track.d_m != centre:
            continue
        gap = abs(track.s_m) - 0.5 * (track.length_m + CAR.length_m)
        behind = track.s_m <= 0.0
        assert gap >= settings.headway.standstill_m + settings.headway.time_gap_s * (track.speed_s_mps if behind else speed) - 1e-9
        if behind and track.speed_s_mps > speed:
            closing = track.speed_s_mps - speed
            assert closing**2 / (2.0 * (gap - closing)) <= MANNERS.follower_braking_mps2


def test_a_side_that_nobody_watches_is_not_wanted() -> None:
    slow = Track(id="slow", s_m=40.0, d_m=0.0, speed_s_mps=15.0)
    road = Road(lanes_left=1, speed_limit_mps=60.0)
    situation = Situation(host=HostState(speed_mps=25.0), tracks=(slow,), road=road, coverage=Coverage())
    assert lane_choice(situation, CAR, QUIET).side is Side.LEFT
    for sector in ("left", "front", "rear"):
        blind = replace(situation, coverage=replace(Coverage(), **{sector: False}))
        assert lane_choice(blind, CAR, QUIET).side is Side.NONE


@pytest.mark.parametrize("kappa", [0.004, -0.004])
def test_lanes_are_not_changed_in_a_bend_nor_before_one(kappa: float) -> None:
    slow = Track(id="slow", s_m=40.0, d_m=0.0, speed_s_mps=15.0)
    for way_m, side in ((-50.0, Side.NONE), (100.0, Side.NONE), (400.0, Side.LEFT)):
        road = Road(lanes_left=1, speed_limit_mps=60.0, curvature=((way_m, 0.0), (way_m + 20.0, kappa), (way_m + 200.0, kappa)))
        situation = Situation(host=HostState(speed_mps=25.0), tracks=(slow,), road=road, coverage=Coverage())
        assert lane_choice(situation, CAR, QUIET).side is side


@pytest.mark.parametrize(("keeps_outer_lane", "d_m"), [(False, 0.0), (True, -LANE_M)])
def test_a_lane_that_one_began_in_is_left_for_a_free_one_outside_only_where_a_setting_says_so(keeps_outer_lane: bool, d_m: float) -> None:
    settings = replace(QUIET, manners=replace(MANNERS, keeps_outer_lane=keeps_outer_lane))
    drive = Drive(cars=[(55.0, 0.0, 25.0)], speed_mps=25.0, wanted_mps=25.0, seconds=12.0, settings=settings, outer=1)
    assert drive.d_m[-1] == pytest.approx(d_m, abs=0.3)


def test_a_wish_that_ends_for_a_moment_begins_anew() -> None:
    slow = Track(id="slow", s_m=40.0, d_m=0.0, speed_s_mps=15.0)
    situation = Situation(
        host=HostState(speed_mps=25.0), tracks=(slow,), road=Road(lanes_left=1, speed_limit_mps=60.0), coverage=Coverage()
    )
    wish = LaneChoice()
    for _ in range(15):
        wish = lane_choice(situation, CAR, QUIET, wish, 0.1)
        assert not wish.is_due
    assert lane_choice(situation, CAR, QUIET, wish, 0.1).is_due
    nothing = lane_choice(replace(situation, tracks=()), CAR, QUIET, wish, 0.1)
    assert not lane_choice(situation, CAR, QUIET, nothing, 0.1).is_due


@pytest.mark.parametrize("slower_mps", [2.1, 2.15])
def test_a_wish_does_not_come_and_go_with_the_noise_of_a_speed(slower_mps: float) -> None:
    """A leader who is as much slower as it takes, give or take: the lane is wanted once, and then is due."""
    wish, wanted, r = LaneChoice(), [], np.random.default_rng(3)
    for _ in range(100):
        seen = Track(id="slow", s_m=40.0, d_m=0.0, speed_s_mps=25.0 - slower_mps + 0.1 * float(r.normal()))
        situation = Situation(
            host=HostState(speed_mps=25.0), tracks=(seen,), road=Road(lanes_left=1, speed_limit_mps=60.0), coverage=Coverage()
        )
        wish = lane_choice(situation, CAR, QUIET, wish, 0.1)
        wanted.append(wish.side)
    assert sum(a is not b for a, b in pairwise(wanted)) <= 1
    assert wish.is_due


def test_who_would_have_to_brake_hard_costs_a_lane_change_that_is_not_needed() -> None:
    road = Road(lanes_left=1, lanes_right=1, speed_limit_mps=60.0)
    front = Track(id="front", s_m=60.0, d_m=0.0, speed_s_mps=10.0)
    fast = Track(id="fast", s_m=-30.0, d_m=LANE_M, speed_s_mps=33.0)
    cycle = Cycle.of(Situation(host=HostState(speed_mps=22.0), tracks=(front, fast), road=road, coverage=Coverage()), CAR, QUIET)
    assert cycle.inconsiderate_sides == {Side.LEFT}


@pytest.mark.parametrize("value", [0.0, -1.0, math.nan])
@pytest.mark.parametrize("name", ["changing_s", "follower_braking_mps2", "advantage_mps"])
def test_what_is_no_manners_is_refused_by_name(name: str, value: float) -> None:
    with pytest.raises(ParameterError, match=name):
        MannersSettings(**{name: value})


@pytest.mark.parametrize(
    ("name", "value"), [("drives_on", "none"), ("drives_on", "up"), ("changes_lanes", 1.5), ("keeps_outer_lane", "yes")]
)
def test_so_is_what_is_no_side_and_no_truth(name: str, value: object) -> None:
    with pytest.raises(ParameterError, match=name):
        MannersSettings(**{name: value})
