"""The compiled filter and fixes against those on filterpy and numpy, which say what they do."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.measurement import BodyDetection, Mounting, RadarDetection
from mcdas_opt.domain.motion import TargetMotion
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.geometry.window import frame_near
from mcdas_opt.native.form import SWITCH
from mcdas_opt.tracking.compiled_filter import CompiledFiltering, compiled_filtering
from mcdas_opt.tracking.filtering import InterpretedFiltering, build_filtering
from mcdas_opt.tracking.fix import Viewpoint

MOTION = TargetMotion(name="test", acceleration_along_mps2=8.0, acceleration_across_mps2=1.5)
ROADS = (Road(), Road(curvature=((0.0, 0.0), (60.0, 0.01), (200.0, -0.012))))
SIZES = ((4.5, 1.8), (12.0, 2.5), None)
pytestmark = pytest.mark.skipif(compiled_filtering() is None, reason="there is no compiler")


def forms() -> tuple[CompiledFiltering, InterpretedFiltering]:
    quick = compiled_filtering()
    assert quick is not None
    return quick, InterpretedFiltering()


@settings(deadline=None, max_examples=120)
@given(seed=st.integers(0, 10**9), road=st.sampled_from(ROADS), size=st.sampled_from(SIZES), steps=st.integers(1, 6))
def test_both_believe_the_same_after_any_fixes(seed, road, size, steps):
    """Radar points and bodies, younger and a little older than the filter; what they would cost before they are taken in, too."""
    random = np.random.default_rng(seed)
    host = HostState(s_m=random.uniform(0.0, 250.0), d_m=random.uniform(-2.0, 2.0), heading_rad=random.uniform(-0.2, 0.2), speed_mps=20.0)
    frame = frame_near(road, host.s_m)
    view = Viewpoint.of(Mounting(x_m=2.0, yaw_rad=random.choice([0.0, math.pi])), host, Vehicle(), frame)
    start = np.array([host.s_m + random.uniform(-60.0, 60.0), random.uniform(-5.0, 35.0), random.uniform(-4.0, 4.0), random.normal()])
    root = random.standard_normal((4, 4))
    quick, plain = (form.begin(start, root @ root.T + np.eye(4), 0.0, MOTION) for form in forms())
    t = 0.0
    for _ in range(steps):
        t = max(t + random.choice([-0.05, 0.0, 0.05, 0.1, 0.5]), quick.time_s - 0.1)
        if random.random() < 0.3:
            s, d = random.uniform(0.0, 250.0), random.uniform(-4.0, 4.0)
            body = BodyDetection(name="x", s_m=s, d_m=d, speed_s_mps=20.0, speed_d_mps=0.3, length_m=4.5, width_m=1.8)
            fixes = [[form.body_fix(body, frame, 0.1, 0.2)] for form in forms()]
        else:
            points = [
                RadarDetection(
                    range_m=random.uniform(0.0, 120.0), azimuth_rad=random.uniform(-1.2, 1.2), range_rate_mps=random.normal(0.0, 8.0)
                )
                for _ in range(3)
            ]
            fixes = [form.radar_fixes(points, view, frame, size) for form in forms()]
        assert [fix is None for fix in fixes[0]] == [fix is None for fix in fixes[1]]
        for one, other in zip(*fixes, strict=True):
            if one is not None:
                assert one.place == pytest.approx(other.place, abs=1e-9)
        costs = quick.costs(t, fixes[0], 1e6), plain.costs(t, fixes[1], 1e6)
        assert costs[0] == pytest.approx(costs[1], rel=1e-7)
        if fixes[0][0] is not None:
            quick.take(t, fixes[0][0])
            plain.take(t, fixes[1][0])
        for ahead in (0.0, 0.3, -0.05):
            for one, other in zip(quick.at(quick.time_s + ahead), plain.at(plain.time_s + ahead), strict=True):
                np.testing.assert_allclose(one, other, rtol=1e-9, atol=1e-9)
        assert quick.place_at(t + 0.1) == pytest.approx(plain.place_at(t + 0.1), abs=1e-9)
        assert quick.time_s == plain.time_s
        assert (quick.covariance == quick.covariance.T).all()


@settings(deadline=None, max_examples=60)
@given(seed=st.integers(0, 10**9), size=st.sampled_from(SIZES))
def test_left_and_right_are_alike_to_the_bit(seed, size):
    random = np.random.default_rng(seed)
    (r, phi, rate), x = random.uniform((1.0, -1.2, -20.0), (100.0, 1.2, 20.0)), random.uniform((-50, 0, -4, -2), (90, 30, 4, 2))
    frame, beliefs = frame_near(Road(), 0.0), []
    for side in (1.0, -1.0):
        quick, _ = forms()
        view = Viewpoint.of(Mounting(x_m=2.0), HostState(d_m=0.7 * side, heading_rad=0.05 * side, speed_mps=20.0), Vehicle(), frame)
        odd = np.array([1.0, 1.0, side, side])
        filter_ = quick.begin(odd * x, np.diag([1.0, 4.0, 1.0, 1.0]), 0.0, MOTION)
        (fix,) = quick.radar_fixes([RadarDetection(range_m=r, azimuth_rad=side * phi, range_rate_mps=rate)], view, frame, size)
        assert fix is not None
        filter_.take(0.1, fix)
        state, covariance = filter_.at(0.2)
        beliefs.append((odd * state, covariance * np.outer(odd, odd)))
    for one, other in zip(*beliefs, strict=True):
        assert (one == other).all()


def test_without_a_compiler_it_is_filterpy(monkeypatch):
    monkeypatch.setenv(SWITCH, "0")
    assert isinstance(build_filtering(), InterpretedFiltering)
