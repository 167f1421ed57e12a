"""A planner that is copied, or sent to another process, goes on as it would have, and the one that was copied is left alone."""

from __future__ import annotations

import copy
import math
import pickle
from collections.abc import Callable

import numpy as np
import pytest

from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.measurement import Mounting, RadarDetection, Scan
from mcdas_opt.domain.plan import Plan
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.vocabulary import Sector
from mcdas_opt.planning.planner import Planner

_ROAD = Road(lanes_left=1, curvature=((0.0, 0.0), (60.0, 0.002)))


def planner(method: str) -> Planner:
    return Planner(method=method, road=_ROAD)


def asked(of: Planner, cycles: range) -> list[Plan]:
    """A car ahead is slower, one behind faster; the host goes on at 20 m/s, whatever is planned."""
    plans = []
    for k in cycles:
        t_s, noise = 0.1 * k, np.random.default_rng(k).normal(0.0, 0.05, 4)
        front = RadarDetection(range_m=45.0 - 7.0 * t_s + noise[0], azimuth_rad=0.0, range_rate_mps=-7.0 + noise[1])
        rear = RadarDetection(range_m=40.0 - 5.0 * t_s + noise[2], azimuth_rad=0.0, range_rate_mps=-5.0 + noise[3])
        scans = [
            Scan(sensor="front", sector=Sector.FRONT, t_s=t_s, mounting=Mounting(x_m=2.3), radar=(front,)),
            Scan(sensor="rear", sector=Sector.REAR, t_s=t_s, mounting=Mounting(x_m=-2.3, yaw_rad=math.pi), radar=(rear,)),
        ]
        plans.append(of.step(scans, HostState(s_m=20.0 * t_s, speed_mps=20.0), t_s, desired_speed_mps=20.0))
    return plans


@pytest.mark.parametrize("method", ["mpc", "closed-form-corrected", "idm-mobil"])
@pytest.mark.parametrize("again", [copy.deepcopy, lambda one: pickle.loads(pickle.dumps(one))], ids=["copied", "pickled"])
def test_a_copy_goes_on_as_its_planner_would_have(method: str, again: Callable[[Planner], Planner]) -> None:
    here, alone = planner(method), planner(method)
    assert [plan.chosen for plan in asked(here, range(12))] == [plan.chosen for plan in asked(alone, range(12))]
    other = again(here)
    theirs, ours, as_alone = (asked(one, range(12, 30)) for one in (other, here, alone))
    assert all(len(plan.situation.tracks) == 2 for plan in ours)
    for plan, twin, copied in zip(ours, as_alone, theirs, strict=True):
        assert plan.trajectory.table.tobytes() == twin.trajectory.table.tobytes()
        assert (copied.status, copied.mode, copied.side, copied.chosen) == (plan.status, plan.mode, plan.side, plan.chosen)
        assert np.abs(copied.trajectory.table[1:3] - plan.trajectory.table[1:3]).max() < 0.02
