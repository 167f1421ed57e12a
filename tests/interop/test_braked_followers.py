"""Whoever brakes after a lane change is asked again in the same traffic: with the lane change, and without."""

from __future__ import annotations

import pytest

pytest.importorskip("libsumo")

from benchmarks.braked_followers import Braking, Pose, brakings, told
from mcdas_opt.interop.sumo.episode import EpisodeSettings, sumo_config


def test_the_same_traffic_comes_about_again_and_another_where_the_host_keeps_its_lane() -> None:
    changes, found = brakings(EpisodeSettings(config=sumo_config("motorway"), ego="ego"), (276, "sumo"))
    assert changes >= len(found) > 0
    for one in found:
        assert one.again_mps2 == pytest.approx(one.driven_mps2, abs=1e-6)
    assert any(abs(one.kept_mps2 - one.again_mps2) > 0.1 for one in found)


def test_a_pose_moves_across_the_road_and_then_looks_along_it() -> None:
    north = Pose(10.0, 20.0, 3.0).beside(2.0, road_yaw_rad=1.5707963267948966)
    assert (north.x_m, north.y_m, north.angle_deg) == pytest.approx((8.0, 20.0, 0.0), abs=1e-9)


def test_who_brakes_only_since_the_host_changed_is_counted_apart() -> None:
    def braking(driven: float, kept: float) -> Braking:
        at = {"time_s": 0.0, "gap_m": 1.0, "host_mps": 1.0, "follower_mps": 1.0}
        return Braking(seed=1, driver="mpc", mode="cruise", follower="a", driven_mps2=driven, again_mps2=driven, kept_mps2=kept, **at)

    text = told("mpc", 10, [braking(-4.5, -4.5), braking(-4.5, -1.0), braking(-5.0, 0.0), braking(-1.0, -6.0), braking(-1.0, 0.0)])
    counts = [line.split(" of ")[0].split()[-1] for line in text.splitlines()[1:]]
    assert counts == ["3", "3", "2", "2", "1"]
