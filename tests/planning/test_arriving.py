"""What a destination asks of ordinary driving: gaps, lanes that begin ahead, bends, headings."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mcdas_opt import Planner
from mcdas_opt.catalogue.scenes import load_scene
from mcdas_opt.domain.comfort import ComfortSettings
from mcdas_opt.domain.cost_weights import CostWeights
from mcdas_opt.domain.destination import Destination
from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.lane import Lane
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.settings import Settings
from mcdas_opt.domain.situation import Coverage, Situation
from mcdas_opt.domain.track import Track
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.domain.vocabulary import Side
from mcdas_opt.planning.candidates.lane_change_cost import lane_change_cost
from mcdas_opt.planning.cycle import Cycle
from mcdas_opt.planning.lanes.best_gap import best_gap
from mcdas_opt.planning.lanes.required_lane import required_lane
from mcdas_opt.planning.proposals.comfortable_speed import bends_ahead
from mcdas_opt.planning.proposals.lane_change import change_on, change_to_required
from mcdas_opt.reference.speed_profile import profile_ahead
from mcdas_opt.simulation.loop import simulate
from tests.planning.situations import car

BENT = Road(curvature=((0.0, 0.0), (30.0, 0.05), (60.0, 0.05), (90.0, 0.0)))


@given(
    cars=st.lists(st.tuples(st.floats(-60.0, 60.0), st.floats(0.0, 30.0)), max_size=5),
    speed=st.floats(0.0, 30.0),
    left_s=st.floats(0.0, 12.0),
)
def test_a_gap_for_a_destination_is_there_in_time(cars: list[tuple[float, float]], speed: float, left_s: float) -> None:
    there = Destination(lane=1, s_m=(-1000.0, 1000.0), time_s=(0.0, left_s))
    tracks = tuple(Track(id=f"{i}", s_m=s, d_m=3.7, speed_s_mps=v) for i, (s, v) in enumerate(cars))
    situation = Situation(host=HostState(speed_mps=speed), tracks=tracks, road=Road(lanes_left=1), destination=there, coverage=Coverage())
    required = required_lane(situation, Vehicle())
    assert required is not None
    gap = best_gap(situation, Vehicle(), Settings(), required, 36.0)
    assert gap is None or gap.wait_s == 0.0 or gap.wait_s < left_s


@pytest.mark.parametrize("closing", [0.0, 2.0, 4.0, 6.0])
def test_who_has_to_be_in_a_lane_goes_behind_somebody_slower_at_a_distance_that_ordinary_braking_makes_a_headway_of(closing: float) -> None:
    v, vehicle, settings = 15.0, Vehicle(), Settings()
    kept_m = vehicle.length_m + settings.headway.standstill_m + 0.65 * settings.headway.time_gap_s * v
    for spare_m, is_open in ((closing * 0.5 + closing**2 / 4.0 + 0.2, True), (closing**2 / 4.0 - 0.2, False)):
        front = Track(id="front", s_m=kept_m + spare_m, d_m=3.7, speed_s_mps=v, length_m=vehicle.length_m)
        there = Destination(lane=1, s_m=(0.0, 200.0), time_s=(0.0, 5.0))
        situation = Situation(
            host=HostState(speed_mps=v + closing), tracks=(front,), road=Road(lanes_left=1), destination=there, coverage=Coverage()
        )
        required = required_lane(situation, vehicle)
        assert required is not None
        gap = best_gap(situation, vehicle, settings, required, 36.0)
        assert (gap is not None and gap.wait_s == 0.0) is is_open


def test_a_lane_that_begins_ahead_is_changed_into_where_it_is() -> None:
    road = Road(lanes_right=1, lanes=(Lane(lane=-1, width_m=((20.0, 0.0), (22.0, 3.7))),))
    there = Destination(lane=-1, s_m=(60.0, 200.0), time_s=(0.0, 9.0))
    cycle = Cycle.of(Situation(host=HostState(s_m=16.0, speed_mps=15.0), road=road, destination=there, coverage=Coverage()), Vehicle())
    required = cycle.required_lane
    assert required is not None
    assert not cycle.situation.road.has_lane(-1, cycle.situation.host.s_m)
    proposed = change_to_required(cycle, required)
    assert proposed is not None
    assert proposed.path.target_d_m == pytest.approx(-3.7, abs=1e-9)


@given(
    speed=st.floats(3.0, 30.0),
    crossed=st.floats(0.05, 1.5),
    heading=st.floats(0.0, 0.2),
    way_s=st.floats(1.0, 9.0),
    side=st.sampled_from((1.0, -1.0)),
)
def test_a_change_goes_on_into_the_lane_beyond_through_where_the_host_is_once_that_is_due(
    speed: float, crossed: float, heading: float, way_s: float, side: float
) -> None:
    road = Road(lanes_left=2, lanes_right=2)
    lane = 2 if side > 0.0 else -2
    there = Destination(lane=lane, s_m=(0.0, speed * way_s), time_s=(0.0, 20.0))
    begun = Situation(host=HostState(speed_mps=speed), road=road, destination=there, coverage=Coverage())
    first = change_to_required(Cycle.of(begun, Vehicle()), required_lane(begun, Vehicle()))
    assert first is not None
    assert first.manoeuvre is not None
    border = side * 0.5 * road.lane_width_m
    for d, is_half_done in ((border - side * crossed, False), (border + side * crossed, True)):
        situation = replace(begun, host=HostState(d_m=d, heading_rad=side * heading, speed_mps=speed))
        cycle = Cycle.of(situation, Vehicle())
        required = required_lane(cycle.situation, Vehicle())
        assert required is not None
        further = change_on(cycle, required, first.manoeuvre)
        assert (further is not None) is (is_half_done and required.left_s <= 8.0)
        if further is not None:
            assert further.path.target_d_m == pytest.approx(lane * road.lane_width_m)
            assert further.side is first.side
            assert float(further.path.d(0.0)) == pytest.approx(d, abs=0.15)
            assert side * float(further.path.slope(0.0)) > 0.0


def cycle_before_bend(time_s: float | None) -> Cycle:
    there = None if time_s is None else Destination(s_m=(100.0, 120.0), time_s=(0.0, time_s))
    return Cycle.of(
        Situation(host=HostState(speed_mps=8.0), road=BENT, desired_speed_mps=12.0, destination=there, coverage=Coverage()), Vehicle()
    )


def test_bends_are_taken_faster_only_as_far_as_a_destination_is_missed_otherwise() -> None:
    places = np.arange(0.0, 100.0, 2.0)

    def squares(time_s: float | None) -> np.ndarray:
        profile = bends_ahead(cycle_before_bend(time_s), 0.0)
        assert profile is not None
        return np.asarray(profile.at(places) ** 2)

    usual = squares(None)
    assert np.array_equal(squares(60.0), usual)
    hurried = [squares(time_s) for time_s in (20.0, 13.5, 13.0, 12.5, 12.0)]
    assert [squared.min() / usual.min() for squared in hurried] == pytest.approx([1.0, 1.125, 1.25, 1.375, 1.5])
    braking = [-np.diff(squared).min() / (2.0 * 2.0) for squared in hurried]  # before the bend, from place to place
    assert braking == pytest.approx([1.5, 1.75, 2.0, 2.25, 2.5])
    icy = [cycle_before_bend(time_s).situation for time_s in (None, 12.0)]
    careful, late = (bends_ahead(Cycle.of(replace(one, road=replace(one.road, friction=0.3)), Vehicle()), 0.0) for one in icy)
    assert careful is not None
    assert late is not None
    assert np.array_equal(late.at(places), careful.at(places))


def test_a_change_to_the_destinations_lane_costs_nothing_by_itself_and_one_away_from_it_more() -> None:
    there = Destination(lane=1, s_m=(100.0, 200.0), time_s=(0.0, 12.0))
    situation = Situation(
        host=HostState(speed_mps=15.0), tracks=(car("front", 40.0, 0.0, 13.0),), road=Road(lanes_left=1, lanes_right=1), coverage=Coverage()
    )
    weights = CostWeights()
    free, bound = (Cycle.of(replace(situation, destination=one), Vehicle()) for one in (None, there))
    assert lane_change_cost(Side.LEFT, bound, weights) == 0.0 < lane_change_cost(Side.LEFT, free, weights)
    assert lane_change_cost(Side.RIGHT, bound, weights) == lane_change_cost(Side.RIGHT, free, weights) + weights.off_destination


@pytest.mark.parametrize("heading", [(-0.2, -0.05), (0.05, 0.2)])
def test_a_heading_that_is_asked_for_is_had_at_the_place(tmp_path: Path, heading: tuple[float, float]) -> None:
    path = tmp_path / "turned.toml"
    asked = f"lane = 0\ns_m = [60.0, 64.0]\ntime_s = [5.0, 7.0]\nd_m = [-1.0, 1.0]\nheading_rad = [{heading[0]}, {heading[1]}]"
    path.write_text(f"duration_s = 7.5\n[road]\n[destination]\n{asked}\n[host]\nspeed_mps = 10.0\n", "utf-8")
    drive = simulate(load_scene(path))
    assert (drive.outcome.value, drive.fallbacks, drive.destination) == ("safe", 0, "reached")
    assert drive.max_lateral_acceleration_mps2 < 3.0
    assert math.isfinite(float(drive.trajectory.d_m[-1]))


@pytest.mark.parametrize("far_m", [2e4, 1e6, 9e8])
def test_a_destination_however_far_away_is_driven_towards_as_one_that_is_not_late(far_m: float) -> None:
    """9e8 m on a bent road were timed in steps of 2 m: gigabytes, and `MemoryError` out of `plan`."""
    road = Road(curvature=((0.0, 0.0), (100.0, 0.01), (200.0, 0.0)))
    bare = Situation(host=HostState(speed_mps=20.0), road=road, coverage=Coverage())
    there = Destination(s_m=(far_m, 1e9), time_s=(0.0, 1e9))
    assert Planner().plan(replace(bare, destination=there)).trajectory == Planner().plan(bare).trajectory


def test_a_car_that_hardly_brakes_before_bends_looks_ahead_so_far_and_no_farther() -> None:
    comfort = ComfortSettings(bend_braking_mps2=1e-9)
    profile = profile_ahead(BENT, 0.0, 0.0, 36.0, comfort)
    assert profile is not None
    assert profile.speed_mps.size * profile.step_m < 11_000.0
