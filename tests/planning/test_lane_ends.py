"""Lanes that end: left in good time, or the car stops before; laws over whole drives and plans."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mcdas_opt.catalogue.scenes import Scene, load_scene
from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.lane import Lane
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.settings import Settings
from mcdas_opt.domain.situation import Coverage, Situation
from mcdas_opt.domain.track import Track
from mcdas_opt.domain.vehicle import GRAVITY_MPS2, Vehicle
from mcdas_opt.domain.vocabulary import Alert, Mode, Side, Status
from mcdas_opt.dynamics.car_following import IdmSettings, Leader, idm_acceleration
from mcdas_opt.manoeuvres.kinds import next_lane_m
from mcdas_opt.planning.cycle import Cycle
from mcdas_opt.planning.lanes.best_gap import best_gap
from mcdas_opt.planning.lanes.gap import Gap
from mcdas_opt.planning.lanes.manoeuvre import Manoeuvre
from mcdas_opt.planning.lanes.merging_gap import merging_time_gap_s
from mcdas_opt.planning.lanes.required_lane import RequiredLane, required_lane
from mcdas_opt.planning.memory import Memory
from mcdas_opt.planning.planner import Planner
from mcdas_opt.planning.proposals.comfortable_speed import comfortable_speed
from mcdas_opt.planning.proposals.evade import steer_out
from mcdas_opt.reference.offset_path import OffsetPath
from mcdas_opt.simulation.loop import simulate
from mcdas_opt.simulation.record import Outcome
from tests.planning.situations import car, mirrored, random_sandwich

ENDING = """
duration_s = {duration}
[road]
lanes_left = 1
[[road.lane]]
lane = 0
width_m = [[{begin}, 3.7], [{end}, 0.0]]
merges = "left"
[host]
speed_mps = {speed}
"""
BESIDE = '[[neighbour]]\nname = "n{k}"\ns_m = {s}\nd_m = 3.7\nspeed_mps = {speed}\n'


def written(folder: Path, *, begin: float, end: float, speed: float, duration: float = 12.0, beside: str = "") -> Path:
    path = folder / "ending.toml"
    path.write_text(ENDING.format(begin=begin, end=end, speed=speed, duration=duration) + beside, "utf-8")
    return path


@pytest.mark.parametrize("speed", [8.0, 20.0, 33.0])
def test_an_ending_lane_is_left_in_time_and_calmly(tmp_path: Path, speed: float) -> None:
    scene = load_scene(written(tmp_path, begin=6.0 * speed, end=9.0 * speed, speed=speed))
    drive = simulate(scene)
    assert (drive.outcome.value, drive.fallbacks, drive.unavoidable) == ("safe", 0, 0)
    assert drive.trajectory.d_m[-1] == pytest.approx(3.7, abs=0.1)
    assert float(drive.trajectory.speed_mps.min()) > 0.95 * speed
    assert drive.max_lateral_acceleration_mps2 < 2.0


THREE_LANES = """
duration_s = 24.0
[road]
lanes_left = 2
[[road.lane]]
lane = 1
closed_m = [[{end}, 1e5]]
[[road.lane]]
lane = 2
closed_m = [[{end}, 1e5]]
[host]
d_m = 7.4
speed_mps = {speed}
"""


@pytest.mark.parametrize("speed", [8.0, 20.0, 33.0])
def test_a_lane_is_left_for_one_that_lies_beyond_another_that_ends_with_it(tmp_path: Path, speed: float) -> None:
    path = tmp_path / "three.toml"
    path.write_text(THREE_LANES.format(end=18.0 * speed, speed=speed), "utf-8")
    drive = simulate(load_scene(path))
    assert (drive.outcome.value, drive.fallbacks, drive.unavoidable) == ("safe", 0, 0)
    assert drive.trajectory.d_m[-1] == pytest.approx(0.0, abs=0.1)
    assert float(drive.trajectory.speed_mps.min()) > 0.9 * speed


def test_the_more_changes_it_takes_the_sooner_a_lane_is_left() -> None:
    lanes = tuple(Lane(lane=k, closed_m=((400.0, 1e4),)) for k in (1, 2, 3))
    road, vehicle = Road(lanes_left=3, lanes=lanes), Vehicle()
    left = {}
    for lane in (1, 2, 3):
        host = HostState(s_m=0.0, d_m=lane * road.lane_width_m, speed_mps=20.0)
        left[lane] = required_lane(Situation(host=host, road=road, coverage=Coverage()), vehicle)
    assert {lane: (one.side, one.left_s, one.end_m) for lane, one in left.items() if one} == {
        lane: (Side.RIGHT, pytest.approx(20.0 / lane), 400.0) for lane in (1, 2, 3)
    }
    beside = replace(road, lanes=(*lanes[:2], Lane(lane=3)))
    nearer = required_lane(
        Situation(host=HostState(d_m=2.0 * road.lane_width_m, speed_mps=20.0), road=beside, coverage=Coverage()), vehicle
    )
    assert nearer is not None
    assert (nearer.side, nearer.left_s) == (Side.LEFT, pytest.approx(20.0))


def test_the_shipped_one_is_left_behind_or_ahead_of_the_other_with_a_headway_that_nobody_has_to_brake_for() -> None:
    drive = simulate(load_scene("lane-ends"))
    assert (drive.outcome.value, drive.fallbacks, drive.unavoidable) == ("safe", 0, 0)
    host = drive.trajectory
    crossed = int(np.argmax(host.d_m > 0.5 * 3.7))
    assert host.d_m[-1] == pytest.approx(3.7, abs=0.1)
    for other in drive.neighbours:
        ahead_m = float(other.s_m[crossed] - host.s_m[crossed])
        follower_mps = float(host.speed_mps[crossed] if ahead_m > 0.0 else other.speed_mps[crossed])
        assert abs(ahead_m) - 0.5 * (other.length_m + 4.5) > 0.7 * follower_mps
    assert float(host.acceleration_mps2.min()) > -2.5


speeds = st.floats(5.0, 36.0)


@given(
    cars=st.lists(st.tuples(st.floats(-120.0, 120.0), speeds, st.floats(3.0, 16.0)), max_size=5),
    speed=speeds,
    left_s=st.floats(0.0, 20.0),
    end_m=st.sampled_from([None, 300.0]),
)
def test_a_gap_that_is_gone_into_makes_nobody_brake_harder_than_manners_allow(
    cars: list[tuple[float, float, float]], speed: float, left_s: float, end_m: float | None
) -> None:
    settings, vehicle = Settings(), Vehicle()
    tracks = tuple(Track(id=f"{i}", s_m=s, d_m=3.7, speed_s_mps=v, length_m=length) for i, (s, v, length) in enumerate(cars))
    situation = Situation(
        host=HostState(speed_mps=speed), tracks=tracks, road=Road(lanes_left=1, speed_limit_mps=40.0), coverage=Coverage()
    )
    gap = best_gap(situation, vehicle, settings, RequiredLane(Side.LEFT, left_s, end_m), 40.0)
    if gap is None or gap.wait_s > 0.0:
        return
    for track in tracks:
        if end_m is None and track.s_m > 0.0:  # behind him the host has a headway once it has braked by 2 m/s^2 to his speed
            closing, opening = max(speed - track.speed_s_mps, 0.0), max(track.speed_s_mps - speed, 0.0)
            room_m = track.s_m - 0.5 * (track.length_m + vehicle.length_m)
            asked_m = 2.0 + 0.78 * min(speed, track.speed_s_mps)
            assert room_m >= 0.7 * asked_m - 1e-6
            assert room_m - closing * 0.5 - closing**2 / 4.0 + 2.5 * opening >= asked_m - 1e-6
            continue
        ahead_m = track.s_m - situation.host.s_m + 2.5 * (track.speed_s_mps - speed)
        follower, leader = (speed, track.speed_s_mps) if ahead_m > 0.0 else (track.speed_s_mps, speed)
        room_m = abs(ahead_m) - 0.5 * (track.length_m + vehicle.length_m)
        braking = -idm_acceleration(
            follower,
            math.inf,
            Leader(room_m, min(leader, follower)),
            IdmSettings(headway_s=0.78, acceleration_mps2=1.5, deceleration_mps2=2.0),
        )
        assert braking <= 2.0 + 1.5 + 1e-6  # what is left of the model's own acceleration
        assert room_m > 0.5 * follower


def test_who_is_beside_is_let_ahead_or_passed_and_only_when_it_is_time() -> None:
    vehicle, settings, host = Vehicle(), Settings(), HostState(speed_mps=22.0)
    road = Road(lanes_left=1)
    for s, slower in ((2.0, True), (-14.0, False)):
        situation = Situation(host=host, tracks=(car("beside", s, 3.7, 22.0),), road=road, desired_speed_mps=30.0, coverage=Coverage())
        assert best_gap(situation, vehicle, settings, RequiredLane(Side.LEFT, 15.0, 330.0), 36.0) is None
        gap = best_gap(situation, vehicle, settings, RequiredLane(Side.LEFT, 11.0, 242.0), 36.0)
        assert gap is not None
        assert (gap.is_slower, (gap.ahead or gap.behind).id) == (slower, "beside")  # type: ignore[union-attr]
        assert 0.0 < gap.wait_s < 10.0


def test_a_lane_change_that_somebody_spoils_is_withdrawn_before_the_line_and_not_after() -> None:
    vehicle, road = Vehicle(), Road(lanes_left=1, speed_limit_mps=40.0)
    path = OffsetPath(start_s_m=-20.0, start_d_m=0.0, amplitude_m=3.7, a_per_m=-0.06, b=50.0)
    memory = Memory(situation=Situation(host=HostState(speed_mps=25.0), road=road, coverage=Coverage()), active=Manoeuvre(
        side=Side.LEFT, path=path, target_d_m=3.7, speed_mps=30.0, mode=Mode.CRUISE))  # fmt: skip
    for d, comes_mps, given_up in ((0.5, 33.0, True), (0.5, 25.0, False), (1.5, 33.0, False)):
        host = HostState(d_m=d, heading_rad=0.03, speed_mps=25.0)
        situation = Situation(
            time_s=0.1, host=host, tracks=(car("fast", -32.0, 3.7, comes_mps),), road=road, desired_speed_mps=30.0, coverage=Coverage()
        )
        cycle = Cycle.of(situation, vehicle, memory=memory)
        assert cycle.is_withdrawn is given_up
        assert cycle.indicator is (Side.NONE if given_up else Side.LEFT)


def test_a_car_that_cannot_get_out_stops_before_the_end(tmp_path: Path) -> None:
    """A column beside it, as fast as it, without a gap."""
    column = "".join(BESIDE.format(k=k, s=5.6 * (k - 20) + 2.0, speed=8.0) for k in range(27))
    drive = simulate(load_scene(written(tmp_path, begin=60.0, end=80.0, speed=8.0, duration=11.0, beside=column)))
    assert drive.outcome.value == "safe"
    assert float(drive.trajectory.s_m[-1]) < 75.0


COLUMN = '[[neighbour]]\nname = "n{k}"\ns_m = {s}\nd_m = -3.7\nspeed_mps = {speed}\n'


def test_who_is_faster_than_a_column_goes_along_with_it_into_a_gap(tmp_path: Path) -> None:
    """Nobody in it makes room; the passing lane ends. Before, the host drove past them all, and braked to almost nothing for the end."""
    column = "".join(COLUMN.format(k=k, s=3.0 + 35.5 * (k - 5), speed=17.0) for k in range(14))
    path = written(tmp_path, begin=290.0, end=330.0, speed=24.0, duration=16.0, beside=column)
    path.write_text(path.read_text("utf-8").replace("lanes_left", "lanes_right").replace('"left"', '"right"'), "utf-8")
    drive = simulate(load_scene(path))
    assert (drive.outcome.value, drive.fallbacks, drive.unavoidable) == ("safe", 0, 0)
    assert drive.trajectory.d_m[-1] == pytest.approx(-3.7, abs=0.3)
    assert float(drive.trajectory.speed_mps.min()) > 0.85 * 17.0
    assert float(drive.trajectory.acceleration_mps2.min()) > -3.5


@pytest.mark.parametrize(("speed", "apart_m", "shifted"), [(20.0, 45.0, 0.0), (20.0, 45.0, 0.5), (20.0, 45.0, 0.75), (24.0, 50.0, 0.0)])
def test_a_short_lane_beside_a_fast_column_is_accelerated_along(tmp_path: Path, speed: float, apart_m: float, shifted: float) -> None:
    """The host comes slowly out of a bend onto 110 m of lane. Before, it crept along it, and stood at its end for good."""
    column = "".join(BESIDE.format(k=k, s=60.0 - apart_m * (k + shifted), speed=speed) + 'behaviour = "idm"\n' for k in range(7))
    path = written(tmp_path, begin=110.0, end=125.0, speed=6.0, duration=14.0, beside=column)
    path.write_text(path.read_text("utf-8").replace("speed_mps = 6.0", "speed_mps = 6.0\ndesired_speed_mps = 30.0", 1), "utf-8")
    drive = simulate(load_scene(path))
    assert (drive.outcome.value, drive.fallbacks, drive.unavoidable) == ("safe", 0, 0)
    assert drive.trajectory.d_m[-1] == pytest.approx(3.7, abs=0.1)
    assert float(drive.trajectory.speed_mps.min()) >= 5.9
    entered = int(np.argmax(drive.trajectory.d_m > 0.5 * 3.7))
    assert drive.trajectory.speed_mps[entered] > 0.75 * speed


@pytest.mark.parametrize(("friction", "most_mps2"), [(1.1, 4.0), (0.3, 0.4 * 0.3 * GRAVITY_MPS2)])
def test_who_hurries_along_a_short_lane_asks_a_slippery_road_for_no_more_than_its_share(friction: float, most_mps2: float) -> None:
    road = Road(lanes_left=1, friction=friction, lanes=(Lane(lane=0, width_m=((70.0, 3.7), (85.0, 0.0)), merges=Side.LEFT),))
    beside = tuple(car(f"{k}", 40.0 * k, 3.7, 24.0) for k in (-1, 1))
    situation = Situation(host=HostState(speed_mps=5.0), tracks=beside, road=road, desired_speed_mps=30.0, coverage=Coverage())
    cycle = Cycle.of(situation, Vehicle())
    assert cycle.hurries_to_merge
    asked = np.diff(comfortable_speed(cycle, 30.0, 0.0).speeds_mps) / np.diff(cycle.settings.grid.times_s)
    assert float(asked.max()) == pytest.approx(most_mps2)


@pytest.mark.parametrize("speed", [12.0, 18.0, 24.0])
def test_a_gap_is_gained_only_by_who_can_still_stop_gently(speed: float) -> None:
    vehicle, settings, road = Vehicle(), Settings(), Road(lanes_right=1)
    rng, gained = np.random.default_rng(round(speed)), 0
    for _ in range(600):
        tracks = tuple(car(f"{k}", float(rng.uniform(-80.0, 120.0)), -3.7, speed - float(rng.uniform(-2.0, 8.0))) for k in range(3))
        end_m = float(rng.uniform(3.0, 16.0)) * speed
        situation = Situation(host=HostState(speed_mps=speed), tracks=tracks, road=road, desired_speed_mps=36.0, coverage=Coverage())
        gap = best_gap(situation, vehicle, settings, RequiredLane(Side.RIGHT, end_m / speed, end_m), 36.0)
        if gap is not None and gap.wait_s > 0.0 and not gap.is_slower:
            gained += 1
            assert speed * gap.wait_s + speed**2 / (2.0 * 1.5) <= end_m
    assert gained > 5


@pytest.mark.parametrize(("end_m", "passes"), [(300.0, True), (None, False)])
def test_from_a_lane_that_ends_whoever_is_slower_is_passed_on_either_side(end_m: float | None, passes: bool) -> None:
    lanes = () if end_m is None else (Lane(lane=0, width_m=((end_m - 60.0, 3.7), (end_m, 0.0)), merges=Side.LEFT),)
    road = Road(lanes_left=1, lanes=lanes)
    situation = Situation(
        host=HostState(speed_mps=26.0), tracks=(car("slow", 20.0, 3.7, 20.0),), road=road, desired_speed_mps=26.0, coverage=Coverage()
    )
    speeds = comfortable_speed(Cycle.of(situation, Vehicle()), 26.0, 0.0).speeds_mps
    assert (float(speeds[-1]) > 25.5) is passes


@given(st.floats(12.0, 30.0), st.floats(0.0, 4.0), st.floats(-6.0, 6.0), st.floats(0.0, 3.0))
def test_a_gap_that_is_barely_long_enough_is_not_raced_for(speed: float, slower: float, nearer_m: float, spare_m: float) -> None:
    """Beside the one who would be behind in it, wanting no more than its own speed."""
    settings, vehicle, v = Settings(), Vehicle(), speed - slower
    ahead_m, behind_m = 0.85 * (2.0 + 0.78 * v), 0.55 * v
    length_m = 2.0 * vehicle.length_m + ahead_m + behind_m + spare_m
    tracks = tuple(replace(car(f"{k}", nearer_m + k * length_m, 3.7, v), length_m=vehicle.length_m) for k in range(-3, 4))
    situation = Situation(
        host=HostState(speed_mps=speed), tracks=tracks, road=Road(lanes_left=1), desired_speed_mps=speed, coverage=Coverage()
    )
    gap = best_gap(situation, vehicle, settings, RequiredLane(Side.LEFT, 12.0, 12.0 * speed), 40.0)
    assert gap is None or gap.fastest_mps <= max(speed, v) or gap.ahead is None


@given(st.floats(5.0, 120.0), st.floats(0.5, 40.0))
def test_what_is_free_in_a_gap_is_shared(free_m: float, speed: float) -> None:
    vehicle, headway = Vehicle(), Settings().headway
    ahead = car("ahead", 4.5 + free_m + vehicle.length_m, -3.7, speed)
    gap = Gap(car("behind", 0.0, -3.7, speed), replace(ahead, length_m=4.5))
    gap = gap._replace(behind=replace(gap.behind, length_m=4.5))  # type: ignore[type-var]
    time_gap_s = merging_time_gap_s(gap, speed, vehicle, headway)
    assert 0.65 * headway.time_gap_s <= time_gap_s <= headway.time_gap_s
    before_m = headway.standstill_m + time_gap_s * speed
    assert before_m <= 0.6 * free_m + 1e-6 or time_gap_s == 0.65 * headway.time_gap_s
    assert merging_time_gap_s(gap._replace(behind=None), speed, vehicle, headway) == headway.time_gap_s


def ending(lane: Lane, situation: Situation) -> Situation:
    return replace(situation, road=replace(situation.road, lanes=(lane,)))


@pytest.mark.parametrize("seed", range(100, 112))
def test_a_mirrored_situation_with_an_ending_lane_has_the_mirrored_plan_to_the_bit(seed: int) -> None:
    situation = random_sandwich(seed)
    road = replace(situation.road, lanes_left=1, lanes_right=1)
    edge = Lane(lane=1 if seed % 2 else -1, width_m=((20.0, 3.7), (70.0, 0.0)))
    situation = ending(edge, replace(situation, road=road))
    plan, image = Planner().plan(situation), Planner().plan(mirrored(situation))
    assert np.array_equal(plan.trajectory.d_m, -image.trajectory.d_m)
    assert np.array_equal(plan.trajectory.s_m, image.trajectory.s_m)


@pytest.mark.parametrize("seed", range(100, 108))
def test_a_lane_that_says_nothing_new_changes_no_bit(seed: int) -> None:
    situation = random_sandwich(seed)
    said = ending(Lane(lane=0, width_m=((10.0, 3.7), (90.0, 3.7))), situation)
    assert np.array_equal(Planner().plan(situation).trajectory.table, Planner().plan(said).trajectory.table)


@pytest.mark.parametrize("by_m", [2000.0, -7000.0])
def test_the_same_farther_along_the_road(by_m: float) -> None:
    """Whole kilometres: states to 1e-6 m."""
    road = Road(lanes_left=1, lanes=(Lane(lane=0, width_m=((120.0, 3.7), (180.0, 0.0)), merges=Side.LEFT),))
    here = Situation(host=HostState(speed_mps=20.0), tracks=(car("a", 20.0, 3.7, 19.0),), road=road, coverage=Coverage())
    there = replace(
        here, host=replace(here.host, s_m=by_m), tracks=tuple(replace(t, s_m=t.s_m + by_m) for t in here.tracks), road=road.seen_from(-by_m)
    )
    one, other = Planner().plan(here), Planner().plan(there)
    assert (one.chosen, one.side) == (other.chosen, other.side)
    assert other.trajectory.s_m - by_m == pytest.approx(one.trajectory.s_m, abs=1e-6)
    assert other.trajectory.d_m == pytest.approx(one.trajectory.d_m, abs=1e-6)


def test_no_candidate_goes_to_a_lane_that_ends_before_it_is_there() -> None:
    host, vehicle = HostState(speed_mps=20.0), Planner().vehicle
    for end, there in ((90.0, False), (400.0, True)):
        road = Road(lanes_left=1, lanes=(Lane(lane=1, width_m=((end - 40.0, 3.7), (end, 0.0))),))
        situation = Situation(host=host, tracks=(car("front", 30.0, 0.0, 5.0),), road=road, coverage=Coverage())
        assert (next_lane_m(situation, vehicle, Side.LEFT) is not None) is there
        plan = Planner().plan(situation)
        if not there:
            (said,) = {row.refusal for row in plan.candidates if row.name == "left"}
            assert said == "the lane to the left does not go on for as long as changing into it takes"


def test_an_oncoming_lane_is_none_to_change_into_and_limits_are_seen_ahead() -> None:
    host, vehicle = HostState(speed_mps=20.0), Planner().vehicle
    road = Road(lanes_left=1, lanes=(Lane(lane=1, oncoming=True), Lane(lane=0, speed_limit_mps=((0.0, 30.0), (60.0, 10.0)))))
    situation = Situation(host=host, road=road, desired_speed_mps=30.0, coverage=Coverage())
    assert next_lane_m(situation, vehicle, Side.LEFT) is None
    assert steer_out(Cycle.of(situation, vehicle), Side.LEFT).refusal == "the lane to the left is one of oncoming traffic"
    assert steer_out(Cycle.of(situation, vehicle), Side.RIGHT).refusal == "no lane and no shoulder to the right"
    limits = [Cycle.of(replace(situation, host=replace(host, s_m=s)), vehicle).limit_mps for s in (-200.0, 0.0, 50.0, 61.0)]
    assert limits[0] == pytest.approx(np.sqrt(10.0**2 + 2 * 1.5 * 260.0))
    assert limits == sorted(limits, reverse=True)
    assert limits[-1] == 10.0


CLOSED, NARROW = {"closed_m": ((50.0, 200.0),)}, {"width_m": ((0.0, 3.7), (100.0, 0.0), (200.0, 0.0), (300.0, 3.7))}


@pytest.mark.parametrize("lane", [CLOSED, NARROW, {**CLOSED, "width_m": ((500.0, 3.7), (600.0, 0.0))}])
def test_a_lane_that_is_closed_or_too_narrow_at_the_host_ends_there(lane: dict[str, Any]) -> None:
    road = Road(lanes_left=1, lanes=(Lane(lane=0, merges=Side.LEFT, **lane),))
    situation = Situation(host=HostState(s_m=80.0, speed_mps=10.0), road=road, coverage=Coverage())
    assert required_lane(situation, Vehicle()) == RequiredLane(Side.LEFT, 0.0, 80.0)
    oncoming = replace(situation, host=replace(situation.host, d_m=3.7), road=Road(lanes_left=1, lanes=(Lane(lane=1, oncoming=True),)))
    required = required_lane(oncoming, Vehicle())
    assert (required.side, required.end_m, required.own_lane_ends, required.own_lane_is_undrivable) == (Side.RIGHT, None, True, True)


@pytest.mark.parametrize("sign", [1, -1])
@pytest.mark.parametrize(("lorry_m", "ahead"), [(16.0, True), (4.0, False), (-14.0, False), (None, False)])
def test_a_lane_of_oncoming_traffic_is_left(lorry_m: float | None, ahead: bool, sign: int) -> None:
    """As after an evasion: there is no end of it to brake for, and the lane beside is gone back to, behind whoever is there or ahead."""
    document = {
        "name": "back",
        "duration_s": 16.0,
        "road": {"lanes_left" if sign > 0 else "lanes_right": 1, "friction": 0.8, "lane": [{"lane": sign, "oncoming": True}]},
        "host": {"d_m": sign * 3.7, "speed_mps": 17.5, "desired_speed_mps": 22.0},
        "neighbour": []
        if lorry_m is None
        else [{"name": "lorry", "s_m": lorry_m, "speed_mps": 16.7, "length_m": 16.5, "width_m": 2.5, "behaviour": "idm"}],
    }
    drive = simulate(Scene.model_validate(document))
    assert (drive.outcome, drive.unverified_plans) == (Outcome.SAFE, 0)
    assert "evade" not in [mode for _, mode in drive.modes]
    assert abs(drive.trajectory.d_m[-1]) < 0.3
    assert {cycle.plan.alert for cycle in drive.cycles} == {Alert.NONE}
    assert any("out of a lane that is none to drive in" in cycle.plan.reason for cycle in drive.cycles)
    if lorry_m is not None:
        assert bool(drive.neighbours[0].s_m[-1] > drive.trajectory.s_m[-1]) is ahead


@pytest.mark.parametrize("end_m", np.arange(6.0, 14.0, 0.5))
@pytest.mark.parametrize("speed", [0.0, 0.1, 0.5])
def test_a_car_that_stands_before_the_end_of_its_lane_goes_round_it(end_m: float, speed: float) -> None:
    # those that stood 9 to 12.5 m before it stayed there, the lane beside them free
    car = Vehicle()
    road = Road(lane_width_m=3.2, lanes_right=1, lanes=(Lane(lane=0, closed_m=((0.5 * car.length_m + end_m, 500.0),)),))
    plan = Planner(car).plan(Situation(host=HostState(speed_mps=speed), road=road, coverage=Coverage(), desired_speed_mps=13.9))
    assert (plan.status, plan.side) == (Status.PLANNED, Side.RIGHT)
