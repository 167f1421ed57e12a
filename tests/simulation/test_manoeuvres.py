"""Whole drives of the kinds that a planner of single lane changes would not survive: safe, and every plan of them judged."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from mcdas_opt.catalogue.scenes import Scene
from mcdas_opt.domain.vocabulary import Status
from mcdas_opt.simulation.loop import simulate
from mcdas_opt.simulation.record import Outcome, Simulation


def scene(duration_s: float, speed_mps: float, neighbours: list[dict[str, Any]], **road: float) -> Scene:
    return Scene.model_validate(
        {"name": "drive", "duration_s": duration_s, "road": road, "host": {"speed_mps": speed_mps}, "neighbour": neighbours}
    )


def car(name: str, s: float, speed: float, d: float = 0.0, motion: tuple[dict[str, float], ...] = (), **more: Any) -> dict[str, Any]:
    return {"name": name, "s_m": s, "d_m": d, "speed_mps": speed, "motion": list(motion), **more}


def driven(what: Scene, seed: int) -> Simulation:
    """The drive, safe, with a judged plan and finite numbers in every cycle."""
    drive = simulate(what, seed=seed)
    assert drive.outcome is Outcome.SAFE, (drive.outcome, drive.collided_with)
    assert drive.unverified_plans == 0
    for cycle in drive.cycles:
        assert np.isfinite(cycle.plan.trajectory.states).all()
        assert cycle.plan.verdict.passed == (cycle.plan.status is not Status.UNAVOIDABLE)
    return drive


@pytest.mark.parametrize("seed", [1, 2])
def test_out_and_back_past_one_obstacle_and_before_the_next(seed: int) -> None:
    """A car stands in the host's lane, another farther on in the only other lane."""
    drive = driven(scene(9.0, 14.0, [car("first", 45.0, 0.0), car("second", 110.0, 0.0, 3.7)], lanes_left=1, lanes_right=0), seed)
    d, s = drive.trajectory.d_m, drive.trajectory.s_m
    assert d[np.abs(s - 45.0) < 2.0].min(initial=9.0) > 1.8  # out ...
    beyond = s > 106.0
    assert not beyond.any() or d[beyond].max() < 1.9  # ... and back, or stopped before


@pytest.mark.parametrize("seed", [1, 2])
def test_a_lane_change_is_given_up_when_somebody_takes_the_lane(seed: int) -> None:
    """Somebody two lanes over moves into the lane that the host has begun to steer for; what follows is planned and judged."""
    taker = car("taker", 4.0, 20.0, 7.4, ({"start_s": 0.6, "lateral_to_m": 3.7, "duration_s": 2.0},))
    drive = driven(scene(7.0, 20.0, [car("front", 50.0, 10.0), taker], lanes_left=2, lanes_right=0), seed)
    begun = [cycle.plan for cycle in drive.cycles if cycle.time_s < 1.0]
    assert any(plan.side.value == "left" for plan in begun)
    assert any(cycle.plan.side.value != "left" for cycle in drive.cycles if cycle.time_s > 1.0)


@pytest.mark.parametrize("seed", [1, 2])
def test_it_stops_before_the_end_of_the_road(seed: int) -> None:
    drive = driven(scene(16.0, 15.0, [car("rear", -45.0, 15.0, behaviour="idm")], lanes_left=1, lanes_right=0, road_end_s_m=90.0), seed)
    assert drive.trajectory.s_m[-1] + 2.25 < 90.0
    assert drive.trajectory.speed_mps[-1] < 1.0


@pytest.mark.parametrize("seed", [1, 2])
def test_boxed_in_on_ice(seed: int) -> None:
    """Friction 0.2: a slower car ahead, a faster one behind, room to one side."""
    cars = [car("front", 50.0, 8.0), car("rear", -40.0, 14.0)]
    drive = driven(scene(8.0, 12.0, cars, lanes_left=1, lanes_right=0, friction=0.2), seed)
    assert drive.max_lateral_acceleration_mps2 < 0.2 * 9.81 * 1.02


@pytest.mark.parametrize("follower", [[], [car("rear", -20.0, 7.0, behaviour="idm")]], ids=["alone", "followed"])
def test_stop_and_go(follower: list[dict[str, Any]]) -> None:
    """The car ahead stops, waits, drives on and stops again."""
    waves = (
        {"start_s": 0.5, "acceleration_mps2": -2.5},
        {"start_s": 6.0, "acceleration_mps2": 1.5, "until_speed_mps": 5.0},
        {"start_s": 12.0, "acceleration_mps2": -2.0},
    )
    drive = driven(scene(16.0, 7.0, [car("front", 18.0, 7.0, 0.0, waves), *follower], lanes_left=0, lanes_right=0), 1)
    t, v = drive.trajectory.t_s, drive.trajectory.speed_mps
    assert v[t < 7.0].min() < 2.5
    assert v[(t > 7.0) & (t < 13.0)].max() > v[t < 7.0].min() + 0.3


@pytest.mark.parametrize(
    ("speed", "ahead", "braking", "behind"),
    [(6.0, 8.5, -2.5, -11.5), (4.0, 7.5, -2.0, -9.0), (10.0, 14.0, -3.0, -14.0), (8.6, 10.8, -2.6, -13.1), (8.9, 10.7, -2.6, -12.7)],
)
def test_in_a_queue_it_stops_as_whoever_follows_does(speed: float, ahead: float, braking: float, behind: float) -> None:
    """Were the follower never to brake, nothing would pass: the plans say so, or that they expect it."""
    stops = ({"start_s": 0.5, "acceleration_mps2": braking},)
    cars = [car("front", ahead, speed, 0.0, stops), car("rear", behind, speed, behaviour="idm")]
    drive = driven(scene(10.0, speed, cars, lanes_left=0, lanes_right=0), 1)
    assert drive.trajectory.speed_mps[-1] < 0.1
    assert any("passes unless" in cycle.plan.reason or "expected to brake" in cycle.plan.reason for cycle in drive.cycles)
