"""Ordinary driving with somebody behind: who keeps his distance is expected to brake, and nobody else is troubled for his sake."""

from __future__ import annotations

from dataclasses import replace
from itertools import product

import numpy as np
import pytest

from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.lane import Lane
from mcdas_opt.domain.plan import Plan
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.situation import Situation
from mcdas_opt.domain.track import Coverage, Track
from mcdas_opt.domain.vocabulary import Alert, Mode, Side, Status
from mcdas_opt.planning.cycle import Cycle
from mcdas_opt.planning.lanes.manoeuvre import Manoeuvre
from mcdas_opt.planning.memory import Memory
from mcdas_opt.planning.planner import Planner
from mcdas_opt.planning.proposals.expected_followers import expected_followers, open_sides
from mcdas_opt.planning.proposals.keep_lane import BRAKE_BEHIND, brake_behind
from mcdas_opt.planning.proposals.lane_change import go_on_unpressed
from mcdas_opt.reference.offset_path import corrected

SPEEDS_MPS, BRAKING_MPS2, FOLLOWING_S = (20.0, 27.0, 33.0), (3.0, 4.0), (1.5, 2.5)
CASES = list(product(SPEEDS_MPS, BRAKING_MPS2, FOLLOWING_S))


def behind_who_brakes(speed_mps: float, braking_mps2: float, following_s: float, *, ahead_s: float = 1.5) -> Situation:
    """A leader that brakes, a follower a little faster than the host, and somebody coming up on the left."""
    lengths = 4.5
    known = {"acceleration_s_sd_mps2": 0.5}
    return Situation(
        host=HostState(speed_mps=speed_mps),
        desired_speed_mps=speed_mps,
        road=Road(lanes_left=1, speed_limit_mps=36.0),
        coverage=Coverage(),
        tracks=(
            Track(
                id="leader",
                s_m=lengths + ahead_s * speed_mps,
                d_m=0.0,
                speed_s_mps=speed_mps - 1.0,
                acceleration_s_mps2=-braking_mps2,
                **known,
            ),
            Track(id="follower", s_m=-lengths - 2.0 - following_s * speed_mps, d_m=0.0, speed_s_mps=1.03 * speed_mps, **known),
            Track(id="fast", s_m=-20.0, d_m=3.7, speed_s_mps=speed_mps + 7.0, **known),
        ),
    )


def planned(situation: Situation) -> Plan:
    return Planner().plan(situation)


@pytest.mark.parametrize(("speed", "braking", "following"), CASES)
def test_who_follows_at_his_distance_is_left_to_brake(speed: float, braking: float, following: float) -> None:
    situation = behind_who_brakes(speed, braking, following)
    assert Cycle.of(situation, Planner().vehicle).attentive_follower == "follower"
    plan = planned(situation)
    assert (plan.status, plan.side) == (Status.PLANNED, Side.NONE)
    assert plan.safe_end is not None
    assert plan.safe_end.safe
    assert plan.safe_end.relies_on in (None, "follower")
    assert ("expected to brake" in plan.reason) == (plan.safe_end.relies_on is not None)


def test_some_of_them_rely_on_him() -> None:
    ends = [planned(behind_who_brakes(*case)).safe_end for case in CASES]
    assert any(end is not None and end.relies_on == "follower" for end in ends)


@pytest.mark.parametrize("speed", SPEEDS_MPS)
def test_a_tailgater_is_relied_on_for_nothing_where_a_lane_is_open(speed: float) -> None:
    situation = behind_who_brakes(speed, 4.0, 0.5)
    situation = replace(situation, tracks=situation.tracks[:2])
    cycle = Cycle.of(situation, Planner().vehicle)
    assert (cycle.attentive_follower, expected_followers(cycle), open_sides(cycle)) == (None, (), {Side.LEFT})
    end = planned(situation).safe_end
    assert end is None or end.relies_on is None


