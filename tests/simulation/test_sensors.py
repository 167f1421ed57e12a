"""Simulated sensors: rates, seeds, fields of view, hidden bodies, and range rates that are the ranges' rates."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from mcdas_opt.catalogue.scenes import SensorsPart
from mcdas_opt.catalogue.sensors import load_sensor
from mcdas_opt.domain.body import Body
from mcdas_opt.domain.host import HostState
from mcdas_opt.domain.measurement import RadarDetection, Scan
from mcdas_opt.domain.road import Road
from mcdas_opt.domain.sensor import Beam, Sensor
from mcdas_opt.domain.vehicle import Vehicle
from mcdas_opt.domain.vocabulary import Sector
from mcdas_opt.dynamics.bicycle import road_bicycle
from mcdas_opt.dynamics.integrator import rk4
from mcdas_opt.errors import InputError
from mcdas_opt.simulation.plant import make_plant
from mcdas_opt.simulation.sensors import SensorSuite, ideal_detections, mounting
from mcdas_opt.simulation.sight import View

CAR = Vehicle()
ESR, CORNER = load_sensor("delphi_esr"), load_sensor("corner_radar")
STRAIGHT = Road(lanes_left=1, lanes_right=1)
BEND = Road(lanes_left=1, lanes_right=1, curvature=((0.0, 0.002), (60.0, 0.008)))
EVERYWHERE = replace(ESR, range_min_m=0.0, beams=(Beam(name="all", range_max_m=200.0, half_angle_rad=math.pi),))


def suite(seed: int = 1, road: Road = STRAIGHT, **sensors: str) -> SensorSuite:
    return SensorSuite(SensorsPart(**sensors), CAR, road, seed)


def cars(t: float) -> list[Body]:
    return [
        Body(name="front", s_m=30.0 + 12.0 * t, speed_mps=12.0),
        Body(name="rear", s_m=-30.0 + 14.0 * t, speed_mps=14.0),
        Body(name="left", s_m=1.0 + 12.0 * t, d_m=3.7, speed_mps=12.0),
    ]


def host(t: float) -> HostState:
    return HostState(s_m=12.0 * t, speed_mps=12.0)


def drive(one: SensorSuite, times: list[float]) -> list[tuple[Scan, ...]]:
    return [one.scans(t, host(t), cars(t)) for t in times]


def test_every_sensor_keeps_its_rate() -> None:
    """20 Hz radars and ideal sensors, called every 10 ms: due every 50 ms, with no drift over ten seconds."""
    times = [0.01 * k - 1.0 for k in range(1001)]
    due = [t for t, scans in zip(times, drive(suite(front="delphi_esr", rear="none"), times), strict=True) if scans]
    np.testing.assert_allclose(due, np.arange(201) * 0.05 - 1.0, atol=1e-9)


def test_missed_scans_are_not_made_up_for() -> None:
    one = suite(front="delphi_esr")
    assert [len(scans) for scans in drive(one, [0.0, 0.02, 0.31, 0.33, 0.35])] == [4, 0, 4, 0, 4]


def test_a_slow_radar_waits() -> None:
    slow = replace(ESR, rate_hz=8.0)
    one = suite(front="delphi_esr", rear="none", left="none", right="none")
    one._posts[0].radar = slow
    count = sum(len(scans) for scans in drive(one, [0.05 * k for k in range(201)]))
    assert count == pytest.approx(10.0 * 8.0, abs=1)


def test_same_seed_same_scans_other_seed_other_noise() -> None:
    times = [0.05 * k for k in range(20)]
    first, again, other = (drive(suite(seed, front="delphi_esr", rear="delphi_esr"), times) for seed in (3, 3, 4))
    assert first == again
    assert first != other


def test_sensors_have_streams_of_their_own() -> None:
    """Front noise is the same whatever looks to the rear, and does not depend on who else is hit by luck."""
    times = [0.05 * k for k in range(20)]
    a = drive(suite(3, front="delphi_esr", rear="none", left="none"), times)
    b = drive(suite(3, front="delphi_esr", rear="delphi_esr", left="corner_radar"), times)
    assert [scans[0] for scans in a] == [scans[0] for scans in b]


def test_none_says_nothing() -> None:
    scans = suite(front="none", left="none").scans(0.0, host(0.0), cars(0.0))
    assert {scan.sector for scan in scans} == {Sector.REAR, Sector.RIGHT}


def test_unknown_sensors_are_refused_with_the_known_ones() -> None:
    with pytest.raises(InputError, match=r"lidar.*known: corner_radar, delphi_esr, ideal, none"):
        suite(front="lidar")


def test_mountings() -> None:
    places = {sector: mounting(sector, CAR) for sector in Sector}
    assert (places[Sector.FRONT].x_m, places[Sector.FRONT].yaw_rad) == (2.25, 0.0)
    assert (places[Sector.REAR].x_m, places[Sector.REAR].yaw_rad) == (-2.25, math.pi)
    assert (places[Sector.LEFT].y_m, places[Sector.LEFT].yaw_rad) == (0.9, math.pi / 2)
    assert (places[Sector.RIGHT].y_m, places[Sector.RIGHT].yaw_rad) == (-0.9, -math.pi / 2)


@settings(deadline=None)
@given(
    s=st.floats(-100.0, 100.0),
    d=st.floats(-12.0, 12.0),
    heading=st.floats(-0.3, 0.3),
    speed=st.floats(0.0, 40.0),
)
def test_ideal_sectors(s: float, d: float, heading: float, speed: float) -> None:
    """Beyond a bumper: front or rear. Beyond a flank within 60 m: that side. Exactly; and the velocity is the body's."""
    ego = HostState(s_m=50.0, d_m=1.0)
    body = Body(name="x", s_m=50.0 + s, d_m=1.0 + d, heading_rad=heading, speed_mps=speed, length_m=6.0, width_m=2.0)
    ahead, left = body.s_m - ego.s_m, body.d_m - ego.d_m
    seen = {sector: ideal_detections(sector, ego, [body], CAR) for sector in Sector}
    assert bool(seen[Sector.FRONT]) is (ahead > 2.25)
    assert bool(seen[Sector.REAR]) is (ahead < -2.25)
    assert bool(seen[Sector.LEFT]) is (left > 0.9 and abs(ahead) <= 60.0)
    assert bool(seen[Sector.RIGHT]) is (left < -0.9 and abs(ahead) <= 60.0)
    for found in seen.values():
        for detection in found:
            assert (detection.name, detection.s_m, detection.d_m) == ("x", body.s_m, body.d_m)
            assert (detection.length_m, detection.width_m) == (6.0, 2.0)
            assert math.hypot(detection.speed_s_mps, detection.speed_d_mps) == pytest.approx(speed)
            assert detection.speed_d_mps == pytest.approx(speed * math.sin(heading))


