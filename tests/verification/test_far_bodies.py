"""Bodies that the fast accept looks at no closer, being far before or behind: it says of them what the array operations say."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mcdas_opt.catalogue.vehicles import load_vehicle
from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.prediction import CruisingBody, Prediction
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.trajectory import Trajectory
from mcdas_opt.geometry.frenet import FrenetFrame
from mcdas_opt.native.library import library
from mcdas_opt.verification.bodies import ALONG_REACHES
from mcdas_opt.verification.conservative_accept import doubtful_bodies, rows_of, rules_of
from mcdas_opt.verification.judge import judge

SEDAN = load_vehicle("sedan")
needs_compiler = pytest.mark.skipif(library() is None, reason="there is no native library")


def steady(v: float) -> Trajectory:
    t = np.round(np.arange(41) * 0.1, 9)
    zero = np.zeros_like(t)
    return Trajectory.from_states(t, np.column_stack([v * t, zero, zero, np.full_like(t, v), zero, zero]), np.zeros((40, 2)))


@needs_compiler
@given(
    host=st.floats(0.0, 30.0),
    s=st.floats(-80.0, 80.0),
    d=st.floats(-8.0, 8.0),
    along=st.floats(-5.0, 45.0),
    across=st.floats(-4.0, 4.0),
    swell=st.sampled_from([0.0, 1.0, 20.0]),
    rate=st.sampled_from([0.0, -9.0, -3.0, 3.0]),
    lasting=st.sampled_from([0.5, 1.0, 4.0]),
)
def test_who_drives_through_the_host_is_never_far(
    host: float, s: float, d: float, along: float, across: float, swell: float, rate: float, lasting: float
) -> None:
    body = CruisingBody(
        id="other",
        length_m=4.5,
        width_m=1.8,
        s_m=s,
        d_m=d,
        speed_s_mps=along,
        speed_d_mps=across,
        covariance=np.zeros((4, 4)),
        lateral_swell=swell,
        acceleration_mps2=rate,
        changing_s=lasting,
    )
    road, drive = Road(lanes_left=2, lanes_right=2), steady(host)
    start, prediction = HostState(speed_mps=host), Prediction(name="test", bodies=(body,))
    compiled, rows = library(), rows_of((body,))
    assert compiled is not None
    said = doubtful_bodies(compiled, drive.table, start, rules_of(SEDAN, road, ALONG_REACHES), rows, FrenetFrame(road=road)) == []
    fine = np.linspace(0.0, 4.0, 801)
    motion = body.at(fine)
    touching = (np.abs(motion.s_m - host * fine) < 3.0) & (np.abs(motion.d_m) < 1.0)
    if touching.any():
        assert not said
    if np.all(np.abs(motion.s_m - host * fine) > 45.0) and abs(across) * (1.0 + swell) < 20.0:
        assert said
    if said:
        assert judge(drive, start, SEDAN, road, prediction).passed