@pytest.mark.parametrize(("speed", "following"), list(product(SPEEDS_MPS, (0.4, 0.6, 0.9))))
def test_a_tailgater_sends_nobody_out_between_others(speed: float, following: float) -> None:
    """The gap behind a host that keeps its lane is his to keep: where no lane beside is open, nobody there makes it good."""
    situation = behind_who_brakes(speed, 4.0, following, ahead_s=2.5)
    beside = tuple(Track(id=f"beside-{s}", s_m=s, d_m=3.7, speed_s_mps=speed - 3.0) for s in (-30.0, 25.0))
    situation = replace(situation, tracks=(*situation.tracks[:2], *beside))
    assert "follower" in expected_followers(Cycle.of(situation, Planner().vehicle))
    plan = planned(situation)
    assert (plan.status, plan.side) == (Status.PLANNED, Side.NONE)
    assert plan.safe_end is not None
    assert plan.safe_end.safe


def test_braking_behind_takes_a_little_more_than_it_needs() -> None:
    for speed, braking in product(SPEEDS_MPS, BRAKING_MPS2):
        situation = behind_who_brakes(speed, braking, 2.5)
        cycle = Cycle.of(situation, Planner().vehicle)
        proposed = brake_behind(cycle)
        assert proposed is not None
        assert proposed.name == BRAKE_BEHIND
        room_m = 1.5 * speed - 2.0
        needed = speed**2 / (2.0 * (room_m + (speed - 1.0) ** 2 / (2.0 * braking)))
        times = cycle.settings.grid.times_s
        rate = (proposed.speeds_mps[0] - proposed.speeds_mps[5]) / times[5]
        assert needed < rate < 1.3 * max(needed, 2.0)
    assert brake_behind(Cycle.of(Situation(host=HostState(speed_mps=20.0), coverage=Coverage()), Planner().vehicle)) is None


@pytest.mark.parametrize("speed", SPEEDS_MPS)
def test_whoever_comes_in_braking_is_braked_for_and_nobody_steers_out(speed: float) -> None:
    known = {"acceleration_s_sd_mps2": 0.8, "age_s": 5.0, "covariance": np.zeros((4, 4))}
    comes = Track(
        id="comes", s_m=2.8 * speed, d_m=-3.0, speed_s_mps=0.85 * speed, speed_d_mps=0.95, acceleration_s_mps2=-6.0, **known
    )  # fmt: skip
    ahead = Track(id="ahead", s_m=1.5 * speed, d_m=0.0, speed_s_mps=1.02 * speed, **known)
    beside = tuple(Track(id=f"beside-{s}", s_m=s, d_m=3.7, speed_s_mps=speed - 1.0, **known) for s in (-30.0, 11.0, 40.0))
    road = Road(lanes_left=1, lanes_right=1, speed_limit_mps=36.0)
    situation = Situation(
        host=HostState(speed_mps=speed), desired_speed_mps=speed, road=road, tracks=(ahead, comes, *beside), coverage=Coverage()
    )
    cycle = Cycle.of(situation, Planner().vehicle)
    proposed, without = brake_behind(cycle), brake_behind(Cycle.of(replace(situation, tracks=(ahead, *beside)), Planner().vehicle))
    assert proposed is not None
    assert without is not None
    assert proposed.speeds_mps[-1] < without.speeds_mps[-1] - 1.0
    plan = planned(situation)
    assert (plan.status, plan.side) == (Status.PLANNED, Side.NONE)


@pytest.mark.parametrize("speed", SPEEDS_MPS)
def test_who_steers_out_does_not_slow_down_for_whom_it_steers_out_for(speed: float) -> None:
    situation = behind_who_brakes(speed, 4.0, 2.5)
    cycle = Cycle.of(replace(situation, tracks=situation.tracks[:2]), Planner().vehicle)
    path = corrected(start_s_m=0.0, start_d_m=0.0, target_d_m=3.7, speed_mps=speed, lateral_acceleration_mps2=3.0)
    out = Manoeuvre(side=Side.LEFT, path=path, target_d_m=3.7, speed_mps=speed)
    slowest = {mode: go_on_unpressed(cycle, replace(out, mode=mode)).speeds_mps.min() for mode in (Mode.EVADE, Mode.CRUISE)}
    assert slowest[Mode.EVADE] >= speed - 1e-9
    assert slowest[Mode.CRUISE] < speed - 1.0  # who changes lanes for nothing that presses still follows


