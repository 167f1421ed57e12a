"""The measures of ordinary driving, on drives whose figures are known."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from mcdas_opt.catalogue.scenes import load_scene
from mcdas_opt.dynamics.car_following import iso_15622_limits
from mcdas_opt.simulation.loop import simulate
from mcdas_opt.simulation.ordinary import (
    OWED_S,
    Instant,
    Leader,
    Placed,
    beyond_iso,
    instant,
    instants_of,
    made_by_others,
    ordinary_driving,
    outside_iso,
)


def drive(leader: Callable[[float], Leader | None], seconds: float = 20.0, speed: float = 20.0) -> list[Instant]:
    times = np.round(np.arange(0.0, seconds, 0.1), 9).tolist()
    return [Instant(time_s=t, speed_mps=speed, acceleration_mps2=0.0, lane=0, leader=leader(t)) for t in times]


def test_a_steady_gap_is_a_steady_headway() -> None:
    found = ordinary_driving(drive(lambda t: Leader(id="x", gap_m=8.0, speed_mps=20.0)))
    assert found.mean_speed_mps == pytest.approx(20.0)
    assert found.following_s == pytest.approx(20.0)
    assert found.short_headway_s == pytest.approx((0.0, 20.0, 20.0))
    assert found.least_headway_s == pytest.approx(0.4)
    assert (found.least_time_to_collision_s, found.near_misses, found.outside_iso_s) == (None, (), 0.0)


def test_what_a_cut_in_took_is_others_for_a_while_and_what_a_lane_change_took_is_own() -> None:
    cut = drive(lambda t: Leader(id="far", gap_m=60.0, speed_mps=20.0) if t < 5.0 else Leader(id="near", gap_m=8.0, speed_mps=20.0), 30.0)
    found = ordinary_driving(cut)
    assert found.short_headway_any_s == pytest.approx(25.0)
    assert found.short_headway_s[-1] == pytest.approx(25.0 - OWED_S, abs=0.11)
    changed = [one if one.time_s < 5.0 else replace(one, lane=1) for one in cut]
    assert ordinary_driving(changed).short_headway_s[-1] == pytest.approx(25.0)
    left = drive(lambda t: Leader(id="near" if t < 5.0 else "far", gap_m=8.0 if t < 5.0 else 60.0, speed_mps=20.0))
    assert not any(made_by_others(left))


def test_a_follower_counts_who_brakes_around_a_lane_change() -> None:
    def at(t: float, braked_s: float) -> Instant:
        braking = {"rear": -5.0 if abs(t - braked_s) < 0.05 else 0.0}
        return Instant(time_s=t, speed_mps=20.0, acceleration_mps2=0.0, lane=int(t >= 10.0), follower="rear", accelerations_mps2=braking)

    times = np.round(np.arange(0.0, 20.0, 0.1), 9).tolist()
    for braked_s, counts in ((7.5, 0), (8.5, 1), (12.5, 1), (13.5, 0)):
        found = ordinary_driving([at(t, braked_s) for t in times])
        assert (found.lane_changes, found.followers_braked) == (1, counts)


def test_one_near_miss_for_each_time_under_the_limit() -> None:
    closing = drive(lambda t: Leader(id="x", gap_m=abs(10.0 - t) * 10.0 + 2.0, speed_mps=10.0))
    found = ordinary_driving(closing)
    assert [(miss.time_s, miss.other) for miss in found.near_misses] == [(pytest.approx(10.0), "x")]
    assert found.least_time_to_collision_s == pytest.approx(0.2)


def test_in_the_lane_is_whose_centre_is_in_it_or_who_reaches_over() -> None:
    host = Placed(id="host", s_m=0.0, d_m=0.0, speed_mps=20.0, length_m=4.0, width_m=1.8, lane=0)
    beside = replace(host, id="beside", s_m=20.0, d_m=3.5, lane=1)
    over, ahead = replace(beside, id="over", d_m=1.7), replace(host, id="ahead", s_m=30.0)
    assert instant(0.0, host, [beside, ahead]).leader == Leader(id="ahead", gap_m=26.0, speed_mps=20.0)
    assert instant(0.0, host, [over, ahead]).leader == Leader(id="over", gap_m=16.0, speed_mps=20.0)
    cyclist = replace(host, id="cyclist", s_m=10.0, d_m=-1.3, width_m=0.6, length_m=2.0)
    assert instant(0.0, host, [cyclist]).leader == Leader(id="cyclist", gap_m=7.0, speed_mps=20.0)
    assert instant(0.0, replace(host, d_m=0.3), [cyclist, ahead]).leader == Leader(id="ahead", gap_m=26.0, speed_mps=20.0)


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_who_will_have_cleared_the_way_is_not_met_and_who_comes_straight_at_the_host_is(side: float) -> None:
    """An oncoming car keeps to its own road where the host's turns off: it lies aslant in the host's lane, and is across it in time."""
    host = Placed(id="host", s_m=0.0, d_m=0.0, speed_mps=9.0, length_m=4.0, width_m=1.8, lane=0)
    straight = replace(host, id="straight", s_m=29.0, heading_rad=np.pi, speed_mps=-10.0)
    across = replace(straight, id="across", d_m=side * 1.0, heading_rad=np.pi - side * 0.5)
    into = replace(straight, id="into", d_m=side * 1.5, heading_rad=np.pi + side * 0.1)
    assert instant(0.0, host, [straight]).time_to_collision_s == pytest.approx(25.0 / 19.0)
    assert instant(0.0, host, [across]).leader is None
    assert instant(0.0, host, [into]).time_to_collision_s == pytest.approx(25.0 / 19.0)
    ahead = replace(host, id="ahead", s_m=40.0)
    assert instant(0.0, host, [across, ahead]).leader == Leader(id="ahead", gap_m=36.0, speed_mps=9.0)
    leaving = replace(ahead, heading_rad=side * 0.5)
    assert instant(0.0, host, [leaving]).leader == Leader(id="ahead", gap_m=36.0, speed_mps=9.0)


def test_behind_is_whose_centre_is_in_the_lane_not_who_is_left_in_the_old_one() -> None:
    host = Placed(id="host", s_m=0.0, d_m=1.8, speed_mps=20.0, length_m=4.0, width_m=1.8, lane=1)
    left, new = replace(host, id="left", s_m=-10.0, d_m=0.1, lane=0), replace(host, id="new", s_m=-30.0, d_m=3.5)
    assert instant(0.0, host, [left, new]).follower == "new"
    assert instant(0.0, host, [left]).follower is None
    assert instant(0.0, host, [replace(host, id="rear", s_m=-9.0), replace(host, id="last", s_m=-19.0)]).follower == "rear"


def test_iso_15622_is_stricter_the_faster() -> None:
    assert [iso_15622_limits(v) for v in (0.0, 5.0, 12.5, 20.0, 40.0)] == [
        (4.0, 5.0, 5.0), (4.0, 5.0, 5.0), (3.0, 4.25, 3.75), (2.0, 3.5, 2.5), (2.0, 3.5, 2.5)
    ]  # fmt: skip
    t = np.arange(0.0, 10.0, 0.1)
    for braking, fast, slow in ((3.4, False, False), (3.7, True, False), (5.2, True, True)):
        for speed, outside in ((25.0, fast), (3.0, slow)):
            assert bool(outside_iso(t, np.full_like(t, speed), np.full_like(t, -braking))[:50].any()) is outside
        accelerating, braked, jolt = beyond_iso(t, np.full_like(t, 25.0), np.full_like(t, -braking))[:, :50]
        assert braked == pytest.approx(braking - 3.5)
        assert accelerating == pytest.approx(-braking - 2.0)
        assert jolt == pytest.approx(-2.5)
    assert outside_iso(t, np.full_like(t, 25.0), np.where(t < 5.0, 0.0, -3.0)).any()  # a jolt
    assert not outside_iso(t, np.full_like(t, 25.0), -3.0 * np.clip(t / 2.0, 0.0, 1.0)).any()


def test_a_drive_of_ours_is_measured_alike() -> None:
    run = simulate(load_scene("stopped-obstacle"), "aeb")
    instants = instants_of(run)
    found = ordinary_driving(instants)
    assert found.duration_s == pytest.approx(run.duration_s, abs=0.1)
    assert found.distance_m == pytest.approx(float(run.trajectory.s_m[-1] - run.trajectory.s_m[0]), rel=0.02)
    assert found.least_time_to_collision_s == pytest.approx(run.min_ttc_front_s, rel=0.1)
