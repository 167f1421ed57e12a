"""Scenarios with another driver's place for the ego: what is asked for is what he drove, wherever the map lies."""

from __future__ import annotations

import warnings
from pathlib import Path

import numpy as np
import pytest

from benchmarks.commonroad_egos import rewritten
from mcdas_opt.interop.commonroad.scenario import CommonRoadScene, read_scenario
from tests.interop.test_commonroad import written

pytest.importorskip("commonroad")
pytest.importorskip("defusedxml")
_WRITTEN_M = 2e-3  # the writer rounds to 0.1 mm, and lanelets are looked at from far away


def read(folder: Path, turned: bool) -> CommonRoadScene:
    warnings.simplefilter("ignore")
    out = folder / f"turned-{turned}"
    out.mkdir()
    (file,) = rewritten(written(folder), out, each=3, least_s=4.0, turned=turned, random=np.random.default_rng(1))
    return read_scenario(file)


def test_the_ego_begins_where_he_began_and_is_to_go_where_he_went(tmp_path: Path) -> None:
    it = read(tmp_path, turned=False)
    assert (it.scene.host.speed_mps, it.scene.host.d_m) == pytest.approx((8.0, 0.0), abs=_WRITTEN_M)
    assert it.obstacles == {"obstacle-8": 8}  # he is gone, the parked car is not
    assert it.goal_is_off == ""
    wanted = it.scene.destination
    assert wanted is not None
    assert wanted.s_m == pytest.approx((32.0 - 3.5, 32.0 + 3.5), abs=0.1)
    assert wanted.time_s == pytest.approx((2.4, 8.0))


def test_a_map_that_is_turned_and_moved_far_away_is_the_same_scene(tmp_path: Path) -> None:
    here, far = (read(tmp_path, turned) for turned in (False, True))
    assert far.placement.x_m > 1e5
    assert far.scene.host.d_m == pytest.approx(here.scene.host.d_m, abs=_WRITTEN_M)
    assert far.scene.host.heading_rad == pytest.approx(here.scene.host.heading_rad, abs=1e-3)
    for one, other in zip(here.scene.neighbour, far.scene.neighbour, strict=True):
        assert one.samples == pytest.approx(other.samples, abs=_WRITTEN_M)
    assert here.scene.road.lane
    for one, other in zip(here.scene.road.lane, far.scene.road.lane, strict=True):
        np.testing.assert_allclose(one.width_m, other.width_m, atol=_WRITTEN_M)