def before_a_lanes_end(following_s: float, end_m: float = 320.0) -> Situation:
    """A host at 31 m/s whose lane ends, beside a queue at 22 m/s, with somebody behind who is faster than it."""
    queue = tuple(Track(id=f"queue-{k}", s_m=-60.0 + 30.0 * k, d_m=-3.7, speed_s_mps=22.0) for k in range(6))
    return Situation(
        host=HostState(speed_mps=31.0),
        desired_speed_mps=33.0,
        road=Road(lanes=(Lane(lane=0, closed_m=((end_m, 5000.0),)),), lanes_right=1, speed_limit_mps=36.0),
        coverage=Coverage(),
        tracks=(Track(id="follower", s_m=-4.5 - 2.0 - following_s * 34.0, d_m=0.0, speed_s_mps=34.0), *queue),
    )


@pytest.mark.parametrize("following", [0.85, 1.0, 1.3])
def test_who_follows_into_a_lanes_end_has_to_brake_for_it_too(following: float) -> None:
    """So the host slows down for the queue beside it in time, and does not wait for the end to force it out."""
    situation = before_a_lanes_end(following)
    assert Cycle.of(situation, Planner().vehicle).attentive_follower == "follower"
    planner = Planner()
    planner.plan(replace(before_a_lanes_end(2.0, end_m=4000.0), time_s=-0.1))  # one that keeps its lane already
    plan = planner.plan(situation)
    assert (plan.status, plan.side, plan.chosen) == (Status.PLANNED, Side.NONE, "keep")
    assert plan.trajectory.speed_mps[-1] < 27.0


def test_a_tailgater_is_not_even_there() -> None:
    assert Cycle.of(before_a_lanes_end(0.6), Planner().vehicle).attentive_follower is None
    assert Cycle.of(before_a_lanes_end(1.0, end_m=4000.0), Planner().vehicle).attentive_follower is None


def steers_out(d_m: float, beside: Track, *, speed_mps: float = 28.0, mode: Mode = Mode.EVADE) -> tuple[Situation, Memory]:
    """A host that steers out to the left, so far out of the middle of its lane by now, with somebody in the next."""
    path = corrected(
        start_s_m=-15.0, start_d_m=0.0, target_d_m=3.7, speed_mps=speed_mps, lateral_acceleration_mps2=2.0, b=50.0
    )  # fmt: skip
    active = Manoeuvre(side=Side.LEFT, path=path, target_d_m=3.7, speed_mps=speed_mps, mode=mode)
    road = Road(lanes_left=1, speed_limit_mps=36.0)
    before = Situation(host=HostState(speed_mps=speed_mps), road=road, coverage=Coverage())
    now = Situation(
        time_s=0.1,
        host=HostState(d_m=d_m, heading_rad=0.03, speed_mps=speed_mps),
        tracks=(beside,),
        road=road,
        desired_speed_mps=speed_mps,
        coverage=Coverage(),
    )
    return now, Memory(situation=before, active=active, chosen="left")


@pytest.mark.parametrize("s_m", [-8.0, -4.0, 0.0, 4.0, 8.0])
@pytest.mark.parametrize("faster_mps", [-2.0, 0.0, 2.0])
def test_steering_out_of_what_threatens_no_more_is_given_up_for_who_is_beside(s_m: float, faster_mps: float) -> None:
    beside = Track(id="beside", s_m=s_m, d_m=3.7, speed_s_mps=28.0 + faster_mps)
    for d_m, given_up in ((0.0, True), (0.8, True), (1.4, False), (2.4, False), (3.5, False)):
        situation, memory = steers_out(d_m, beside)
        cycle = Cycle.of(situation, Planner().vehicle, memory=memory)
        assert cycle.is_withdrawn is given_up
        assert cycle.is_ordinary or not given_up
    far = replace(beside, s_m=60.0)
    situation, memory = steers_out(0.8, far)
    assert not Cycle.of(situation, Planner().vehicle, memory=memory).is_withdrawn