def look(body: Body, sector: Sector = Sector.FRONT, sensor: Sensor = ESR, others: tuple[Body, ...] = ()) -> RadarDetection | None:
    found = View(HostState(speed_mps=12.0), [body, *others], CAR, STRAIGHT).detections(sensor, mounting(sector, CAR))
    return next((point for i, point in found if i == 0), None)


@pytest.mark.parametrize(
    ("sector", "s", "d", "range_m", "azimuth_rad"),
    [
        (Sector.FRONT, 32.25, 0.0, 27.75, 0.0),
        (Sector.REAR, -32.25, 0.0, 27.75, 0.0),
        (Sector.LEFT, 0.0, 3.7, 1.9, 0.0),
        (Sector.RIGHT, 0.0, -3.7, 1.9, 0.0),
        (Sector.FRONT, 32.25, 3.0, math.hypot(30.0, 3.0) * 27.75 / 30.0, math.atan2(3.0, 30.0)),
        (Sector.REAR, -32.25, 3.0, math.hypot(30.0, 3.0) * 27.75 / 30.0, -math.atan2(3.0, 30.0)),  # looking back, left is right
    ],
)
def test_where_a_point_lies(sector: Sector, s: float, d: float, range_m: float, azimuth_rad: float) -> None:
    point = look(Body(name="x", s_m=s, d_m=d, speed_mps=12.0), sector, CORNER if sector in (Sector.LEFT, Sector.RIGHT) else ESR)
    assert point is not None
    assert point.range_m == pytest.approx(range_m, abs=1e-12)
    assert point.azimuth_rad == pytest.approx(azimuth_rad, abs=1e-12)


