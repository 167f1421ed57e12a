"""Between two cars that cannot both be kept clear of, the host does not weave."""

from __future__ import annotations

import numpy as np
import pytest

from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.situation import Coverage, Situation
from mcdas_opt.domain.track import Track
from mcdas_opt.domain.vocabulary import Status
from mcdas_opt.planning.planner import Planner

SD = np.array([0.2, 0.15, 0.15, 0.1])
CYCLE_S = 0.1


@pytest.mark.parametrize("seed", [1, 2, 3, 4])
def test_no_weaving_where_nothing_passes(seed: int) -> None:
    """One lane, 30 m behind somebody at 14 m/s, and somebody 60 m behind at 29 m/s."""
    planner, host, rng = Planner(), HostState(speed_mps=14.0), np.random.default_rng(seed)
    offsets, unavoidable = [0.0], 0
    for k in range(45):
        t = k * CYCLE_S
        tracks = []
        for name, s_m, speed_mps in (("rear", -60.0 + 29.0 * t, 29.0), ("lead", 30.0 + 14.0 * t, 14.0)):
            s, d, along, across = np.array([s_m, 0.0, speed_mps, 0.0]) + rng.normal(size=4) * SD
            told = {"speed_s_mps": along, "speed_d_mps": across, "covariance": np.diag(SD**2), "length_m": 4.5, "width_m": 1.8}
            told |= {"acceleration_s_mps2": 0.3 * rng.normal(), "acceleration_s_sd_mps2": 0.3}
            tracks.append(Track(id=name, s_m=s, d_m=d, **told))
        situation = Situation(time_s=round(t, 6), host=host, tracks=tuple(tracks), road=Road(), coverage=Coverage(), desired_speed_mps=14.0)
        plan = planner.plan(situation)
        unavoidable += plan.status is Status.UNAVOIDABLE
        host = HostState.from_vector(plan.trajectory.states[1])
        offsets.append(host.d_m)
    assert unavoidable > 15
    assert np.abs(np.diff(offsets)).sum() < 0.9  # 1.1 to 1.9 m before
