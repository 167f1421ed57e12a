"""What a car can drive is never refused."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from mcdas_opt.catalogue.vehicles import load_vehicle
from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.trajectory import Trajectory
from tests.verification.rollouts import NOBODY, SEDAN, WIDE, WIDE_CURVED, Drive, legal, straight_on

seeds = st.integers(0, 10**9)
both_roads = pytest.mark.parametrize("road", [WIDE, WIDE_CURVED], ids=["straight", "curved"])


@settings(max_examples=60, deadline=None)
@given(seed=seeds)
@both_roads
def test_no_legal_drive_is_refused(road, seed):
    verdict = legal(seed, road).verdict()
    assert verdict.passed, verdict.reason


@settings(max_examples=10, deadline=None)
@given(seed=seeds)
@pytest.mark.parametrize("name", ["lincoln_mkz", "bmw_320i"])
def test_nor_with_another_car(name, seed):
    verdict = legal(seed, WIDE, load_vehicle(name)).verdict()
    assert verdict.passed, verdict.reason


@settings(max_examples=10, deadline=None)
@given(seed=seeds)
@both_roads
def test_what_scipy_integrates_from_a_hand_written_right_side_passes(road, seed):
    """Slip-angle form of the bicycle at the body centre, in the plane for the straight road and along the road for the curved one."""
    drive = legal(seed, road, duration_s=2.0)
    t, u = drive.trajectory.t_s, drive.trajectory.inputs
    knots = np.array(road.curvature)

    def right_side(_, x, jerk, rate):
        s, d, psi, v, a, delta = x
        beta = math.atan(SEDAN.centre_m / SEDAN.wheelbase_m * math.tan(delta))
        over_ground = v / math.cos(beta)
        kappa = np.interp(s, knots[:, 0], knots[:, 1])
        s_dot = over_ground * math.cos(psi + beta) / (1.0 - d * kappa)
        return [s_dot, over_ground * math.sin(psi + beta), over_ground * math.sin(beta) / SEDAN.centre_m - kappa * s_dot, a, jerk, rate]

    rows = [drive.start.to_vector()]
    for k, h in enumerate(np.diff(t)):
        rows.append(solve_ivp(right_side, (0.0, h), rows[-1], args=tuple(u[k]), rtol=1e-9, atol=1e-10, max_step=0.02).y[:, -1])
    truth = Trajectory.from_states(t, np.array(rows), u)
    assert truth.states == pytest.approx(drive.trajectory.states, abs=2e-5)  # the family itself is sound, over a knot too
    verdict = replace(drive, trajectory=truth).verdict()
    assert verdict.passed, verdict.reason


@settings(max_examples=15, deadline=None)
@given(seed=seeds)
def test_three_decimals_of_a_file_are_enough(seed):
    drive = legal(seed)
    columns = {
        name: np.round(values, 4 if name in ("steering_rad", "heading_rad") else 3) for name, values in drive.trajectory.to_dict().items()
    }
    columns["steering_rate_radps"] = drive.trajectory.steering_rate_radps
    verdict = drive.with_columns(**columns).verdict()
    assert verdict.passed, verdict.reason


@pytest.mark.parametrize("a", [-2.0, -5.0, -8.0])
def test_a_stop_ends_at_once_at_standstill(a):
    """Braking to rest and standing there: the jump of acceleration at standstill is the brakes' hold, wherever in an interval it falls."""
    for extra in np.linspace(0.0, 0.099, 7):
        drive = stopping(a, extra)
        verdict = drive.verdict()
        assert verdict.passed, (extra, verdict.reason)


def test_but_deceleration_does_not_end_at_once_while_the_car_moves():
    drive = stopping(-5.0, 0.03)
    a = drive.trajectory.acceleration_mps2.copy()
    first = int(np.flatnonzero(drive.trajectory.speed_mps < 2.0)[0])
    a[first:] = 0.0
    assert "dynamics residual" in [v.name for v in drive.with_columns(acceleration_mps2=a).verdict().violations]


def test_a_stop_and_a_start_again_is_one_drive():
    drive = stopping(-4.0, 0.05)
    t, x, u = drive.trajectory.t_s, drive.trajectory.states, drive.trajectory.inputs.copy()
    more = np.round(t[-1] + 0.1 * np.arange(1, 11), 9)
    tau = more - t[-1]
    again = np.tile(x[-1], (10, 1))
    again[:, 4], again[:, 3], again[:, 0] = 2.0 * tau, tau**2, x[-1, 0] + tau**3 / 3.0
    u[-1] = (2.0, 0.0)
    longer = Trajectory.from_states(np.concatenate([t, more]), np.vstack([x, again]), np.vstack([u, np.tile([2.0, 0.0], (10, 1))]))
    verdict = replace(drive, trajectory=longer).verdict()
    assert verdict.passed, verdict.reason


def test_a_parked_car_may_stay():
    assert straight_on(speed=0.0).verdict().passed


@pytest.mark.parametrize("road", [WIDE, WIDE_CURVED], ids=["straight", "curved"])
def test_where_a_trajectory_begins_is_free_without_a_measured_state(road):
    assert replace(legal(7, road), start=None).verdict().passed


def stopping(a: float, extra_s: float) -> Drive:
    """From 5 m/s at constant deceleration to a stop, which falls `extra_s` after a sample, and a second of standing; closed form."""
    v0 = 5.0
    stop = v0 / -a
    v0 += -a * ((extra_s - stop) % 0.1)
    stop = v0 / -a
    t = np.round(0.1 * np.arange(math.ceil(stop / 0.1) + 11), 9)
    driving = np.minimum(t, stop)
    x = np.zeros((t.size, 6))
    x[:, 0] = v0 * driving + 0.5 * a * driving**2
    x[:, 3] = np.maximum(v0 + a * driving, 0.0)
    x[:, 4] = np.where(t < stop - 1e-9, a, 0.0)
    trajectory = Trajectory.from_states(t, x, np.zeros((t.size - 1, 2)))
    start = HostState(speed_mps=v0, acceleration_mps2=a)
    return Drive(trajectory=trajectory, start=start, vehicle=SEDAN, road=WIDE, prediction=NOBODY)