def test_field_of_view() -> None:
    """60 m within 45 degrees, 174 m within 10, nothing nearer than a metre."""

    def seen(distance: float, degrees: float) -> bool:
        angle = math.radians(degrees)
        small = Body(name="x", s_m=2.25 + distance * math.cos(angle), d_m=distance * math.sin(angle), length_m=1e-3, width_m=1e-3)
        return look(small) is not None

    assert seen(173.9, 0.0)
    assert not seen(174.1, 0.0)
    assert seen(59.0, 44.9)
    assert seen(59.0, -44.9)
    assert not seen(59.0, 45.1)
    assert not seen(61.0, 10.1)
    assert seen(61.0, -9.9)
    assert seen(1.1, 0.0)
    assert not seen(0.9, 0.0)
    assert not seen(20.0, 180.0)


def test_a_car_behind_a_car_is_hidden() -> None:
    hidden = Body(name="x", s_m=60.0, speed_mps=12.0)
    assert look(hidden) is not None
    assert look(hidden, others=(Body(name="y", s_m=30.0, d_m=0.8),)) is None
    assert look(hidden, others=(Body(name="y", s_m=30.0, d_m=1.5),)) is not None
    assert look(hidden, others=(Body(name="y", s_m=90.0),)) is not None  # behind it
    across = Body(name="y", s_m=30.0, d_m=1.5, heading_rad=0.5 * math.pi)  # standing across the lane
    assert look(hidden, others=(across,)) is None
    beyond = Body(name="z", s_m=0.0, d_m=7.4)
    assert look(beyond, Sector.LEFT, CORNER) is not None
    assert look(beyond, Sector.LEFT, CORNER, others=(Body(name="y", s_m=0.0, d_m=3.7),)) is None


@settings(deadline=None, max_examples=60)
@given(
    sector=st.sampled_from(list(Sector)),
    s=st.floats(-60.0, 60.0),
    d=st.floats(-9.0, 9.0),
    heading=st.floats(-0.2, 0.2),
    speed=st.floats(0.0, 30.0),
    steering=st.floats(-0.05, 0.05),
    bend=st.booleans(),
)
def test_the_range_rate_is_the_rate_of_the_centre_s_range(sector, s, d, heading, speed, steering, bend) -> None:
    """Against a finite difference: the host moved by the bicycle, the body along its heading; its centre's range changes as said."""
    assume(abs(s) > 8.0 or abs(d) > 4.0)
    road = BEND if bend else STRAIGHT
    place = mounting(sector, CAR)
    x = [100.0, 0.5, heading, 15.0, 0.0, steering]
    body = Body(name="x", s_m=100.0 + s, d_m=d, heading_rad=0.5 * heading, speed_mps=speed)
    point_like = {"length_m": 1e-9, "width_m": 1e-9}

    def range_at(h: float) -> float:
        moved = rk4(lambda q: road_bicycle(q, (0.0, 0.0), float(road.curvature_at(q[0])), CAR.wheelbase_m, CAR.centre_m, np), x, h)
        kappa = float(road.curvature_at(body.s_m))
        there = replace(
            body,
            s_m=body.s_m + h * body.speed_along_mps / (1.0 - body.d_m * kappa),
            d_m=body.d_m + h * body.speed_across_mps,
            **point_like,
        )
        (seen,) = View(HostState.from_vector(np.array(moved)), [there], CAR, road).detections(EVERYWHERE, place)
        return seen[1].range_m

    found = View(HostState.from_vector(np.array(x)), [body], CAR, road).detections(EVERYWHERE, place)
    assume(found)
    h = 1e-4
    assert found[0][1].range_rate_mps == pytest.approx((range_at(h) - range_at(-h)) / (2.0 * h), abs=1e-4)


