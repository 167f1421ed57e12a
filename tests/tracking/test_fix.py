"""Detections turned into body centres: exact without noise, and with an honest covariance."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from mcdas_opt.domain.body import Body
from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.measurement import BodyDetection, RadarDetection
from mcdas_opt.domain.rules import Array
from mcdas_opt.domain.sensor import Beam, Sensor
from mcdas_opt.domain.vocabulary import Sector
from mcdas_opt.geometry.window import frame_near
from mcdas_opt.simulation.sensors import mounting
from mcdas_opt.simulation.sight import View
from mcdas_opt.tracking.fix import RadarFix, Viewpoint, body_fix, radar_fixes
from tests.tracking.worlds import BEND, CAR, STRAIGHT

ALL_ROUND = Sensor(
    name="all-round",
    beams=(Beam(name="all", range_max_m=250.0, half_angle_rad=math.pi),),
    range_min_m=0.0,
    rate_hz=20.0,
    range_sd_m=0.25,
    azimuth_sd_rad=0.0087,
    range_rate_sd_mps=0.12,
)
SURE = np.diag([1.0, 1.0, 1.0, 1e-12])  # a belief that knows its lateral speed


def one_fix(body: Body, host: HostState, sector: Sector, road, size: tuple[float, float] | None) -> RadarFix | None:
    place = mounting(sector, CAR)
    seen = View(host, [body], CAR, road).detections(ALL_ROUND, place)
    if not seen:
        return None
    frame = frame_near(road, host.s_m)
    return radar_fixes([seen[0][1]], Viewpoint.of(place, host, CAR, frame), frame, size)[0]


worlds = {
    "s": st.floats(-150.0, 150.0),
    "d": st.floats(-8.0, 8.0),
    "speed": st.floats(0.0, 40.0),
    "host_speed": st.floats(0.0, 40.0),
    "heading": st.floats(-0.2, 0.2),
    "steering": st.floats(-0.1, 0.1),
    "length": st.floats(2.5, 16.0),
    "sector": st.sampled_from(list(Sector)),
}


@settings(deadline=None, max_examples=60)
@given(**worlds)
def test_straight_road_round_trip_is_exact(s, d, speed, host_speed, heading, steering, length, sector) -> None:
    """A car along the road, wherever it is and however the host stands, turns and drives: its centre and its speed come back."""
    host = HostState(s_m=7.0, d_m=0.4, heading_rad=heading, speed_mps=host_speed, steering_rad=steering)
    body = Body(name="a", s_m=7.0 + s, d_m=d, speed_mps=speed, length_m=length, width_m=2.0)
    fix = one_fix(body, host, sector, STRAIGHT, (length, 2.0))
    assume(fix is not None)
    x = np.array([body.s_m, speed, d, 0.0])
    z, H, _ = fix.read((x, SURE))
    np.testing.assert_allclose(z, H @ x, atol=1e-9)
    np.testing.assert_allclose(fix.place, (body.s_m, d), atol=1e-9)


@settings(deadline=None, max_examples=60)
@given(**worlds)
def test_bent_road_round_trip(s, d, speed, host_speed, heading, steering, length, sector) -> None:
    """In a bend the assumed heading is the road's at the centre; a long truck's far centre is found to centimetres."""
    assume(abs(s) > 0.5 * length + 4.0 or abs(d) > 3.5)  # not upon the host
    host = HostState(s_m=120.0, d_m=0.4, heading_rad=heading, speed_mps=host_speed, steering_rad=steering)
    body = Body(name="a", s_m=120.0 + s, d_m=d, speed_mps=speed, length_m=length, width_m=2.0)
    fix = one_fix(body, host, sector, BEND, (length, 2.0))
    assume(fix is not None)
    x = np.array([body.s_m, speed / (1.0 - d * float(BEND.curvature_at(body.s_m))), d, 0.0])
    z, H, _ = fix.read((x, SURE))
    np.testing.assert_allclose(z, H @ x, atol=0.1)


@settings(deadline=None, max_examples=60)
@given(heading=st.floats(-0.3, 0.3), s=st.floats(8.0, 60.0), d=st.floats(-6.0, 6.0), speed=st.floats(5.0, 40.0))
def test_a_believed_heading_is_undone(heading: float, s: float, d: float, speed: float) -> None:
    """A car across the road: once its lateral speed is believed, its centre comes back exactly."""
    body = Body(name="a", s_m=s, d_m=d, heading_rad=heading, speed_mps=speed)
    fix = one_fix(body, HostState(speed_mps=10.0), Sector.FRONT, STRAIGHT, (4.5, 1.8))
    assume(fix is not None)
    x = np.array([s, body.speed_along_mps, d, body.speed_across_mps])
    z, H, _ = fix.read((x, SURE))
    np.testing.assert_allclose(z, H @ x, atol=1e-6)


@pytest.mark.parametrize(
    ("sector", "body", "face"),
    [
        (Sector.FRONT, Body(name="front", s_m=30.0), (30.0 - 2.25, 0.0)),  # its rear bumper
        (Sector.REAR, Body(name="rear", s_m=-30.0), (-30.0 + 2.25, 0.0)),  # its front bumper
        (Sector.LEFT, Body(name="left", s_m=0.0, d_m=3.7), (0.0, 3.7 - 0.9)),  # its right flank
        (Sector.RIGHT, Body(name="right", s_m=0.0, d_m=-3.7), (0.0, -3.7 + 0.9)),
    ],
)
def test_the_point_lies_on_the_face_that_is_seen(sector: Sector, body: Body, face: tuple[float, float]) -> None:
    fix = one_fix(body, HostState(), sector, STRAIGHT, None)  # read as a point target
    assert fix is not None
    np.testing.assert_allclose(fix.place, face, atol=1e-12)


def centre(point: RadarDetection, view: Viewpoint, road) -> Array:
    frame = frame_near(road, view.host_s_m)
    (fix,) = radar_fixes([point], view, frame, (4.5, 1.8))
    assert fix is not None
    return np.array([*fix.place, fix.relative])


@settings(deadline=None, max_examples=60)
@given(
    r=st.floats(3.0, 150.0),
    phi=st.floats(-0.6, 0.6),
    sector=st.sampled_from(list(Sector)),
    road=st.sampled_from([STRAIGHT, BEND]),
)
def test_covariance_is_that_of_the_finite_differences(r: float, phi: float, sector: Sector, road) -> None:
    """R = J diag(sd^2) J' for a car on its way along the road; the line of sight's own error counts for the speed.

    In a bend the line of sight meets another direction of the road where the place is mistaken; that counts too.
    """
    host = HostState(s_m=120.0, speed_mps=15.0, heading_rad=0.02, steering_rad=0.01)
    frame = frame_near(road, host.s_m)
    view = Viewpoint.of(mounting(sector, CAR), host, CAR, frame)
    point = RadarDetection(range_m=r, azimuth_rad=phi, range_rate_mps=-2.0)
    (fix,) = radar_fixes([point], view, frame, (4.5, 1.8))
    assume(fix is not None and abs(fix.place[1]) < 8.0)
    bend = math.atan2(1.8, 4.5)
    assume(abs(abs(math.remainder(fix.bearing_rad, math.pi)) - bend) > 1e-3)  # the corner, where the slope jumps
    x = np.array([fix.place[0], 12.0, fix.place[1], 0.0])
    belief = (x, SURE)

    def residual(range_m: float, azimuth: float) -> Array:
        moved = RadarDetection(range_m=range_m, azimuth_rad=azimuth, range_rate_mps=-2.0)
        (there,) = radar_fixes([moved], view, frame, (4.5, 1.8))
        assert there is not None
        z, H, _ = there.read(belief)
        return z - H @ x

    h = 1e-5
    J = np.column_stack(
        [
            (residual(r + h, phi) - residual(r - h, phi)) / (2 * h),
            (residual(r, phi + h) - residual(r, phi - h)) / (2 * h),
            np.array([0.0, 0.0, 1.0]),
        ]
    )
    expected = J @ np.diag([0.25**2, math.radians(0.5) ** 2, 0.12**2]) @ J.T
    scale = np.sqrt(np.outer(np.diag(expected), np.diag(expected)))
    np.testing.assert_allclose(fix.read(belief).R / scale, expected / scale, atol=1e-4 if road is STRAIGHT else 0.12)


def test_beyond_the_bend_s_centre_there_is_no_road() -> None:
    host = HostState(s_m=120.0)
    frame = frame_near(BEND, host.s_m)
    view = Viewpoint.of(mounting(Sector.LEFT, CAR), host, CAR, frame)
    near, far = (RadarDetection(range_m=r, azimuth_rad=0.0, range_rate_mps=0.0) for r in (20.0, 140.0))
    fixes = radar_fixes([near, far], view, frame, (4.5, 1.8))
    assert fixes[0] is not None
    assert fixes[1] is None
    assert radar_fixes([], view, frame, (4.5, 1.8)) == []


def test_an_ideal_detection_states_the_rate_of_s() -> None:
    """Speed over ground on the inside of a bend is more metres of s a second."""
    kappa = float(BEND.curvature_at(100.0))
    body = BodyDetection(name="a", s_m=100.0, d_m=3.7, speed_s_mps=20.0, speed_d_mps=0.5, length_m=4.5, width_m=1.8)
    fix = body_fix(body, frame_near(BEND, 100.0), 1e-3, 1e-3)
    np.testing.assert_allclose(fix.state, [100.0, 20.0 / (1.0 - 3.7 * kappa), 3.7, 0.5])