@pytest.mark.parametrize("mode", [Mode.EVADE, Mode.CRUISE])
def test_who_is_in_both_lanes_goes_on_and_a_follower_there_is_expected_to_brake(mode: Mode) -> None:
    """Not so who is in one lane still: he may stay there."""
    follower = Track(id="follower", s_m=-25.0, d_m=3.7, speed_s_mps=30.0, acceleration_s_sd_mps2=0.5)
    for d_m, relies in ((0.4, False), (1.7, True)):
        situation, memory = steers_out(d_m, follower, mode=mode)
        cycle = Cycle.of(situation, Planner().vehicle, memory=memory)
        assert cycle.active is not None
        assert go_on_unpressed(cycle, cycle.active).relies_on_followers is relies


def in_a_queue(road: Road, follower_mps: float, behind_m: float, *lanes: int, host_mps: float = 0.0, queue_mps: float = 0.0) -> Plan:
    """The host stands, or rolls, 3 m and 1.5 s behind somebody who does; in these lanes others do, too."""
    standing = {f"{lane} {k}": (7.0 * k - 8.0, road.lane_width_m * lane) for lane in lanes for k in range(4)}
    tracks = [
        Track(id=name, s_m=s_m, d_m=d_m, speed_s_mps=queue_mps)
        for name, (s_m, d_m) in {"leader": (7.5 + 1.5 * queue_mps, 0.0), **standing}.items()
    ]
    tracks.append(Track(id="follower", s_m=-4.5 - behind_m, d_m=0.0, speed_s_mps=follower_mps))
    return planned(
        Situation(host=HostState(speed_mps=host_mps), road=road, coverage=Coverage(), desired_speed_mps=13.9, tracks=tuple(tracks))
    )


@pytest.mark.parametrize("beside", ["nothing", "oncoming", "standing"])
@pytest.mark.parametrize("follower_mps", [8.0, 13.9, 16.5])
def test_who_comes_up_to_a_queue_that_the_host_is_held_in_is_expected_to_stop(follower_mps: float, beside: str) -> None:
    """Until he needs more than 4 m/s^2, or more than 3 and does not brake: then the driver is warned."""
    road = Road(lanes_left=int(beside != "nothing"), lanes=(Lane(lane=1, oncoming=True),) if beside == "oncoming" else ())
    lanes = [1] if beside == "standing" else []
    for behind_s in (5.0, 3.0, 2.1):
        plan = in_a_queue(road, follower_mps, max(behind_s * follower_mps, follower_mps**2 / 5.9), *lanes)
        assert plan.status is Status.PLANNED
        assert "follower keeps its distance behind and is expected to brake" in plan.reason or behind_s == 5.0  # too far to matter
        assert plan.trajectory.states[-1, 0] < 1.5
    late = in_a_queue(road, follower_mps, 1.2 * follower_mps, *lanes)
    assert "is expected to brake" not in late.reason
    assert late.status is Status.UNAVOIDABLE
    assert late.alert is not Alert.NONE


BESIDE_A_WAY_OUT = [Road(lanes_left=1), Road(lanes_right=1), Road(shoulder_right_m=2.5)]


@pytest.mark.parametrize("road", BESIDE_A_WAY_OUT)
def test_where_there_is_a_way_out_and_the_host_drives_he_is_not(road: Road) -> None:
    assert "is expected to brake" not in in_a_queue(road, 16.5, 50.0, host_mps=4.0, queue_mps=4.0).reason


@pytest.mark.parametrize("road", BESIDE_A_WAY_OUT)
@pytest.mark.parametrize(("follower_mps", "behind_m"), [(13.3, 40.0), (13.9, 60.0), (16.5, 50.0)])
@pytest.mark.parametrize("host_mps", [0.0, 0.5, 1.0, 2.0, 2.9])
def test_a_host_that_stands_or_rolls_in_a_queue_stays_there(road: Road, follower_mps: float, behind_m: float, host_mps: float) -> None:
    # it steered out, or drove into the car ahead at 6 m/s, for a follower who needs no more than 2.8 m/s^2
    plan = in_a_queue(road, follower_mps, behind_m, host_mps=host_mps, queue_mps=host_mps)
    assert (plan.status, plan.side) == (Status.PLANNED, Side.NONE)
    assert "follower keeps its distance behind and is expected to brake" in plan.reason
    assert plan.trajectory.states[-1, 0] < 4.0 * host_mps + 1.5