def test_noise_and_detection_rate_are_those_of_the_file() -> None:
    one = suite(7, front="delphi_esr", rear="none", left="none", right="none")
    target = [Body(name="x", s_m=60.0, d_m=2.0)]
    truth = look(replace(target[0]))
    assert truth is not None
    ego = HostState(speed_mps=12.0)
    points = [scan.radar for k in range(4000) for scan in one.scans(0.05 * k, ego, target)]
    hits = [radar[0] for radar in points if radar]
    assert len(hits) / len(points) == pytest.approx(0.98, abs=0.01)
    errors = np.array(
        [(p.range_m - truth.range_m, p.azimuth_rad - truth.azimuth_rad, p.range_rate_mps - truth.range_rate_mps) for p in hits]
    )
    np.testing.assert_allclose(errors.std(axis=0), [0.25, math.radians(0.5), 0.12], rtol=0.05)
    np.testing.assert_allclose(errors.mean(axis=0) / errors.std(axis=0), 0.0, atol=0.06)
    assert np.abs(np.corrcoef(errors.T) - np.eye(3)).max() < 0.05


def test_far_down_a_bent_road() -> None:
    """After kilometres the geometry is what it was at the start (the road's table follows the host)."""
    ring = Road(lanes_left=1, lanes_right=1, curvature=((0.0, 0.002),))
    found = []
    for s in (0.0, 2600.0, 7777.0):
        ego = HostState(s_m=s, speed_mps=20.0, steering_rad=math.atan(2.7 * 0.002))
        body = Body(name="x", s_m=s + 50.0, d_m=3.7, speed_mps=22.0)
        found.append(View(ego, [body], CAR, ring).detections(ESR, mounting(Sector.FRONT, CAR))[0][1])
    for point in found[1:]:
        assert point.range_m == pytest.approx(found[0].range_m, abs=1e-9)
        assert point.azimuth_rad == pytest.approx(found[0].azimuth_rad, abs=1e-9)
        assert point.range_rate_mps == pytest.approx(found[0].range_rate_mps, abs=1e-9)


@pytest.mark.parametrize("sector", list(Sector))
@pytest.mark.parametrize(("plant", "steering_rate_radps"), [("kinematic", 0.08), ("dynamic", 0.25)])
def test_the_range_rate_is_how_fast_the_range_changes_also_of_a_car_that_slips(
    plant: str, steering_rate_radps: float, sector: Sector
) -> None:
    """By differences along a swerve, at the tyres' limit where there are any, past a post that stands beside a straight road."""
    road = replace(STRAIGHT, friction=0.9)
    post = Body(name="post", s_m=20.0, d_m=30.0, heading_rad=0.0, speed_mps=0.0, length_m=0.02, width_m=0.02)
    driven, seen = make_plant(plant, CAR, road, HostState(speed_mps=25.0)), []
    for k in range(120):
        driven.step(0.0, steering_rate_radps if k < 40 else -steering_rate_radps)
        ((_, point),) = View(driven.state, [post], CAR, road).detections(EVERYWHERE, mounting(sector, CAR))
        seen.append((point.range_m, point.range_rate_mps))
    ranges, rates = np.array(seen).T
    assert np.abs((ranges[2:] - ranges[:-2]) / 0.02 - rates[1:-1]).max() < 0.02
