"""Somewhere to go: what is refused, what can still be had, how fast."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from mcdas_opt.catalogue.scenes import load_scene
from mcdas_opt.catalogue.vehicles import load_vehicle
from mcdas_opt.domain.destination import Destination
from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.situation import Coverage, Situation
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.errors import InputError, ParameterError
from mcdas_opt.planning.lanes.kept_offset import kept_d_m
from mcdas_opt.planning.planner import Planner
from mcdas_opt.simulation.loop import simulate

ROAD = Road(lanes_left=1)
HOST = HostState(s_m=100.0, speed_mps=20.0)


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({}, "must say where or when"),
        ({"s_m": (5.0, 3.0)}, "s_m.*must begin before it ends"),
        ({"s_m": (5.0,)}, "must be a pair"),
        ({"s_m": (float("nan"), 3.0)}, "must be finite"),
        ({"s_m": (0.0, 3e9)}, "s_m.*must lie within"),
        ({"lane": 0, "d_m": (1e308, 1e308)}, "d_m.*must lie within"),
        ({"lane": 1.5}, "must be a whole number"),
        ({"time_s": ("a", 3.0)}, "must be a number"),
        ({"s_m": (3.0, 5.0), "speed_mps": (9.0, 2.0)}, "speed_mps.*must begin before it ends"),
        ({"speed_mps": (9.0, 12.0)}, "must say where or when"),
    ],
)
def test_a_destination_that_is_none_is_refused(given: dict[str, Any], said: str) -> None:
    with pytest.raises(ParameterError, match=said):
        Destination(**given)


@pytest.mark.parametrize(
    ("destination", "said"),
    [
        (Destination(s_m=(10.0, 90.0)), "behind the host"),
        (Destination(s_m=(210.0, 250.0), time_s=(1.0, 2.0)), "are beyond the car, which comes"),
        (Destination(s_m=(135.0, 250.0), time_s=(0.0, 1.0)), "comes 2"),
        (Destination(s_m=(210.0, 250.0), speed_mps=(70.0, 80.0)), "70 m/s are beyond the car's"),
        (Destination(lane=2), "there is no lane 2"),
        (Destination(time_s=(-9.0, -1.0)), "its time is over"),
        (Destination(lane=1, s_m=(150.0, 160.0), time_s=(0.0, 9.0)), ""),
    ],
)
def test_what_cannot_be_had_is_said_and_driven_on_without(destination: Destination, said: str) -> None:
    assert said in destination.why_unreachable(HOST, 0.0, ROAD, load_vehicle("sedan"))
    plan = Planner().plan(Situation(host=HOST, road=ROAD, destination=destination, coverage=Coverage()))
    assert plan.destination.startswith("unreachable" if said else "ahead")
    assert said in plan.destination
    assert plan.verdict.passed
    if said:
        without = Planner().plan(Situation(host=HOST, road=ROAD, coverage=Coverage()))
        assert (plan.trajectory.table == without.trajectory.table).all()


def test_it_is_the_same_seen_from_elsewhere_and_later() -> None:
    there = Destination(s_m=(150.0, 160.0), lane=1, time_s=(3.0, 9.0))
    moved = there.seen_from(100.0, 2.0)
    assert (moved.s_m, moved.time_s, moved.lane) == ((50.0, 60.0), (1.0, 7.0), 1)
    host = HostState(s_m=155.0, d_m=3.7)
    assert there.is_reached(host, 4.0, ROAD)
    assert moved.is_reached(host.seen_from(100.0), 2.0, ROAD)
    assert not there.is_reached(replace(host, d_m=0.0), 4.0, ROAD)
    situation = Situation(host=HOST, road=ROAD, destination=there, coverage=Coverage())
    again = Situation.from_json(situation.to_json())
    assert again.destination == there
    later = replace(situation, time_s=2.0, destination=there.seen_from(0.0, -2.0))
    assert (Planner().plan(later).trajectory.table == Planner().plan(situation).trajectory.table).all()


@pytest.mark.parametrize(
    ("asked", "is_there"),
    [
        ({}, True),
        ({"d_m": (3.0, 4.0), "speed_mps": (9.0, 11.0), "heading_rad": (-0.1, 0.1)}, True),
        ({"d_m": (0.0, 3.0)}, False),
        ({"speed_mps": (0.0, 9.9)}, False),
        ({"heading_rad": (0.1, 0.3)}, False),
        ({"heading_rad": (6.1, math.tau)}, True),
        ({"heading_rad": (3.0, 3.3)}, False),
    ],
)
def test_a_host_is_there_as_it_is_asked_to_be(asked: dict[str, tuple[float, float]], is_there: bool) -> None:
    there = Destination(s_m=(150.0, 160.0), lane=1, time_s=(3.0, 9.0), **asked)
    for turns in (0.0, 2.0 * math.pi):
        assert there.is_reached(HostState(s_m=155.0, d_m=3.7, speed_mps=10.0, heading_rad=turns), 4.0, ROAD) is is_there


@given(middle=st.floats(-3.1, 3.1), half=st.floats(0.0, 3.1), heading=st.floats(-10.0, 10.0))
@example(middle=3.15, half=0.15, heading=3.2)
@example(middle=-1.0, half=math.pi, heading=2.5)
def test_headings_are_compared_as_angles(middle: float, half: float, heading: float) -> None:
    window = middle - half, middle + half
    there = Destination(lane=0, heading_rad=window)
    is_there = there.is_reached(HostState(heading_rad=heading), 0.0, ROAD)
    assert Destination(lane=0, heading_rad=(-window[1], -window[0])).is_reached(HostState(heading_rad=-heading), 0.0, ROAD) is is_there
    off = abs(math.remainder(heading - middle, math.tau))
    if abs(off - half) > 1e-12:
        assert is_there is (off < half)
    assert all(there.is_reached(HostState(heading_rad=edge), 0.0, ROAD) for edge in window if abs(edge) <= math.pi)
    assert Destination(lane=0, heading_rad=(0.0, math.tau)).is_reached(HostState(heading_rad=heading), 0.0, ROAD)


def test_a_window_of_headings_is_driven_to_as_the_same_by_a_turn() -> None:
    """Beside the lane's middle, so as to be across it there."""
    asked = Destination(s_m=(130.0, 132.0), d_m=(-1.0, 1.0), heading_rad=(0.05, 0.2))
    again = replace(asked, heading_rad=(0.05 - math.tau, 0.2 - math.tau))
    ways = [kept_d_m(Situation(host=HOST, road=ROAD, destination=one, coverage=Coverage()), Vehicle(), 0.0) for one in (asked, again)]
    assert ways[0] < -0.5
    assert ways[1] == pytest.approx(ways[0])


