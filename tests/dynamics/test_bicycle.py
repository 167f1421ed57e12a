"""The bicycle against geometry, against itself in two frames, and against scipy on a right side written from another form of it."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from mcdas_opt.domain.road import Road
from mcdas_opt.dynamics.bicycle import bicycle, lateral_acceleration, road_bicycle
from mcdas_opt.dynamics.integrator import rk4
from mcdas_opt.geometry.frenet import FrenetFrame

L, CENTRE = 2.7, 1.35
STRAIGHT = Road()
CURVED = Road(curvature=((0.0, -0.02), (120.0, 0.03)))  # no knot on the way: there a Runge-Kutta step loses its order
speeds = st.floats(0.5, 35.0)
angles = st.floats(-0.5, 0.5)


def in_the_plane(x0, u, times):
    """Rear axle (x, y, yaw, v, delta) at `times` under constant acceleration and steering rate, by Runge-Kutta."""
    path = [list(x0)]
    for h in np.diff(times):
        x = path[-1]
        for _ in range(20):
            x = rk4(lambda q: bicycle(q, u, L, math), x, h / 20)
        path.append(x)
    return np.array(path)


def along_the_road(x0, u, times, road):
    """(s, d, psi, v, a, delta) at `times` under constant jerk and steering rate, by Runge-Kutta."""
    path = [list(x0)]
    for h in np.diff(times):
        x = path[-1]
        for _ in range(20):
            x = rk4(lambda q: road_bicycle(q, u, float(road.curvature_at(q[0])), L, CENTRE, math), x, h / 20)
        path.append(x)
    return np.array(path)


@given(v=speeds, delta=st.one_of(st.floats(0.02, 0.5), st.floats(-0.5, -0.02)), yaw=st.floats(-3.0, 3.0))
def test_constant_steering_drives_a_circle_of_radius_l_over_tan_delta(v, delta, yaw):
    radius = L / math.tan(delta)
    path = in_the_plane([1.0, 2.0, yaw, v, delta], (0.0, 0.0), np.linspace(0.0, 0.8, 9))
    centre = np.array([1.0 - radius * math.sin(yaw), 2.0 + radius * math.cos(yaw)])
    assert np.hypot(*(path[:, :2] - centre).T) == pytest.approx(abs(radius), rel=1e-6)
    assert path[-1, 2] - yaw == pytest.approx(0.8 * v / radius, rel=1e-9)


@given(v=speeds, a=st.floats(-3.0, 3.0), yaw=st.floats(-3.0, 3.0))
def test_wheels_straight_drive_straight(v, a, yaw):
    t = np.linspace(0.0, 1.0, 6)
    path = in_the_plane([0.0, 0.0, yaw, v, 0.0], (a, 0.0), t)
    way = v * t + 0.5 * a * t**2
    assert path[:, 0] == pytest.approx(way * math.cos(yaw), abs=1e-9)
    assert path[:, 1] == pytest.approx(way * math.sin(yaw), abs=1e-9)


@settings(max_examples=20, deadline=None)
@given(
    v=speeds,
    a=st.floats(-3.0, 3.0),
    delta=st.floats(-0.15, 0.15),
    rate=st.floats(-0.1, 0.1),
    d=st.floats(-1.5, 1.5),
    psi=st.floats(-0.2, 0.2),
)
@pytest.mark.parametrize("road", [STRAIGHT, CURVED], ids=["straight", "curved"])
def test_along_the_road_and_in_the_plane_are_the_same_motion(road, v, a, delta, rate, d, psi):
    frame = FrenetFrame(road=road, s_min_m=-50.0, s_max_m=300.0)
    times = np.linspace(0.0, 2.0, 21)
    if v + 2.0 * a < 0.0:
        a = 0.0
    on_road = along_the_road([5.0, d, psi, v, a, delta], (0.0, rate), times, road)
    x, y, yaw = (float(q[0]) for q in frame.to_plane(*(np.array([q]) for q in (5.0, d, psi))))
    rear = [x - CENTRE * math.cos(yaw), y - CENTRE * math.sin(yaw), yaw, v, delta]
    plane = in_the_plane(rear, (a, rate), times)
    inside = np.cumprod(np.abs(on_road[:, 1]) < 10.0).astype(bool)  # far off, the frame nears its fold
    px, py, pyaw = frame.to_plane(*on_road[inside, :3].T)
    centre_x = plane[inside, 0] + CENTRE * np.cos(plane[inside, 2])
    centre_y = plane[inside, 1] + CENTRE * np.sin(plane[inside, 2])
    assert px == pytest.approx(centre_x, abs=1e-6)
    assert py == pytest.approx(centre_y, abs=1e-6)
    assert pyaw == pytest.approx(plane[inside, 2], abs=1e-6)


@settings(max_examples=15, deadline=None)
@given(v=speeds, jerk=st.floats(-4.0, 4.0), delta=st.floats(-0.1, 0.1), rate=st.floats(-0.1, 0.1), d=st.floats(-1.5, 1.5))
@pytest.mark.parametrize("road", [STRAIGHT, CURVED], ids=["straight", "curved"])
def test_scipy_on_the_slip_angle_form_agrees(road, v, jerk, delta, rate, d):
    """The same model as textbooks write it at the body centre: course psi + beta, speed v / cos(beta), tan(beta) = (l_r / L) tan(delta)."""
    times = np.linspace(0.0, 1.0, 6)
    knots = np.array(road.curvature)

    def right_side(t, x):
        s, d, psi, v, a, delta = x
        beta = math.atan(CENTRE / L * math.tan(delta))
        kappa = np.interp(s, knots[:, 0], knots[:, 1])
        over_ground = v / math.cos(beta)
        s_dot = over_ground * math.cos(psi + beta) / (1.0 - d * kappa)
        return [s_dot, over_ground * math.sin(psi + beta), over_ground * math.sin(beta) / CENTRE - kappa * s_dot, a, jerk, rate]

    x0 = [10.0, d, 0.05, v, 1.0, delta]
    truth = solve_ivp(right_side, (0.0, 1.0), x0, t_eval=times, rtol=1e-10, atol=1e-11, max_step=0.02).y.T
    ours = along_the_road(x0, (jerk, rate), times, road)
    assert ours == pytest.approx(truth, abs=1e-6)


@given(v=speeds, delta=angles, psi=angles, d=st.floats(-3.0, 3.0), kappa=st.floats(-0.05, 0.05), rate=angles, jerk=st.floats(-10.0, 10.0))
def test_mirrored_road_and_car_mirror_the_motion(v, delta, psi, d, kappa, rate, jerk):
    one = road_bicycle((0.0, d, psi, v, 1.0, delta), (jerk, rate), kappa, L, CENTRE, math)
    other = road_bicycle((0.0, -d, -psi, v, 1.0, -delta), (jerk, -rate), -kappa, L, CENTRE, math)
    signs = np.array([1.0, -1.0, -1.0, 1.0, 1.0, -1.0])
    assert np.array(other) == pytest.approx(signs * np.array(one), abs=1e-12)


def test_lateral_acceleration_is_that_of_the_circle():
    v, delta = np.array([3.0, 11.0, 30.0]), np.array([-0.3, 0.1, 0.02])
    assert lateral_acceleration(v, delta, L, np) == pytest.approx(v**2 / (L / np.tan(delta)))