@pytest.mark.parametrize(("behind_m", "speed_mps"), [(5.6, 1.4), (5.6, 1.8), (8.0, 2.5), (8.0, 3.5), (15.0, 6.0)])
@pytest.mark.parametrize("acceleration_mps2", [2.0, 3.0, 4.0])
def test_in_a_queue_that_starts_up_who_is_behind_does_not_accelerate_into_the_host(
    behind_m: float, speed_mps: float, acceleration_mps2: float
) -> None:
    # who started from 5.6 m behind at 4 m/s^2 was predicted to go on so for a second, and nothing passed
    tracks = [Track(id=f"{k} {d_m}", s_m=7.5 * k, d_m=d_m, speed_s_mps=0.0) for k in range(-2, 3) for d_m in (0.0, 3.7) if k > 0 or d_m]
    follower = Track(
        id="follower",
        s_m=-4.5 - behind_m,
        d_m=0.0,
        speed_s_mps=speed_mps,
        acceleration_s_mps2=acceleration_mps2,
        acceleration_s_sd_mps2=0.8,
    )
    plan = planned(Situation(host=HostState(), road=Road(lanes_left=1), coverage=Coverage(), tracks=(*tracks, follower)))
    assert plan.status is Status.PLANNED
    assert plan.trajectory.states[-1, 0] < 1.5


@pytest.mark.parametrize("host_mps", [0.7, 1.2, 1.8, 2.5])
@pytest.mark.parametrize(("follower_mps", "behind_s"), [(9.0, 3.0), (12.0, 4.5), (15.0, 3.0), (22.0, 4.0), (30.0, 4.5)])
def test_from_a_queue_that_rolls_it_steers_out_in_time_for_who_never_brakes(host_mps: float, follower_mps: float, behind_s: float) -> None:
    planner, road, host = Planner(), Road(lanes_left=1), HostState(speed_mps=host_mps)
    leader_m, follower_m = 9.0 + 1.5 * host_mps, -4.5 - behind_s * (follower_mps - host_mps)
    for k in range(100):
        t = 0.1 * k
        tracks = (
            Track(id="leader", s_m=leader_m + host_mps * t, d_m=0.0, speed_s_mps=host_mps),
            Track(id="follower", s_m=follower_m + follower_mps * t, d_m=0.0, speed_s_mps=follower_mps),
        )
        plan = planner.plan(
            Situation(time_s=t, host=host, road=road, coverage=Coverage(), tracks=tracks, desired_speed_mps=max(host_mps, 1.0))
        )
        host = HostState.from_vector(plan.trajectory.states[1])
        beside = abs(host.d_m) > 1.85
        assert beside or all(abs(one.s_m + 0.1 * one.speed_s_mps - host.s_m) > 4.5 for one in tracks)
    assert beside


@pytest.mark.parametrize(
    ("width_m", "is_held"),
    [(((6.0, 3.7), (12.0, 0.0)), True), (((27.0, 3.7), (33.0, 0.0)), True), (((60.0, 3.7), (66.0, 0.0)), False)],
)
def test_who_comes_up_to_a_host_that_stands_where_its_lane_ends_is_expected_to_stop(
    width_m: tuple[tuple[float, float], ...], is_held: bool
) -> None:
    """A column passes on the lane that leads on: there is nowhere to go, and nobody stands ahead."""
    road = Road(lanes_left=1, lanes=(Lane(lane=0, width_m=width_m, merges=Side.LEFT),))
    tracks = [Track(id=f"{k}", s_m=8.0 * k, d_m=3.7, speed_s_mps=12.0) for k in range(-9, 5)]
    tracks.append(Track(id="follower", s_m=-50.0, d_m=0.0, speed_s_mps=13.9))
    plan = planned(Situation(host=HostState(), road=road, coverage=Coverage(), desired_speed_mps=13.9, tracks=tuple(tracks)))
    assert ("follower keeps its distance behind and is expected to brake" in plan.reason) is is_held
    assert plan.status is Status.PLANNED or not is_held