def scene(folder: Path, destination: str) -> Path:
    path = folder / "there.toml"
    path.write_text(f"duration_s = 11.0\n[road]\nlanes_left = 2\n[destination]\n{destination}\n[host]\nspeed_mps = 15.0\n", "utf-8")
    return path


def test_a_lane_two_away_is_reached_in_its_window(tmp_path: Path) -> None:
    drive = simulate(load_scene(scene(tmp_path, "lane = 2\ns_m = [140.0, 200.0]\ntime_s = [8.0, 10.0]")))
    assert (drive.outcome.value, drive.fallbacks, drive.destination) == ("safe", 0, "reached")
    assert drive.destination_reached_s is not None
    assert 8.0 <= drive.destination_reached_s <= 10.0


def test_it_is_reached_beside_the_lanes_middle_and_at_the_speed_that_is_asked_for(tmp_path: Path) -> None:
    asked = "lane = 1\ns_m = [90.0, 100.0]\ntime_s = [7.0, 8.0]\nd_m = [4.2, 5.6]\nspeed_mps = [6.0, 9.0]"
    drive = simulate(load_scene(scene(tmp_path, asked)))
    assert (drive.outcome.value, drive.fallbacks, drive.destination) == ("safe", 0, "reached")


@pytest.mark.parametrize(
    ("destination", "said"),
    [
        ("s_m = [-50.0, -20.0]", "destination: cannot be reached: it lies 20 m behind the host"),
        ("lane = 4", "cannot be reached: there is no lane 4"),
        ("", "must say where or when"),
    ],
)
def test_a_scene_with_a_goal_behind_the_host_is_refused(tmp_path: Path, destination: str, said: str) -> None:
    with pytest.raises(InputError, match=said):
        load_scene(scene(tmp_path, destination))
