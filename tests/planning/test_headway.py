"""Ordinary driving: the time gap behind a steady leader, who owes what is short of it, and the speed limit."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mcdas_opt.domain.assessment import Assessment
from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.plan import Plan
from mcdas_opt.domain.prediction import BodyMotion
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.safe_end import EndKind, SafeEndSettings
from mcdas_opt.domain.settings import HeadwaySettings, Settings, WarningSettings
from mcdas_opt.domain.situation import Coverage, Situation
from mcdas_opt.domain.track import Track
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.domain.vocabulary import Status
from mcdas_opt.errors import ParameterError
from mcdas_opt.native.form import SWITCH
from mcdas_opt.planning.front.front_deficit import FrontDeficit, front_deficits
from mcdas_opt.planning.front.front_gap import OWED_S, CutIn, cut_in
from mcdas_opt.planning.front.headway import asked_time_gap_s, missing_headway
from mcdas_opt.planning.memory import Memory
from mcdas_opt.planning.planner import Planner
from mcdas_opt.planning.traffic.observed import Observed

CYCLE_S, LENGTH_M = 0.1, 4.5
HEADWAY = HeadwaySettings()
ROAD = Road(speed_limit_mps=60.0)


@pytest.fixture(scope="module")
def planner() -> Planner:
    return Planner(settings=Settings(warning=WarningSettings(escapes=False)))


def leader(s_m: float, speed_mps: float, acceleration_mps2: float = 0.0) -> Track:
    return Track(
        id="leader",
        s_m=s_m,
        d_m=0.0,
        speed_s_mps=speed_mps,
        covariance=np.zeros((4, 4)),
        length_m=LENGTH_M,
        acceleration_s_mps2=acceleration_mps2,
        acceleration_s_sd_mps2=0.3,
        age_s=9.0,
    )


class Follow:
    """A drive in which everybody does as planned, turn by turn: the gap [m] and the host after each, and the plans."""

    def __init__(self, planner: Planner, speed_mps: float, gap_m: float | None, wanted_mps: float, road: Road = ROAD) -> None:
        planner.reset()
        self.planner, self.wanted_mps, self.road = planner, wanted_mps, road
        self.host, self.time_s = HostState(speed_mps=speed_mps), 0.0
        self.lengths_m = 0.5 * (planner.vehicle.length_m + LENGTH_M)
        self.leader = None if gap_m is None else leader(gap_m + self.lengths_m, speed_mps)
        self.plans: list[Plan] = []
        self.gaps_m: list[float] = []
        self.hosts: list[HostState] = []

    def drive(self, seconds: float, braking_mps2: float = 0.0) -> Follow:
        for _ in range(round(seconds / CYCLE_S)):
            tracks = () if self.leader is None else (self.leader,)
            situation = Situation(
                time_s=round(self.time_s, 9),
                host=self.host,
                tracks=tracks,
                road=self.road,
                desired_speed_mps=self.wanted_mps,
                coverage=Coverage(),
            )
            plan = self.planner.plan(situation)
            self.host, self.time_s = HostState.from_vector(plan.trajectory.states[1]), self.time_s + CYCLE_S
            self.plans.append(plan)
            self.hosts.append(self.host)
            if self.leader is not None:
                speed = max(self.leader.speed_s_mps - braking_mps2 * CYCLE_S, 0.0)
                s_m = self.leader.s_m + 0.5 * (speed + self.leader.speed_s_mps) * CYCLE_S
                self.leader = leader(s_m, speed, -braking_mps2 if speed > 0.0 else 0.0)
                self.gaps_m.append(s_m - self.host.s_m - self.lengths_m)
        return self


@pytest.mark.parametrize("speed_mps", [5.0, 12.0, 20.0, 28.0, 36.0])
def test_following_settles_at_the_time_gap_and_survives_full_braking(planner: Planner, speed_mps: float) -> None:
    drive = Follow(planner, speed_mps, 2.0 * speed_mps, 1.3 * speed_mps).drive(15.0)
    asked_m = HEADWAY.standstill_m + HEADWAY.time_gap_s * speed_mps
    assert drive.gaps_m[-1] >= 0.9 * asked_m
    assert drive.gaps_m[-1] <= 1.2 * asked_m + 1.0
    assert min(drive.gaps_m) >= 0.9 * HEADWAY.time_gap_s * speed_mps
    assert {plan.status for plan in drive.plans} == {Status.PLANNED}
    drive.drive(speed_mps / 8.0 + 2.0, braking_mps2=8.0)
    assert min(drive.gaps_m) > 0.5


@pytest.mark.parametrize("speed_mps", [10.0, 25.0])
def test_a_gap_that_somebody_else_took_opens_gently(planner: Planner, speed_mps: float) -> None:
    drive = Follow(planner, speed_mps, 0.4 * speed_mps, 1.2 * speed_mps).drive(12.0)
    assert drive.gaps_m[-1] >= 0.9 * HEADWAY.time_gap_s * drive.hosts[-1].speed_mps
    assert min(host.acceleration_mps2 for host in drive.hosts) >= -2.3
    assert {plan.status for plan in drive.plans} == {Status.PLANNED}


@pytest.mark.parametrize(("speed_mps", "gap_m", "leader_mps", "braking_mps2"), [(31.0, 80.0, 20.0, 0.8), (25.0, 60.0, 15.0, 0.8)])
def test_who_comes_up_to_traffic_that_slows_down_keeps_its_distance(
    planner: Planner, speed_mps: float, gap_m: float, leader_mps: float, braking_mps2: float
) -> None:
    """A gap that shrinks by the host's own doing is not the next cycle's allowance."""
    drive = Follow(planner, speed_mps, gap_m, 33.0)
    drive.leader = leader(gap_m + drive.lengths_m, leader_mps, -braking_mps2)
    drive.drive(0.5 * leader_mps / braking_mps2, braking_mps2)
    headways = [gap / host.speed_mps for gap, host in zip(drive.gaps_m, drive.hosts, strict=True)]
    assert min(headways) > 0.8
    assert min(host.acceleration_mps2 for host in drive.hosts) > -3.5
    assert {plan.status for plan in drive.plans} == {Status.PLANNED}


def behind(gap_m: float, *, name: str = "leader", host_mps: float = 25.0) -> Assessment:
    return Assessment(front_id=name, front_gap_m=gap_m, front_speed_mps=host_mps)


def cut_in_of(now: Assessment, before: Assessment | None, known: CutIn | None = None, *, steers: bool = False) -> CutIn | None:
    return cut_in(now, before, known, CYCLE_S, asked_m=HEADWAY.standstill_m + HEADWAY.time_gap_s * 25.0, steers=steers)


@given(gap=st.floats(0.0, 31.0), other=st.floats(40.0, 150.0))
def test_a_gap_is_owed_by_who_comes_in_between_and_for_a_while(gap: float, other: float) -> None:
    near = behind(gap)
    assert cut_in_of(near, None) == CutIn(id="leader")  # whom a drive begins behind
    assert cut_in_of(near, behind(other, name="before")) == CutIn(id="leader")
    assert cut_in_of(near, Assessment()) == CutIn(id="leader")
    assert cut_in_of(near, behind(other, name="before"), steers=True) is None  # the host came to him
    assert cut_in_of(near, behind(gap)) is None  # he was there
    assert cut_in_of(near, behind(0.5 * gap, name="before")) is None  # somebody between them is gone
    assert cut_in_of(behind(other), Assessment()) is None  # he takes nothing
    known: CutIn | None = CutIn(id="leader")
    for _ in range(round(OWED_S / CYCLE_S) - 1):
        known = cut_in_of(near, near, known)
    assert known is not None
    assert cut_in_of(near, near, cut_in_of(near, near, known)) is None


def test_the_speed_limit_binds_ordinary_driving(planner: Planner) -> None:
    limited = replace(ROAD, speed_limit_mps=20.0)
    free = Follow(planner, 18.0, None, 33.0, limited).drive(4.0)
    assert max(host.speed_mps for host in free.hosts) <= 20.05
    assert all("speed limit" not in plan.reason for plan in free.plans)
    slower = Follow(planner, 26.0, None, 33.0, limited).drive(5.0)
    assert slower.hosts[-1].speed_mps <= 20.5
    assert min(host.acceleration_mps2 for host in slower.hosts) >= -2.5


def test_a_setting_says_by_how_much_the_limit_may_be_exceeded() -> None:
    lenient = Planner(settings=Settings(warning=WarningSettings(escapes=False), speed_limit_excess=0.1))
    drive = Follow(lenient, 20.0, None, 33.0, replace(ROAD, speed_limit_mps=20.0)).drive(5.0)
    assert drive.hosts[-1].speed_mps == pytest.approx(22.0, abs=0.1)


def test_escaping_from_behind_may_exceed_the_limit_and_says_so(planner: Planner) -> None:
    planner.reset()
    behind = replace(leader(-44.0, 30.0), id="rear")
    limited = replace(ROAD, speed_limit_mps=20.0)
    plan = planner.plan(
        Situation(host=HostState(speed_mps=20.0), tracks=(behind,), road=limited, desired_speed_mps=20.0, coverage=Coverage())
    )
    assert plan.status is Status.PLANNED
    assert float(plan.trajectory.speed_mps.max()) > 21.0
    assert "faster than the speed limit of 20 m/s, to escape from behind" in plan.reason


@given(found=st.floats(0.0, 3.0), speed=st.floats(0.0, 40.0))
def test_what_is_asked_for_is_what_is_there_and_then_opens(found: float, speed: float) -> None:
    t = np.linspace(0.0, 30.0, 301)
    asked = asked_time_gap_s(HEADWAY.standstill_m + found * max(speed, 1.0) + speed * t, np.full_like(t, speed), speed, t, HEADWAY)
    assert asked[0] == pytest.approx(min(found, HEADWAY.time_gap_s), abs=1e-9)
    assert asked[-1] == HEADWAY.time_gap_s
    assert float(np.diff(asked).max(initial=0.0)) <= HEADWAY.opening * 0.1 + 1e-9


@given(speed=st.floats(5.0, 40.0), closing=st.floats(0.0, 10.0), gap=st.floats(0.0, 100.0))
def test_gentle_braking_keeps_what_is_asked_for_at_first(speed: float, closing: float, gap: float) -> None:
    t, front = np.linspace(0.0, 4.0, 41), max(speed - closing, 0.0)
    braked = np.maximum(speed - 1.2 * t, front)
    gone = np.concatenate([[0.0], np.cumsum(0.05 * (braked[1:] + braked[:-1]))])
    asked = asked_time_gap_s(gap + front * t, np.full_like(t, front), speed, t, HEADWAY, closing_s=2.5)
    short = HEADWAY.standstill_m + asked * np.maximum(braked, 1.0) + 2.5 * (braked - front) - (gap + front * t - gone)
    opening = HEADWAY.opening * t * t / (t + 1.5) * np.maximum(braked, 1.0)
    assert float((short - opening)[asked > 0.1 * t].max(initial=-1.0)) < 1e-6


def deficits(host_mps: float, ahead: Track, before: tuple[FrontDeficit, ...] = (), elapsed_s: float = 0.1) -> tuple[FrontDeficit, ...]:
    situation = Situation(host=HostState(speed_mps=host_mps), tracks=(ahead,), road=ROAD, coverage=Coverage())
    return front_deficits(situation, Vehicle(), SafeEndSettings(), before, elapsed_s)


@given(speed=st.floats(5.0, 40.0), closer=st.floats(0.1, 5.0))
def test_a_deficit_of_ones_own_making_is_not_owed(speed: float, closer: float) -> None:
    (before,) = deficits(speed, leader(60.0, speed))
    (crept,) = deficits(speed, leader(4.6 + closer, speed), (before,))
    assert crept.owed_m == 0.0
    (new,) = deficits(speed, leader(4.6 + closer, speed))
    assert new.owed_m == min(new.margin_m, 0.0)


@given(speed=st.floats(10.0, 40.0), slower=st.floats(0.5, 8.0))
def test_what_the_front_car_takes_by_braking_is_owed_and_paid_back(speed: float, slower: float) -> None:
    (before,) = deficits(speed, leader(6.0, speed))
    (braked,) = deficits(speed, leader(6.0, speed - slower), (before,))
    assert braked.owed_m < before.owed_m
    later, owed = (braked,), braked.owed_m
    for _ in range(100):
        later = deficits(speed, leader(6.0, speed - slower), later)
        assert later[0].owed_m >= owed
        owed = later[0].owed_m
    assert owed >= 0.2 * braked.owed_m  # after 10 s


def test_held_is_never_said_of_a_deficit_of_ones_own_making(planner: Planner) -> None:
    planner.reset()
    ahead, host = leader(6.5, 25.0), HostState(speed_mps=25.0)
    own = FrontDeficit(id="leader", margin_m=0.0, owed_m=0.0, speed_mps=25.0, is_in_the_way=True)
    situation = Situation(time_s=1.0, host=host, tracks=(ahead,), road=ROAD, desired_speed_mps=33.3, coverage=Coverage())
    for deficits, allowed_m in (((own,), -0.1), ((), -4.3)):
        planner.memory = Memory(situation=replace(situation, time_s=0.9), observed=Observed(deficits=deficits))
        plan = planner.plan(situation)
        assert plan.safe_end is not None
        assert plan.safe_end.kind in (EndKind.HELD, EndKind.STOPPED)
        assert plan.safe_end.front_margin_m is not None
        assert plan.safe_end.kind is EndKind.STOPPED or plan.safe_end.front_margin_m >= allowed_m


@pytest.mark.parametrize("name", ["time_gap_s", "standstill_m", "opening", "braking_mps2", "pressed_s"])
@pytest.mark.parametrize("value", [0.0, -1.0])
def test_no_headway_is_refused_by_name_and_value(name: str, value: float) -> None:
    with pytest.raises(ParameterError, match=f"headway.{name}"):
        HeadwaySettings(**{name: value})


def test_the_speed_limit_binds_idm_mobil_too() -> None:
    limited = replace(ROAD, speed_limit_mps=20.0)
    drive = Follow(Planner(method="idm-mobil"), 18.0, None, 33.0, limited).drive(20.0)
    assert 19.0 <= max(host.speed_mps for host in drive.hosts) <= 20.05


@pytest.mark.parametrize(("friction", "braking_mps2", "hard"), [(0.31, 3.0, True), (0.31, 1.0, False), (0.9, 3.0, False)])
def test_who_follows_somebody_that_brakes_as_hard_as_the_road_allows_does_so_at_once(
    planner: Planner, friction: float, braking_mps2: float, hard: bool
) -> None:
    """At 39 m/s, 1.27 s behind: nobody comes near for 5 s, and gentle braking would be too little."""
    planner.reset()
    ahead = replace(leader(54.3, 37.9, -braking_mps2), acceleration_s_sd_mps2=1.19)
    road = replace(ROAD, friction=friction)
    plan = planner.plan(Situation(host=HostState(speed_mps=39.4), tracks=(ahead,), road=road, desired_speed_mps=45.0, coverage=Coverage()))
    assert plan.status is Status.PLANNED
    assert (float(plan.trajectory.acceleration_mps2[:15].min()) < -0.9 * friction * 9.81) is hard
    assert plan.reason.endswith("brakes about as hard as the road allows") is hard


@given(seed=st.integers(0, 2**32 - 1), others=st.integers(1, 6), drives=st.integers(1, 4), since=st.sampled_from([0.0, 1.7]))
def test_both_forms_ask_the_same_to_the_bit(seed: int, others: int, drives: int, since: float) -> None:
    rng, t = np.random.default_rng(seed), 0.1 * np.arange(41)
    speeds = rng.uniform(-3.0, 40.0, (others, 1)) + rng.normal(0.0, 1.0, (others, 1)) * t
    places = rng.uniform(-20.0, 60.0, (others, 1)) + np.cumsum(0.1 * speeds, axis=1)
    aside = rng.uniform(-4.0, 4.0, (others, 1)) + rng.normal(0.0, 0.5, (others, 1)) * t
    motion = BodyMotion(s_m=places, d_m=aside, heading_rad=np.zeros_like(aside), speed_s_mps=speeds, speed_d_mps=aside)
    host = HostState(speed_mps=float(rng.uniform(0.0, 40.0)), d_m=float(rng.uniform(-1.0, 1.0)))
    tables = rng.normal(0.0, 1.0, (drives, 9, t.size))
    tables[:, 0], tables[:, 1] = t, host.s_m + np.cumsum(0.1 * rng.uniform(0.0, 40.0, (drives, t.size)), axis=1)
    halves = rng.uniform(0.5, 3.0, (others, 2))

    def both() -> list[bytes]:
        gaps = asked_time_gap_s(places, speeds, host.speed_mps, t, HEADWAY, closing_s=0.5, since_s=since)
        one = asked_time_gap_s(places[0], speeds[0], host.speed_mps, t, HEADWAY)
        return [found.tobytes() for found in (gaps, one, missing_headway(tables, motion, halves, host, HEADWAY))]

    compiled = both()
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv(SWITCH, "0")
        assert both() == compiled
