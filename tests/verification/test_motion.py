"""The judge's own integration against scipy's, on a right side written by hand."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from mcdas_opt.geometry.frenet import FrenetFrame
from mcdas_opt.verification.finding import Findings
from mcdas_opt.verification.motion import FINE_STEP_S, drive
from mcdas_opt.verification.record import Samples
from tests.verification.rollouts import SEDAN, WIDE, WIDE_CURVED, legal


@settings(max_examples=8, deadline=None)
@given(seed=st.integers(0, 10**9))
@pytest.mark.parametrize("road", [WIDE, WIDE_CURVED], ids=["straight", "curved"])
def test_fine_poses_are_scipys(road, seed):
    """In the plane, at the body centre: course yaw + beta, yaw rate V sin(beta) / l_r with tan(beta) = (l_r / L) tan(delta)."""
    trajectory = legal(seed, road, duration_s=2.0).trajectory
    frame = FrenetFrame(road=road)
    found = Findings(1)
    motion = drive(Samples.of([trajectory.table]), SEDAN, frame, found)
    assert found.of == [[]]
    assert np.diff(motion.node_t_s).max() <= FINE_STEP_S + 1e-9

    def right_side(_, q, jerk, rate):
        _, _, yaw, v, a, delta = q
        beta = math.atan(SEDAN.centre_m / SEDAN.wheelbase_m * math.tan(delta))
        over_ground = v / math.cos(beta)
        course = yaw + beta
        return [
            over_ground * math.cos(course),
            over_ground * math.sin(course),
            over_ground * math.sin(beta) / SEDAN.centre_m,
            a,
            jerk,
            rate,
        ]

    x, y, yaw = frame.to_plane(trajectory.s_m, trajectory.d_m, trajectory.heading_rad)
    for k in range(len(trajectory) - 1):
        inside = (motion.node_t_s >= trajectory.t_s[k] - 1e-9) & (motion.node_t_s < trajectory.t_s[k + 1] - 1e-9)
        at = np.append(motion.node_t_s[inside], motion.middle_t_s[inside[:-1]])
        order = np.argsort(at)
        begin = [x[k], y[k], yaw[k], *trajectory.states[k, 3:]]
        truth = solve_ivp(
            right_side,
            (trajectory.t_s[k], trajectory.t_s[k + 1]),
            begin,
            "DOP853",
            at[order],
            args=tuple(trajectory.inputs[k]),
            rtol=1e-10,
            atol=1e-10,
        ).y[:3]
        ours = np.array(
            [
                np.append(node[0, inside], middle[0, inside[:-1]])[order]
                for node, middle in (
                    (motion.node_x_m, motion.middle_x_m),
                    (motion.node_y_m, motion.middle_y_m),
                    (motion.node_yaw_rad, motion.middle_yaw_rad),
                )
            ]
        )
        # the drive was made by Runge-Kutta along the road, whose knots cost it a little; the poses are bent to meet its samples
        assert ours == pytest.approx(truth, abs=1e-6 if road.is_straight else 2e-5)


@settings(max_examples=20, deadline=None)
@given(seed=st.integers(0, 10**9), shift=st.floats(-0.004, 0.004))
def test_fine_poses_pass_through_every_sample(seed, shift):
    trajectory = legal(seed).trajectory
    d = trajectory.d_m.copy()
    d[1::2] += shift
    crooked = legal(seed).with_columns(d_m=d).trajectory
    motion = drive(Samples.of([crooked.table]), SEDAN, FrenetFrame(road=WIDE), Findings(1))
    at = np.searchsorted(motion.node_t_s, crooked.t_s - 1e-9)
    assert motion.node_x_m[0, at] == pytest.approx(crooked.s_m, abs=1e-12)
    assert motion.node_y_m[0, at] == pytest.approx(crooked.d_m, abs=1e-12)
    assert np.abs(np.diff(motion.node_y_m)).max() < 1.0