@pytest.mark.parametrize(
    ("follower_mps", "behind_m", "is_expected"),
    [(20.0, 65.0, True), (20.0, 55.0, False), (25.0, 90.0, True), (33.0, 150.0, True), (33.0, 120.0, False)],
)
def test_who_comes_up_to_a_queue_is_expected_to_stop_while_he_can_however_fast_he_is(
    follower_mps: float, behind_m: float, is_expected: bool
) -> None:
    plan = in_a_queue(Road(lanes_left=1), follower_mps, behind_m)
    assert ("is expected to brake" in plan.reason) is is_expected
    assert not is_expected or (plan.status, plan.side) == (Status.PLANNED, Side.NONE)


@pytest.mark.parametrize("host_mps", [4.0, 5.5, 7.0, 8.5])
@pytest.mark.parametrize("follower_mps", [10.0, 13.9, 18.0])
def test_who_is_behind_a_host_that_comes_up_to_a_queue_is_left_to_brake(host_mps: float, follower_mps: float) -> None:
    """Two lanes stand ahead, 1.5 m/s^2 away; who is behind brakes as he needs to, once that is 2.8. The host braked by up to 8 m/s^2."""
    planner, host, strongest = Planner(), HostState(speed_mps=host_mps), 0.0
    follower_m, speed_mps, rate = -4.5 - 3.0 * follower_mps, follower_mps, 0.0
    queue_m = 4.5 + 2.5 + host_mps**2 / 3.0
    queue = [Track(id=f"{d_m} {k}", s_m=queue_m + 7.5 * k, d_m=d_m, speed_s_mps=0.0) for d_m in (0.0, 3.7) for k in range(3)]
    for k in range(80):
        known = {"acceleration_s_mps2": -rate, "acceleration_s_sd_mps2": 0.3}
        tracks = (*queue, Track(id="follower", s_m=follower_m, d_m=0.0, speed_s_mps=speed_mps, **known))
        given = {"road": Road(lanes_left=1), "coverage": Coverage(), "desired_speed_mps": host_mps}
        plan = planner.plan(Situation(time_s=0.1 * k, host=host, tracks=tracks, **given))
        assert plan.status is Status.PLANNED
        at = plan.trajectory
        host = HostState.from_vector(np.array([np.interp(0.1, at.t_s, row) for row in at.states.T]))
        strongest = min(strongest, host.acceleration_mps2)
        needed = speed_mps**2 / (2.0 * max(host.s_m - follower_m - 6.0, 0.1))
        rate = needed if rate or needed >= 2.8 else 0.0
        slower = max(speed_mps - 0.1 * rate, 0.0)
        follower_m, speed_mps = follower_m + 0.05 * (speed_mps + slower), slower
        assert abs(host.d_m) < 0.5
    assert strongest > -5.0


@pytest.mark.parametrize("host_mps", [0.0, 0.5, 1.5, 3.0])
@pytest.mark.parametrize(("fast_mps", "behind_m"), [(22.0, 83.0), (22.0, 60.0), (13.9, 20.0)])
def test_a_host_that_moves_off_cares_for_nobody_who_has_somebody_between_to_brake_for(
    host_mps: float, fast_mps: float, behind_m: float
) -> None:
    """Somebody stands behind the host, and a fast one comes up to him. The host drove off at 4.9 m/s^2, or had no plan."""
    between = Track(id="between", s_m=-7.8, d_m=0.0, speed_s_mps=0.0)
    fast = Track(id="fast", s_m=-12.3 - behind_m, d_m=0.0, speed_s_mps=fast_mps)
    given = {"host": HostState(speed_mps=host_mps), "coverage": Coverage(), "desired_speed_mps": 13.9}
    alone, plan = (planned(Situation(tracks=tracks, **given)) for tracks in ((between,), (between, fast)))
    assert (plan.status, plan.alert, plan.side) == (Status.PLANNED, Alert.NONE, Side.NONE)
    assert np.array_equal(plan.trajectory.states, alone.trajectory.states)
